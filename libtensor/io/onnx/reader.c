/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/onnx/reader.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { BLOCK = 1 << 14 };

lt_status onnx_bad(const onnx_reader *r, const uint8_t *at, const char *fmt, ...)
{
    char why[256];
    va_list args;

    va_start(args, fmt);
    vsnprintf(why, sizeof(why), fmt, args);
    va_end(args);
    return lt_error(LT_EFORMAT, "%s: offset %zu: %s", r->name, (size_t)(at - r->bytes), why);
}

/* Small pieces share blocks: an arena's own pieces are a cache line at least. */
lt_status onnx_take(onnx_reader *r, const uint8_t *at, size_t count, size_t size, void *out)
{
    size_t n;

    if (!lt_size_mul(count, size, &n) || n > r->budget)
        return onnx_bad(r, at, "asks for more memory than such a file may");
    n = n ? (n + 7) / 8 * 8 : 8;
    if (n > r->left) {
        const size_t block = n > BLOCK ? n : BLOCK;

        r->block = lt_arena_alloc(r->arena, block);
        if (!r->block)
            return lt_error(LT_ENOMEM, "%s: no memory for %zu bytes", r->name, block);
        r->left = block;
    }
    r->budget -= n < r->budget ? n : r->budget;
    *(void **)out = r->block;
    r->block += n;
    r->left -= n;
    return LT_OK;
}

bool onnx_next(const onnx_reader *r, pb_span *m, pb_field *f, lt_status *st)
{
    const char *wrong;

    if (*st || m->at >= m->end)
        return false;
    wrong = pb_next(m, f);
    if (wrong)
        *st = onnx_bad(r, f->at, "%s", wrong);
    return !wrong;
}

lt_status onnx_want(const onnx_reader *r, const pb_field *f, pb_wire wire)
{
    return f->wire == wire ? LT_OK : onnx_bad(r, f->at, "field %d is of kind %d, want %d", f->number, f->wire, wire);
}

lt_status onnx_take_text(onnx_reader *r, const pb_field *f, const char **out)
{
    const size_t n = pb_size(f->body);
    char *text;
    lt_status st = onnx_want(r, f, PB_BYTES);

    if (st == LT_OK && memchr(f->body.at, 0, n))
        st = onnx_bad(r, f->at, "a name with a zero byte");
    if (st == LT_OK)
        st = onnx_take(r, f->at, n + 1, 1, &text);
    if (st)
        return st;
    memcpy(text, f->body.at, n);
    text[n] = '\0';
    *out = text;
    return LT_OK;
}

lt_status onnx_take_int(const onnx_reader *r, const pb_field *f, int64_t *out)
{
    const lt_status st = onnx_want(r, f, PB_VARINT);

    *out = (int64_t)f->value;
    return st;
}

lt_status onnx_count_fields(const onnx_reader *r, pb_span m, int n[ONNX_COUNTED])
{
    pb_field f;
    lt_status st = LT_OK;

    memset(n, 0, ONNX_COUNTED * sizeof(*n));
    while (onnx_next(r, &m, &f, &st))
        if (f.number < ONNX_COUNTED)
            n[f.number]++;
    return st;
}

lt_status onnx_add_ints(const onnx_reader *r, const pb_field *f, int64_t *list, int room, int *n)
{
    pb_span packed = f->body;
    uint64_t x;

    if (f->wire == PB_VARINT) {
        if (*n < room)
            list[(*n)++] = (int64_t)f->value;
        return LT_OK;
    }
    for (; f->wire == PB_BYTES && packed.at < packed.end && *n < room; list[(*n)++] = (int64_t)x)
        if (!pb_varint(&packed, &x))
            return onnx_bad(r, f->at, "a packed list that does not end");
    return onnx_want(r, f, PB_BYTES);
}

lt_status onnx_add_floats(const onnx_reader *r, const pb_field *f, float *list, int room, int *n)
{
    const size_t bytes = pb_size(f->body);
    const uint32_t bits = (uint32_t)f->value;

    if (f->wire == PB_FIXED32) {
        if (*n < room)
            memcpy(&list[(*n)++], &bits, sizeof(bits));
        return LT_OK;
    }
    if (f->wire == PB_BYTES && bytes % sizeof(float))
        return onnx_bad(r, f->at, "a packed list that does not end");
    for (size_t at = 0; f->wire == PB_BYTES && at < bytes && *n < room; at += sizeof(float))
        memcpy(&list[(*n)++], f->body.at + at, sizeof(float));
    return onnx_want(r, f, PB_BYTES);
}
