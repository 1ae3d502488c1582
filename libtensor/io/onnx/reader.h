/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: what the functions share that read a message of onnx.proto each.
 */
#ifndef LT_IO_ONNX_READER_H
#define LT_IO_ONNX_READER_H

#include "libtensor/io/onnx/onnx.h"
#include "libtensor/io/protobuf.h"

typedef struct {
    lt_arena *arena;
    const char *name;
    const uint8_t *bytes;
    size_t budget;                      /* bytes that may still be asked for */
    char *block;
    size_t left;                        /* of block */
    bool has_graph;
} onnx_reader;

/* onnx_bad - the error of a file that is wrong at this place */
lt_status onnx_bad(const onnx_reader *r, const uint8_t *at, const char *fmt, ...) LT_PRINTF(3, 4);

/* onnx_take - memory for count pieces of this size, from the budget; *out, a pointer of any type, points to it */
lt_status onnx_take(onnx_reader *r, const uint8_t *at, size_t count, size_t size, void *out);

/* onnx_next - the next field *f of a message; false at its end, when it is damaged, which *st then says, and where *st
 * already is no LT_OK: while (onnx_next(r, &m, &f, &st)) st = ...; */
bool onnx_next(const onnx_reader *r, pb_span *m, pb_field *f, lt_status *st);

enum { ONNX_COUNTED = 32 };             /* above the number of any field whose memory is counted */

/**
 * onnx_want         - it must be of this kind
 * onnx_take_text    - a text, without zero bytes
 * onnx_take_int     - a whole number
 * onnx_count_fields - how many fields of each number below ONNX_COUNTED a message has
 * onnx_add_ints     - one more of a list of whole numbers, or several in a pack; those beyond room are dropped
 * onnx_add_floats   - the same of reals
 */
lt_status onnx_want(const onnx_reader *r, const pb_field *f, pb_wire wire);
lt_status onnx_take_text(onnx_reader *r, const pb_field *f, const char **out);
lt_status onnx_take_int(const onnx_reader *r, const pb_field *f, int64_t *out);
lt_status onnx_count_fields(const onnx_reader *r, pb_span m, int n[ONNX_COUNTED]);
lt_status onnx_add_ints(const onnx_reader *r, const pb_field *f, int64_t *list, int room, int *n);
lt_status onnx_add_floats(const onnx_reader *r, const pb_field *f, float *list, int room, int *n);

/* onnx_take_tensor - a TensorProto: in tensor.c */
lt_status onnx_take_tensor(onnx_reader *r, const pb_field *field, lt_onnx_tensor *t);

#endif
