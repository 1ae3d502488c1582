/* SPDX-License-Identifier: Apache-2.0 */
/* S4: the bodies of those whom the camera in front sees, else the one at the side; and whose each hand is. */
#include "pipeline/watch/internal.h"

#include "libtensor/base/order.h"
#include "libtensor/geometry/mat3.h"

#include <math.h>
#include <string.h>

enum { PELVIS = 0, LEFT_WRIST = 12, RIGHT_WRIST = 13 };     /* of data/action's joints */
enum { LEAST_HEIGHT = 64, AROUND = 2 };                     /* pixels of a person's box, and around the pelvis */

static const double NEAR_WRIST = 1.0;                       /* of a hand's box's longer side, plus: */
static const double UNDER_CLOTHES = 0.1;                    /* metres from what is seen of the pelvis to its joint */
static const double INSIDE = 0.7, ONE_PLACE = 0.4;          /* share of a box within another; metres along the floor */
static const double GONE = 1;                               /* seconds without being seen */

/* ---- who is there ---- */

static watch_person *person_of(watch_world *w, int64_t id)
{
    for (int i = 0; i < w->n_people; i++)
        if (w->person[i].id == id)
            return &w->person[i];
    return NULL;
}

static lt_status add_person(watch_world *w, int64_t id, double t, watch_person **out)
{
    watch_person *p = &w->person[w->n_people];
    lt_status st;

    *p = (watch_person){ .id = id, .t = t, .action = { .cls = -1 } };
    st = watch_actions_new(&p->actions);
    if (st)
        return st;
    w->n_people++;
    *out = p;
    return LT_OK;
}

static void drop_gone(watch_world *w, double t)
{
    int kept = 0;

    for (int i = 0; i < w->n_people; i++) {
        w->person[i].state = LT_FILTER_OFF;
        if (t - w->person[i].t <= GONE)
            w->person[kept++] = w->person[i];
        else
            watch_actions_free(w->person[i].actions);
    }
    w->n_people = kept;
}

/* ---- where he stands ---- */

/* The median of the person's depth around a pixel; NaN where none is known, as where something stands before it */
static double depth_around(const watch_eye *e, const recording_camera *c, const watch_sight *s, const float uv[2])
{
    const int u = (int)lrintf(uv[0]), v = (int)lrintf(uv[1]);
    double z[(2 * AROUND + 1) * (2 * AROUND + 1)];
    int64_t n = 0;

    for (int y = v - AROUND; e->metres && y <= v + AROUND; y++)
        for (int x = u - AROUND; x <= u + AROUND; x++)
            if (x >= 0 && x < c->width && y >= 0 && y < c->height && watch_shows(&s->seen, x, y) &&
                e->metres[(int64_t)y * c->width + x] > 0)
                z[n++] = (double)e->metres[(int64_t)y * c->width + x];
    return lt_median(n, z);
}

/* The pelvis: as deep as it is measured where it is seen, else as all of the person is, else as the network has it */
static void place_pelvis(const watch_eye *e, const recording_camera *c, const watch_sight *s, const body_estimate *b,
                         double out[3])
{
    const double pixel[2] = { (double)b->nodes2d[PELVIS][0], (double)b->nodes2d[PELVIS][1] };
    double z = depth_around(e, c, s, b->nodes2d[PELVIS]), middle[3];

    for (int d = 0; d < 3; d++)
        out[d] = b->pelvis[d];
    if (!(z > 0) && s->placed) {
        watch_to_camera(c, s->centre, middle);
        z = middle[2];
    }
    if (z > 0)
        lt_camera_backproject(&c->K, pixel, z + UNDER_CLOTHES, out);
}

static void take_body(const watch_eye *e, const recording_camera *c, const watch_sight *s, const body_estimate *b,
                      watch_person *p)
{
    double pelvis[3];

    place_pelvis(e, c, s, b, pelvis);
    for (int i = 0; i < ACTION_BODY; i++) {
        double at[3];

        for (int d = 0; d < 3; d++)
            at[d] = b->nodes[i][d] + pelvis[d];
        watch_to_world(c, at, p->joint[i]);
    }
}

static void note_seen(watch_person *p, const float box[4], double t, lt_filter_state state)
{
    memcpy(p->box, box, sizeof(p->box));
    p->t = t;
    p->state = state;
}

static lt_status look_at(watch_world *w, const watch_set *set, int camera, const watch_sight *s)
{
    const recording_camera *c = &w->o->rig.camera[camera];
    const crop_box b = s->seen.box;
    const float box[4] = { b.x0, b.y0, b.x1, b.y1 };
    watch_person *p = person_of(w, s->id);
    body_estimate body;
    lt_status st = LT_OK;

    if (!p && w->n_people == WATCH_PEOPLE)
        return LT_OK;
    if (!p)
        st = add_person(w, s->id, set->t, &p);
    if (!st)
        st = body_estimator_run(w->o->models.body, set->picture[camera].rgb.data, c->width, c->height, box, &c->K,
                                &body);
    if (st)
        return st;
    take_body(&w->eye[camera], c, s, &body, p);
    p->camera = camera;
    p->looked = set->t;
    note_seen(p, box, set->t, LT_FILTER_ON);
    return LT_OK;
}

/* Until his next turn a person's joints stay, in the axes of the camera that saw them. */
static void wait_for_turn(watch_world *w, const watch_set *set, int camera, const watch_sight *s)
{
    const crop_box b = s->seen.box;
    watch_person *p = person_of(w, s->id);

    if (p && p->camera == camera)
        note_seen(p, (const float[4]){ b.x0, b.y0, b.x1, b.y1 }, set->t, LT_FILTER_COAST);
}

static bool is_large(const watch_sight *s)
{
    return s->seen.kind == DETECTED_PERSON && s->id && s->seen.box.y1 - s->seen.box.y0 >= LEAST_HEIGHT;
}

/* The share of the smaller of two boxes that lies in the other */
static double share_inside(crop_box a, crop_box b)
{
    const double wide = (double)(fminf(a.x1, b.x1) - fmaxf(a.x0, b.x0)),
        high = (double)(fminf(a.y1, b.y1) - fmaxf(a.y0, b.y0));
    const double least = fmin((double)((a.x1 - a.x0) * (a.y1 - a.y0)), (double)((b.x1 - b.x0) * (b.y1 - b.y0)));

    return wide > 0 && high > 0 && least > 0 ? wide * high / least : 0;
}

/* What lies in somebody's box, or partly does and stands where he stands, is a part of him: legs under a table */
static bool is_part(const recording_camera *c, const watch_sight *of, const watch_sight *s)
{
    const double share = share_inside(of->seen.box, s->seen.box);
    const double apart = c->placed && of->placed && s->placed
        ? hypot(of->centre[0] - s->centre[0], of->centre[1] - s->centre[1]) : INFINITY;

    return share > INSIDE || (share > 0 && apart < ONE_PLACE);
}

/* Worth a look: nobody is a part of somebody who is known for longer. */
static bool is_somebody(const watch_world *w, int camera, int i)
{
    const watch_eye *e = &w->eye[camera];

    if (!is_large(&e->sight[i]))
        return false;
    for (int k = 0; k < e->n; k++)
        if (is_large(&e->sight[k]) && e->sight[k].id < e->sight[i].id &&
            is_part(&w->o->rig.camera[camera], &e->sight[k], &e->sight[i]))
            return false;
    return true;
}

static int count_people(const watch_world *w, const watch_set *set, int camera)
{
    int n = 0;

    for (int i = 0; set->there[camera] && i < w->eye[camera].n; i++)
        n += is_somebody(w, camera, i);
    return n;
}

static int choose_camera(const watch_world *w, const watch_set *set)
{
    static const recording_role order[] = { RECORDING_FRONT, RECORDING_SIDE, RECORDING_TABLE };

    for (size_t k = 0; k < LT_COUNT(order); k++)
        for (int c = 0; c < w->o->rig.n; c++)
            if (w->o->rig.camera[c].role == order[k] && count_people(w, set, c))
                return c;
    return -1;
}

/* ---- whose turn ---- */

/* A newcomer's, if there is room for one, else his whose body was estimated longest ago; NULL: nobody's */
static const watch_sight *whose_turn(watch_world *w, int camera)
{
    const watch_eye *e = &w->eye[camera];
    const watch_sight *next = NULL;
    double oldest = INFINITY;

    for (int i = 0; i < e->n; i++) {
        const watch_person *p = person_of(w, e->sight[i].id);
        const double looked = p ? p->looked : w->n_people < WATCH_PEOPLE ? -INFINITY : INFINITY;

        if (is_somebody(w, camera, i) && looked < oldest) {
            oldest = looked;
            next = &e->sight[i];
        }
    }
    return next;
}

/* On a small machine one body is estimated in each set, in turn, so that many persons take no longer than one. */
static lt_status look_around(watch_world *w, const watch_set *set, int camera)
{
    const bool all = w->o->profile == WATCH_FULL;
    const watch_sight *turn = whose_turn(w, camera);
    lt_status st = LT_OK;

    for (int i = 0; i < w->eye[camera].n && !st; i++) {
        const watch_sight *s = &w->eye[camera].sight[i];

        if (!is_somebody(w, camera, i))
            continue;
        if (all || s == turn)
            st = look_at(w, set, camera, s);
        else
            wait_for_turn(w, set, camera, s);
    }
    return st;
}

/* ---- whose hands ---- */

/* A wrist in a camera's picture; false: behind it */
static bool wrist_in(const recording_camera *c, const watch_person *p, int wrist, double uv[2])
{
    double at[3];

    watch_to_camera(c, p->joint[wrist], at);
    return lt_camera_project(&c->K, at, uv);
}

/* A hand is of the nearest wrist; which side that is decides where the detector does not. */
static void give_hand(watch_world *w, int camera, const watch_sight *s)
{
    const recording_camera *c = &w->o->rig.camera[camera];
    const crop_box b = s->seen.box;
    const double side = (double)fmaxf(b.x1 - b.x0, b.y1 - b.y0), middle[2] = { (b.x0 + b.x1) / 2, (b.y0 + b.y1) / 2 };
    watch_thing *hand = watch_thing_of(w, s->id);
    double nearest = (0.5 + NEAR_WRIST) * side;

    for (int i = 0; hand && i < w->n_people; i++)
        for (int k = LEFT_WRIST; k <= RIGHT_WRIST; k++) {
            const watch_person *p = &w->person[i];
            double uv[2];

            if ((!c->placed && p->camera != camera) || !wrist_in(c, p, k, uv) ||
                !(hypot(uv[0] - middle[0], uv[1] - middle[1]) < nearest))
                continue;
            nearest = hypot(uv[0] - middle[0], uv[1] - middle[1]);
            hand->person = p->id;
            if (s->seen.side == PREDICT_ANY_SIDE)
                hand->side = k == LEFT_WRIST ? PREDICT_LEFT : PREDICT_RIGHT;
        }
}

lt_status watch_people_run(watch_world *w, const watch_set *set)
{
    const int camera = w->o->models.body ? choose_camera(w, set) : -1;
    lt_status st = LT_OK;

    drop_gone(w, set->t);
    if (camera >= 0)
        st = look_around(w, set, camera);
    for (int c = 0; c < w->o->rig.n && !st; c++)
        for (int i = 0; w->eye[c].fresh && i < w->eye[c].n; i++)
            if (w->eye[c].sight[i].seen.kind == DETECTED_HAND)
                give_hand(w, c, &w->eye[c].sight[i]);
    return st;
}
