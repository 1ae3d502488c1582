/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parameters beside the arrays of a file: as such, and out of such.
 */
#ifndef ESTIMATE_PARAM_ARRAYS_H
#define ESTIMATE_PARAM_ARRAYS_H

#include "libtensor/graph/param.h"
#include "libtensor/io/array/array.h"

/* reals_array - reals of this shape as an array, which borrows them */
lt_array reals_array(const lt_shape *shape, const lt_real *data);

/* param_arrays - all of a set in its order, *n of them, with room for so many more behind; NULL without memory */
lt_named_array *param_arrays(lt_arena *arena, const lt_params *set, size_t more, size_t *n);

/* array_fits - numbers, of this shape, or of it behind more dimensions of 1: a token (1, 1, C) is one of (C) */
bool array_fits(const lt_array *a, const lt_shape *shape);

/* array_check - LT_EINVAL where an array of a file does not fit what the model calls name; the line has both shapes */
lt_status array_check(const char *path, const char *array, const lt_array *a, const char *name,
                      const lt_shape *shape);

/* array_load - the elements of an array that fits */
void array_load(const lt_array *a, lt_real *out);

#endif
