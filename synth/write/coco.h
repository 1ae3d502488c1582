/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes what is seen in pictures as COCO's instances.
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
    const char *file;               /* within the dataset: ".../annotations/instances_SPLIT.json" */
    synth_growing images, annotations;
    int64_t n_images, n_annotations;
} synth_coco;

/* One image: file's name without its folder. The masks' runs are made where the picture is. */
typedef struct {
    char file[32];
    int width, height;
    const char *camera;             /* of a film's frame, whose things have track ids; NULL: a single picture */
    int frame;                      /* its number */
    int n;
    struct {
        synth_thing thing;
        synth_pixels box;
        int64_t area;
        double visible;             /* share */
        const char *counts;         /* lt_rle_encode */
        synth_pixels whole_box;     /* of all of it, as if nothing hid it ... */
        int64_t whole_area;
        const char *whole_counts;   /* ... NULL: that is not written */
    } seen[SYNTH_THINGS];
} synth_coco_image;

/* synth_coco_open - begin a file; synth_coco_fini frees c in any case. LT_ENOMEM. */
lt_status synth_coco_open(synth_coco *c, const char *file);
void synth_coco_fini(synth_coco *c);

/* synth_coco_counts - whether so much is seen of a thing that it is annotated: a tenth, and 16 pixels */
bool synth_coco_counts(const synth_seen *seen);

/**
 * synth_coco_see - one more thing that an image shows; the runs are the arena's
 *
 *   whole    its amodal mask (synth_world_cover), or NULL: that is not written
 *
 * Errors: LT_ENOMEM.
 */
lt_status synth_coco_see(lt_arena *arena, const synth_thing *thing, const synth_seen *seen, const uint8_t *whole,
                         synth_coco_image *image);

/* synth_coco_add - an image and what it shows; ids count from 1 */
void synth_coco_add(synth_coco *c, const synth_coco_image *image);

/* synth_coco_close - write root/file, and add it to the manifest */
lt_status synth_coco_close(synth_coco *c, const char *root, synth_manifest *manifest);

#ifdef __cplusplus
}
#endif
#endif
