/* SPDX-License-Identifier: Apache-2.0 */
/* judge: what is to be said of what was found, to whoever watches too. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

static lt_status open_judge(const predict_options *o, void **state)
{
    (void)o;
    *state = lt_alloc(sizeof(predict_said));
    return *state ? LT_OK : lt_error(LT_ENOMEM, "no memory to predict with");
}

static void close_judge(void *state)
{
    lt_release(state);
}

static void note_found(const predict_view *v, const predict_result *r, predict_notes *notes)
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
    else if (v->object && predict_trusted(v, r) && !predict_object_trusted(v, r))
        predict_note_add(notes, v, NOTE_OBJECT_APART, "low trust: the pose of %s leaves it %.2g m from the hand that "
                         "holds it; is it another object?", v->object->name, predict_object_apart(v, r));
}

/* Of a detector: that it found nothing, and what it is not sure of */
static void note_detected(predict_frame *f)
{
    static const double DOUBTFUL = 0.5;
    int doubtful = 0;

    for (int i = 0; i < f->n; i++)
        doubtful += f->view[i].hand_seen->score < DOUBTFUL;
    if (!f->n_detections)
        predict_note_add(&f->notes, NULL, NOTE_NOTHING, "the detector found nothing");
    else if (!f->n && f->o->m)
        predict_note_add(&f->notes, NULL, NOTE_NO_HAND, "no hand was found");
    if (f->n_detections && !f->n_people && f->o->body)
        predict_note_add(&f->notes, NULL, NOTE_NO_PERSON, "no person was found");
    if (doubtful)
        predict_note_add(&f->notes, NULL, NOTE_LOW_SCORE, "low confidence: %d of %d hands have a score below %g",
                         doubtful, f->n, DOUBTFUL);
}

static lt_status run(void *state, predict_frame *f)
{
    if (f->detected)
        note_detected(f);
    if (f->input.frame && !f->film && f->o->m)
        predict_note_add(&f->notes, NULL, NOTE_NOT_SMOOTHED, "the film does not say its frames per second, so they are "
                         "not smoothed; --fps does");
    for (int i = 0; i < f->n && (f->has & FRAME_POSES); i++)
        note_found(&f->view[i], &f->result[i], &f->notes);
    if (f->notes.lost)
        return lt_error(LT_ENOMEM, "%s: no memory", f->input.path);
    predict_say_notes(f->o, f->input.path, f->among_many, f->input.frame > 0 || f->film, &f->notes, state);
    return LT_OK;
}

const stage judge_stage = {
    .name = "judge", .needs = FRAME_VIEWS, .gives = FRAME_VERDICT,
    .open = open_judge, .run = run, .close = close_judge,
};
