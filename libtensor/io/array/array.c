/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Arrays as files hold them: element types, conversions, shapes.
 */
#include "libtensor/io/array/array.h"

#include <assert.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char *name;
    size_t size;
} elems[LT_ELEM_COUNT] = {
    [LT_ELEM_F4] = { "f4", 4 }, [LT_ELEM_F8] = { "f8", 8 }, [LT_ELEM_F2] = { "f2", 2 },
    [LT_ELEM_BF16] = { "bf16", 2 },
    [LT_ELEM_I1] = { "i1", 1 }, [LT_ELEM_I2] = { "i2", 2 }, [LT_ELEM_I4] = { "i4", 4 },
    [LT_ELEM_I8] = { "i8", 8 }, [LT_ELEM_U1] = { "u1", 1 }, [LT_ELEM_U2] = { "u2", 2 },
    [LT_ELEM_U4] = { "u4", 4 }, [LT_ELEM_U8] = { "u8", 8 }, [LT_ELEM_BOOL] = { "bool", 1 },
    [LT_ELEM_TEXT] = { "text", sizeof(const char *) },
};

size_t lt_elem_size(lt_elem type)
{
    return elems[type].size;
}

const char *lt_elem_name(lt_elem type)
{
    return elems[type].name;
}

lt_array lt_array_make(lt_elem type, int rank, const int64_t *shape, const void *data)
{
    lt_array a = { .type = type, .rank = rank, .data = (void *)(uintptr_t)data };

    assert(rank >= 0 && rank <= LT_ARRAY_MAX_RANK);
    for (int i = 0; i < rank; i++)
        a.shape[i] = shape[i];
    return a;
}

const lt_refused_array *lt_refused_find(const lt_refused_array *list, size_t n, const char *name)
{
    for (size_t i = 0; i < n; i++)
        if (strcmp(list[i].name, name) == 0)
            return &list[i];
    return NULL;
}

size_t lt_array_count(const lt_array *a)
{
    size_t n = 1;

    for (int i = 0; i < a->rank; i++)
        n *= (size_t)a->shape[i];
    return n;
}

bool lt_array_bytes(const lt_array *a, size_t *out)
{
    size_t n = elems[a->type].size;

    for (int i = 0; i < a->rank; i++)
        if (a->shape[i] < 0 || !lt_size_mul(n, (size_t)a->shape[i], &n))
            return false;
    *out = n;
    return true;
}

double lt_array_get(const lt_array *a, size_t i)
{
    switch (a->type) {
    case LT_ELEM_F4:   return ((const float *)a->data)[i];
    case LT_ELEM_F8:   return ((const double *)a->data)[i];
    case LT_ELEM_F2:   return lt_f16_to_f32(((const uint16_t *)a->data)[i]);
    case LT_ELEM_BF16: return lt_bf16_to_f32(((const uint16_t *)a->data)[i]);
    case LT_ELEM_I8:   return (double)((const int64_t *)a->data)[i];
    case LT_ELEM_U8:   return (double)((const uint64_t *)a->data)[i];
    case LT_ELEM_TEXT: case LT_ELEM_COUNT: assert(!"text is no number"); return 0;
    default:           return (double)lt_array_int(a, i);
    }
}

static int64_t int_of_double(double x)
{
    return x >= -0x1p63 && x < 0x1p63 ? (int64_t)x : INT64_MIN;
}

int64_t lt_array_int(const lt_array *a, size_t i)
{
    switch (a->type) {
    case LT_ELEM_I1:   return ((const int8_t *)a->data)[i];
    case LT_ELEM_I2:   return ((const int16_t *)a->data)[i];
    case LT_ELEM_I4:   return ((const int32_t *)a->data)[i];
    case LT_ELEM_I8:   return ((const int64_t *)a->data)[i];
    case LT_ELEM_U1:
    case LT_ELEM_BOOL: return ((const uint8_t *)a->data)[i];
    case LT_ELEM_U2:   return ((const uint16_t *)a->data)[i];
    case LT_ELEM_U4:   return ((const uint32_t *)a->data)[i];
    case LT_ELEM_U8: {
        const uint64_t u = ((const uint64_t *)a->data)[i];

        return u <= INT64_MAX ? (int64_t)u : INT64_MIN;
    }
    default:           return int_of_double(lt_array_get(a, i));
    }
}

const char *lt_array_text(const lt_array *a, size_t i)
{
    return a->type == LT_ELEM_TEXT ? ((const char *const *)a->data)[i] : NULL;
}

void lt_array_to_float(const lt_array *a, float *out, size_t n)
{
    if (a->type == LT_ELEM_F4 && n) {
        memcpy(out, a->data, n * sizeof(*out));
        return;
    }
    for (size_t i = 0; i < n; i++)
        out[i] = (float)lt_array_get(a, i);
}

bool lt_array_has_shape(const lt_array *a, int rank, const int64_t *shape)
{
    if (a->rank != rank)
        return false;
    for (int i = 0; i < rank; i++)
        if (shape[i] != -1 && a->shape[i] != shape[i])
            return false;
    return true;
}

const char *lt_array_shape_text(const lt_array *a, char *out, size_t n)
{
    size_t used = (size_t)snprintf(out, n, "(");

    for (int i = 0; i < a->rank && used < n; i++)
        used += (size_t)snprintf(out + used, n - used, "%s%" PRId64, i ? ", " : "", a->shape[i]);
    if (used < n)
        snprintf(out + used, n - used, ")");
    return out;
}

static float float_of_bits(uint32_t bits)
{
    float x;

    memcpy(&x, &bits, sizeof(x));
    return x;
}

static uint32_t bits_of_float(float x)
{
    uint32_t bits;

    memcpy(&bits, &x, sizeof(bits));
    return bits;
}

float lt_f16_to_f32(uint16_t h)
{
    const uint32_t sign = (uint32_t)(h & 0x8000) << 16, exponent = (h >> 10) & 31, fraction = h & 1023;

    if (exponent == 31)                                         /* infinity, NaN */
        return float_of_bits(sign | 0x7f800000 | fraction << 13);
    if (exponent == 0) {                                        /* zero, or fraction * 2^-24 */
        const float x = (float)fraction * 0x1p-24f;

        return sign ? -x : x;
    }
    return float_of_bits(sign | (exponent + 112) << 23 | fraction << 13);
}

float lt_bf16_to_f32(uint16_t h)
{
    return float_of_bits((uint32_t)h << 16);
}

/* value >> shift, to nearest, ties to even */
static uint32_t shift_round(uint32_t value, int shift)
{
    const uint32_t half = 1u << (shift - 1), rest = value & ((1u << shift) - 1);
    const uint32_t cut = value >> shift;

    return cut + (rest > half || (rest == half && (cut & 1)));
}

uint16_t lt_f32_to_f16(float x)
{
    const uint32_t bits = bits_of_float(x), a = bits & 0x7fffffff, sign = (bits >> 16) & 0x8000;

    if (a > 0x7f800000)                                         /* NaN stays one, made quiet */
        return (uint16_t)(sign | 0x7e00 | ((a >> 13) & 1023));
    if (a >= 0x477ff000)                                        /* 65520 and more round to infinity */
        return (uint16_t)(sign | 0x7c00);
    if (a >= 0x38800000)                                        /* normal: 2^-14 and more */
        return (uint16_t)(sign | shift_round(a - 0x38000000, 13));
    if (a < 0x33000000)                                         /* below half the smallest, 2^-25 */
        return (uint16_t)sign;
    return (uint16_t)(sign | shift_round((a & 0x7fffff) | 0x800000, 126 - (int)(a >> 23)));
}

uint16_t lt_f32_to_bf16(float x)
{
    const uint32_t bits = bits_of_float(x);

    if ((bits & 0x7fffffff) > 0x7f800000)
        return (uint16_t)((bits >> 16) | 0x40);
    return (uint16_t)shift_round(bits, 16);
}
