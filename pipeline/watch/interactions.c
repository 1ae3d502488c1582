/* SPDX-License-Identifier: Apache-2.0 */
/* The rest of S9: what people and objects are about, by rules over what the other stages say. */
#include "pipeline/watch/internal.h"

#include "libtensor/geometry/mat3.h"

#include <math.h>

enum { LEFT_WRIST = 12, RIGHT_WRIST = 13 };             /* of data/action's joints */

static const double AT_REST = 0.03;                     /* metres a second */
static const double HALF = 0.03;                        /* metres: of an object that nothing is known of */

/* Half the smallest side of an object */
static double half_extent(const watch_thing *object)
{
    const ycb_object *known = ycb_find_name(object->name);

    return known ? 0.5 * fmin(known->size[0], fmin(known->size[1], known->size[2])) : HALF;
}

static const watch_contact *contact_of(watch_world *w, const watch_person *p)
{
    for (int i = 0; i < w->n_contacts; i++)
        if (w->contact[i].on && watch_thing_of(w, w->contact[i].hand)->person == p->id)
            return &w->contact[i];
    return NULL;
}

/* The object whose side is nearest to one of a person's wrists */
static watch_thing *nearest_object(watch_world *w, const watch_person *p, bool *left, double *reach)
{
    watch_thing *best = NULL;

    *reach = INFINITY;
    for (int i = 0; i < w->n_things; i++)
        for (int k = LEFT_WRIST; k <= RIGHT_WRIST; k++) {
            watch_thing *o = &w->thing[i];
            double d;

            if (o->kind != DETECTED_OBJECT || !o->placed)
                continue;
            d = lt_vec3_distance(o->centre.x, p->joint[k]) - half_extent(o);
            if (d < *reach) {
                *reach = d;
                *left = k == LEFT_WRIST;
                best = o;
            }
        }
    return best;
}

/* Of the fingers but the thumb, the angle between their first and last bone over all; degrees */
static double flexion(const watch_thing *hand)
{
    double sum = 0;

    for (int f = 1; f < 5; f++) {
        const int base = 1 + 4 * f;
        double a[3], b[3], cosine;

        lt_vec3_sub(hand->joint[base + 1].x, hand->joint[base].x, a);
        lt_vec3_sub(hand->joint[base + 3].x, hand->joint[base + 2].x, b);
        cosine = lt_vec3_dot(a, b) / fmax(1e-12, lt_vec3_norm(a) * lt_vec3_norm(b));
        sum += acos(fmax(-1, fmin(1, cosine)));
    }
    return 45 / M_PI * sum;
}

static double flexion_of(const watch_world *w, const watch_person *p, bool left)
{
    for (int i = 0; i < w->n_things; i++)
        if (w->thing[i].kind == DETECTED_HAND && w->thing[i].person == p->id &&
            (w->thing[i].side == PREDICT_LEFT) == left &&
            w->thing[i].state != LT_FILTER_OFF)
            return flexion(&w->thing[i]);
    return NAN;
}

/* What the rules ask; the wrist's velocity is that of its hand. */
static interaction_seen see(watch_world *w, const watch_person *p, double t)
{
    const watch_contact *k = contact_of(w, p);
    const recording_rig *rig = &w->o->rig;
    interaction_seen e = { .t = t, .action = p->action.cls, .p = p->action.p, .object_speed = NAN, .slip = NAN,
                           .lift = NAN, .robot = NAN, .robot_speed = NAN, .contact = k != NULL };
    watch_thing *object = nearest_object(w, p, &e.left, &e.reach);
    const watch_thing *hand = k ? watch_thing_of(w, k->hand) : NULL;
    const double *wrist;
    double apart[3];

    if (k) {
        object = watch_thing_of(w, k->object);
        e.contact_since = k->since;
        e.left = hand->side == PREDICT_LEFT;
        e.reach = 0;
    }
    wrist = p->joint[e.left ? LEFT_WRIST : RIGHT_WRIST];
    if (object) {
        e.object = object->id;
        e.object_speed = lt_vec3_norm(object->centre.v);
        e.lift = object->centre.x[2] - object->support;
    }
    if (object && hand) {
        lt_vec3_sub(object->centre.v, hand->centre.v, apart);
        e.slip = lt_vec3_norm(apart);
    }
    if (rig->has_robot) {
        e.robot = rig->robot[3] - lt_vec3_dot(rig->robot, wrist);
        e.robot_speed = hand ? lt_vec3_dot(rig->robot, hand->centre.v) : NAN;
    }
    e.flexion_deg = flexion_of(w, p, e.left);
    return e;
}

/* Where each object stood when nothing touched it and it was at rest */
static void note_support(watch_world *w)
{
    for (int i = 0; i < w->n_things; i++) {
        watch_thing *o = &w->thing[i];
        bool touched = false;

        for (int k = 0; k < w->n_contacts; k++)
            touched = touched || (w->contact[k].object == o->id && w->contact[k].on);
        if (o->kind == DETECTED_OBJECT && o->placed && !touched && lt_vec3_norm(o->centre.v) < AT_REST)
            o->support = o->centre.x[2];
    }
}

lt_status watch_interactions_run(watch_world *w, const watch_set *set)
{
    note_support(w);
    for (int i = 0; i < w->n_people; i++) {
        const interaction_seen seen = see(w, &w->person[i], set->t);

        interaction_step(&w->person[i].interaction, &seen);
    }
    return LT_OK;
}
