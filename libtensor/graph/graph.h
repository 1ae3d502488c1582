/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Recording. Ops called on tensors of a graph are written down, shapes inferred, nothing computed. The
 * first mistake is remembered, later calls are harmless, and lt_compile reports it.
 */
#ifndef LT_GRAPH_GRAPH_H
#define LT_GRAPH_GRAPH_H

#include "libtensor/base/status.h"
#include "libtensor/graph/op.h"
#include "libtensor/graph/param.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_graph_new - an empty graph, NULL without memory; the graph owns its tensors */
/* A program and the library that it is linked with mean the same lt_real, or do not link. */
#ifdef LT_DOUBLE
#define lt_graph_new lt_graph_new_of_doubles
#endif
LT_API lt_graph *lt_graph_new(void);
LT_API void lt_graph_free(lt_graph *g);

/* lt_graph_status - the first mistake, also in lt_last_error(); LT_OK when there was none */
LT_API lt_status lt_graph_status(const lt_graph *g);

/* lt_input - a tensor to fill before each run; the name is for messages */
LT_API lt_tensor *lt_input(lt_graph *g, const char *name, lt_dtype dtype, int rank, const int64_t *dim);

/* lt_use - the parameter as a tensor of g; the same tensor each time */
LT_API lt_tensor *lt_use(lt_graph *g, lt_param *p);

/* lt_constant - a tensor with these values, copied; lt_scalar - one number, shape () */
LT_API lt_tensor *lt_constant(lt_graph *g, lt_dtype dtype, lt_shape shape, const void *values);
LT_API lt_tensor *lt_scalar(lt_graph *g, double value);

/* lt_constant_reals - a constant *out of real numbers, to be filled in place: returns its elements, zeros so far; NULL
 * after a mistake, where *out is as harmless as what lt_constant returns then */
LT_API lt_real *lt_constant_reals(lt_graph *g, lt_shape shape, lt_tensor **out);

/* lt_output - t will be readable after each run, under this name; returns t */
LT_API lt_tensor *lt_output(lt_tensor *t, const char *name);

/* lt_want_grad - the gradient of an input is wanted too (lt_plan_grad); returns it. A result is a mistake. */
LT_API lt_tensor *lt_want_grad(lt_tensor *input);

/* lt_scope - name the layers recorded from now on that have no parameter of their own; "" for none */
LT_API void lt_scope(lt_graph *g, const char *name);

#ifdef __cplusplus
}
#endif
#endif
