/* SPDX-License-Identifier: Apache-2.0 */
/*
 * NumPy's .npz: a zip archive of .npy files.
 */
#ifndef LT_IO_ARRAY_NPZ_H
#define LT_IO_ARRAY_NPZ_H

#include "libtensor/io/array/array.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const char *path;               /* for error lines */
    size_t n, n_refused;
    lt_named_array *entry;          /* names without ".npy", in the order of the archive */
    lt_refused_array *refused;      /* of Python's objects, complex numbers and the like */
} lt_npz;

/**
 * lt_npz_read - all arrays of a .npz file
 *
 *   out      owned by the arena; touched only on success
 *
 * Every entry's checksum is verified. Sizes are checked before anything is unpacked: an entry may hold
 * at most 1032 bytes for each packed byte, which is what deflate can do, and all of them together
 * LT_FILE_MAX. One entry with elements that we do not read does not spoil the rest.
 *
 * Errors: LT_EFORMAT: not a zip archive, damaged, encrypted, packed in another way than stored or
 * deflate, two entries of one name, an entry that is no .npy array. LT_EIO, LT_ENOMEM.
 */
LT_API lt_status lt_npz_read(lt_arena *arena, const char *path, lt_npz *out);

/* lt_npz_read_only - the same for some of them: n names; what is not named is not unpacked, and a name that
 * is not there is left to lt_npz_get */
LT_API lt_status lt_npz_read_only(lt_arena *arena, const char *path, const char *const *names, size_t n,
                                  lt_npz *out);

/* lt_npz_parse - the same from n bytes in memory; name is for the error line */
LT_API lt_status lt_npz_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                              lt_npz *out);

/* lt_npz_parse_list - what is in it without its elements, whose data are NULL: no more is held in memory than a header,
 * however large the arrays are. lt_npz_parse_one - only the array of this name, if it is there */
LT_API lt_status lt_npz_parse_list(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_npz *out);
LT_API lt_status lt_npz_parse_one(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, const char *array,
                                  lt_npz *out);

/* lt_npz_find - the array of that name, or NULL; borrowed from the arena of npz */
LT_API const lt_array *lt_npz_find(const lt_npz *npz, const char *name);

/* lt_npz_get - the same, with a line that names the file and the key when it is missing or refused */
LT_API lt_status lt_npz_get(const lt_npz *npz, const char *name, const lt_array **out);

/**
 * lt_npz_write - n arrays as a .npz file, atomically
 *
 *   deflate  packed; otherwise stored
 *
 * Text arrays are written as NumPy's U. The same arrays give the same bytes: every entry is dated
 * 1980-01-01.
 * Errors: LT_EINVAL (no arrays; a bf16 array, which NumPy has no name for; two arrays of one name; a
 * name that is not made of letters, digits and "_.-/"), and those of lt_atomic_commit.
 */
LT_API lt_status lt_npz_write(const char *path, const lt_named_array *entry, size_t n, bool deflate);

#ifdef __cplusplus
}
#endif
#endif
