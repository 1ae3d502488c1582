/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures of persons with the pose of a body model in each, as `palmar synth --preset body` writes them:
 *
 *   train/000001.jpg ...   evaluation/000001.jpg ...      192 x 256, each with one person
 *   train.npz, evaluation.npz                             rows.h, in the order of the pictures
 *   body.npz                                              the body model
 */
#ifndef DATA_BODY_SET_H
#define DATA_BODY_SET_H

#include "data/body/rows.h"
#include "libtensor/io/image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { BODY_PICTURE_WIDTH = 192, BODY_PICTURE_HEIGHT = 256 };

typedef struct {
    const char *root, *split;
    const body_row *row;            /* (n) */
    const char **name;              /* (n) "train/000001.jpg" */
    int64_t n;
    int subjects;                   /* how many different ones */
    bool synthetic;                 /* its manifest says so */
} body_set;

/* body_set_open - a split ("train", "evaluation") of a folder, into the arena. Errors: LT_EIO; those of
 * body_rows_parse; a split without pictures. */
lt_status body_set_open(lt_arena *arena, const char *root, const char *split, body_set *out);

/* body_set_probe - whether root is such a folder */
bool body_set_probe(const char *root);

/* body_set_body - the name of the body model in a folder */
const char *body_set_body(lt_arena *arena, const char *root);

/* body_set_picture - number i from 0: RGB in the arena. Errors: those of lt_image_read; another size, no colours. */
lt_status body_set_picture(const body_set *set, int64_t i, lt_arena *arena, lt_image *out);

#ifdef __cplusplus
}
#endif
#endif
