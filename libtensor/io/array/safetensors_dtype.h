/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What safetensors calls the element types.
 */
#ifndef LT_IO_ARRAY_SAFETENSORS_DTYPE_H
#define LT_IO_ARRAY_SAFETENSORS_DTYPE_H

#include "libtensor/io/array/array.h"

/* "F32" and so on by lt_elem; NULL for those that it has no name for */
extern const char *const lt_safetensors_dtype[LT_ELEM_COUNT];

#endif
