/* SPDX-License-Identifier: Apache-2.0 */
/*
 * NumPy's .npy: one array in a file.
 *
 * Source: NumPy enhancement proposal 1 and numpy.lib.format, versions 1.0, 2.0 and 3.0.
 */
#ifndef LT_IO_ARRAY_NPY_H
#define LT_IO_ARRAY_NPY_H

#include "libtensor/io/array/array.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_npy_read - the array of a .npy file
 *
 *   out      data in the arena; touched only on success
 *
 * Both byte orders and both index orders are read; the result is native and C-ordered. NumPy's S and U
 * become LT_ELEM_TEXT. Bytes after the data are ignored, as NumPy ignores them.
 *
 * Errors: LT_EFORMAT: not a .npy file; a header that is no literal dict of descr, fortran_order and
 * shape; objects, structures and complex numbers; rank above LT_ARRAY_MAX_RANK; fewer bytes than the
 * shape promises. LT_EIO, LT_ENOMEM.
 */
LT_API lt_status lt_npy_read(lt_arena *arena, const char *path, lt_array *out);

/* lt_npy_parse - the same from n bytes in memory, which are copied; name is for the error line */
LT_API lt_status lt_npy_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                              lt_array *out);

/* lt_npy_write - version 1.0, native byte order, C order, atomically; not for bf16 and text */
LT_API lt_status lt_npy_write(const char *path, const lt_array *a);

#ifdef __cplusplus
}
#endif
#endif
