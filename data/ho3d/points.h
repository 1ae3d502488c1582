/* SPDX-License-Identifier: Apache-2.0 */
/*
 * HO3D's files of points as streams: evaluation_xyz.json, evaluation_verts.json, pred.json, pred.zip. They are up to
 * a gigabyte of text; reading them takes one frame and a block of text at a time.
 */
#ifndef DATA_HO3D_POINTS_H
#define DATA_HO3D_POINTS_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ho3d_points ho3d_points;

enum { HO3D_MOST_POINTS = 20000 };                  /* of a frame in a list that may have any number */

/**
 * ho3d_points_open - begin to read a file
 *
 *   path     JSON, or a zip archive with pred.json in it; its first bytes tell
 *   points   (lists) of a frame of each list: { 21, 778 } for predictions, { 21 } for evaluation_xyz.json
 *   lists    1: the file is a list of frames; 2: it is a list of two such lists
 *
 * In an archive pred.json may lie in a folder, and the only JSON file may have another name, which ho3d_points_note
 * says. End with ho3d_points_close. Errors: LT_EIO, LT_EFORMAT (an archive without such a file or with several; what is
 * neither JSON nor zip), LT_ENOMEM.
 */
lt_status ho3d_points_open(const char *path, const int *points, int lists, ho3d_points **out);

/**
 * ho3d_points_any - take what people hand in for predictions, as the official script does or nearly so
 *
 * Frames of the last list may have another number of points than was said, all the same and at most HO3D_MOST_POINTS;
 * the list may be empty, null or missing, and the file be the first list alone. Before the first ho3d_points_next.
 */
void ho3d_points_any(ho3d_points *p);

/* ho3d_points_of - how many points the frames of a list have: as was said, until a frame of it was read */
int ho3d_points_of(const ho3d_points *p, int list);

/* ho3d_points_note - what is odd about the file though it is read, a sentence; NULL: nothing. As long as p. */
const char *ho3d_points_note(const ho3d_points *p);

/**
 * ho3d_points_next - the next frame of the list that is being read
 *
 *   out      (points, 3) as in the file; after ho3d_points_any room for HO3D_MOST_POINTS
 *   more     false: the list has ended and out is untouched; the next call begins the next list
 *
 * After the last list's end the rest of the file has been looked at as well. Errors: LT_EFORMAT with frame, joint or
 * vertex, and axis: not that shape, not a number below 10 km; NaN and infinities are read as Python's json writes them
 * and refused as such; those of reading.
 */
lt_status ho3d_points_next(ho3d_points *p, float *out, bool *more);

void ho3d_points_close(ho3d_points *p);             /* NULL is fine */

#ifdef __cplusplus
}
#endif
#endif
