/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A model while it is described: what the walk over the graph and the words of ops share.
 */
#ifndef LT_GRAPH_ONNX_INTERNAL_H
#define LT_GRAPH_ONNX_INTERNAL_H

#include "libtensor/graph/internal.h"
#include "libtensor/graph/onnx/onnx.h"

struct lt_onnx {
    lt_arena *arena;
    const lt_graph *g, *twin;
    lt_onnx_model model;
    size_t nodes_room, tensors_room;
    const char **value;             /* of each tensor, by id; NULL where it is not described yet */
    const lt_node *at;              /* the node that is being described */
    int part;                       /* values of its inside so far */
    lt_status status;               /* of the first mistake */
};

/* lt_onnx_fail - keep the first mistake; returns it */
lt_status lt_onnx_fail(lt_onnx *w, lt_status status, const char *fmt, ...) LT_PRINTF(3, 4);

/* lt_onnx_alloc - in the arena; NULL, and a mistake, without memory or after a mistake */
void *lt_onnx_alloc(lt_onnx *w, size_t count, size_t size);

/* lt_onnx_name_of   - "trunk.conv1/conv2d.7" and a suffix: the layer, the op, the node's number
 * lt_onnx_part_name - for the next value inside the node */
const char *lt_onnx_name_of(lt_onnx *w, const lt_node *n, const char *suffix);
const char *lt_onnx_part_name(lt_onnx *w);

/* lt_onnx_add_tensor - a constant; data is borrowed, but reals that are not floats are converted */
const char *lt_onnx_add_tensor(lt_onnx *w, const char *name, lt_onnx_type type, lt_shape shape, const void *data,
                               bool reals);

#endif
