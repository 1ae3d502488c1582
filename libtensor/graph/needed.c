/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/graph/internal.h"

bool lt_node_is_needed(const lt_node *n, const bool *needed)
{
    for (int i = 0; i < n->n_out; i++)
        if (needed[n->outs[i]->id])
            return true;
    return false;
}

/* From the last node to the first: who reads a value comes after who makes it. */
void lt_graph_mark_needed(const lt_graph *g, bool *needed)
{
    for (int i = 0; i < g->n_tensors; i++)
        needed[i] = g->tensor[i]->is_output;
    for (int k = g->n_nodes - 1; k >= 0; k--) {
        const lt_node *n = g->node[k];

        if (!n || !lt_node_is_needed(n, needed))
            continue;
        for (int i = 0; i < n->n_in; i++)
            if (n->in[i])
                needed[n->in[i]->id] = true;
    }
}
