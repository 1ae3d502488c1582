/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which layers of an inference plan read their inputs as 8-bit integers, and how: a table by the layers' names. Two
 * ways to run a plan show what such a table is made from, and what it costs.
 */
#ifndef LT_GRAPH_INT8_H
#define LT_GRAPH_INT8_H

#include "libtensor/graph/op.h"

#ifdef __cplusplus
extern "C" {
#endif

struct lt_plan;

typedef struct {
    const char *layer;              /* "fpn.hand.lateral3" */
    lt_int8_range range;            /* of its input */
} lt_int8_layer;

/* A layer is there once; the order is indifferent. */
typedef struct {
    const lt_int8_layer *layer;
    int n;
} lt_int8_table;

/* lt_int8_find - how the layer reads its input; NULL when it is not in the table, or table is NULL */
LT_API const lt_int8_range *lt_int8_find(const lt_int8_table *table, const char *layer);

/* lt_int8_takes - could this node be in a table? It has a name, its weights are known, it is large enough, and what it
 * makes is no output of the graph: results that are looked at stay as exact as they are. */
LT_API bool lt_int8_takes(const lt_node *n);

/**
 * lt_plan_observe - lt_run, showing the input of each layer that could be in a table
 *
 * For a plan without backward, compiled with no_fusion: what others multiply into an input is in it then. A layer with
 * several uses is shown as often.
 */
typedef void (*lt_observer)(void *ctx, const char *layer, const lt_real *x, int64_t n);
LT_API void lt_plan_observe(struct lt_plan *p, lt_observer see, void *ctx);

/**
 * lt_plan_compare - lt_run of exact, showing each layer of rounded that reads integers beside it
 *
 * Both are inference plans of one graph, rounded with this table and exact with an empty one. Such a layer is run on
 * what exact has for input, so that its error is its own; of rounded nothing else is run. n numbers of each result are
 * shown.
 */
typedef void (*lt_comparer)(void *ctx, const char *layer, const lt_real *exact, const lt_real *rounded, int64_t n);
LT_API void lt_plan_compare(struct lt_plan *exact, struct lt_plan *rounded, const lt_int8_table *table,
                            lt_comparer see, void *ctx);

#ifdef __cplusplus
}
#endif
#endif
