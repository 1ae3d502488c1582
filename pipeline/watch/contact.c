/* SPDX-License-Identifier: Apache-2.0 */
/* S5: which hand touches which object, in pixels and in depth, with hysteresis. */
#include "pipeline/watch/internal.h"

#include "libtensor/base/order.h"

#include <math.h>
#include <string.h>

static const double OVERLAP = 0.05, DEPTH_APART = 0.05;     /* IoU; metres */
enum { REACH = 3, GROWN = 10, FEW_DEPTHS = 20 };            /* pixels */
enum { SETS_ON = 2, SETS_OFF = 5 };
static const double UNSEEN = 0.5;                           /* seconds */

typedef struct { int x0, y0, x1, y1; } area;                /* x1 and y1 one past the last */

static double iou(crop_box a, crop_box b)
{
    const double w = (double)(fminf(a.x1, b.x1) - fmaxf(a.x0, b.x0)),
        h = (double)(fminf(a.y1, b.y1) - fmaxf(a.y0, b.y0));
    const double both = w > 0 && h > 0 ? w * h : 0;
    const double all = (double)((a.x1 - a.x0) * (a.y1 - a.y0)) + (double)((b.x1 - b.x0) * (b.y1 - b.y0)) - both;

    return all > 0 ? both / all : 0;
}

static bool pixel_at(const detection_pixels *w, int x, int y)
{
    return x >= w->x0 && x < w->x1 && y >= w->y0 && y < w->y1 && w->pixel[(y - w->y0) * (w->x1 - w->x0) + x - w->x0];
}

static bool any_within_reach(const detection_pixels *w, int x, int y)
{
    for (int v = y - REACH; v <= y + REACH; v++)
        for (int u = x - REACH; u <= x + REACH; u++)
            if (pixel_at(w, u, v))
                return true;
    return false;
}

/* Whether the hand's mask, grown by 3 pixels, meets the object's */
static bool masks_meet(const detection_pixels *hand, const detection_pixels *object)
{
    const int x0 = (int)lt_max_i64(hand->x0 - REACH, object->x0), x1 = (int)lt_min_i64(hand->x1 + REACH, object->x1);
    const int y0 = (int)lt_max_i64(hand->y0 - REACH, object->y0), y1 = (int)lt_min_i64(hand->y1 + REACH, object->y1);

    if (!hand->pixel || !object->pixel)
        return false;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++)
            if (pixel_at(object, x, y) && any_within_reach(hand, x, y))
                return true;
    return false;
}

/* The median depth of a mask within an area; NaN: fewer than 20 of its pixels there have depth */
static double depth_of(lt_arena *arena, const watch_eye *e, const recording_camera *c, const detection_pixels *w,
                       area a)
{
    const int x0 = (int)lt_max_i64(a.x0, w->x0), x1 = (int)lt_min_i64(a.x1, w->x1);
    const int y0 = (int)lt_max_i64(a.y0, w->y0), y1 = (int)lt_min_i64(a.y1, w->y1);
    const size_t most = x1 > x0 && y1 > y0 ? (size_t)(x1 - x0) * (size_t)(y1 - y0) : 0;
    double *z = lt_arena_array(arena, most, sizeof(*z));
    int64_t n = 0;

    for (int y = y0; z && y < y1; y++)
        for (int x = x0; x < x1; x++)
            if (pixel_at(w, x, y) && e->metres[(int64_t)y * c->width + x] > 0)
                z[n++] = (double)e->metres[(int64_t)y * c->width + x];
    return n < FEW_DEPTHS ? NAN : lt_median(n, z);
}

static area whole(const detection_pixels *w)
{
    return (area){ w->x0, w->y0, w->x1, w->y1 };
}

static bool depths_agree(const watch_world *w, int camera, const predict_detection *hand,
                         const predict_detection *object)
{
    const recording_camera *c = &w->o->rig.camera[camera];
    const watch_eye *e = &w->eye[camera];
    const area both = {
        (int)fmaxf(hand->box.x0, object->box.x0) - GROWN, (int)fmaxf(hand->box.y0, object->box.y0) - GROWN,
        (int)fminf(hand->box.x1, object->box.x1) + 1 + GROWN, (int)fminf(hand->box.y1, object->box.y1) + 1 + GROWN,
    };
    double of_hand, of_object;

    if (!hand->window.pixel || !object->window.pixel)
        return false;
    of_hand = depth_of(w->arena, e, c, &hand->window, both);
    of_object = depth_of(w->arena, e, c, &object->window, both);
    if (isnan(of_hand) || isnan(of_object)) {
        of_hand = depth_of(w->arena, e, c, &hand->window, whole(&hand->window));
        of_object = depth_of(w->arena, e, c, &object->window, whole(&object->window));
    }
    return fabs(of_hand - of_object) <= DEPTH_APART;
}

/* Without depth what overlaps is taken for touching. */
static bool touches(const watch_world *w, int camera, const predict_detection *hand, const predict_detection *object)
{
    return (iou(hand->box, object->box) >= OVERLAP || masks_meet(&hand->window, &object->window)) &&
           (!w->eye[camera].metres || depths_agree(w, camera, hand, object));
}

/* ---- pairs ---- */

static watch_contact *find_contact(watch_world *w, int64_t hand, int64_t object)
{
    for (int i = 0; i < w->n_contacts; i++)
        if (w->contact[i].hand == hand && w->contact[i].object == object)
            return &w->contact[i];
    return NULL;
}

static watch_contact *add_contact(watch_world *w, int64_t hand, int64_t object)
{
    if (w->n_contacts == WATCH_CONTACTS)
        return NULL;
    w->contact[w->n_contacts] = (watch_contact){ .hand = hand, .object = object, .camera = -1 };
    return &w->contact[w->n_contacts++];
}

/* What a camera that was searched says of a pair: it touches where one says so, and the largest overlap counts. */
static void look_at(watch_world *w, int camera, const watch_sight *hand, const watch_sight *object, double t)
{
    const bool touching = touches(w, camera, &hand->seen, &object->seen);
    const double overlap = iou(hand->seen.box, object->seen.box);
    watch_contact *k = find_contact(w, hand->id, object->id);

    if (!k && touching)
        k = add_contact(w, hand->id, object->id);
    if (!k)
        return;
    if (k->camera < 0 || overlap > k->overlap) {
        k->camera = camera;
        k->overlap = overlap;
    }
    k->touching = k->touching || touching;
    k->looked = t;
}

static void look_around(watch_world *w, int camera, double t)
{
    const watch_eye *e = &w->eye[camera];

    for (int i = 0; i < e->n; i++)
        for (int k = 0; k < e->n; k++)
            if (e->sight[i].seen.kind == DETECTED_HAND && e->sight[k].seen.kind == DETECTED_OBJECT && e->sight[i].id &&
                e->sight[k].id)
                look_at(w, camera, &e->sight[i], &e->sight[k], t);
}

/* Of several objects that a hand touches the one that it overlaps most */
static bool is_best(const watch_world *w, const watch_contact *k)
{
    for (int i = 0; i < w->n_contacts; i++)
        if (w->contact[i].hand == k->hand && w->contact[i].touching && w->contact[i].overlap > k->overlap)
            return false;
    return true;
}

void watch_contact_step(watch_contact *k, bool touching, double t)
{
    k->positive = touching ? k->positive + 1 : 0;
    k->negative = touching ? 0 : k->negative + 1;
    if (!k->on && k->positive >= SETS_ON) {
        k->on = true;
        k->since = t;
    }
    k->on = k->on && k->negative < SETS_OFF;
}

/* A set in which no camera looked at both says nothing, if that does not last. */
static void count(const watch_world *w, watch_contact *k, double t)
{
    if (k->looked >= t || t - k->looked >= UNSEEN)
        watch_contact_step(k, k->touching && is_best(w, k), t);
}

/* One of a thing that is gone, or that came to nothing */
static bool is_over(watch_world *w, const watch_contact *k)
{
    return !watch_thing_of(w, k->hand) || !watch_thing_of(w, k->object) || (!k->on && k->negative >= SETS_OFF);
}

static void drop_over(watch_world *w)
{
    int kept = 0;

    for (int i = 0; i < w->n_contacts; i++)
        if (!is_over(w, &w->contact[i]))
            w->contact[kept++] = w->contact[i];
    w->n_contacts = kept;
}

lt_status watch_contact_run(watch_world *w, const watch_set *set)
{
    for (int i = 0; i < w->n_contacts; i++) {
        w->contact[i].touching = false;
        w->contact[i].overlap = 0;
        w->contact[i].camera = w->contact[i].on ? w->contact[i].camera : -1;
    }
    for (int c = 0; c < w->o->rig.n; c++)
        if (w->eye[c].fresh)
            look_around(w, c, set->t);
    for (int i = 0; i < w->n_contacts; i++)
        count(w, &w->contact[i], set->t);
    drop_over(w);
    return LT_OK;
}
