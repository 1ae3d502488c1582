/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From the bytes in a .npy file or a pickle to an lt_array.
 */
#include "libtensor/io/array/raw_array.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/utf8.h"

#include <string.h>

enum { MAX_TEXT_BYTES = 1 << 20 };

static const bool host_is_big = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;

static const struct {
    char code[3];
    lt_elem type;
} codes[] = {
    { "f4", LT_ELEM_F4 }, { "f8", LT_ELEM_F8 }, { "f2", LT_ELEM_F2 }, { "b1", LT_ELEM_BOOL },
    { "i1", LT_ELEM_I1 }, { "i2", LT_ELEM_I2 }, { "i4", LT_ELEM_I4 }, { "i8", LT_ELEM_I8 },
    { "u1", LT_ELEM_U1 }, { "u2", LT_ELEM_U2 }, { "u4", LT_ELEM_U4 }, { "u8", LT_ELEM_U8 },
};

static const char *text_type(lt_raw_array *raw, const char *digits, size_t n)
{
    size_t width = 0;

    for (size_t i = 0; i < n; i++) {
        if (digits[i] < '0' || digits[i] > '9')
            return "an element type that NumPy does not have";
        width = width * 10 + (size_t)(digits[i] - '0');
        if (width > MAX_TEXT_BYTES)
            return "text elements of over a million characters";
    }
    if (width == 0)
        return "text elements of no characters";
    raw->type = LT_ELEM_TEXT;
    raw->width = raw->unicode ? 4 * width : width;
    return NULL;
}

const char *lt_raw_type(lt_raw_array *raw, const char *code, size_t n)
{
    for (size_t i = 0; n == 2 && i < LT_COUNT(codes); i++) {
        if (memcmp(codes[i].code, code, 2) != 0)
            continue;
        raw->type = codes[i].type;
        raw->width = lt_elem_size(raw->type);
        return NULL;
    }
    if (n > 1 && (code[0] == 'S' || code[0] == 'U')) {
        raw->unicode = code[0] == 'U';
        return text_type(raw, code + 1, n - 1);
    }
    raw->objects = n > 0 && code[0] == 'O';
    if (raw->objects)
        return "elements are Python objects";
    if (n > 0 && code[0] == 'V')
        return "elements are structures";
    if (n > 0 && code[0] == 'c')
        return "elements are complex numbers";
    return "elements are of a type that is not read";
}

bool lt_raw_order(lt_raw_array *raw, char order)
{
    raw->swap = (order == '>' && !host_is_big) || (order == '<' && host_is_big);
    return order == '<' || order == '>' || order == '=' || order == '|';
}

bool lt_raw_bytes(const lt_raw_array *raw, size_t *out)
{
    size_t n = raw->width;

    for (int i = 0; i < raw->rank; i++) {
        if (raw->shape[i] < 0 || raw->shape[i] > INT32_MAX)
            return false;
        if (!lt_size_mul(n, (size_t)raw->shape[i], &n) || n > LT_FILE_MAX)
            return false;
    }
    *out = n;
    return true;
}

void lt_swap_bytes(uint8_t *p, size_t n, size_t size)
{
    for (size_t i = 0; i + size <= n; i += size) {
        for (size_t k = 0; k < size / 2; k++) {
            const uint8_t byte = p[i + k];

            p[i + k] = p[i + size - 1 - k];
            p[i + size - 1 - k] = byte;
        }
    }
}

void lt_copy_strided(uint8_t *to, const uint8_t *from, size_t size, int rank, const int64_t *shape,
                     const uint64_t *stride)
{
    int64_t index[LT_ARRAY_MAX_RANK] = { 0 };
    size_t count = 1;
    uint64_t at = 0;

    for (int d = 0; d < rank; d++)
        count *= (size_t)shape[d];
    for (size_t i = 0; i < count; i++) {
        memcpy(to + i * size, from + at * size, size);
        for (int d = rank - 1; d >= 0; d--) {
            at += stride[d];
            if (++index[d] < shape[d])
                break;
            at -= stride[d] * (uint64_t)shape[d];
            index[d] = 0;
        }
    }
}

static void copy_fortran(uint8_t *out, const uint8_t *in, const lt_raw_array *raw)
{
    uint64_t stride[LT_ARRAY_MAX_RANK], step = 1;

    for (int d = 0; d < raw->rank; d++) {
        stride[d] = step;
        step *= (uint64_t)raw->shape[d];
    }
    lt_copy_strided(out, in, raw->width, raw->rank, raw->shape, stride);
}

static void copy_elements(uint8_t *out, const uint8_t *in, const lt_raw_array *raw, size_t bytes)
{
    if (raw->fortran && raw->rank > 1)
        copy_fortran(out, in, raw);
    else
        memcpy(out, in, bytes);
    if (raw->swap)
        lt_swap_bytes(out, bytes, raw->type != LT_ELEM_TEXT ? raw->width : raw->unicode ? 4 : 1);
}

/* One element as NUL-terminated UTF-8; trailing NULs are padding. Returns the end, or NULL. */
static char *decode_text(char *out, const uint8_t *in, const lt_raw_array *raw)
{
    const size_t unit = raw->unicode ? 4 : 1;
    char *end = out;

    for (size_t i = 0; i < raw->width; i += unit) {
        uint32_t code = in[i];
        size_t n;

        if (raw->unicode)
            memcpy(&code, in + i, sizeof(code));
        n = lt_utf8_put(end, code);
        if (n == 0)
            return NULL;
        end += n;
    }
    while (end > out && end[-1] == '\0')
        end--;
    *end = '\0';
    return end;
}

static lt_status load_text(lt_arena *arena, const lt_raw_array *raw, uint8_t *elements, size_t count,
                           lt_array *out)
{
    const size_t longest = (raw->unicode ? raw->width : 2 * raw->width) + 1;
    const char **text = lt_arena_array(arena, count, sizeof(*text));
    char *chars = lt_arena_array(arena, count, longest);

    if (!text || !chars)
        return lt_error(LT_ENOMEM, "no memory for %zu texts", count);
    for (size_t i = 0; i < count; i++) {
        text[i] = chars;
        chars = decode_text(chars, elements + i * raw->width, raw);
        if (!chars)
            return lt_error(LT_EFORMAT, "text with a character beyond Unicode");
        chars++;
    }
    *out = lt_array_make(LT_ELEM_TEXT, raw->rank, raw->shape, text);
    return LT_OK;
}

lt_status lt_raw_load(lt_arena *arena, const lt_raw_array *raw, const uint8_t *bytes, lt_array *out)
{
    size_t n, count;
    void *data;
    lt_status st;

    if (!lt_raw_bytes(raw, &n))
        return lt_error(LT_EFORMAT, "array is too large");
    count = n / raw->width;
    st = lt_arena_try(arena, n, &data);
    if (st)
        return st;
    if (n)
        copy_elements(data, bytes, raw, n);
    if (raw->type == LT_ELEM_TEXT)
        return load_text(arena, raw, data, count, out);
    for (size_t i = 0; raw->type == LT_ELEM_BOOL && i < n; i++)
        ((uint8_t *)data)[i] = ((uint8_t *)data)[i] != 0;
    *out = lt_array_make(raw->type, raw->rank, raw->shape, data);
    return LT_OK;
}
