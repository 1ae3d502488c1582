/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Batches for estimators that look at one crop with a hand and an object: the sample preparation from an
 * image and its annotation to the arrays that the network and the losses take.
 *
 * Source: Semi-Hand-Object and HFL-Net, dataset/ho3d.py and dataset/dex_ycb_object_test.py; Bandi and Thomas 2025,
 * section 4.
 */
#ifndef DATA_HAND_OBJECT_H
#define DATA_HAND_OBJECT_H

#include "data/dataset.h"
#include "data/loader.h"
#include "vision/augment.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where the crop's window comes from, and what the batch's boxes are. */
typedef enum {
    HAND_OBJECT_BOXES,              /* around enlarged boxes of hand and object, jittered; to pool from */
    HAND_OBJECT_UNION,              /* around all points of both and 15 pixels, in training 10 to 20 on each
                                     * side alone; sampled between pixels, ImageNet's mean colour outside; both
                                     * boxes are the crop */
} hand_object_crop;

typedef struct {
    hand_object_crop crop;
    bool depth;                     /* read it and fill it in */
    int size;                       /* side of the crop in pixels; 256 in the paper */
    int cells;                      /* side of the object mask; 32, the size of the pooled features */
    uint64_t seed;                  /* of all augmentation */
    bool augment;                   /* training: jitter, rotation, colour. Off: the test crop */
    double centre_jitter;           /* of the side, each axis; 0.1 */
    double scale_jitter;            /* deviation, clipped to +- itself; 0.2 */
    double rotation;                /* uniform in +- this, radians; pi for HO3D */
    double rotation_chance;         /* where below 1 (DexYCB: 0.6), the angle is instead
                                       clip(normal, -2, 2) * rotation with this chance, else 0 */
    augment_limits colour;          /* 0.5, 0.5, 0.5, 0.5, 0.15 */
    double background;              /* chance of another one in the image, where there are segments; 0 */
    bool bilinear;                  /* the paper's parents sample the nearest pixel */
} hand_object_options;

/* hand_object_defaults - the options above as HOCAT trains on HO3D, without augmentation if !augment */
hand_object_options hand_object_defaults(bool augment, uint64_t seed);

/* B slots of capacity, of which the first count are filled. A slot whose sample could not be read is
 * zero with weight 0. Boxes and 2D arrays are in crop pixels or in units of their box. */
typedef struct {
    int count;                      /* B of this batch; the last of an epoch may be smaller */
    int capacity, size, cells;
    float *image;                   /* (B, 3, size, size) in [0, 1] */
    float *depth, *metres;          /* (B, size, size) both as depth_crop has them; 0 where not asked for */
    float *hand_box, *object_box;   /* (B, 4) x0 y0 x1 y1 in crop pixels */
    float *joints2d;                /* (B, 21, 2) simple order, in units of hand_box */
    float *rotation;                /* (B, 16, 9) row-major, [0] turned with the crop */
    float *beta;                    /* (B, 10) */
    float *points2d;                /* (B, 21, 2) control points in units of object_box */
    float *mask;                    /* (B, cells, cells) object silhouette within object_box, 0 or 1 */
    float *weight;                  /* (B) 1, or 0 for a sample that could not be read */
    float *object_weight;           /* (B) the same, and 0 where the annotation has no object */
    /* for scoring; not turned with the crop */
    float *affine;                  /* (B, 6) points of the image to the crop */
    float *K;                       /* (B, 9) affine times the camera's intrinsics */
    float *wrist;                   /* (B, 3) camera, metres */
    float *joints;                  /* (B, 21, 3) camera, metres, simple order; zero where unknown */
    float *R, *t;                   /* (B, 9), (B, 3) object pose in the camera */
    int32_t *object;                /* (B) index into the dataset's objects; -1 none */
    uint32_t *flags;                /* (B) of sample_flag */
    const float (**vertices)[3];    /* (B) borrowed from the dataset, NULL where unknown */
    int64_t *index;                 /* (B) of the sample in its dataset */

    float *scratch;                 /* (B, size, size) for blurring */
    lt_arena *memory;               /* of all of these */
} hand_object_batch;

/* hand_object_batch_new - zeroed, or NULL without memory */
hand_object_batch *hand_object_batch_new(int capacity, int size, int cells);
void hand_object_batch_free(hand_object_batch *b);

/* hand_object_batch_slot - one slot of b as a batch of its own, which is borrowed */
hand_object_batch hand_object_batch_slot(const hand_object_batch *b, int slot);

/* hand_object_batch_clear - a slot as it is before sample `index` is in it: zero, with weight 0 and no object */
void hand_object_batch_clear(hand_object_batch *b, int slot, int64_t index);

/**
 * hand_object_prepare - crop and augment one sample into a slot of b
 *
 * All randomness is a function of (options->seed, epoch, index). Without augmentation the boxes are
 * computed in the image and their corners mapped; with it, from the mapped points. Where the
 * annotation has a hand box (HO3D evaluation) that is taken; without an object the hand alone
 * decides, and the object's arrays are zero.
 */
lt_status hand_object_prepare(const dataset_sample *s, const hand_object_options *options,
                              uint64_t epoch, int64_t index, hand_object_batch *b, int slot);

/* hand_object_want - what dataset_read must give for these options */
unsigned hand_object_want(const hand_object_options *options);

/* Where a loader's samples come from, and how they are prepared. */
typedef struct {
    const dataset *data;
    hand_object_options options;
    const int64_t *index;           /* (count) which of its samples; NULL: all */
    int64_t count;
} hand_object_feed;

/* hand_object_source - what a loader needs to make such batches; feed must outlive the loader */
loader_source hand_object_source(const hand_object_feed *feed);

#ifdef __cplusplus
}
#endif
#endif
