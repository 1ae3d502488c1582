/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The passes of lt_compile over a plan's own copy of the graph, in the order they run.
 */
#ifndef LT_GRAPH_PASSES_H
#define LT_GRAPH_PASSES_H

#include "libtensor/graph/int8.h"
#include "libtensor/graph/internal.h"

/**
 * pass_copy - copy the graph, so that later passes may change it
 *
 * of[id] is set to the copy of each tensor. With lower, ops that know a simpler form for inference
 * (batch norm, dropout) record that instead.
 */
lt_graph *pass_copy(const lt_graph *source, bool lower, lt_tensor **of);

/* pass_dead_code - remove every node that no output needs */
lt_status pass_dead_code(lt_graph *g);

/* pass_fuse - let producers take over their element-wise tails: batch norm folds into the weights */
lt_status pass_fuse(lt_graph *g);

/* pass_fuse_for_training - the same where there is a backward pass, with tails, then with what is before */
lt_status pass_fuse_for_training(lt_graph *g);

/* pass_block - let chains of nodes keep their maps in blocks of channels; after pass_fuse. Renumbers the nodes. */
lt_status pass_block(lt_graph *g);

/* pass_pair - let products and convolutions take over those before them; after pass_block */
lt_status pass_pair(lt_graph *g);

/* pass_prepare - let ops replace their constant inputs by what they read faster, and those that int8 names read 8-bit
 * integers; after pass_pair */
lt_status pass_prepare(lt_graph *g, const lt_int8_table *int8);

#endif
