/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What recording and compiling share, and nobody else sees.
 */
#ifndef LT_GRAPH_INTERNAL_H
#define LT_GRAPH_INTERNAL_H

#include "libtensor/base/arena.h"
#include "libtensor/graph/graph.h"
#include "libtensor/graph/rows.h"

struct lt_graph {
    lt_arena *arena;
    lt_tensor **tensor;             /* by id */
    int n_tensors;
    size_t tensors_room;
    lt_node **node;                 /* in the order of execution; NULL where a pass removed one */
    int n_nodes;
    size_t nodes_room;
    const char *scope;
    lt_status status;
    char error[1024];
    lt_tensor *harmless;            /* what calls return after a mistake */
};

/* lt_shape_fits_memory - no dimension is negative, and the bytes of the largest type can be counted */
bool lt_shape_fits_memory(const lt_shape *s);

/* lt_where - " (file:line)", or "" where file is NULL */
enum { LT_WHERE = 256 };
const char *lt_where(const char *file, int line, char out[LT_WHERE]);

/* lt_take_stray_error - the first mistake on this thread that had no graph to be kept in, which is forgotten by it */
lt_status lt_take_stray_error(void);

/* lt_graph_add_tensor, lt_graph_add_node - append one made by hand; false without memory (kept in the graph) */
bool lt_graph_add_tensor(lt_graph *g, lt_tensor *t);
bool lt_graph_add_node(lt_graph *g, lt_node *n);

/* lt_params_version      - another one means that values have changed
 * lt_params_collect      - a run of a training plan has added what its batch measured to the statistics, or replaced it
 * lt_params_take_batches - for an update of the statistics: whether any batch came since the last one, and of how many
 *                          the sums in grad are */
uint64_t lt_params_version(const lt_params *set);
void lt_params_collect(lt_params *set, bool replaced);
bool lt_params_take_batches(lt_params *set, int *n);

/* lt_params_moved - a parameter has another place in memory; lt_params_moves - how often that was so */
void lt_params_moved(lt_params *set);
uint64_t lt_params_moves(const lt_params *set);

/* rows.c, of a parameter that is stepped by rows: that it is; its data; both given back by _fini; its gradient; zeros
 * for the touched rows of grad, its own or a plan's; how often it has got another place in memory, of any parameter */
lt_status lt_rows_init(lt_param *p);
lt_status lt_rows_allocate(lt_param *p);
void lt_rows_fini(lt_param *p);
bool lt_rows_need_grad(lt_param *p);
void lt_rows_clear(const lt_param *p, lt_real *grad);
uint64_t lt_rows_moves(const lt_param *p);

/* lt_graph_mark_needed - what outputs need, themselves included: needed[id] of each tensor of g
 * lt_node_is_needed    - whether that includes a result of n */
void lt_graph_mark_needed(const lt_graph *g, bool *needed);
bool lt_node_is_needed(const lt_node *n, const bool *needed);

/* lt_tensor_new - a tensor of g with this kind; NULL without memory */
lt_tensor *lt_tensor_new(lt_graph *g, lt_tensor_kind kind, const char *name, lt_dtype dtype, lt_shape shape);

/* lt_call_init - a call with the node's attr, inputs and outputs, nothing else set */
void lt_call_init(lt_call *c, const lt_node *n);

static inline bool lt_op_is_view(const lt_op *op) { return op->flags & LT_OP_VIEW; }

#endif
