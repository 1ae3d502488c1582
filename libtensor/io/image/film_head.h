/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a film's file says beside its frames: which way up they are shown.
 */
#ifndef LT_IO_IMAGE_FILM_HEAD_H
#define LT_IO_IMAGE_FILM_HEAD_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int orientation;            /* of the frames as they are stored, 1 upright .. 8 as EXIF has it; 1 where the file
                                 * does not say, or names an angle that is no quarter turn */
    int64_t want_bytes;         /* more than the file has, where it is cut off; else 0 */
} lt_film_head;

/**
 * lt_film_head_read - from an MP4 or QuickTime film, or a Matroska or WebM one
 *
 * Never fails: what is missing, damaged or in a film of another kind reads as upright and whole. A film's first track
 * of pictures counts. What the head holds is skipped over, not read: this is quick for a film of any length.
 *
 * Source: ISO/IEC 14496-12, 6.2.2 (the matrix), 8.2.2, 8.3.2, 8.4.3; RFC 9559, 5.1.4.1.28.41 (projection).
 */
lt_film_head lt_film_head_read(const char *path);

#ifdef __cplusplus
}
#endif
#endif
