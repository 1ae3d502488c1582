/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The array that a pickled value stands for: NumPy's own, chumpy's expressions, SciPy's sparse matrices.
 */
#ifndef LT_IO_PICKLE_DENSE_H
#define LT_IO_PICKLE_DENSE_H

#include "libtensor/io/pickle/pickle.h"

/* lt_pickle_dense - v as an array, in the arena or borrowed from v; LT_EFORMAT when it is none, or has
 * an index out of range; expressions may nest 16 deep */
lt_status lt_pickle_dense(lt_arena *arena, const lt_pvalue *v, lt_array *out);

#endif
