/* SPDX-License-Identifier: Apache-2.0 */
/*
 * ONNX files: written whole, read within bounds, and turned into graphs of our ops.
 *
 * Source: onnx/onnx, onnx/onnx.proto and docs/IR.md.
 */
#ifndef LT_IO_ONNX_ONNX_H
#define LT_IO_ONNX_ONNX_H

#include "libtensor/graph/onnx/onnx.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_onnx_write - a model as a ModelProto, weights included: one file, nothing beside it
 *
 * Goes to an open stream, whose own error flag tells whether it arrived (lt_atomic_commit looks at it).
 * The same model gives the same bytes. Errors: LT_EINVAL for a model of 2 GB, which the format does not hold.
 */
LT_API lt_status lt_onnx_write(FILE *f, const char *name, const lt_onnx_model *m);

/**
 * lt_onnx_parse - a model from n bytes in memory
 *
 *   out      its lists and names are in the arena, its numbers stay where they are in bytes, which must
 *            outlive it; touched only on success
 *
 * Needs at most 16 bytes of memory for each of the file, and 64 KB. Errors: LT_EFORMAT, with the offset: no
 * ModelProto; cut short; a field of the wrong kind; numbers in another file (no such file is opened) or of a
 * type other than FLOAT, INT32, INT64, BOOL; data that disagree with a shape; operators that are not standard,
 * contain graphs, or are of an operator set below 11; more than 6 dimensions. LT_ENOMEM.
 */
LT_API lt_status lt_onnx_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                               lt_onnx_model *out);

/* lt_onnx_read - the same from a file, whose bytes stay in the arena; also LT_EIO */
LT_API lt_status lt_onnx_read(lt_arena *arena, const char *path, lt_onnx_model *out);

/* The inputs and outputs of an imported model, in the model's order */
typedef struct {
    lt_tensor **input, **output;
} lt_onnx_ports;

/**
 * lt_onnx_import - record a model into a graph of our ops
 *
 *   arena    of ports' lists
 *   g        inputs and outputs get the model's names; constants are copied
 *   batch    for first dimensions that are left open, and others of their name
 *
 * Understands what docs/onnx.md lists under "Reading". Errors: LT_EFORMAT names an operator or an attribute that it
 * does not; an open height or width; a value that nobody has made, or two have; shapes that do not fit. LT_ENOMEM.
 */
LT_API lt_status lt_onnx_import(lt_arena *arena, lt_graph *g, const lt_onnx_model *m, int64_t batch,
                                lt_onnx_ports *ports);

#ifdef __cplusplus
}
#endif
#endif
