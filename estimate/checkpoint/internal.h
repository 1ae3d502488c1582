/* SPDX-License-Identifier: Apache-2.0 */
/* What writing and reading a checkpoint share. */
#ifndef ESTIMATE_CHECKPOINT_INTERNAL_H
#define ESTIMATE_CHECKPOINT_INTERNAL_H

#include "estimate/checkpoint/checkpoint.h"
#include "libtensor/io/array/safetensors.h"

#define CHECKPOINT_FORMAT "palmar-checkpoint"

/* checkpoint_crc - one flipped bit anywhere changes it; the metadata's own "crc32" is left out */
uint32_t checkpoint_crc(const lt_named_array *entry, size_t n, const lt_text_pair *meta, size_t n_meta);

/* checkpoint_read_file - a file whose format, version and check sum are right. Errors: those of reading; LT_EFORMAT for
 * one that is damaged or no checkpoint; LT_EINVAL for one of a later version. */
lt_status checkpoint_read_file(lt_arena *arena, const char *path, lt_safetensors *f);

#endif
