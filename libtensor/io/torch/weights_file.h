/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Files of weights, whatever wrote them: safetensors and PyTorch's checkpoints, told apart by their bytes.
 */
#ifndef LT_IO_TORCH_WEIGHTS_FILE_H
#define LT_IO_TORCH_WEIGHTS_FILE_H

#include "libtensor/io/array/array.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const char *path, *format;      /* "safetensors", "PyTorch (zip)", "PyTorch (stream)", "PyTorch (tar)" */
    size_t n;
    lt_named_array *entry;
} lt_weights_file;

/* lt_weights_read - names and arrays, in the arena; errors of lt_torch_read and lt_safetensors_read */
LT_API lt_status lt_weights_read(lt_arena *arena, const char *path, lt_weights_file *out);

#ifdef __cplusplus
}
#endif
#endif
