/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures that come through standard input one behind the other, as ffmpeg -f image2pipe and GStreamer's fdsink write
 * them: PPM, PNG or JPEG, of any sizes.
 */
#ifndef PIPELINE_PIPE_H
#define PIPELINE_PIPE_H

#include "libtensor/io/image/pixels.h"

typedef struct pipe_reader pipe_reader;

/* pipe_open - stop: asked where a signal interrupts the wait for a picture; NULL: never. LT_ENOMEM */
lt_status pipe_open(bool (*stop)(void), pipe_reader **out);
void pipe_close(pipe_reader *p);

/**
 * pipe_next - the next picture, RGB of 8 bits, in the arena; *more is false when there is none
 *
 * Errors: LT_EFORMAT: a picture that cannot be read: where its end was found all the same *more is true, and the next
 * may be read; what is no picture, or ends within one. LT_ENOMEM, LT_EIO, LT_ESTOPPED.
 */
lt_status pipe_next(pipe_reader *p, lt_arena *arena, lt_image *out, bool *more);

#endif
