/* SPDX-License-Identifier: Apache-2.0 */
/* S6 to S8: while a hand touches an object the estimator looks at both, and filters follow them in the world. */
#include "pipeline/watch/internal.h"

#include "libtensor/base/clock.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

enum { COAST = 15 };                    /* frames that a hand is predicted without being seen */

lt_status watch_hands_open(watch_world *w)
{
    static const char *const see[] = { "look", "estimate", NULL }, *const solve[] = { "solve", NULL };
    const watch_models *m = &w->o->models;
    lt_status st;

    if (!m->estimator || !m->detector)
        return LT_OK;
    w->hand_options = (predict_options){
        .m = &m->estimator->m, .detector = m->detector, .bilinear = m->estimator->bilinear, .hand = m->estimator->hand,
        .checkpoint = m->estimator->path, .alone = true,
    };
    st = pipeline_open(&w->hand_options, FRAME_SCENE | FRAME_DETECTIONS, see, &w->estimate);
    return st ? st : pipeline_open(&w->hand_options, FRAME_VIEWS | FRAME_ESTIMATES, solve, &w->solve);
}

/* ---- which camera ---- */

static const watch_sight *sight_of(const watch_world *w, int camera, int64_t id)
{
    for (int i = 0; i < w->eye[camera].n; i++)
        if (w->eye[camera].sight[i].id == id)
            return &w->eye[camera].sight[i];
    return NULL;
}

static int64_t area_of(const watch_sight *s)
{
    const detection_pixels *p = &s->seen.window;
    const int64_t n = (int64_t)(p->x1 - p->x0) * (p->y1 - p->y0);
    int64_t sum = 0;

    for (int64_t i = 0; p->pixel && i < n; i++)
        sum += p->pixel[i];
    return sum;
}

/* The one that was searched in this set in which the smaller of the two masks is largest; -1: none sees both */
static int best_camera(const watch_world *w, const watch_set *set, const watch_contact *k)
{
    int64_t most = 0;
    int best = -1;

    for (int c = 0; c < w->o->rig.n; c++) {
        const watch_sight *hand = sight_of(w, c, k->hand), *object = sight_of(w, c, k->object);
        const int64_t area = hand && object && set->there[c] && w->eye[c].fresh
            ? 1 + lt_min_i64(area_of(hand), area_of(object)) : 0;

        if (area > most) {
            most = area;
            best = c;
        }
    }
    return best;
}

/* ---- looking ---- */

typedef struct {
    bool hand, object;              /* what was found can be believed */
    double joint[LT_HAND_KEYPOINTS][3];
    lt_pose_measurement pose;
    const predict_object *model;
} look;

static void take_look(const recording_camera *c, const predict_frame *f, look *out)
{
    const predict_result *r = &f->result[0];
    double R[9], own[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 };

    out->hand = predict_trusted(&f->view[0], r);
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const double p[3] = { r->e.joints[i][0], r->e.joints[i][1], r->e.joints[i][2] };

        watch_to_world(c, p, out->joint[i]);
    }
    out->object = f->view[0].object && r->object_found && predict_object_trusted(&f->view[0], r);
    if (!out->object)
        return;
    memcpy(out->pose.R_world_cam, c->placed ? c->R : own, sizeof(own));
    watch_to_world(c, r->e.object.t, out->pose.p);
    lt_mat3_mul(out->pose.R_world_cam, r->e.object.R, R);
    lt_rot_to_quat(R, out->pose.q);
    out->pose.reprojection_px = (double)r->e.object_error_px;
    out->model = f->view[0].object;
    out->pose.symmetry = f->view[0].object->symmetry;
    out->pose.n_symmetries = f->view[0].object->n_symmetries;
}

/* The estimator's look at one pair in one camera */
static lt_status look_at(watch_world *w, const watch_set *set, int camera, const watch_contact *k, look *out)
{
    const recording_camera *c = &w->o->rig.camera[camera];
    const watch_thing *hand = watch_thing_of(w, k->hand);
    predict_detection pair[2] = { sight_of(w, camera, k->hand)->seen, sight_of(w, camera, k->object)->seen };
    predict_frame f = {
        .o = &w->hand_options, .arena = w->arena, .has = FRAME_SCENE | FRAME_DETECTIONS, .detected = true,
        .detection = pair, .n_detections = 2, .notes = { .arena = w->arena },
        .input = { .path = c->name, .name = c->name },
        .scene
            = { .path = c->name, .name = c->name, .rgb = set->picture[camera].rgb.data, .depth = w->eye[camera].metres,
                   .width = c->width, .height = c->height, .orientation = 1, .camera = c->K,
                   .camera_from = PREDICT_GIVEN },
    };
    double begin = lt_clock();
    lt_status st;

    pair[0].side = hand->side == PREDICT_LEFT ? PREDICT_LEFT : PREDICT_RIGHT;
    st = pipeline_run(w->estimate, &f);
    watch_spent(w, 6, &begin);
    st = st ? st : pipeline_run(w->solve, &f);
    if (!st && f.n == 1)
        take_look(c, &f, out);
    watch_spent(w, 7, &begin);
    return st;
}

/* ---- filters ---- */

static void step_hand(watch_thing *hand, double dt, const look *seen)
{
    const bool there = seen && seen->hand;

    if (!there && hand->state == LT_FILTER_OFF)
        return;
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        lt_point_filter_step(&hand->joint[i], dt, there ? seen->joint[i] : NULL);
    hand->coasted = there ? 0 : hand->coasted + (int)lt_max_i64(1, lrint(30 * dt));
    hand->state = there ? LT_FILTER_ON : LT_FILTER_COAST;
    if (hand->coasted <= COAST)
        return;
    hand->state = LT_FILTER_OFF;
    memset(hand->joint, 0, sizeof(hand->joint));
}

static lt_status follow(watch_world *w, const watch_set *set, const watch_contact *k, bool stepped[WATCH_THINGS])
{
    watch_thing *hand = watch_thing_of(w, k->hand), *object = watch_thing_of(w, k->object);
    const int camera = best_camera(w, set, k);
    look seen = { .hand = false };
    lt_status st = camera >= 0 ? look_at(w, set, camera, k, &seen) : LT_OK;
    double begin = lt_clock();

    if (st)
        return st;
    hand->camera = camera >= 0 ? camera : hand->camera;
    step_hand(hand, w->dt, &seen);
    if (seen.object)
        object->model = seen.model;
    lt_pose_filter_step(&object->pose, w->dt, seen.object ? &seen.pose : NULL);
    stepped[hand - w->thing] = stepped[object - w->thing] = true;
    watch_spent(w, 8, &begin);
    return LT_OK;
}

lt_status watch_hands_run(watch_world *w, const watch_set *set)
{
    bool stepped[WATCH_THINGS] = { false };
    lt_status st = LT_OK;

    for (int i = 0; i < w->n_contacts && w->solve && !st; i++)
        if (w->contact[i].on && !stepped[watch_thing_of(w, w->contact[i].hand) - w->thing])
            st = follow(w, set, &w->contact[i], stepped);
    for (int i = 0; i < w->n_things && !st; i++) {
        if (stepped[i])
            continue;
        step_hand(&w->thing[i], w->dt, NULL);
        if (w->thing[i].pose.state != LT_FILTER_OFF)
            lt_pose_filter_step(&w->thing[i].pose, w->dt, NULL);
    }
    return st;
}
