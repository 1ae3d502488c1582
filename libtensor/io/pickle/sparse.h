/* SPDX-License-Identifier: Apache-2.0 */
/*
 * SciPy's sparse matrices and arrays, as the pickle reader leaves them: objects, by the names of their members.
 */
#ifndef LT_IO_PICKLE_SPARSE_H
#define LT_IO_PICKLE_SPARSE_H

#include "libtensor/io/pickle/pickle.h"

enum { LT_DENSE_MAX = 1 << 22 };        /* elements of an array that a pickle only describes */

/* lt_is_sparse - an object of one of SciPy's formats: bsr, coo, csc, csr, dia, dok, lil */
bool lt_is_sparse(const lt_pvalue *v);

/* lt_sparse_dense - all its elements, in the arena; LT_EFORMAT says what is wrong with it */
lt_status lt_sparse_dense(lt_arena *arena, const lt_pvalue *v, lt_array *out);

/* lt_take_shape - a tuple, list or array of at most 8 sizes, as a shape */
bool lt_take_shape(const lt_pvalue *v, lt_array *out);

#endif
