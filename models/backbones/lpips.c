/* SPDX-License-Identifier: Apache-2.0 */
#include "models/backbones/lpips.h"

#include "libtensor/nn/init.h"

enum { TRUNK_SEED = 0x4c504950 };

void lpips_new(lpips *m, lt_params *set, const char *prefix)
{
    const char *dot = *prefix ? "." : "";

    alexnet_new(&m->trunk, set, prefix);
    for (int l = 0; l < ALEXNET_TAPS; l++) {
        m->lin[l] = lt_params_add(set, lt_name(set, "%s%slin%d.model.1", prefix, dot, l), "weight", LT_WEIGHT,
                                  LT_SHAPE(1, alexnet_layers[l].o, 1, 1));
        m->lin[l]->frozen = true;
    }
}

void lpips_init(lpips *m)
{
    alexnet_init(&m->trunk, TRUNK_SEED);
    for (int l = 0; l < ALEXNET_TAPS; l++) {
        m->drawn[l] = m->trunk.conv[l].weight->data[0];
        lt_init_constant(m->lin[l], 1.0 / alexnet_layers[l].o);
    }
}

bool lpips_is_random(const lpips *m)
{
    for (int l = 0; l < ALEXNET_TAPS; l++) {
        const lt_real each = (lt_real)(1.0 / alexnet_layers[l].o), *lin = m->lin[l]->data;

        if (m->trunk.conv[l].weight->data[0] == m->drawn[l] || (lin[0] == each && lin[1] == each))
            return true;
    }
    return false;
}

const char *lpips_name(const lpips *m)
{
    return lpips_is_random(m) ? "lpips (random trunk)" : "lpips";
}
