/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A message is a list of fields: number and kind in one varint, then the value. Varints have seven bits a
 * byte, the lowest first.
 */
#include "libtensor/io/protobuf.h"

#include <string.h>

/* ---- writing -------------------------------------------------------------------------------------------- */

static void put(pb_sink *s, const void *bytes, size_t n)
{
    s->bytes += n;
    if (s->f && n)
        fwrite(bytes, 1, n, s->f);
}

static void put_varint(pb_sink *s, uint64_t x)
{
    uint8_t bytes[10];
    size_t n = 0;

    for (; x >= 0x80; x >>= 7)
        bytes[n++] = (uint8_t)(x | 0x80);
    bytes[n++] = (uint8_t)x;
    put(s, bytes, n);
}

static void put_tag(pb_sink *s, int field, pb_wire wire)
{
    put_varint(s, (uint64_t)field << 3 | wire);
}

static void put_fixed(pb_sink *s, uint64_t x, int bytes)
{
    uint8_t b[8];

    for (int i = 0; i < bytes; i++)
        b[i] = (uint8_t)(x >> (8 * i));
    put(s, b, (size_t)bytes);
}

void pb_put_int(pb_sink *s, int field, int64_t value)
{
    put_tag(s, field, PB_VARINT);
    put_varint(s, (uint64_t)value);
}

void pb_put_float(pb_sink *s, int field, float value)
{
    uint32_t bits;

    memcpy(&bits, &value, sizeof(bits));
    put_tag(s, field, PB_FIXED32);
    put_fixed(s, bits, 4);
}

void pb_put_double(pb_sink *s, int field, double value)
{
    uint64_t bits;

    memcpy(&bits, &value, sizeof(bits));
    put_tag(s, field, PB_FIXED64);
    put_fixed(s, bits, 8);
}

void pb_put_bytes(pb_sink *s, int field, const void *bytes, size_t n)
{
    put_tag(s, field, PB_BYTES);
    put_varint(s, n);
    put(s, bytes, n);
}

void pb_put_text(pb_sink *s, int field, const char *text)
{
    pb_put_bytes(s, field, text, strlen(text));
}

void pb_put_message(pb_sink *s, int field, pb_message_fn fn, const void *what)
{
    pb_sink count = { NULL, 0 };

    fn(&count, what);
    put_tag(s, field, PB_BYTES);
    put_varint(s, count.bytes);
    if (s->f)
        fn(s, what);
    else
        s->bytes += count.bytes;
}

/* ---- reading -------------------------------------------------------------------------------------------- */

bool pb_varint(pb_span *list, uint64_t *out)
{
    uint64_t x = 0;

    for (int shift = 0; shift < 64 && list->at < list->end; shift += 7) {
        const uint8_t byte = *list->at++;

        x |= (uint64_t)(byte & 0x7f) << shift;
        if (byte < 0x80) {
            *out = x;
            return true;
        }
    }
    return false;
}

static const char *take_fixed(pb_span *m, pb_field *f, size_t bytes)
{
    if (pb_size(*m) < bytes)
        return "a number is cut off";
    for (size_t i = 0; i < bytes; i++)
        f->value |= (uint64_t)m->at[i] << (8 * i);
    m->at += bytes;
    return NULL;
}

static const char *take_bytes(pb_span *m, pb_field *f)
{
    uint64_t n;

    if (!pb_varint(m, &n))
        return "a length that does not end";
    if (n > pb_size(*m))
        return "a length that passes the end";
    f->body = (pb_span){ m->at, m->at + n };
    m->at += n;
    return NULL;
}

const char *pb_next(pb_span *m, pb_field *f)
{
    uint64_t tag;

    *f = (pb_field){ .at = m->at, .body = { m->at, m->at } };
    if (!pb_varint(m, &tag))
        return "a field's number that does not end";
    if (tag >> 3 == 0 || tag >> 3 > 0x1fffffff)
        return "a field's number that cannot be";
    f->number = (int)(tag >> 3);
    f->wire = (pb_wire)(tag & 7);
    switch (f->wire) {
    case PB_VARINT: return pb_varint(m, &f->value) ? NULL : "a number that does not end";
    case PB_FIXED64: return take_fixed(m, f, 8);
    case PB_FIXED32: return take_fixed(m, f, 4);
    case PB_BYTES: return take_bytes(m, f);
    default: return "a field of a kind that is not read";
    }
}
