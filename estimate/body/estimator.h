/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A network for whole bodies at work: the box of a person in a picture in, the person's body out.
 */
#ifndef ESTIMATE_BODY_ESTIMATOR_H
#define ESTIMATE_BODY_ESTIMATOR_H

#include "assets/run_body.h"
#include "estimate/body/graph.h"
#include "estimate/trained.h"
#include "libtensor/geometry/camera.h"

typedef struct {
    trained t;                      /* path, model */
    run_body body;                  /* that it was trained with */
    body_graph graph;
    compiled c;
} body_estimator;

typedef struct {
    double nodes[BODY_NODES][3];    /* from the pelvis, in camera axes, metres */
    float nodes2d[BODY_NODES][2];   /* pixels of the picture */
    double pelvis[3];               /* in camera axes, metres; how far away it is, is rough: from the person's size */
    double pose[BODY_JOINTS][3];    /* SMPL-X's, axis-angle; the pelvis's in camera axes, no mean pose added, eyes 0 */
    double shape[BODY_SHAPES], expression[BODY_EXPRESSIONS];
} body_estimate;

/**
 * body_estimator_open - a run of osx, or its checkpoint file, with the body model that it was trained with
 *
 * body_estimator_close frees it, also after a failure; out stays where it is. Errors: those of trained_open, of
 * run_body_open, and of compiling.
 */
lt_status body_estimator_open(const char *path, body_estimator *out);
void body_estimator_close(body_estimator *e);

/**
 * body_estimator_run - the body in a box; allocates nothing
 *
 *   rgb      (height, width, 3), upright
 *   box      x0 y0 x1 y1 of the person, pixels; a pixel's centre is a whole number. It is made 3:4 and grown by a
 *            quarter here, and may reach outside
 *   camera   the picture's
 *
 * Errors: LT_EINVAL: a box that is empty or not finite; LT_ENUMERIC: numbers that are not finite.
 */
lt_status body_estimator_run(body_estimator *e, const uint8_t *rgb, int width, int height, const float box[4],
                             const lt_camera *camera, body_estimate *out);

#endif
