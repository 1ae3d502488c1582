/* SPDX-License-Identifier: Apache-2.0 */
/* One set in one frame, for hogs_record.c alone. */
#ifndef MODELS_HOGS_HOGS_SET_H
#define MODELS_HOGS_HOGS_SET_H

#include "models/hogs/hogs.h"

/* What a frame tells its sets: of B images for V-PM, of one frame for the avatar */
typedef struct {
    vpm_condition vpm[2];           /* of hands, of objects */
    lt_tensor *pose, *started;      /* (16, AVATAR_JOINT) of the hand; (1), 0 while it keeps its shape */
    lt_tensor *code;                /* (1, AVATAR_CODE) */
} hogs_seen;

/* hogs_look - record what they are told, with inputs "image" or what was seen in it, or "articulation", "started" and
 * "frame_code" */
hogs_seen hogs_look(const hogs *m, model_record *r, hogs_stage stage);

/* The places and who is in use, of all frames */
typedef struct {
    lt_tensor *alive, *place;
} hogs_set_in;

hogs_set_in hogs_set_inputs(const hogs *m, model_record *r, bool object);

/* hogs_set_of - of frame b, in its canonical place: the whole set, or only its rows `drawn` (1, P) */
hogs_drawn_set hogs_set_of(const hogs *m, model_record *r, bool object, int b, const hogs_set_in *in,
                           const hogs_seen *seen, lt_tensor *drawn);

/* hogs_set_place - put it where the transforms (N or 1, 3, 4) say */
void hogs_set_place(hogs_drawn_set *s, lt_tensor *transforms);

/* hogs_set_colour - as it is seen from the camera, whose direction is turned by `view`                 [Eq. 6, 7] */
void hogs_set_colour(const hogs *m, hogs_drawn_set *s, lt_tensor *transforms, lt_tensor *view, lt_tensor *degree);

/* hogs_bend - a hand's transforms (N, 3, 4): linear blend skinning by the learnt field, at p'          [Eq. 3, 4] */
lt_tensor *hogs_bend(const hogs *m, const hogs_drawn_set *s, lt_tensor *bones);

/* hogs_integers_of - an input of frame b alone: graphs take no slices of integers;  hogs_frame_of - x (B, ...) of frame
 * b, without its first dimension, which stays, as 1, where `keep` */
lt_tensor *hogs_integers_of(const hogs *m, model_record *r, const char *name, int b, lt_shape shape);
lt_tensor *hogs_frame_of(lt_tensor *x, int b, bool keep);

#endif
