/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of this folder share. */
#ifndef DATA_TRANSFORMS_INTERNAL_H
#define DATA_TRANSFORMS_INTERNAL_H

#include "data/transforms/transforms.h"

#include <cjson/cJSON.h>

/* transforms_lens_read - a frame's keys, and the file's where the frame has none; where: "FILE: frame 3" */
lt_status transforms_lens_read(const char *where, const cJSON *file, const cJSON *frame, transforms_lens *out);

/* transforms_hold_out - which views of a file are held out, by its lists of names or every holdout-th by name */
lt_status transforms_hold_out(const cJSON *file, int holdout, transforms_set *s);

/* transforms_points - those of the file that ply_file_path names; none where there is no such key */
lt_status transforms_points(lt_arena *arena, const char *folder, const cJSON *file, transforms_set *s);

/* transforms_camera - of a picture of this size. Errors: another shape than the file says. */
lt_status transforms_camera(const transforms_view *v, int width, int height, lt_camera *out);

#endif
