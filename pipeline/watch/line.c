/* SPDX-License-Identifier: Apache-2.0 */
/* The record of a set, palmar.set/1 (docs/formats.md). */
#include "pipeline/watch/internal.h"

#include "libtensor/geometry/rotation.h"

#include <cjson/cJSON.h>
#include <math.h>

static const char SCHEMA[] = "palmar.set/1";

/* Rounded to what is meant, so that a line is no longer than it need be: tenths of a millimetre, of a pixel ... */
static double rounded(double x, double per)
{
    return isfinite(x) ? round(x * per) / per : NAN;
}

static const double METRES = 1e4, PIXELS = 10, SECONDS = 1e4, SHARE = 1e3, TURN = 1e5;

static void add(cJSON *to, const char *key, double x, double per)
{
    const double r = rounded(x, per);

    if (isnan(r))
        cJSON_AddNullToObject(to, key);
    else
        cJSON_AddNumberToObject(to, key, r);
}

static cJSON *list(const double *x, int n, double per)
{
    cJSON *out = cJSON_CreateArray();

    for (int i = 0; i < n; i++)
        cJSON_AddItemToArray(out, cJSON_CreateNumber(rounded(x[i], per)));
    return out;
}

static cJSON *box_of(crop_box b)
{
    const double x[] = { (double)b.x0, (double)b.y0, (double)b.x1, (double)b.y1 };

    return list(x, 4, PIXELS);
}

static const char *side_name(predict_side s)
{
    return s == PREDICT_LEFT ? "left" : "right";
}

static const char *state_name(lt_filter_state s)
{
    return s == LT_FILTER_ON ? "on" : "coast";
}

static void add_id(cJSON *to, const char *key, int64_t id)
{
    if (id)
        cJSON_AddNumberToObject(to, key, (double)id);
    else
        cJSON_AddNullToObject(to, key);
}

/* ---- what there is ---- */

static void add_tracks(const watch_world *w, cJSON *to)
{
    cJSON *tracks = cJSON_AddArrayToObject(to, "tracks");

    for (int c = 0; c < w->o->rig.n; c++)
        for (int i = 0; i < w->eye[c].n && w->eye[c].fresh; i++) {
            const watch_sight *s = &w->eye[c].sight[i];
            cJSON *t = s->id ? cJSON_CreateObject() : NULL;

            if (!t)
                continue;
            cJSON_AddNumberToObject(t, "id", (double)s->id);
            cJSON_AddStringToObject(t, "class", s->seen.name);
            cJSON_AddNumberToObject(t, "camera", c);
            cJSON_AddNumberToObject(t, "track", (double)s->seen.track);
            cJSON_AddItemToObject(t, "box", box_of(s->seen.box));
            add(t, "score", s->seen.score, SHARE);
            cJSON_AddItemToObject(t, "centre", s->placed ? list(s->centre, 3, METRES) : cJSON_CreateNull());
            cJSON_AddItemToArray(tracks, t);
        }
}

static cJSON *hand_json(const watch_thing *h)
{
    cJSON *out = cJSON_CreateObject(), *joints;

    cJSON_AddNumberToObject(out, "id", (double)h->id);
    cJSON_AddStringToObject(out, "side", side_name(h->side));
    add_id(out, "person", h->person);
    joints = cJSON_AddArrayToObject(out, "joints");
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        cJSON_AddItemToArray(joints, list(h->joint[i].x, 3, METRES));
    cJSON_AddStringToObject(out, "state", state_name(h->state));
    cJSON_AddNumberToObject(out, "camera", h->camera);
    add(out, "score", h->score, SHARE);
    return out;
}

static cJSON *object_json(const watch_thing *o)
{
    cJSON *out = cJSON_CreateObject();
    double R[9];

    lt_rot_from_quat(o->pose.q, R);
    cJSON_AddNumberToObject(out, "id", (double)o->id);
    cJSON_AddStringToObject(out, "class", o->name);
    cJSON_AddItemToObject(out, "R", list(R, 9, TURN));
    cJSON_AddItemToObject(out, "t", list(o->pose.p, 3, METRES));
    cJSON_AddStringToObject(out, "state", state_name(o->pose.state));
    return out;
}

static void add_things(const watch_world *w, cJSON *to)
{
    cJSON *hands = cJSON_AddArrayToObject(to, "hands"), *objects = cJSON_AddArrayToObject(to, "objects");

    for (int i = 0; i < w->n_things; i++) {
        if (w->thing[i].state != LT_FILTER_OFF)
            cJSON_AddItemToArray(hands, hand_json(&w->thing[i]));
        if (w->thing[i].pose.state != LT_FILTER_OFF)
            cJSON_AddItemToArray(objects, object_json(&w->thing[i]));
    }
}

static void add_people(const watch_world *w, cJSON *to)
{
    cJSON *people = cJSON_AddArrayToObject(to, "people");

    for (int i = 0; i < w->n_people; i++) {
        const watch_person *p = &w->person[i];
        cJSON *out = p->state != LT_FILTER_OFF ? cJSON_CreateObject() : NULL, *joints;

        if (!out)
            continue;
        cJSON_AddNumberToObject(out, "id", (double)p->id);
        joints = cJSON_AddArrayToObject(out, "joints");
        for (int k = 0; k < ACTION_BODY; k++)
            cJSON_AddItemToArray(joints, list(p->joint[k], 3, METRES));
        cJSON_AddStringToObject(out, "state", state_name(p->state));
        cJSON_AddNumberToObject(out, "camera", p->camera);
        cJSON_AddItemToObject(out, "box", box_of((crop_box){ p->box[0], p->box[1], p->box[2], p->box[3] }));
        cJSON_AddItemToArray(people, out);
    }
}

static void add_contact(const watch_world *w, cJSON *to)
{
    cJSON *contact = cJSON_AddArrayToObject(to, "contact");

    for (int i = 0; i < w->n_contacts; i++) {
        const watch_contact *k = &w->contact[i];
        cJSON *out = k->on ? cJSON_CreateObject() : NULL;

        if (!out)
            continue;
        cJSON_AddNumberToObject(out, "hand", (double)k->hand);
        cJSON_AddNumberToObject(out, "object", (double)k->object);
        cJSON_AddNumberToObject(out, "camera", k->camera);
        add(out, "since", k->since, SECONDS);
        cJSON_AddItemToArray(contact, out);
    }
}

static void add_doing(const watch_world *w, cJSON *to)
{
    cJSON *action = cJSON_AddArrayToObject(to, "action"), *states = cJSON_AddArrayToObject(to, "interaction");

    for (int i = 0; i < w->n_people; i++) {
        const watch_person *p = &w->person[i];
        const watch_action a = p->action;
        cJSON *s = cJSON_CreateObject();

        if (a.cls >= 0) {
            cJSON *out = cJSON_CreateObject();

            cJSON_AddNumberToObject(out, "person", (double)p->id);
            cJSON_AddStringToObject(out, "class", action_classes[a.cls]);
            add(out, "p", a.p, SHARE);
            add(out, "onset", a.onset, SECONDS);
            cJSON_AddItemToArray(action, out);
        }
        cJSON_AddNumberToObject(s, "person", (double)p->id);
        cJSON_AddStringToObject(s, "state", interaction_names[p->interaction.state]);
        add_id(s, "object", p->interaction.object);
        cJSON_AddStringToObject(s, "side", p->interaction.left ? "left" : "right");
        add(s, "since", p->interaction.since, SECONDS);
        add(s, "p", p->interaction.p, SHARE);
        cJSON_AddItemToArray(states, s);
    }
}

cJSON *watch_line_of(const watch_world *w, const watch_set *set)
{
    cJSON *out = cJSON_CreateObject(), *times, *dropped;

    cJSON_AddStringToObject(out, "schema", SCHEMA);
    cJSON_AddNumberToObject(out, "set", (double)set->number);
    times = cJSON_AddArrayToObject(out, "t");
    for (int c = 0; c < w->o->rig.n; c++)
        cJSON_AddItemToArray(times, set->there[c] ? cJSON_CreateNumber(rounded(set->picture[c].t, SECONDS))
                                                  : cJSON_CreateNull());
    add(out, "pair_ms", set->pair_ms, 10);
    dropped = cJSON_AddArrayToObject(out, "dropped");
    for (int c = 0; c < w->o->rig.n; c++)
        cJSON_AddItemToArray(dropped, cJSON_CreateNumber((double)set->dropped[c]));
    add_tracks(w, out);
    add_things(w, out);
    add_people(w, out);
    add_contact(w, out);
    add_doing(w, out);
    return out;
}
