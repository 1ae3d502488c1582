/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/graph/internal.h"

#include <stdio.h>
#include <string.h>

bool lt_same_shape(const lt_shape *a, const lt_shape *b)
{
    return a->rank == b->rank && memcmp(a->dim, b->dim, (size_t)a->rank * sizeof(a->dim[0])) == 0;
}

size_t lt_dtype_size(lt_dtype dtype)
{
    static const size_t size[] = {
        [LT_F32] = sizeof(lt_real), [LT_I32] = 4, [LT_I8] = 1, [LT_U8] = 1,
    };

    return size[dtype];
}

size_t lt_nbytes(const lt_tensor *t)
{
    return (size_t)lt_numel(t) * lt_dtype_size(t->dtype);
}

char *lt_shape_text(const lt_shape *s, char buf[LT_SHAPE_TEXT])
{
    int n = snprintf(buf, LT_SHAPE_TEXT, "(");

    if (s->rank < 0 || s->rank > LT_MAX_RANK) {
        snprintf(buf, LT_SHAPE_TEXT, "(of %d dimensions)", s->rank);
        return buf;
    }
    for (int i = 0; i < s->rank; i++)
        n += snprintf(buf + n, (size_t)(LT_SHAPE_TEXT - n), i ? ", %lld" : "%lld", (long long)s->dim[i]);
    snprintf(buf + n, (size_t)(LT_SHAPE_TEXT - n), ")");
    return buf;
}

bool lt_shape_fits_memory(const lt_shape *s)
{
    size_t bytes = sizeof(double);

    if (s->rank < 0 || s->rank > LT_MAX_RANK)
        return false;
    for (int i = 0; i < s->rank; i++)
        if (s->dim[i] < 0 || !lt_size_mul(bytes, (size_t)s->dim[i], &bytes) || bytes > PTRDIFF_MAX)
            return false;
    return true;
}
