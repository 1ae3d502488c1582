/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An n-dimensional array as files hold it: any element type, C order, native byte order.
 */
#ifndef LT_IO_ARRAY_ARRAY_H
#define LT_IO_ARRAY_ARRAY_H

#include "libtensor/base/arena.h"
#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_ARRAY_MAX_RANK = 8 };

/* Element types, in NumPy's words; the digit is the size in bytes. */
typedef enum {
    LT_ELEM_F4, LT_ELEM_F8,
    LT_ELEM_F2, LT_ELEM_BF16,               /* 16 bits; held as uint16_t */
    LT_ELEM_I1, LT_ELEM_I2, LT_ELEM_I4, LT_ELEM_I8,
    LT_ELEM_U1, LT_ELEM_U2, LT_ELEM_U4, LT_ELEM_U8,
    LT_ELEM_BOOL,                           /* one byte, 0 or 1 */
    LT_ELEM_TEXT,                           /* const char *, UTF-8; from NumPy's S and U */
    LT_ELEM_COUNT
} lt_elem;

/* Outermost dimension first, the last one contiguous. Rank 0 is one element. */
typedef struct {
    lt_elem type;
    int rank;
    int64_t shape[LT_ARRAY_MAX_RANK];
    void *data;                             /* belongs to whoever made the array, mostly an arena */
} lt_array;

typedef struct {
    const char *name;
    lt_array array;
} lt_named_array;

/* One that is in a file and whole, but not read, as its elements are of a type that nothing here has a use for; the
 * rest of the file is none the worse for it. */
typedef struct {
    const char *name, *reason;
    const uint8_t *pickle;                  /* of a .npy of Python's objects: n bytes, a pickle; else NULL */
    size_t n;
} lt_refused_array;

/* lt_refused_find - why the array of that name was not read, or NULL */
LT_API const lt_refused_array *lt_refused_find(const lt_refused_array *list, size_t n, const char *name);

/* lt_elem_size - bytes of one element; lt_elem_name - "f4", "bf16", "bool", "text" */
LT_API size_t lt_elem_size(lt_elem type);
LT_API const char *lt_elem_name(lt_elem type);

/* lt_array_make - a description of data that the caller owns; rank <= LT_ARRAY_MAX_RANK */
LT_API lt_array lt_array_make(lt_elem type, int rank, const int64_t *shape, const void *data);

/* lt_array_count - number of elements; 1 for rank 0. Never overflows for an array that we read. */
LT_API size_t lt_array_count(const lt_array *a);

/* lt_array_bytes - count * size into *out, or false when a dimension is negative or it overflows */
LT_API bool lt_array_bytes(const lt_array *a, size_t *out);

/* lt_array_get - element i in C order as a double; an 8-byte integer is rounded; not for text */
LT_API double lt_array_get(const lt_array *a, size_t i);

/* lt_array_int - element i as an integer, exact for the integer types; floats are cut towards 0, and
 * what does not fit (NaN, 1e300, a u8 above 2^63 - 1) gives INT64_MIN */
LT_API int64_t lt_array_int(const lt_array *a, size_t i);

/* lt_array_text - element i of a text array, NUL-terminated; NULL for any other type */
LT_API const char *lt_array_text(const lt_array *a, size_t i);

/* lt_array_to_float - elements [0, n) into out; n is at most lt_array_count; not for text */
LT_API void lt_array_to_float(const lt_array *a, float *out, size_t n);

/* lt_array_has_shape - same rank and dimensions; a wanted -1 matches any */
LT_API bool lt_array_has_shape(const lt_array *a, int rank, const int64_t *shape);

/* lt_array_shape_text - "(778, 3)" into out, cut at n bytes; returns out, for use in an error line */
LT_API const char *lt_array_shape_text(const lt_array *a, char *out, size_t n);

/* lt_f16_to_f32, lt_bf16_to_f32 - exact; lt_f32_to_f16, lt_f32_to_bf16 - to nearest, ties to even */
LT_API float lt_f16_to_f32(uint16_t h);
LT_API float lt_bf16_to_f32(uint16_t h);
LT_API uint16_t lt_f32_to_f16(float x);
LT_API uint16_t lt_f32_to_bf16(float x);

#ifdef __cplusplus
}
#endif
#endif
