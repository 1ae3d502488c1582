/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A frame as a layout writes it: the picture and all that is known of it.
 *
 * OpenCV camera axes, metres, as the framework has them; what a layout has of its own, its writer turns.
 */
#ifndef SYNTH_TAKE_PICTURE_H
#define SYNTH_TAKE_PICTURE_H

#include "libtensor/geometry/box21.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/hand/model.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SYNTH_WIDTH = 640, SYNTH_HEIGHT = 480 };      /* unless a preset has smaller pictures */

/* How hand vertices meet the object. */
typedef struct {
    bool contact[LT_HAND_VERTICES];             /* within 4 mm of its surface */
    bool inside[LT_HAND_VERTICES];
    float distance[LT_HAND_VERTICES];           /* metres to the surface, also from inside */
    float nearest[LT_HAND_VERTICES][3];         /* the point of the surface, camera axes */
} synth_contact;

/* One picture and all that is known of it. */
typedef struct {
    const char *sequence;                       /* "SYN3MB10": its last digit is the camera */
    int frame;                                  /* 0 .. 9999 */
    bool evaluation;
    int width, height;
    lt_camera camera;
    int n_cameras;

    double pose[3 * LT_HAND_JOINTS];            /* axis-angle, flat hand zero, wrist first */
    double trans[3], beta[LT_HAND_BETAS];
    double rest_wrist[3];                       /* lt_hand_rest_wrist for beta */
    double joints[LT_HAND_KEYPOINTS][3];        /* MANO order */
    double vertices[LT_HAND_VERTICES][3];
    synth_contact contact;

    const char *object;                         /* the model's name */
    int object_id;                              /* 1..21 */
    lt_box box;                                 /* of its points */
    double R[9], t[3];                          /* x_cam = R x_model + t */

    const uint8_t *rgb;                         /* (height, width, 3) */
    const float *depth;                         /* (height, width) metres, 0 unknown */
    const uint8_t *label;                       /* (height, width) 255 hand, object_id object */
} synth_picture;

#ifdef __cplusplus
}
#endif
#endif
