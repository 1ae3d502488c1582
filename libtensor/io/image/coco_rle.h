/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Masks as COCO writes them: lengths of runs down the columns, zeros first, packed into printable characters.
 *
 * Source: ppwwyyxx/cocoapi common/maskApi.c (rleToString, rleFrString).
 */
#ifndef LT_IO_IMAGE_COCO_RLE_H
#define LT_IO_IMAGE_COCO_RLE_H

#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_rle_encode - mask (height, width), row-major, 0 or not, as text in the arena; NULL without memory */
LT_API const char *lt_rle_encode(lt_arena *arena, const uint8_t *mask, int height, int width);

/* lt_rle_of_runs - the text of n runs, none of them negative or above 2^31, zeros first; NULL without memory */
LT_API const char *lt_rle_of_runs(lt_arena *arena, const int64_t *run, size_t n);

/**
 * lt_rle_decode - the mask of a text, into height * width bytes of 0 and 1
 *
 * Errors: LT_EFORMAT: a character that is none, a run that is negative or too long, runs that do not add up
 * to height * width.
 */
LT_API lt_status lt_rle_decode(const char *text, int height, int width, uint8_t *mask);

#ifdef __cplusplus
}
#endif
#endif
