/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/graph/passes/passes.h"

static bool any_alive(const lt_node *n, const bool *alive)
{
    for (int i = 0; i < n->n_out; i++)
        if (n->outs[i]->is_output || alive[n->outs[i]->id])
            return true;
    return false;
}

lt_status pass_dead_code(lt_graph *g)
{
    bool *alive = lt_arena_array(g->arena, (size_t)g->n_tensors, sizeof(*alive));

    if (!alive)
        return lt_error(LT_ENOMEM, "no memory to compile the graph");
    for (int k = g->n_nodes - 1; k >= 0; k--) {
        const lt_node *n = g->node[k];

        if (n && any_alive(n, alive)) {
            for (int i = 0; i < n->n_in; i++)
                if (n->in[i])
                    alive[n->in[i]->id] = true;
        } else {
            g->node[k] = NULL;
        }
    }
    return LT_OK;
}
