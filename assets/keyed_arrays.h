/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Named arrays out of a .npz or a pickled dict, for models of hands and bodies: found by key, held against the
 * shape wanted, checked number by number.
 */
#ifndef ASSETS_KEYED_ARRAYS_H
#define ASSETS_KEYED_ARRAYS_H

#include "libtensor/io/array/npz.h"
#include "libtensor/io/pickle/pickle.h"

/* Exactly one of npz.path and dict is there. */
typedef struct {
    lt_arena *arena;                    /* where arrays are made */
    const char *path;                   /* for error lines */
    lt_npz npz;
    const lt_pvalue *dict;
} keyed;

/* keyed_open - read path, whose first bytes tell the format; all of it lives in the arena */
lt_status keyed_open(lt_arena *arena, const char *path, keyed *out);

/* keyed_has - false, and no error, when the key is not there */
bool keyed_has(const keyed *k, const char *key);

/* keyed_text - the text under key, or NULL */
const char *keyed_text(const keyed *k, const char *key);

/* keyed_get - the numbers under key, of exactly this shape; -1 matches any */
lt_status keyed_get(const keyed *k, const char *key, int rank, const int64_t *shape, lt_array *out);

/* keyed_floats - the same into out, all of them finite; keyed_faces - into (n, 3), each index below
 * n_vertices */
lt_status keyed_floats(const keyed *k, const char *key, int rank, const int64_t *shape, float *out);
lt_status keyed_faces(const keyed *k, const char *key, int n, int n_vertices, int32_t (*out)[3]);

/* keyed_sums - n rows of weights sum to 1; rows are width long */
lt_status keyed_sums(const keyed *k, const char *key, const float *weights, int n, int width);

#endif
