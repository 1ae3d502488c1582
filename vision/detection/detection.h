/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From the maps of a detector to what it found: boxes from the cells that are sure enough, of boxes of one class that
 * overlap the surest alone, and their masks out of prototypes.
 *
 * Source: the decoding of Li et al. 2020, "Generalized focal loss", and the masks of Bolya et al. 2019, "YOLACT".
 */
#ifndef VISION_DETECTION_DETECTION_H
#define VISION_DETECTION_DETECTION_H

#include "libtensor/base/arena.h"
#include "vision/detection/letterbox.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { DETECTION_LEVELS = 3, DETECTION_SIDES = 4, DETECTION_BINS = 16, DETECTION_COEFFICIENTS = 32 };

/* One image's: level i has size / (8 << i) cells a side. */
typedef struct {
    int size, classes;
    const float *box[DETECTION_LEVELS];     /* (64, H, W): 16 bins of the distance to left, top, right, bottom */
    const float *cls[DETECTION_LEVELS];     /* (classes, H, W) logits */
    const float *mask[DETECTION_LEVELS];    /* (32, H, W) */
    const float *proto;                     /* (32, size / 4, size / 4) */
} detection_maps;

typedef struct {
    double score;                   /* least */
    double iou;                     /* of two boxes of one class that overlap more, the surer one stays */
    int most;                       /* in an image; with every_class, of each class */
    bool every_class;               /* a cell may find one of each class; else its surest alone */
} detection_rules;

/* detection_rules_shown - score 0.25, IoU 0.7, 300: what people look at. detection_rules_scored - from 0.001 on, 100 of
 * every class: what an average precision is measured of */
extern const detection_rules detection_rules_shown, detection_rules_scored;

typedef struct {
    int cls;
    float score;
    float box[4];                   /* x0 y0 x1 y1 in pixels of the square */
    float coefficient[DETECTION_COEFFICIENTS];
} detection;

/* detection_find - what is found, the surest first, in the arena. LT_ENOMEM. */
lt_status detection_find(lt_arena *arena, const detection_maps *maps, const detection_rules *rules, detection **out,
                         int *n);

/* Pixels of the picture: those of a (y1 - y0, x1 - x0) window that are the object's are 1 */
typedef struct {
    int x0, y0, x1, y1;
    uint8_t *pixel;
} detection_pixels;

/* What is found in a picture, in its pixels, whose first one covers 0 to 1; window.pixel NULL: without a mask */
typedef struct {
    int cls;
    double score;
    float box[4];
    detection_pixels window;
} detect_found;

/**
 * detection_pixels_of - masks of n findings, in pixels of the picture that the letterbox fitted
 *
 * A pixel of the picture belongs to an object where it lies in its box and the sigmoid of coefficients times
 * prototypes, mixed of the four nearest cells, is above 1/2. out (n); pixels in the arena. LT_ENOMEM.
 */
lt_status detection_pixels_of(lt_arena *arena, const detection_maps *maps, const detection *found, int n,
                              const letterbox *l, int width, int height, detection_pixels *out);

/* detection_runs - such a mask as COCO writes that of a whole width x height picture (libtensor/io/image/coco_rle.h);
 * pixels that is NULL: nothing. In the arena; NULL without memory */
const char *detection_runs(lt_arena *arena, const detection_pixels *p, int width, int height);

#ifdef __cplusplus
}
#endif
#endif
