/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes poses of objects as BOP has them: a scene for each camera, and the models. Lengths there are millimetres, and
 * a model's origin is the centre of its box in the table of assets/ycb.
 *
 *   models/obj_000004.ply, models_info.json
 *   SPLIT/000001/scene_camera.json, scene_gt.json, scene_gt_info.json
 *
 * Source: Hodan et al., BOP toolkit, docs/bop_datasets_format.md, and scripts/calc_gt_info.py for what is counted.
 */
#ifndef SYNTH_WRITE_BOP_H
#define SYNTH_WRITE_BOP_H

#include "synth/world/seen.h"
#include "synth/write/growing.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SYNTH_BOP_OBJECTS = 8 };                 /* of an image */

typedef struct {
    int id;                                     /* YCB number */
    double R[9], t[3];                          /* x_cam = R x_model + t, metres, the frame of assets/ycb/ycb.h */
    int64_t whole;                              /* pixels of it alone, those past the picture's border too */
    int64_t measured;                           /* of these in the picture, with a depth */
    int64_t visible;
    synth_pixels whole_box, box;                /* around whole and visible */
} synth_bop_object;

typedef struct {
    int number;                                 /* of its files */
    synth_camera camera;
    double depth_step;                          /* metres of a step of its depth */
    int n;
    synth_bop_object object[SYNTH_BOP_OBJECTS];
} synth_bop_image;

typedef struct {
    synth_growing camera, poses, counts;
    int64_t n;
} synth_bop_scene;

/* synth_bop_open - begin a scene; synth_bop_fini frees it in any case. LT_ENOMEM. */
lt_status synth_bop_open(synth_bop_scene *s);
void synth_bop_fini(synth_bop_scene *s);

/* synth_bop_add - one more image */
void synth_bop_add(synth_bop_scene *s, const synth_bop_image *image);

/* synth_bop_close - write the scene's three files into the folder root/within, which is there */
lt_status synth_bop_close(synth_bop_scene *s, const char *root, const char *within, synth_manifest *manifest);

/* A model as it is here: metres, with a texture (SYNTH_TEXTURE a side, top row first). */
typedef struct {
    int id;
    const lt_mesh *mesh;
    const uint8_t (*rgb)[3];
} synth_bop_model;

/**
 * synth_bop_models - write n models, each with the colours of its texture at the vertices, and what is known of them
 *
 *   within   the folder, which is there
 *
 * One that is listed twice is written once. Symmetries are those of ycb_symmetries. Errors: LT_EIO, LT_ENOSPC,
 * LT_ENOMEM.
 */
lt_status synth_bop_models(const synth_bop_model *model, int n, const char *root, const char *within,
                           synth_manifest *manifest);

#ifdef __cplusplus
}
#endif
#endif
