/* SPDX-License-Identifier: Apache-2.0 */
/* Ops that read constants faster in another form, as packed weights, ask for it once the graph is fused. */
#include "libtensor/graph/passes/passes.h"

static void prepare(lt_node *n, const lt_int8_table *int8)
{
    const lt_int8_range *range = lt_int8_takes(n) ? lt_int8_find(int8, n->name) : NULL;

    if (range)
        n->op->prepare_int8(n, range);
    else if (n->op->prepare)
        n->op->prepare(n);
}

lt_status pass_prepare(lt_graph *g, const lt_int8_table *int8)
{
    const int n_nodes = g->n_nodes;             /* preparing records more, all of them constant */

    for (int k = 0; k < n_nodes; k++)
        if (g->node[k] && !g->node[k]->constant)
            prepare(g->node[k], int8);
    return lt_graph_status(g);
}
