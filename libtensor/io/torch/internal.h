/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of the checkpoint reader: pickle.c gives meaning to PyTorch's pickled functions,
 * zip.c, stream.c and tar.c find the bytes of storages, elements.c makes tensors of them,
 * names.c names the result.
 */
#ifndef LT_IO_TORCH_INTERNAL_H
#define LT_IO_TORCH_INTERNAL_H

#include "libtensor/io/pickle/machine.h"
#include "libtensor/io/torch/torch.h"

/* One mention of a storage. The same storage may be mentioned by many tensors. */
typedef struct lt_torch_storage lt_torch_storage;
struct lt_torch_storage {
    const char *key;
    lt_elem type;                   /* u1 where the file says only bytes, and of what is not read */
    const char *unread;             /* the class of a storage whose elements are not read; NULL: they are */
    uint64_t count;                 /* elements promised */
    uint64_t stored;                /* and how the stream counts them: an untyped storage's are bytes */
    uint64_t view_begin, view_count;        /* the part that is meant */
    size_t at;                      /* offset of the mention */
    bool used;                      /* a tensor is in it */
    const uint8_t *bytes;           /* count elements in native order; NULL until found */
    lt_torch_storage *next;
};

/* One tensor, whose elements are filled in when its storage was found. */
typedef struct lt_torch_tensor lt_torch_tensor;
struct lt_torch_tensor {
    lt_array *array;
    lt_torch_storage *storage;
    uint64_t begin;                 /* in elements, of the view */
    uint64_t stride[LT_ARRAY_MAX_RANK];
    lt_torch_tensor *next;
};

/* A file that is being read. */
typedef struct {
    lt_arena *arena;
    const char *path;
    const uint8_t *bytes;
    size_t n;
    bool big_endian;
    bool in_stream;                 /* storages stand one behind the other */
    size_t spent;                   /* of lt_pm_budget(n) */
    lt_torch_storage *storages;
    size_t n_storages;
    lt_torch_tensor *tensors;
    lt_pvalue *(*by_key)(lt_pmachine *m, const lt_pvalue *id);      /* tar: what PERSID 7 stands for */
    void *container;
} lt_torch;

/* lt_torch_pickle - the value of a pickle in bytes at *pos, which moves behind it; its mentions of
 * storages and tensors join t's lists. name is for the error line. */
lt_status lt_torch_pickle(lt_torch *t, const char *name, const uint8_t *bytes, size_t n, size_t *pos,
                          const lt_pvalue **out);

/* What LT_POWN values of this address are: tensors that are not read; own is why, a text. And how the names of the
 * functions begin that make a tensor of what was saved: an object of one is a tensor of a kind that is not read. */
extern const char lt_torch_unread[], lt_torch_makers[];

/* lt_torch_view - the elements of a tensor: shape and strides in elements, behind begin, of the storage.
 * NULL, and *array its shape, or why it cannot be. */
const char *lt_torch_view(lt_torch_storage *s, uint64_t begin, int rank, const int64_t *shape,
                          const int64_t *stride, lt_array *array, lt_torch_tensor *out);

/* lt_torch_add - one more tensor to fill */
void lt_torch_add(lt_torch *t, lt_torch_tensor *x);

/* lt_torch_type - the element type of "torch.FloatStorage" or "torch.float32"; false for those we do not read */
bool lt_torch_type(const char *dotted, lt_elem *out);

/* lt_torch_sorted - the mentions by key; NULL without memory */
lt_torch_storage **lt_torch_sorted(lt_torch *t);

/* lt_torch_alloc - memory in the arena for what is made of the file's bytes; LT_EFORMAT when that is too much of it */
lt_status lt_torch_alloc(lt_torch *t, size_t bytes, uint8_t **out);

/* lt_torch_native - n bytes of elements into this machine's order; bools become 0 or 1 */
void lt_torch_native(const lt_torch *t, uint8_t *p, size_t n, lt_elem type);

/* lt_torch_fill - give every tensor its elements, all storages having been found */
lt_status lt_torch_fill(lt_torch *t);

/* The containers: the saved value, its storages found. */
lt_status lt_torch_zip(lt_torch *t, const lt_pvalue **out);
lt_status lt_torch_stream(lt_torch *t, const lt_pvalue **out);
lt_status lt_torch_tar(lt_torch *t, const lt_pvalue **out);

/* lt_torch_names - the weights in a saved value, into out's n and entry */
lt_status lt_torch_names(lt_torch *t, const lt_pvalue *value, lt_torch_file *out);

#endif
