/* SPDX-License-Identifier: Apache-2.0 */
/* What was assumed of an image. */
#include "pipeline/internal.h"

static void note_turn(const predict_view *v, predict_notes *notes)
{
    if (v->orientation != 1)
        predict_note_add(notes, NULL, NOTE_TURNED, "turned upright (orientation %d of EXIF's), now %d x %d",
                         v->orientation, v->width, v->height);
}

/* which: "hand"; instead: what was taken where nobody gave one */
static void note_box(const predict_options *o, const predict_view *v, predict_note_code code, predict_source from,
                     const char *which, const char *instead, predict_notes *notes)
{
    if (o->boxes && from == PREDICT_DEFAULT)
        predict_note_add(notes, v, code, "no %s box in %s: took %s", which, o->boxes, instead);
    else if (o->boxes && from == PREDICT_GIVEN)
        predict_note_add(notes, v, code, "no %s box in %s: took --%s-box", which, o->boxes, which);
    else if (from == PREDICT_DEFAULT)
        predict_note_add(notes, v, code, "no --%s-box: took %s", which, instead);
}

static void note_hand_box(const predict_options *o, const predict_view *v, predict_notes *notes)
{
    const crop_box b = v->hand_box;
    char middle[128];

    snprintf(middle, sizeof(middle), "the middle of the image, %.0f,%.0f,%.0f,%.0f", (double)b.x0, (double)b.y0,
             (double)b.x1, (double)b.y1);
    note_box(o, v, NOTE_HAND_BOX, v->hand_from, "hand", middle, notes);
}

/* Without numbers: they follow the hand's, which moves. */
static void note_object_box(const predict_options *o, const predict_view *v, predict_notes *notes)
{
    note_box(o, v, NOTE_OBJECT_BOX, v->object_from, "object", "the hand's box grown 1.3 times", notes);
}

static void note_object(const predict_options *o, const predict_view *v, predict_notes *notes)
{
    if (predict_hand_alone(o))
        predict_note_add(notes, v, NOTE_NO_OBJECT, "the model was trained on hands alone (model.w_p2d is 0): no object "
                         "pose");
    else if (!v->object && v->object_seen)
        predict_note_add(notes, v, NOTE_OBJECT_UNKNOWN, "it goes with %s, which there is no model of: no object pose; "
                         "--models has others", v->object_seen->name);
    else if (!v->object && !v->hand_seen)
        predict_note_add(notes, v, NOTE_NO_OBJECT, "no --object: the hand alone, no object pose");
    if (v->object && v->object->unit_note)
        predict_note_add(notes, v, NOTE_OBJECT_UNIT, "%s", v->object->unit_note);
    if (v->object && v->object->axes_note)
        predict_note_add(notes, v, NOTE_OBJECT_AXES, "%s", v->object->axes_note);
}

/* One line for all hands, however many there are */
static void note_side(predict_frame *f)
{
    bool unsaid = false;

    for (int i = 0; i < f->n; i++)
        unsaid = unsaid || (f->view[i].hand_seen && f->view[i].hand_seen->side == PREDICT_ANY_SIDE);
    if (unsaid && f->o->any_side)
        predict_note_add(&f->notes, NULL, NOTE_SIDE, "the detector does not tell left hands from right ones: each is "
                         "taken for what it looks most like; --side says which");
    else if (unsaid)
        predict_note_add(&f->notes, NULL, NOTE_SIDE, "the detector does not tell left hands from right ones: took them "
                         "for %s, as --side has it", f->o->left ? "left" : "right");
}

static void note_camera(const predict_view *v, predict_notes *notes)
{
    if (v->camera_from == PREDICT_EXIF)
        predict_note_add(notes, NULL, NOTE_CAMERA,
                         "no --K: focal length %.0f px from EXIF; right unless the image was cut", v->camera.fx);
    else if (v->camera_from == PREDICT_DEFAULT)
        predict_note_add(notes, NULL, NOTE_CAMERA, "no --K: assumed a focal length of %.0f px (1.2 times the longer "
                         "side), so distances are rough", v->camera.fx);
}

static void note_hands(predict_frame *f)
{
    for (int i = 0; i < f->n; i++) {
        if (!f->view[i].hand_seen) {
            note_hand_box(f->o, &f->view[i], &f->notes);
            note_object_box(f->o, &f->view[i], &f->notes);
        }
        note_object(f->o, &f->view[i], &f->notes);
    }
    note_side(f);
}

/* What no model looks at need not be said, nor that a hand that was found holds nothing. */
void predict_note_assumed(predict_frame *f)
{
    const predict_options *o = f->o;

    note_turn(&f->scene, &f->notes);
    if (o->m)
        note_hands(f);
    if (o->m || o->body)
        note_camera(&f->scene, &f->notes);
    if (o->m && o->m->depth && !o->depth)
        predict_note_add(&f->notes, NULL, NOTE_NO_DEPTH, "no --depth: %s %s was trained with it, and sees worse "
                         "without", o->m->cls->name, o->m->variant);
}
