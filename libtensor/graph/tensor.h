/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A tensor: a shape, and during a run its data. Dimensions run outermost first; the last is contiguous.
 */
#ifndef LT_GRAPH_TENSOR_H
#define LT_GRAPH_TENSOR_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_MAX_RANK = 6 };

typedef enum {
    LT_F32,                         /* lt_real: float, and double in the double build */
    LT_I32,                         /* indices and labels; never has a gradient */
    LT_I8,
    LT_U8,
} lt_dtype;

typedef struct {
    int rank;                       /* 0: a scalar */
    int64_t dim[LT_MAX_RANK];
} lt_shape;

typedef enum {
    LT_INPUT,                       /* filled by the caller before a run */
    LT_PARAM,                       /* lives in an lt_params, shared by graphs and plans */
    LT_CONSTANT,                    /* lives in the graph */
    LT_RESULT,                      /* made by a node */
} lt_tensor_kind;

typedef struct lt_graph lt_graph;
typedef struct lt_node lt_node;
typedef struct lt_param lt_param;
typedef struct lt_tensor lt_tensor;

struct lt_tensor {
    lt_shape shape;
    lt_dtype dtype;
    void *data;                     /* set inside an op's forward and backward */
    const char *name;
    lt_graph *graph;
    lt_node *node;                  /* who makes it; NULL unless kind is LT_RESULT */
    lt_param *param;                /* NULL unless kind is LT_PARAM */
    lt_tensor_kind kind;
    int id;                         /* its place among the graph's tensors */
    bool is_output;                 /* must be there after a run */
    bool wants_grad;                /* an input whose gradient is asked for */
};

static inline int64_t lt_shape_numel(const lt_shape *s)
{
    int64_t n = 1;

    for (int i = 0; i < s->rank; i++)
        n *= s->dim[i];
    return n;
}

static inline int64_t lt_numel(const lt_tensor *t) { return lt_shape_numel(&t->shape); }

/* lt_dim - dimension i; negative i counts from the end */
static inline int64_t lt_dim(const lt_tensor *t, int i)
{
    return t->shape.dim[i < 0 ? t->shape.rank + i : i];
}

LT_API bool lt_same_shape(const lt_shape *a, const lt_shape *b);
LT_API size_t lt_dtype_size(lt_dtype dtype);

/* lt_nbytes - bytes of the tensor's data */
LT_API size_t lt_nbytes(const lt_tensor *t);

/* lt_shape_text - "(2, 3, 8)" in buf, which is returned */
enum { LT_SHAPE_TEXT = 160 };
LT_API char *lt_shape_text(const lt_shape *s, char buf[LT_SHAPE_TEXT]);

/* LT_SHAPE(2, 3, 8) - a shape in one word */
#define LT_SHAPE(...) \
    ((lt_shape){ (int)(sizeof((int64_t[]){ __VA_ARGS__ }) / sizeof(int64_t)), { __VA_ARGS__ } })

#ifdef __cplusplus
}
#endif
#endif
