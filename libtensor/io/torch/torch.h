/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PyTorch's checkpoints (.pt, .pth, .pth.tar, .ckpt) as data: tensors and their names, in every container
 * that torch.save has written.
 *
 * Source: pytorch torch/serialization.py (_load, _legacy_load), torch/_utils.py.
 */
#ifndef LT_IO_TORCH_TORCH_H
#define LT_IO_TORCH_TORCH_H

#include "libtensor/io/array/array.h"
#include "libtensor/io/pickle/pickle.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LT_TORCH_NONE,                  /* the bytes are no checkpoint's */
    LT_TORCH_ZIP,                   /* since 1.6 */
    LT_TORCH_STREAM,                /* pickles and raw storages one behind the other */
    LT_TORCH_TAR,                   /* before 0.1.10 */
} lt_torch_container;

typedef struct {
    const char *path;               /* for error lines */
    lt_torch_container container;
    const lt_pvalue *value;         /* what was saved; its tensors are LT_PARRAY */
    size_t n, n_refused;
    lt_named_array *entry;          /* all tensors: "state_dict.conv1.weight" */
    size_t *within;                 /* n of them: where in the name that begins which its dict has for it */
    lt_refused_array *refused;      /* quantized, sparse and complex tensors, those of 8-bit floats */
} lt_torch_file;

/**
 * lt_torch_read - a checkpoint's tensors
 *
 *   out      owned by the arena; touched only on success
 *
 * Dicts and lists join their keys and indices with a dot, of whatever class they are. A pickled module (as ultralytics
 * saves them) gives its parameters and buffers, a TorchScript program (as OpenAI's CLIP is) those of its modules.
 * Tensors of half precision stay so. Views, strides and shared storages give C-ordered arrays, which may share memory.
 *
 * Pickles are read with lt_pickle_read's classes and PyTorch's own tensor functions; other names are objects that stay
 * closed. Nothing is ever called.
 *
 * Errors: LT_EFORMAT names file, offset and reason: a storage of another size than
 * promised; a tensor beyond its storage, or one with more elements than the file could hold;
 * whatever the pickle and zip readers refuse. LT_EIO, LT_ENOMEM.
 */
LT_API lt_status lt_torch_read(lt_arena *arena, const char *path, lt_torch_file *out);

/* lt_torch_parse - the same from n bytes in memory, which must live as long as the arena */
LT_API lt_status lt_torch_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                                lt_torch_file *out);

/* lt_torch_sniff - which container the first bytes of a file speak of. A zip archive may be an npz as
 * well; it is a checkpoint when it has an entry that ends in "/data.pkl". */
LT_API lt_torch_container lt_torch_sniff(const uint8_t *bytes, size_t n);

#ifdef __cplusplus
}
#endif
#endif
