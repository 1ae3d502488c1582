/* SPDX-License-Identifier: Apache-2.0 */
/* Ops that read constants faster in another form, as packed weights, ask for it once the graph is fused. */
#include "libtensor/graph/passes/passes.h"

lt_status pass_prepare(lt_graph *g)
{
    const int n_nodes = g->n_nodes;             /* preparing records more, all of them constant */

    for (int k = 0; k < n_nodes; k++)
        if (g->node[k] && g->node[k]->op->prepare && !g->node[k]->constant)
            g->node[k]->op->prepare(g->node[k]);
    return lt_graph_status(g);
}
