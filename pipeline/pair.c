/* SPDX-License-Identifier: Apache-2.0 */
/* Which of the objects that a detector sees goes with which hand, and the models of these. */
#include "pipeline/internal.h"

#include "pipeline/objects/objects.h"

#include <math.h>

static const double NEAR = 0.25;        /* of a hand's longer side: the gap to what it may be about to touch */

/* ---- pairs ----------------------------------------------------------------------------------------------- */

static double area(crop_box b)
{
    return (double)(b.x1 - b.x0) * (double)(b.y1 - b.y0);
}

static double overlap(crop_box a, crop_box b)
{
    const double w = (double)fminf(a.x1, b.x1) - (double)fmaxf(a.x0, b.x0);
    const double h = (double)fminf(a.y1, b.y1) - (double)fmaxf(a.y0, b.y0);
    const double both = w > 0 && h > 0 ? w * h : 0;

    return both > 0 ? both / (area(a) + area(b) - both) : 0;
}

/* Between two boxes, 0 where they touch */
static double gap(crop_box a, crop_box b)
{
    const double x = fmax(0, (double)fmaxf(a.x0 - b.x1, b.x0 - a.x1));
    const double y = fmax(0, (double)fmaxf(a.y0 - b.y1, b.y0 - a.y1));

    return hypot(x, y);
}

/* How well an object goes with a hand: above 0 by their overlap, down to -NEAR by their distance in hands */
static double closeness(const predict_detection *hand, const predict_detection *object)
{
    const crop_box b = hand->box;
    const double both = overlap(b, object->box);

    return both > 0 ? both : -gap(b, object->box) / (double)fmaxf(b.x1 - b.x0, b.y1 - b.y0);
}

const predict_detection *predict_partner(const predict_detection *hand, const predict_detection *all, int n)
{
    const predict_detection *best = NULL;

    for (int i = 0; i < n; i++)
        if (all[i].kind == DETECTED_OBJECT && closeness(hand, &all[i]) >= -NEAR &&
            (!best || closeness(hand, &all[i]) > closeness(hand, best)))
            best = &all[i];
    return best;
}

/* ---- models ---------------------------------------------------------------------------------------------- */

/* The one of a class's name, loaded once; *out NULL where there is none. */
static lt_status model_of(predict_models *m, const predict_detection *d, const predict_object **out)
{
    predict_object *object;
    lt_status st;

    *out = m->of[d->cls].object;
    if (m->of[d->cls].tried)
        return LT_OK;
    object = lt_arena_alloc(m->arena, sizeof(*object));
    if (!object)
        return lt_error(LT_ENOMEM, "%s: no memory", d->name);
    st = predict_load_object(m->arena, m->o, d->name, object);
    if (st == LT_ENOMEM)
        return st;
    if (st && m->o->models)
        predict_say(m->o, "%s", lt_last_error());
    m->of[d->cls].tried = true;
    m->of[d->cls].object = *out = st ? NULL : object;
    return LT_OK;
}

/* ---- views ----------------------------------------------------------------------------------------------- */

static lt_status look_at(predict_frame *f, const predict_detection *hand, predict_models *models, predict_view *v)
{
    const predict_detection *object = predict_partner(hand, f->detection, f->n_detections);

    v->hand_seen = hand;
    v->hand_box = hand->box;
    v->hand_from = PREDICT_DETECTED;
    v->object_seen = object;
    v->object_box = object ? object->box : predict_default_object_box(hand->box);
    v->object_from = object ? PREDICT_DETECTED : PREDICT_DEFAULT;
    predict_choose_side(f->o, hand->side, v);
    v->object = predict_hand_alone(f->o) ? NULL : f->object;
    return object && !f->object && f->o->m && !f->o->m->hand_alone ? model_of(models, object, &v->object) : LT_OK;
}

lt_status predict_views_detected(predict_frame *f, predict_models *models)
{
    int hands = 0, k = 0;
    lt_status st;

    for (int i = 0; i < f->n_detections; i++)
        hands += f->detection[i].kind == DETECTED_HAND;
    st = predict_views_new(f, hands);
    for (int i = 0; i < f->n_detections && !st; i++)
        if (f->detection[i].kind == DETECTED_HAND)
            st = look_at(f, &f->detection[i], models, &f->view[k++]);
    return st;
}
