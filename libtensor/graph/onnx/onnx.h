/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A graph in ONNX's words: a model made of standard operators, in memory. libtensor/io/onnx/onnx.h writes it to
 * a file and reads it from one.
 *
 * No table says how our ops map to ONNX's. An op says so itself, in the `onnx` function of its lt_op, with the
 * words below: what it is made of there, and which value is its result. docs/onnx.md lists what they say.
 *
 * Source: onnx/onnx, docs/IR.md and docs/Operators.md, operator set 17.
 */
#ifndef LT_GRAPH_ONNX_ONNX_H
#define LT_GRAPH_ONNX_ONNX_H

#include "libtensor/base/arena.h"
#include "libtensor/graph/graph.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_ONNX_OPSET = 17, LT_ONNX_IR = 8 };

/* ---- a model -------------------------------------------------------------------------------------------- */

typedef enum {
    LT_ONNX_FLOAT = 1, LT_ONNX_INT32 = 6, LT_ONNX_INT64 = 7, LT_ONNX_BOOL = 9,          /* numbers of the format */
} lt_onnx_type;

/* An input or output. A dimension of -1 is open: the batch, whatever the caller brings. */
typedef struct {
    const char *name;
    lt_onnx_type type;
    lt_shape shape;
    const char *open[LT_MAX_RANK];      /* what a file calls its open dimensions; NULL where it does not say */
} lt_onnx_port;

/* A constant: little-endian, in order, at any address */
typedef struct {
    const char *name;
    lt_onnx_type type;
    lt_shape shape;
    const void *data;
} lt_onnx_tensor;

typedef enum {
    LT_ONNX_A_FLOAT = 1, LT_ONNX_A_INT = 2, LT_ONNX_A_TEXT = 3, LT_ONNX_A_TENSOR = 4, LT_ONNX_A_FLOATS = 6,
    LT_ONNX_A_INTS = 7,                                                                 /* numbers of the format */
} lt_onnx_attr_kind;

typedef struct {
    const char *name;
    lt_onnx_attr_kind kind;
    float f;
    int64_t i;
    const char *text;
    const int64_t *ints;
    int n_ints;
    const float *floats;
    int n_floats;
    const lt_onnx_tensor *tensor;
} lt_onnx_attr;

/* One use of an operator; values are known by name, "" is an input that was left out */
typedef struct {
    const char *op, *name;
    const char **in, **out;
    lt_onnx_attr *attr;
    int n_in, n_out, n_attr;
} lt_onnx_node;

typedef struct {
    const char *key, *value;
} lt_onnx_text;

typedef struct {
    const char *path;                   /* for error lines; NULL for one that was described */
    const char *producer, *version;     /* the program that wrote it */
    const char *name;
    int64_t opset;
    lt_onnx_port *input, *output;
    lt_onnx_tensor *tensor;
    lt_onnx_node *node;                 /* in an order of execution */
    lt_onnx_text *meta;
    int n_inputs, n_outputs, n_tensors, n_nodes, n_meta;
} lt_onnx_model;

/**
 * lt_onnx_describe - what a graph computes, as a model
 *
 *   g       recorded; its outputs and whatever they need become the model
 *   twin    the same recorded for another batch: sizes that differ between the two become the batch, -1;
 *           NULL: all sizes are fixed
 *   out     name, inputs, outputs, tensors, nodes; in the arena, but for weights, which stay where they are:
 *           g, its parameters and the arena must outlive it
 *
 * Inputs and outputs keep their names, weights those of their parameters.
 * Errors: LT_EINVAL: an op has no ONNX form (all such are named); a twin that is not the same graph; a
 * constant or a shape that depends on the batch in a way that ONNX cannot say. A mistake of the graph.
 */
LT_API lt_status lt_onnx_describe(lt_arena *arena, const lt_graph *g, const lt_graph *twin, lt_onnx_model *out);

/* ---- words for an op's onnx function ---------------------------------------------------------------------- */

/*
 * Values are names, owned by w. The first mistake is kept in w, calls after it do no harm.
 *
 *     static void onnx(lt_onnx *w, const lt_node *n)       y = x sigmoid(x)
 *     {
 *         const char *x = lt_onnx_of(w, n->in[0]), *s = LT_ONNX(w, "Sigmoid", x);
 *
 *         lt_onnx_is(w, n->outs[0], LT_ONNX(w, "Mul", x, s));
 *     }
 */

/* lt_onnx_of - the value of an input of the node; "" for one that was left out */
LT_API const char *lt_onnx_of(lt_onnx *w, const lt_tensor *t);

/* LT_ONNX - use an operator on values; returns its first result. Attributes are set right after it. */
#define LT_ONNX(w, op, ...) \
    lt_onnx_put(w, op, (const char *const[]){ __VA_ARGS__ }, \
                (int)(sizeof((const char *const[]){ __VA_ARGS__ }) / sizeof(const char *)))
LT_API const char *lt_onnx_put(lt_onnx *w, const char *op, const char *const *in, int n_in);

/* lt_onnx_int, _ints, _float, _text - give the operator that was used last an attribute */
LT_API void lt_onnx_int(lt_onnx *w, const char *name, int64_t value);
LT_API void lt_onnx_ints(lt_onnx *w, const char *name, const int64_t *value, int n);
LT_API void lt_onnx_float(lt_onnx *w, const char *name, double value);
LT_API void lt_onnx_text_of(lt_onnx *w, const char *name, const char *value);

/* lt_onnx_is - t is this value; returns the name to go on with, which may be another */
LT_API const char *lt_onnx_is(lt_onnx *w, const lt_tensor *t, const char *value);

/* lt_onnx_same - the node is one operator, with the node's inputs in their order */
LT_API void lt_onnx_same(lt_onnx *w, const lt_node *n, const char *op);

/* lt_onnx_number, _numbers, _index, _indices - constants: a real; reals of this shape; a whole number; a list
 * of them */
LT_API const char *lt_onnx_number(lt_onnx *w, double value);
LT_API const char *lt_onnx_numbers(lt_onnx *w, lt_shape shape, const lt_real *value);
LT_API const char *lt_onnx_index(lt_onnx *w, int64_t value);
LT_API const char *lt_onnx_indices(lt_onnx *w, const int64_t *value, int n);

/* lt_onnx_dim - dimension i of t (negative: from the end); -1 where it is the batch */
LT_API int64_t lt_onnx_dim(lt_onnx *w, const lt_tensor *t, int i);

/* lt_onnx_reshape - to this shape, of which one dimension may be -1; _transpose; _slice - elements
 * start .. start + length - 1 along axis; _gather - these elements along axis; _sum - over axis, which goes */
LT_API const char *lt_onnx_reshape(lt_onnx *w, const char *x, lt_shape shape);
LT_API const char *lt_onnx_transpose(lt_onnx *w, const char *x, const int *order, int rank);
LT_API const char *lt_onnx_slice(lt_onnx *w, const char *x, int axis, int64_t start, int64_t length);
LT_API const char *lt_onnx_gather(lt_onnx *w, const char *x, int axis, const int *index, int n);
LT_API const char *lt_onnx_sum(lt_onnx *w, const char *x, int axis, bool keep);

/* lt_onnx_refuse - this use of the op has no ONNX form; why, for one line */
LT_API void lt_onnx_refuse(lt_onnx *w, const char *fmt, ...) LT_PRINTF(2, 3);

#ifdef __cplusplus
}
#endif
#endif
