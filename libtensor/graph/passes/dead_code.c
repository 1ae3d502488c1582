/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/graph/passes/passes.h"

lt_status pass_dead_code(lt_graph *g)
{
    bool *needed = lt_arena_array(g->arena, (size_t)g->n_tensors, sizeof(*needed));

    if (!needed)
        return lt_error(LT_ENOMEM, "no memory to compile the graph");
    lt_graph_mark_needed(g, needed);
    for (int k = 0; k < g->n_nodes; k++)
        if (g->node[k] && !lt_node_is_needed(g->node[k], needed))
            g->node[k] = NULL;
    return LT_OK;
}
