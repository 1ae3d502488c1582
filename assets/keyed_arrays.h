/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Named arrays out of whatever people keep them in, for models of hands and bodies: found by key, held against the
 * shape wanted before they are read, checked number by number.
 */
#ifndef ASSETS_KEYED_ARRAYS_H
#define ASSETS_KEYED_ARRAYS_H

#include "libtensor/io/array/npz.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/pickle/pickle.h"

/* A dict, or else arrays, of which those of an .npz are read when they are asked for. */
typedef struct keyed {
    lt_arena *arena;                    /* where all of it lives, and arrays are made */
    const char *path;                   /* for error lines */
    lt_kind kind;                       /* of the file */
    const uint8_t *bytes;               /* n of them */
    size_t n;
    const lt_pvalue *dict;
    lt_npz npz;                         /* or the arrays of a safetensors file */
} keyed;

/**
 * keyed_open - read path, whose first bytes tell the format; all of it lives in the arena
 *
 * An .npz, also one of object arrays, as numpy.savez(**dict) leaves them; a pickled dict; a .npy of one, as numpy.save
 * leaves it; a dict of tensors that torch.save wrote; safetensors.
 * Errors: LT_EFORMAT: another kind of file, or a damaged one; LT_EIO, LT_ENOMEM.
 */
lt_status keyed_open(lt_arena *arena, const char *path, keyed *out);

/* keyed_has - false, and no error, when the key is not there */
bool keyed_has(const keyed *k, const char *key);

/* keyed_text - the text under key, or NULL */
const char *keyed_text(const keyed *k, const char *key);

/* keyed_value - what is under key where that is an object of Python's, in an .npz too; *out is NULL where it is none */
lt_status keyed_value(const keyed *k, const char *key, const lt_pvalue **out);

/* keyed_get - the numbers under key, of exactly this shape; -1 matches any */
lt_status keyed_get(const keyed *k, const char *key, int rank, const int64_t *shape, lt_array *out);

/* keyed_floats - the same into out, all of them finite; keyed_faces - into (n, 3), each index below
 * n_vertices */
lt_status keyed_floats(const keyed *k, const char *key, int rank, const int64_t *shape, float *out);
lt_status keyed_faces(const keyed *k, const char *key, int n, int n_vertices, int32_t (*out)[3]);

/* keyed_sums - n rows of weights sum to 1; rows are width long */
lt_status keyed_sums(const keyed *k, const char *key, const float *weights, int n, int width);

#endif
