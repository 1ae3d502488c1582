/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hogs/skin_field.h"

lt_tensor *hogs_in_box(const hogs_box *box, lt_tensor *places)
{
    return lt_mul(lt_sub(places, box->centre), box->inverse);
}

void skin_field_new(skin_field *m, lt_params *set, const char *prefix, int sets, int width)
{
    set_mlp_new(&m->mlp, set, prefix, sets, (int[]){ 3, width, width, width, width, SKIN_FIELD_BONES }, 5);
}

void skin_field_init(const skin_field *m, uint64_t seed)
{
    set_mlp_init(&m->mlp, seed);
}

lt_tensor *skin_field_forward(const skin_field *m, lt_tensor *places, lt_tensor *which)
{
    return lt_softmax(set_mlp_forward(&m->mlp, places, which));
}

lt_tensor *skin_field_loss(lt_tensor *weights, lt_tensor *target)
{
    return lt_scale(lt_mse_loss(weights, target, NULL), SKIN_FIELD_BONES);
}
