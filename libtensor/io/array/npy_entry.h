/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What .npz needs of .npy: a reader that can say "whole, but not for us", and the header alone.
 */
#ifndef LT_IO_ARRAY_NPY_ENTRY_H
#define LT_IO_ARRAY_NPY_ENTRY_H

#include "libtensor/io/array/array.h"

/* lt_npy_parse_entry - lt_npy_parse; elements that we do not read are LT_OK with refused->reason set and out untouched,
 * otherwise that is NULL. Of Python's objects refused->pickle is where in bytes their pickle begins. */
lt_status lt_npy_parse_entry(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                             lt_array *out, lt_refused_array *refused);

/* lt_npy_describe - type and shape alone, data NULL, out of the first n bytes of `all`; LT_NPY_READ_MAX are enough */
lt_status lt_npy_describe(const char *name, const uint8_t *bytes, size_t n, size_t all, lt_array *out,
                          const char **refused);

enum { LT_NPY_READ_MAX = (1 << 16) + 12 };

enum { LT_NPY_HEADER_MAX = 512 };

/* lt_npy_header - the header of a C-ordered array into out; its length, a multiple of 64. Text is
 * described as U of text_width characters. */
size_t lt_npy_header(const lt_array *a, size_t text_width, uint8_t out[LT_NPY_HEADER_MAX]);

#endif
