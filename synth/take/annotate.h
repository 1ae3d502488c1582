/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is known of a filmed frame: the annotation that goes to the files, and how much can be seen.
 */
#ifndef SYNTH_TAKE_ANNOTATE_H
#define SYNTH_TAKE_ANNOTATE_H

#include "synth/take/picture.h"
#include "synth/take/stage.h"

#ifdef __cplusplus
extern "C" {
#endif

/* synth_annotate - fills in everything but sequence, frame, evaluation, contact and the images; camera axes.
 * synth_annotate_contact - of a picture that has the rest */
void synth_annotate(const synth_stage *s, int camera, int k, const synth_posed_hand *world,
                    synth_picture *out);
void synth_annotate_contact(const synth_stage *s, synth_picture *out);

/* What can be seen of one frame, and how hand and object meet. */
typedef struct {
    synth_phase phase;
    int inside;                     /* joints within the picture */
    int hidden, hidden_by_object;   /* of those */
    double hand_visible, object_visible;        /* share of the amodal mask */
    bool contact;                   /* some vertex touches the object */
    bool inside_object;             /* some vertex is in it */
    bool both;                      /* hand and object can be seen, a pixel each at least */
    double tip[5];                  /* metres from each finger's last segment to the object's surface */
} synth_visibility;

/**
 * synth_look - measure a filmed, annotated frame
 *
 *   part     (778) of synth_hand_parts
 *
 * A joint is hidden by the object when the object is before it, and hidden at all when anything is more
 * than 15 mm before it: joints lie inside the hand.
 */
void synth_look(const synth_picture *p, const synth_frame *frame, synth_phase phase,
                const uint8_t part[LT_HAND_VERTICES], synth_visibility *out);

#ifdef __cplusplus
}
#endif
#endif
