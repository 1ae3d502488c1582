/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes what is seen in pictures as COCO's instances: annotations/instances_SPLIT.json.
 */
#ifndef SYNTH_WRITE_COCO_H
#define SYNTH_WRITE_COCO_H

#include "synth/world/seen.h"
#include "synth/write/growing.h"
#include "synth/write/manifest.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const char *split;
    synth_growing images, annotations;
    int64_t n_images, n_annotations;
} synth_coco;

/* One image: file's name without its folder. The masks' runs are made where the picture is. */
typedef struct {
    char file[32];
    int width, height;
    int n;
    struct {
        synth_thing thing;
        synth_pixels box;
        int64_t area;
        double visible;             /* share */
        const char *counts;         /* lt_rle_encode */
    } seen[SYNTH_THINGS];
} synth_coco_image;

/* synth_coco_open - begin a split; synth_coco_fini frees c in any case. LT_ENOMEM. */
lt_status synth_coco_open(synth_coco *c, const char *split);
void synth_coco_fini(synth_coco *c);

/* synth_coco_add - an image and what it shows; ids count from 1 */
void synth_coco_add(synth_coco *c, const synth_coco_image *image);

/* synth_coco_close - write root/annotations/instances_SPLIT.json, and add it to the manifest */
lt_status synth_coco_close(synth_coco *c, const char *root, synth_manifest *manifest);

#ifdef __cplusplus
}
#endif
#endif
