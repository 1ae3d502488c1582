/* SPDX-License-Identifier: Apache-2.0 */
/* S9: what a person does, from the last 30 frames of the body and of a hand with an object. */
#include "pipeline/watch/internal.h"

#include "data/action/axes.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "models/action/action.h"

#include <math.h>
#include <string.h>

enum {
    MOST_FRAMES = 90, EVERY = 5,        /* frames in a window at most; between two looks at one */
    LEAST_VALID = 8,                    /* frames with hand and object, else stream 2 is off */
    AGREED = 2,                         /* looks in a row that must say the same */
    PELVIS = 0, CORNERS = 8,
};
static const double FRAME = 1.0 / 30, LOST = 1;         /* seconds */
static const double SURE = 0.5;

/* A ring of frames at 30 a second, whatever the cameras gave */
struct watch_actions {
    float body[MOST_FRAMES][ACTION_BODY][3], hand_object[MOST_FRAMES][ACTION_HAND_OBJECT][3];
    bool valid[MOST_FRAMES];
    int64_t frames;                     /* since the beginning; 0: none */
    double t;                           /* of the last one */
    double last[ACTION_BODY][3], last_t;/* the last skeleton, and when */
    int64_t looked;                     /* frames at the last look */
    watch_action now;
    int next, agreed;                   /* the class that the last looks said, and how many in a row */
    double next_since;
};

lt_status watch_actions_new(watch_actions **out)
{
    *out = lt_alloc(sizeof(**out));
    if (!*out)
        return lt_error(LT_ENOMEM, "no memory for actions");
    (*out)->now.cls = (*out)->next = -1;
    return LT_OK;
}

void watch_actions_free(watch_actions *a)
{
    lt_release(a);
}

/* ---- the network ---- */

static lt_status record(const void *m, model_record *r)
{
    ((const model *)m)->cls->record(m, false, r);
    return LT_OK;
}

lt_status watch_actions_open(watch_world *w)
{
    const trained *t = w->o->models.action;

    if (!t)
        return LT_OK;
    if (action_frames(&t->m) > MOST_FRAMES)
        return lt_error(LT_EINVAL, "%s: looks at %d frames, at most %d are kept", t->path, action_frames(&t->m),
                        MOST_FRAMES);
    return compiled_new(&(recipe){ .ctx = &t->m, .record = record }, 1, false, &w->act);
}

void watch_actions_close(watch_world *w)
{
    if (w->act.plan)
        compiled_free(&w->act);
    for (int i = 0; i < w->n_people; i++)
        watch_actions_free(w->person[i].actions);
}

/* ---- frames ---- */

/* He looks at the robot; without one known, at the camera. */
static void axes_of(const watch_world *w, const watch_person *p, double R[9])
{
    const recording_rig *rig = &w->o->rig;
    const recording_camera *c = &rig->camera[p->camera];
    const double at_camera[3] = { -c->R[2], -c->R[5], 0 };

    lt_mat3_identity(R);
    if (c->placed)
        action_axes(rig->has_robot ? rig->robot : at_camera, R);
    else
        R[0] = R[8] = -1;               /* the camera's own axes: he looks against its z */
}

static void turned(const double R[9], const double p[3], float out[3])
{
    double q[3];

    lt_mat3_mulvec(R, p, q);
    for (int d = 0; d < 3; d++)
        out[d] = (float)q[d];
}

/* The corners of its cuboid and their mean, as its pose has them */
static void fill_object(const watch_thing *object, const double R[9], float (*out)[3])
{
    double O[9], middle[3] = { 0 };

    lt_rot_from_quat(object->pose.q, O);
    for (int k = 0; k < CORNERS; k++) {
        double at[3] = { object->model->control[k][0], object->model->control[k][1], object->model->control[k][2] };

        lt_rigid_apply(O, object->pose.p, at, at);
        turned(R, at, out[k]);
        for (int d = 0; d < 3; d++)
            middle[d] += at[d] / CORNERS;
    }
    turned(R, middle, out[CORNERS]);
}

/* Wrist and fingers, the corners of the object's cuboid and its middle; false: the pair is not known */
static bool fill_pair(watch_world *w, const watch_person *p, const double R[9], float (*out)[3])
{
    for (int i = 0; i < w->n_contacts; i++) {
        const watch_thing *hand = watch_thing_of(w, w->contact[i].hand);
        const watch_thing *object = watch_thing_of(w, w->contact[i].object);

        if (hand->person != p->id || hand->state == LT_FILTER_OFF || object->pose.state == LT_FILTER_OFF)
            continue;
        for (int k = 0; k < LT_HAND_KEYPOINTS; k++)
            turned(R, hand->joint[k].x, out[k]);
        fill_object(object, R, out + LT_HAND_KEYPOINTS);
        return true;
    }
    return false;
}

/* One frame more: between the last skeleton and this one, of which `share` */
static void push(watch_actions *a, const double now[ACTION_BODY][3], double share, const double R[9],
                 const float (*pair)[3])
{
    const int64_t k = a->frames++ % MOST_FRAMES;

    for (int i = 0; i < ACTION_BODY; i++) {
        double p[3];

        for (int d = 0; d < 3; d++)
            p[d] = a->last[i][d] + share * (now[i][d] - a->last[i][d]);
        turned(R, p, a->body[k][i]);
    }
    a->valid[k] = pair != NULL;
    if (pair)
        memcpy(a->hand_object[k], pair, sizeof(a->hand_object[k]));
}

/* The frames between the last skeleton and this one, 30 a second; after a long gap all begins anew. */
static void extend(watch_world *w, watch_person *p, double t)
{
    watch_actions *a = p->actions;
    float pair[ACTION_HAND_OBJECT][3];
    double R[9];
    bool has_pair;

    axes_of(w, p, R);
    has_pair = fill_pair(w, p, R, pair);
    if (!a->frames || t - a->last_t > LOST) {
        *a = (watch_actions){ .t = t - FRAME, .now = { .cls = -1 }, .next = -1 };
        a->last_t = t - FRAME;
        memcpy(a->last, p->joint, sizeof(a->last));
    }
    for (; a->t + FRAME <= t + 1e-9; a->t += FRAME)
        push(a, (const double (*)[3])p->joint, (a->t + FRAME - a->last_t) / (t - a->last_t), R,
             has_pair ? (const float (*)[3])pair : NULL);
    memcpy(a->last, p->joint, sizeof(a->last));
    a->last_t = t;
}

/* ---- looking ---- */

static lt_real *input(const watch_world *w, const char *name)
{
    return lt_plan_data(w->act.plan, model_port_find(&w->act.record.inputs, name));
}

/* The last T frames as the network takes them: less the first pelvis, and less the first valid wrist */
static void fill(const watch_world *w, const watch_actions *a, int T)
{
    lt_real *body = input(w, "body"), *pair = input(w, "hand_object"), *valid = input(w, "valid"), *on = input(w, "on");
    const float *wrist = NULL;
    int n = 0;

    for (int i = 0; i < T; i++) {
        const int64_t k = (a->frames - T + i) % MOST_FRAMES, first = (a->frames - T) % MOST_FRAMES;

        wrist = !wrist && a->valid[k] ? a->hand_object[k][0] : wrist;
        for (int d = 0; d < 3; d++) {
            for (int v = 0; v < ACTION_BODY; v++)
                body[(d * T + i) * ACTION_BODY + v] = (lt_real)(a->body[k][v][d] - a->body[first][PELVIS][d]);
            for (int v = 0; v < ACTION_HAND_OBJECT; v++)
                pair[(d * T + i) * ACTION_HAND_OBJECT + v] = a->valid[k] ? (lt_real)(a->hand_object[k][v][d] - wrist[d])
                    : 0;
        }
        valid[i] = a->valid[k];
        n += a->valid[k];
    }
    on[0] = n >= LEAST_VALID;
}

static void softmax(const lt_real *logit, double out[ACTION_CLASSES])
{
    double most = -INFINITY, sum = 0;

    for (int i = 0; i < ACTION_CLASSES; i++)
        most = fmax(most, (double)logit[i]);
    for (int i = 0; i < ACTION_CLASSES; i++)
        sum += out[i] = exp((double)logit[i] - most);
    for (int i = 0; i < ACTION_CLASSES; i++)
        out[i] /= sum;
}

/* A class becomes what is done when two looks in a row are sure of it; its onset is the first of them. */
static void decide(watch_actions *a, const double p[ACTION_CLASSES])
{
    int best = 0;

    for (int i = 1; i < ACTION_CLASSES; i++)
        best = p[i] > p[best] ? i : best;
    if (best != a->next || p[best] < SURE) {
        a->agreed = 0;
        a->next_since = a->t;
    }
    a->next = best;
    a->agreed += p[best] >= SURE;
    if (a->agreed >= AGREED && best != a->now.cls)
        a->now = (watch_action){ .cls = best, .onset = a->next_since };
    if (a->now.cls >= 0)
        a->now.p = p[a->now.cls];
}

static void look(watch_world *w, watch_actions *a)
{
    const int T = action_frames(&w->o->models.action->m);
    double p[ACTION_CLASSES];

    if (a->frames < T || a->frames - a->looked < EVERY)
        return;
    a->looked = a->frames;
    fill(w, a, T);
    lt_run(w->act.plan);
    softmax(compiled_output(&w->act, "logits"), p);
    decide(a, p);
}

lt_status watch_actions_run(watch_world *w, const watch_set *set)
{
    for (int i = 0; i < w->n_people; i++)
        if (w->person[i].state == LT_FILTER_ON) {
            extend(w, &w->person[i], set->t);
            if (w->act.plan)
                look(w, w->person[i].actions);
            w->person[i].action = w->person[i].actions->now;
        }
    return LT_OK;
}
