/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Files of weights, whatever wrote them: safetensors, NumPy's .npz and PyTorch's checkpoints, told apart by their
 * bytes, and the index of what is cut into several files.
 */
#ifndef LT_IO_TORCH_WEIGHTS_FILE_H
#define LT_IO_TORCH_WEIGHTS_FILE_H

#include "libtensor/io/array/array.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const char *path;
    const char *format;             /* "safetensors", "NumPy (npz)", "PyTorch (zip)", "PyTorch (stream)", ".. (tar)" */
    size_t n, n_refused;
    lt_named_array *entry;          /* of nested dicts with the keys on the way: "state_dict.conv1.weight" */
    size_t *within;                 /* n of them: where in the name that begins which its own dict has for it */
    lt_refused_array *refused;
} lt_weights_file;

/**
 * lt_weights_read - names and arrays, in the arena
 *
 * An index (model.safetensors.index.json, pytorch_model.bin.index.json) stands for the files that its "weight_map"
 * names, which lie in its folder or below.
 *
 * Errors: those of lt_torch_read, lt_safetensors_read, lt_npz_read and lt_json_parse; a file of an index that is not
 * there, or whose name leads out of its folder.
 */
LT_API lt_status lt_weights_read(lt_arena *arena, const char *path, lt_weights_file *out);

#ifdef __cplusplus
}
#endif
#endif
