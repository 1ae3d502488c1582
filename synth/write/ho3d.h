/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes frames as an HO3D v3 tree has them (or v2: png images), in its axes, orders and keys.
 *
 * Everything handed in is in our convention: OpenCV camera axes, metres; only the files have OpenGL's.
 */
#ifndef SYNTH_WRITE_HO3D_H
#define SYNTH_WRITE_HO3D_H

#include "synth/take/picture.h"
#include "synth/write/file.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * synth_write_picture - rgb, depth, seg and meta of one frame under root
 *
 *   png      version 2: the colour image as PNG in place of JPEG of the given quality, its colours in the mask
 *   files    what was written, SYNTH_FRAME_FILES of them
 *
 * The folders must be there: synth_make_sequence. May run on many threads for different frames.
 */
lt_status synth_write_picture(const char *root, const synth_picture *p, bool png, int quality,
                              synth_file *files);

/* synth_make_sequence - root/split/sequence/{rgb,depth,meta,seg} */
lt_status synth_make_sequence(const char *root, const char *sequence, bool evaluation);

#ifdef __cplusplus
}
#endif
#endif
