/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hocat/fpn.h"

enum { SE_REDUCTION = 16 };

static bool gates_laterals(hocat_se_place se)
{
    return se == SE_LATERAL_AND_OUT || se == SE_LATERAL;
}

static bool gates_out(hocat_se_place se)
{
    return se == SE_LATERAL_AND_OUT || se == SE_OUT;
}

void hocat_fpn_new(hocat_fpn *m, lt_params *set, const char *prefix, const int channels[RESNET_STAGES],
                   int out, hocat_se_place se)
{
    m->se = se;
    m->top = lt_conv_layer_new(set, lt_name(set, "%s.top", prefix), channels[3], out, 1, true, NULL);
    for (int i = 2; i >= 0; i--) {
        m->lateral[i] = lt_conv_layer_new(set, lt_name(set, "%s.lateral%d", prefix, i + 2), channels[i], out, 1,
                                          true, NULL);
        if (gates_laterals(se))
            m->gate[i] = lt_se_layer_new(set, lt_name(set, "%s.se%d", prefix, i + 2), channels[i], SE_REDUCTION);
    }
    m->smooth = lt_conv_layer_new(set, lt_name(set, "%s.smooth", prefix), out, out, 3, true,
                                  &(lt_conv_opts){ .pad = 1 });
    if (gates_out(se))
        m->gate_out = lt_se_layer_new(set, lt_name(set, "%s.se_out", prefix), out, SE_REDUCTION);
}

/* P_i = up(P_{i+1}) + lat_i(g_i C_i) */
static lt_tensor *top_down(const hocat_fpn *m, int i, lt_tensor *above, lt_tensor *c)
{
    lt_tensor *gated = gates_laterals(m->se) ? lt_se_layer_forward(&m->gate[i], c) : c;
    lt_tensor *lateral = lt_conv_layer_forward(&m->lateral[i], gated);

    return lt_add(lateral, lt_resize_bilinear(above, lt_dim(lateral, 2), lt_dim(lateral, 3)));
}

lt_tensor *hocat_fpn_forward(const hocat_fpn *m, const resnet_out *c)
{
    lt_tensor *p = lt_conv_layer_forward(&m->top, c->c[3]);             /* P5, stride 32 */

    for (int i = 2; i >= 0; i--)
        p = top_down(m, i, p, c->c[i]);                                 /* P4, P3, P2' */
    p = lt_conv_layer_forward(&m->smooth, p);
    return gates_out(m->se) ? lt_se_layer_forward(&m->gate_out, p) : p; /* P2, stride 4 */
}
