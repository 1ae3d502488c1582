/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the parts of the HO3D reader share.
 */
#ifndef DATA_HO3D_INTERNAL_H
#define DATA_HO3D_INTERNAL_H

#include "data/ho3d/ho3d.h"

#include <pthread.h>

/* Which channels of a mask are hand and object, and where the joints of some hands lie in these colours. */
typedef struct {
    bool known;
    int hand, object;
    int64_t joints_on_hand, joints_on_object;
} ho3d_mask_colours;

typedef struct {
    pthread_mutex_t lock;           /* several threads read samples */
    ho3d_mask_colours colours;
} ho3d_masks;

typedef struct {
    dataset base;                   /* first: a dataset * is a ho3d * */
    lt_arena *arena;                /* of everything, this struct included */
    const char *models;
    const char **name;              /* base.count of them, "ABF10/0123" */
    bool evaluation;
    int width, height;              /* of the pictures: 640 x 480, unless a manifest of ours says otherwise */
    int version;                    /* 2: the colour images are PNG; 3: JPEG */
    ho3d_masks masks;
    const float *xyz, *vertices;    /* ground truth of the evaluation: our axes, MANO order; or NULL */
} ho3d;

/* ho3d_picture - "train/ABF10/rgb/0123.png" of a sample and a kind ("rgb", "depth", "seg"), with the ending that is
 * there; ho3d_meta_path - of its annotation. NULL without memory */
const char *ho3d_picture(const ho3d *h, int64_t index, lt_arena *arena, const char *kind);
const char *ho3d_meta_path(const ho3d *h, int64_t index, lt_arena *arena);

/* ho3d_from_gl - from OpenGL axes: y and z change their sign. out may be in. */
static inline void ho3d_from_gl(const float in[3], float out[3])
{
    out[0] = in[0];
    out[1] = -in[1];
    out[2] = -in[2];
}

/* ho3d_read_segments - the mask of a sample whose size is known. Not every copy of the data has masks: without one, the
 * sample has no segments. Errors: a broken mask; masks whose object is where the hands are. */
lt_status ho3d_read_segments(const ho3d *h, int64_t index, lt_arena *arena, dataset_sample *s);

/* ho3d_read_meta - a sample's annotation: camera, hand or wrist, object */
lt_status ho3d_read_meta(const ho3d *h, int64_t index, lt_arena *arena, dataset_sample *s);

/* ho3d_read_sample, ho3d_read_annotation - read and annotation of dataset_ops */
lt_status ho3d_read_sample(const dataset *d, int64_t index, unsigned want, lt_arena *arena, dataset_sample *out);
lt_status ho3d_read_annotation(const dataset *d, int64_t index, lt_arena *arena, dataset_sample *out);

#endif
