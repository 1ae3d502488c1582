/* SPDX-License-Identifier: Apache-2.0 */
/* body: the whole body of each person that is detected, or of the one in the box that was given. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

#include <strings.h>

static lt_status open_estimator(const predict_options *o, void **state)
{
    const detector *d = o->detector;
    bool people = !d;

    for (int c = 0; d && c < d->n; c++)
        people = people || strcasecmp(d->name[c], "person") == 0;
    if (!people)
        predict_say(o, "%s: none of its %d classes is called person, so it finds no bodies", d->t.path, d->n);
    *state = o->body;
    return LT_OK;
}

/* ---- who is there ---- */

static lt_status people_new(predict_frame *f, int n)
{
    f->n_people = 0;
    f->person = lt_arena_array(f->arena, (size_t)n, sizeof(*f->person));
    return f->person ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
}

static lt_status take_detected(predict_frame *f)
{
    const lt_status st = people_new(f, f->n_detections);

    for (int i = 0; i < f->n_detections && !st; i++)
        if (f->detection[i].kind == DETECTED_PERSON)
            f->person[f->n_people++] = (predict_person){ .box = f->detection[i].box, .from = PREDICT_DETECTED,
                                                         .seen = &f->detection[i] };
    return st;
}

static lt_status take_given(predict_frame *f)
{
    const predict_view *v = &f->scene;
    const crop_box *given = f->o->person_box;
    lt_status st = given ? predict_check_inside(v, "person", *given) : LT_OK;

    st = st ? st : people_new(f, 1);
    if (st)
        return st;
    f->n_people = 1;
    if (given)
        f->person[0] = (predict_person){ .box = predict_undistort_box(v, *given), .from = PREDICT_GIVEN };
    else
        f->person[0] = (predict_person){ .box = { 0, 0, (float)(v->width - 1), (float)(v->height - 1) },
                                         .from = PREDICT_DEFAULT };
    if (!given)
        predict_note_add(&f->notes, NULL, NOTE_PERSON_BOX, "no --person-box: took the whole picture for the person");
    return LT_OK;
}

/* ---- their bodies ---- */

static lt_status run(void *state, predict_frame *f)
{
    const predict_view *v = &f->scene;
    lt_status st = f->detected ? take_detected(f) : take_given(f);

    for (int i = 0; i < f->n_people && !st; i++) {
        const crop_box b = f->person[i].box;

        st = body_estimator_run(state, v->rgb, v->width, v->height, (float[4]){ b.x0, b.y0, b.x1, b.y1 }, &v->camera,
                                &f->person[i].body);
        if (st)
            return lt_error_prefix(st, "%s", v->path);
    }
    return st;
}

/* A box outside of the image */
static bool forgives(lt_status st)
{
    return st == LT_EINVAL;
}

const stage body_stage = {
    .name = "body", .needs = FRAME_SCENE, .gives = FRAME_BODIES, .forgives = forgives,
    .open = open_estimator, .run = run,
};
