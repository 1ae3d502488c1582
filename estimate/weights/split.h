/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Attention whose queries, keys and values are made by one array in a file, and by three in the model.
 */
#ifndef ESTIMATE_WEIGHT_SPLIT_H
#define ESTIMATE_WEIGHT_SPLIT_H

#include "libtensor/graph/param.h"
#include "libtensor/io/torch/weights_file.h"

/**
 * weight_split_attention - "attn.in_proj_weight" and "attn.qkv.weight" (3 C, C) become "attn.q_proj.weight",
 * "attn.k_proj.weight" and "attn.v_proj.weight" (C, C), rows of the one array; "..bias" likewise
 *
 * Not where the model itself has a parameter whose name ends so, or where the rows are no three equal parts. Errors:
 * LT_ENOMEM.
 */
lt_status weight_split_attention(lt_arena *arena, const lt_params *set, lt_weights_file *file);

#endif
