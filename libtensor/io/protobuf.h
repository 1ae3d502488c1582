/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: protobuf's wire format, for the two formats of ours that are made of it: ONNX models and
 * TensorBoard's event files.
 *
 * Reading is ours, not protobuf-c's: its unpacking gives every empty sub-message of a hostile file a struct
 * before anyone has looked at it, and wants the format's .proto compiled in. A cursor over the bytes allocates
 * nothing, and goes only where it is led, so that nesting is as deep as its caller's code.
 *
 * Source: protobuf.dev, "Encoding".
 */
#ifndef LT_IO_PROTOBUF_H
#define LT_IO_PROTOBUF_H

#include "libtensor/base/common.h"

#include <stdio.h>

/* ---- writing -------------------------------------------------------------------------------------------- */

/* Where a message goes; without a file it is only counted. */
typedef struct {
    FILE *f;
    uint64_t bytes;
} pb_sink;

typedef void (*pb_message_fn)(pb_sink *s, const void *what);

void pb_put_int(pb_sink *s, int field, int64_t value);
void pb_put_float(pb_sink *s, int field, float value);
void pb_put_double(pb_sink *s, int field, double value);
void pb_put_bytes(pb_sink *s, int field, const void *bytes, size_t n);
void pb_put_text(pb_sink *s, int field, const char *text);

/* pb_put_message - fn writes what is in it; called twice, as its length stands before it */
void pb_put_message(pb_sink *s, int field, pb_message_fn fn, const void *what);

/* ---- reading -------------------------------------------------------------------------------------------- */

typedef struct {
    const uint8_t *at, *end;
} pb_span;

typedef enum { PB_VARINT = 0, PB_FIXED64 = 1, PB_BYTES = 2, PB_FIXED32 = 5 } pb_wire;

typedef struct {
    int number;
    pb_wire wire;
    uint64_t value;                 /* of PB_VARINT, PB_FIXED64, PB_FIXED32 */
    pb_span body;                   /* of PB_BYTES */
    const uint8_t *at;              /* where it begins */
} pb_field;

/* pb_next - the next field of a message, which moves on; NULL, or what is wrong with it. Not at the end. */
const char *pb_next(pb_span *message, pb_field *out);

/* pb_varint - one number of a packed list; false when it does not end in time */
bool pb_varint(pb_span *list, uint64_t *out);

static inline size_t pb_size(pb_span s) { return (size_t)(s.end - s.at); }

#endif
