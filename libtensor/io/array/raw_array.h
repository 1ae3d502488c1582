/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From the bytes in a .npy file or a pickle to an lt_array: NumPy's type codes, byte and index order.
 */
#ifndef LT_IO_ARRAY_RAW_ARRAY_H
#define LT_IO_ARRAY_RAW_ARRAY_H

#include "libtensor/io/array/array.h"

/* How an array's bytes lie in a file. */
typedef struct {
    lt_elem type;
    size_t width;                   /* bytes of an element; of text: all its characters */
    bool unicode;                   /* text of 4-byte characters (U), not of bytes (S) */
    bool objects;                   /* of Python's, which are refused: a pickle follows */
    bool swap;                      /* the other byte order */
    bool fortran;                   /* the first index runs fastest */
    int rank;
    int64_t shape[LT_ARRAY_MAX_RANK];
} lt_raw_array;

/* lt_raw_type - take type and width from n bytes such as "f4"; NULL, or why it cannot be read */
const char *lt_raw_type(lt_raw_array *raw, const char *code, size_t n);

/* lt_raw_order - take one of "<>=|"; false for anything else */
bool lt_raw_order(lt_raw_array *raw, char order);

/* lt_raw_bytes - what the elements take in the file, or false when it is absurd */
bool lt_raw_bytes(const lt_raw_array *raw, size_t *out);

/* lt_swap_bytes - the other byte order, in place, of n bytes of elements of so many bytes each */
void lt_swap_bytes(uint8_t *p, size_t n, size_t size);

/* lt_copy_strided - elements of so many bytes, side by side in C order, out of memory where those next to each other
 * along dimension d are stride[d] elements apart; the memories do not overlap */
void lt_copy_strided(uint8_t *to, const uint8_t *from, size_t size, int rank, const int64_t *shape,
                     const uint64_t *stride);

/* lt_raw_load - lt_raw_bytes of bytes as an array in the arena; LT_ENOMEM, or LT_EFORMAT for a
 * character beyond Unicode */
lt_status lt_raw_load(lt_arena *arena, const lt_raw_array *raw, const uint8_t *bytes, lt_array *out);

#endif
