/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where hands and objects are, image by image, as a detector wrote it to a CSV file.
 */
#ifndef PIPELINE_BOXES_H
#define PIPELINE_BOXES_H

#include "libtensor/base/arena.h"
#include "vision/crop.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { PREDICT_ANY_SIDE, PREDICT_RIGHT, PREDICT_LEFT } predict_side;

struct predict_object;

typedef struct {
    const char *image;              /* as the file has it: no folder, with or without its ending; or a frame's name */
    int64_t line;
    crop_box hand, object;          /* pixels of the upright image */
    bool has_hand, has_object;
    predict_side side;              /* PREDICT_ANY_SIDE: the file does not say */
    const char *object_name;        /* "": the file does not say */
    const struct predict_object *model;         /* of that name, once it is loaded */
    int input, frame;               /* whose they are, which is found out later; read as -1: nobody's */
} predict_boxes_row;

typedef struct {
    const char *path;
    predict_boxes_row *row;         /* in the order of `image` */
    size_t n;
    const char *unread;             /* the first column that means nothing here, or NULL */
} predict_boxes;

/**
 * predict_boxes_read - all lines of a file whose first line names its columns
 *
 *   image                                   a file's name, film.mp4#12 or film-000012
 *   hand_x0, hand_y0, hand_x1, hand_y1      pixels
 *   object_x0 ... object_y1, side           optional; side is left or right
 *   object_name                             optional; as --object has it
 *
 * An image may have several lines, one for each hand. Columns stand in any order, others are passed over. Empty cells
 * are not known; a box has all of its numbers or none. What it gives is in the arena, which takes at most 16 times the
 * file.
 * Errors: LT_EIO, LT_ENOMEM; LT_EFORMAT with file and line for a column that is missing or there twice, a line with
 * more or fewer cells than columns, what is no number, an empty box.
 */
lt_status predict_boxes_read(lt_arena *arena, const char *path, predict_boxes *out);

#ifdef __cplusplus
}
#endif
#endif
