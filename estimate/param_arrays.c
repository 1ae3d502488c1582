/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/param_arrays.h"

#include <string.h>

lt_array reals_array(const lt_shape *shape, const lt_real *data)
{
    return lt_array_make(sizeof(*data) == sizeof(float) ? LT_ELEM_F4 : LT_ELEM_F8, shape->rank, shape->dim, data);
}

lt_named_array *param_arrays(lt_arena *arena, const lt_params *set, size_t more, size_t *n)
{
    lt_named_array *list;
    size_t count = 0;

    for (const lt_param *p = lt_params_first(set); p; p = p->next)
        count++;
    list = lt_arena_array(arena, count + more, sizeof(*list));
    if (!list)
        return NULL;
    *n = 0;
    for (const lt_param *p = lt_params_first(set); p; p = p->next)
        list[(*n)++] = (lt_named_array){ p->name, reals_array(&p->shape, p->data) };
    return list;
}

bool array_fits(const lt_array *a, const lt_shape *shape)
{
    const int more = a->rank > shape->rank ? a->rank - shape->rank : 0;

    for (int i = 0; i < more; i++)
        if (a->shape[i] != 1)
            return false;
    return a->type != LT_ELEM_TEXT && a->rank - more == shape->rank
           && memcmp(a->shape + more, shape->dim, (size_t)shape->rank * sizeof(*shape->dim)) == 0;
}

lt_status array_check(const char *path, const char *array, const lt_array *a, const char *name,
                      const lt_shape *shape)
{
    char have[160], want[LT_SHAPE_TEXT];

    if (array_fits(a, shape))
        return LT_OK;
    return lt_error(LT_EINVAL, "%s: \"%s\" is %s, the model's \"%s\" is %s", path, array,
                    lt_array_shape_text(a, have, sizeof(have)), name, lt_shape_text(shape, want));
}

void array_load(const lt_array *a, lt_real *out)
{
    const size_t n = lt_array_count(a);

    for (size_t i = 0; i < n; i++)
        out[i] = (lt_real)lt_array_get(a, i);
}
