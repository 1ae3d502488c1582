/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is known of pictures of one person each, as an .npz whose arrays have a row for each picture, under the names of
 * the fields.
 *
 * Camera axes: x right, y down, z forward; metres. Pixels of the picture; a pixel's centre is a whole number.
 */
#ifndef DATA_BODY_ROWS_H
#define DATA_BODY_ROWS_H

#include "assets/body/body.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { BODY_BOXES = 3 };                        /* left hand, right hand, face */

typedef enum { BODY_IN_PICTURE = 1, BODY_UNHIDDEN = 2 } body_seen;

typedef struct {
    float pose[BODY_JOINTS][3];                 /* axis-angle; the pelvis's in the camera */
    float shape[BODY_SHAPES], expression[BODY_EXPRESSIONS];
    float trans[3];                             /* added to all vertices at the end */
    float K[3][3];
    float nodes_3d[BODY_NODES][3], nodes_2d[BODY_NODES][2];
    uint8_t seen[BODY_NODES];                   /* body_seen: where there is a picture; nothing but the person is
                                                 * before */
    float boxes[BODY_BOXES][4];                 /* x0 y0 x1 y1 of the vertices; zeros: behind the camera */
    int32_t subject;
    uint8_t holds[2];                           /* left, right: YCB's number of the object, 0: none */
    uint8_t cut;                                /* 1: the wider picture's edge cuts the person off */
    uint8_t sits;
} body_row;

/* body_row_mirror - as a mirror shows a picture of so many pixels across: sides are changed, bodies are taken for
 * symmetric, expressions stay */
void body_row_mirror(body_row *row, int width);

/* body_rows_write - n of them, atomically and packed. LT_ENOMEM, those of lt_npz_write. */
lt_status body_rows_write(lt_arena *arena, const char *path, const body_row *row, int64_t n);

/**
 * body_rows_parse - all rows of such a file, of n bytes in memory
 *
 *   name     for the error line
 *   out      (*n_rows) in the arena
 *
 * Errors: LT_EFORMAT: an array is missing, of another type or shape; fewer or more rows than another one; a number that
 * is not finite; a camera without focal length; a body that is not before its camera; a hand that holds what is no
 * object. Those of lt_npz_parse.
 */
lt_status body_rows_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, body_row **out,
                          int64_t *n_rows);

#ifdef __cplusplus
}
#endif
#endif
