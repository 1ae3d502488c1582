/* SPDX-License-Identifier: Apache-2.0 */
/* What is to be said of what was found. */
#include "pipeline/internal.h"

void predict_note_found(const predict_view *v, const predict_result *r, predict_notes *notes)
{
    if (!r->placed)
        predict_note_add(notes, v, NOTE_HAND_GUESSED, "the hand's position could not be solved (0.05 to 10 m are "
                         "believed); it is put 0.6 m away in its box");
    else if (!predict_trusted(v, r))
        predict_note_add(notes, v, NOTE_LOW_TRUST, "low trust: the hand's 2D and 3D joints differ by %.0f px",
                         r->agreement_px);
    predict_note_depth(v, r, notes);
    if (v->object && r->object_far)
        predict_note_add(notes, v, NOTE_POSE_FAR, "the pose of %s lies %.3g m away (0.05 to 10 m are believed): does "
                         "its model have another unit, or K another image size?", v->object->name,
                         r->e.object.t[2]);
    else if (v->object && !r->object_found)
        predict_note_add(notes, v, NOTE_NO_POSE, "no pose of %s was found (confidence %.2f)", v->object->name,
                         (double)r->e.object_confidence);
}
