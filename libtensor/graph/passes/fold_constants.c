/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/graph/passes/passes.h"

void pass_fold_constants(const lt_graph *g, bool *constant)
{
    for (int k = 0; k < g->n_nodes; k++)
        constant[k] = g->node[k] && lt_is_constant(g->node[k]->outs[0]);
}
