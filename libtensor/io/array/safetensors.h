/* SPDX-License-Identifier: Apache-2.0 */
/*
 * safetensors: named arrays behind a JSON header; our own format for weights.
 *
 * Source: huggingface/safetensors, README section "Format".
 */
#ifndef LT_IO_ARRAY_SAFETENSORS_H
#define LT_IO_ARRAY_SAFETENSORS_H

#include "libtensor/io/array/array.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const char *key, *value;
} lt_text_pair;

typedef struct {
    const char *path;               /* for error lines */
    size_t n, n_meta, n_refused;
    lt_named_array *entry;          /* in the order of their data */
    lt_refused_array *refused;      /* of dtypes that are not read: 8-bit floats among them */
    lt_text_pair *meta;             /* "__metadata__" */
} lt_safetensors;

/**
 * lt_safetensors_read - all arrays of a safetensors file
 *
 *   out      owned by the arena; touched only on success
 *
 * Errors: LT_EFORMAT: header larger than 100 MB or than the file; no JSON object; two entries of one
 * name; byte ranges that overlap, leave holes, pass the end (the file is cut) or disagree with dtype and shape; rank
 * above LT_ARRAY_MAX_RANK. LT_EIO, LT_ENOMEM.
 */
LT_API lt_status lt_safetensors_read(lt_arena *arena, const char *path, lt_safetensors *out);

/* lt_safetensors_parse - the same from n bytes in memory, which are copied; name is for error lines */
LT_API lt_status lt_safetensors_parse(lt_arena *arena, const char *name, const uint8_t *bytes,
                                      size_t n, lt_safetensors *out);

/* lt_safetensors_find - the array of that name, or NULL; borrowed from the arena */
LT_API const lt_array *lt_safetensors_find(const lt_safetensors *s, const char *name);

/* lt_safetensors_meta - the metadata text under key, or NULL; borrowed from the arena */
LT_API const char *lt_safetensors_meta(const lt_safetensors *s, const char *key);

/**
 * lt_safetensors_write - n arrays and a text map, atomically
 *
 *   entry    written in this order, straight from their data; names are unique UTF-8
 *   meta     n_meta pairs, unique keys; may be NULL when there are none
 *
 * The data starts at a multiple of 64 bytes, padded with spaces. The same input gives the same bytes.
 * Errors: LT_EINVAL (a text array; two entries of one name; "__metadata__" as a name), and those of
 * lt_atomic_commit.
 */
LT_API lt_status lt_safetensors_write(const char *path, const lt_named_array *entry, size_t n,
                                      const lt_text_pair *meta, size_t n_meta);

#ifdef __cplusplus
}
#endif
#endif
