/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures with objects in them, each with a class, a box and, where it is known, a mask: COCO's instances and YOLO's
 * text files.
 */
#ifndef DATA_DETECTION_DETECTION_H
#define DATA_DETECTION_DETECTION_H

#include "libtensor/io/image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    DETECTION_NO_MASK,
    DETECTION_POLYGONS,
    DETECTION_RLE,                  /* as lt_rle_decode reads it */
} detection_mask_kind;

typedef struct {
    int cls;
    float box[4];                   /* x0 y0 x1 y1 in pixels, whose first one covers 0 to 1 */
    double area;                    /* of the mask in pixels, by the file, or of the box */
    bool crowd;                     /* a region with many of its class: nothing to learn from, and never wrong */
    detection_mask_kind mask;
    const float *point;             /* of polygons: x y of all their corners, in pixels */
    const int *corners;             /* (n_polygons) */
    int n_polygons;
    bool border;                    /* pixels on their edges belong to them */
    const char *rle;
} detection_object;

typedef struct {
    int64_t id;                     /* COCO's; else the number of the image */
    const char *name, *path;        /* as the dataset has it; where the file is */
    int width, height;              /* 0: not known before it is read; then its objects are in shares of them */
    const detection_object *object;
    int n;
} detection_image;

typedef struct {
    const char *root, *title;       /* "COCO", "YOLO" */
    const char *split;
    const char *list;               /* the file that names the images, for error lines */
    bool synthetic;
    int64_t seed;                   /* of a set by `palmar synth --preset detect`; -1: none */
    int classes;
    const char *const *class_name;
    const int64_t *class_id;        /* COCO's categories; NULL for YOLO */
    const detection_image *image;
    int64_t count;                  /* images that can be used */
    int64_t objects, masks;         /* in all */
    int64_t missing, empty, corrupt, dropped;       /* images not there, without objects, with labels that cannot be;
                                                     * objects that were left out: outside their image, or twice */
    const char *first_fault;        /* one line of the first of these; or NULL */
} detection_set;

/**
 * detection_open - a split of a dataset
 *
 *   root     a folder with annotations/instances_SPLIT.json (COCO) or with data.yaml (YOLO), or such a .yaml file
 *   split    "train" or "evaluation", which others call val, val2017 or test
 *   out      owned by the arena; touched only on success
 *
 * Files are looked for, not opened: a picture that cannot be read is found when it is. Where YOLO's labels of an image
 * cannot be, the image is left out and counted. Errors: no such split; a file that is not what it should be, with its
 * place; names of classes that are not as many as the file says; no image left.
 */
lt_status detection_open(lt_arena *arena, const char *root, const char *split, detection_set **out);

/* detection_probe - whether root is such a dataset */
bool detection_probe(const char *root);

/* detection_summary - one line on what was found, in the arena; NULL without memory */
const char *detection_summary(lt_arena *arena, const detection_set *s);

/* A picture with its objects */
typedef struct {
    const detection_image *image;
    lt_image rgb;                   /* 8 bits */
    const detection_object *object; /* in pixels of rgb */
    int n;
} detection_sample;

/**
 * detection_objects - the objects of image i, which has width x height pixels, in pixels; borrowed, or in the arena
 *
 * Errors: another size than the file says; LT_ENOMEM.
 */
lt_status detection_objects(const detection_set *s, int64_t i, int width, int height, lt_arena *arena,
                            const detection_object **out);

/* detection_read - image i, into the arena. Errors: those of lt_image_read; another size than the file says. */
lt_status detection_read(const detection_set *s, int64_t i, lt_arena *arena, detection_sample *out);

/**
 * detection_mask - which pixels of a width x height picture are an object's: bytes of 0 and 1, row by row
 *
 * Of an object without a mask: those of its box. Errors: LT_EFORMAT, runs that do not add up to the picture.
 */
lt_status detection_mask(const detection_object *o, int width, int height, uint8_t *mask);

#ifdef __cplusplus
}
#endif
#endif
