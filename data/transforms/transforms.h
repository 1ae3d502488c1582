/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Photos of one still scene with their cameras: a folder with transforms.json, or with transforms_train.json and
 * transforms_test.json (or _val).
 *
 * The world and its scale are left as the file has them. Cameras become ours (x right, y down, z forward; a pixel's
 * centre has integer coordinates), from OpenGL's with principal points that count from the image's edge.
 *
 * Source: nerfstudio-project/nerfstudio docs/quickstart/data_conventions.md.
 */
#ifndef DATA_TRANSFORMS_TRANSFORMS_H
#define DATA_TRANSFORMS_TRANSFORMS_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/lens.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { TRANSFORMS_MOST_VIEWS = 100000 };

/* What the keys of a frame, or of its file, say of a camera; 0: they do not say it */
typedef struct {
    double fl_x, fl_y, cx, cy, w, h;        /* pixels; cx, cy from the image's edge */
    double angle_x, angle_y;                /* fields of view, radians */
    lt_lens lens;
} transforms_lens;

typedef struct {
    const char *name;                       /* file_path, as the file has it */
    const char *image, *mask;               /* paths; mask: or NULL */
    transforms_lens lens;
    double R_cam_world[9], t_cam_world[3];
    bool held_out;
} transforms_view;

typedef struct {
    const char *path;                       /* of the json file, the first of two */
    int n, n_held_out;
    transforms_view *view;                  /* (n) */
    int n_points;                           /* 0: the file names none */
    float (*point)[3], (*colour)[3];        /* (n_points) in the world; colours 0 .. 1, NULL: they have none */
    bool synthetic;                         /* a manifest beside it says so */
} transforms_set;

/**
 * transforms_open - the cameras of a folder, or of the json file at path
 *
 *   holdout  where the files do not say which views are held out: of those sorted by name every so many-th
 *
 * Pictures are looked for, not read. Everything is in the arena. Errors: LT_EFORMAT with file and frame: no frames, a
 * matrix that turns and scales, a lens that is none of ours (fisheye), no focal length, a picture that is not there, a
 * path that leaves the folder, masks of some frames alone, no view that is left to learn from; those of lt_json_read
 * and lt_ply_read.
 */
lt_status transforms_open(lt_arena *arena, const char *path, int holdout, transforms_set *out);

/* A view as a pinhole camera took it */
typedef struct {
    int width, height;
    lt_camera camera;
    uint8_t *rgb;                           /* (height, width, 3) */
    uint8_t *mask;                          /* (height, width) 0 or 255; NULL: there is none */
} transforms_picture;

/**
 * transforms_read - the picture of a view, made `downscale` times smaller by means of squares, without distortion
 *
 *   white    what an image with an alpha channel, which then is its mask, lies over; off: black
 *
 * A picture of another size than the file says is fine where it has the same shape: the camera is scaled. Errors:
 * LT_EFORMAT: another shape, a mask of another size, smaller than downscale; those of lt_image_read.
 */
lt_status transforms_read(lt_arena *arena, const transforms_view *v, int downscale, bool white,
                          transforms_picture *out);

#ifdef __cplusplus
}
#endif
#endif
