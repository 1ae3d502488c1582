/* SPDX-License-Identifier: Apache-2.0 */
/* A picture of a person in the making. Private to this folder. */
#ifndef SYNTH_BODY_PICTURE_H
#define SYNTH_BODY_PICTURE_H

#include "synth/body/crop.h"
#include "vision/person_window.h"

enum { PICTURE_WIDE = 640, PICTURE_HIGH = 480 };        /* of the wider picture */

typedef struct {
    lt_arena *arena;
    const synth_crop_place *place;
    lt_rng r;
    int who;
    synth_body_stance stance;
    lt_rig rig;
    double (*vertex)[3], joint[BODY_JOINTS][3];
    synth_camera wide, camera;                  /* of the wider picture, and of the one that is written */
    double box[4];                              /* x0 y0 x1 y1 of the person in the wider one */
    person_window window;                       /* of the wider one, that is written */
    bool cut;
    synth_world world;
    synth_room room;
} body_picture;

/* picture_project - false behind the camera */
bool picture_project(const synth_camera *c, const double p[3], double uv[2]);

/* picture_outside - whether a pixel of what is written is one that the wider picture has not */
bool picture_outside(const body_picture *p, double u, double v);

/* picture_truth - what is written of it; f is what was drawn, with its labels */
void picture_truth(const body_picture *p, const synth_frame *f, body_row *out);

#endif
