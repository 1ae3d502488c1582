/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Films, frame by frame, through OpenCV where it was built in.
 */
#ifndef LT_IO_IMAGE_FILM_H
#define LT_IO_IMAGE_FILM_H

#include "libtensor/io/image/pixels.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lt_film lt_film;

/**
 * lt_film_open - a film of any kind that OpenCV reads: mp4, avi, mov, mkv, webm
 *
 * OpenCV's module is looked for as lt_image_read does. Which way is up is read from MP4, QuickTime, Matroska and WebM
 * ourselves: releases of OpenCV differ in it. Errors: LT_EIO: no such file, or no regular one; LT_EFORMAT: not a film,
 * cut off, or no OpenCV; LT_ENOMEM.
 */
LT_API lt_status lt_film_open(const char *path, lt_film **out);
LT_API void lt_film_close(lt_film *film);

/* lt_film_open_camera - camera number `number` of this machine (/dev/video0 ...), as a film that ends when it is
 * unplugged; each frame is waited for. Errors: LT_EIO: no camera answers; LT_EFORMAT: no OpenCV; LT_ENOMEM. */
LT_API lt_status lt_film_open_camera(int number, lt_film **out);

/* lt_film_fps - frames per second as the film says; 0 where it does not */
LT_API double lt_film_fps(const lt_film *film);

/* lt_film_frames - how many frames the film says it has; 0 where it does not. It may be off by some. */
LT_API int64_t lt_film_frames(const lt_film *film);

/* lt_film_orientation - how its frames are stored, as EXIF has it (lt_exif_turn): 1 upright, 6 as a phone held upright
 * stores them */
LT_API int lt_film_orientation(const lt_film *film);

/**
 * lt_film_next - the next frame, RGB of 8 bits, turned upright, in the arena; *more is false when there is none
 *
 * A film that breaks off ends there: OpenCV does not tell the two apart, but lt_film_frames may.
 * Errors: LT_EFORMAT: beyond the limits of lt_image_read; LT_ENOMEM.
 */
LT_API lt_status lt_film_next(lt_film *film, lt_arena *arena, lt_image *out, bool *more);

/* A film to write, also through OpenCV */
typedef struct lt_film_writer lt_film_writer;

/**
 * lt_film_create - a film of frames of one size, by the ending of its name: mp4
 *
 *   out      ends in lt_film_finish or lt_film_abort, exactly one of them
 *
 * H.264, or MPEG-4 where FFmpeg has no encoder for that. The last column and row of odd sizes are left out. Until it is
 * finished it has another name (lt_atomic_open_named), and what is at path stays.
 * Errors: LT_EIO: it cannot be written there; LT_EFORMAT: no OpenCV; LT_ENOMEM.
 */
LT_API lt_status lt_film_create(const char *path, int width, int height, double fps, lt_film_writer **out);

/* lt_film_put - one more frame, RGB of 8 bits. Errors: LT_EINVAL: of another size; LT_EIO.
 * lt_film_finish - the end of it: it is at its path. Errors: those of lt_atomic_commit, which change nothing.
 * lt_film_abort - nothing of it stays; of NULL nothing */
LT_API lt_status lt_film_put(lt_film_writer *film, const lt_image *frame);
LT_API lt_status lt_film_finish(lt_film_writer *film);
LT_API void lt_film_abort(lt_film_writer *film);

#ifdef __cplusplus
}
#endif
#endif
