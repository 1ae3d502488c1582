/* SPDX-License-Identifier: Apache-2.0 */
/* S1 and S2: what each camera sees, and which of it is which. */
#include "pipeline/watch/internal.h"

#include "libtensor/base/clock.h"
#include "libtensor/base/order.h"
#include "libtensor/geometry/mat3.h"

#include <string.h>

enum { FEW_PIXELS = 20, ENOUGH_PIXELS = 2000 };         /* with depth, to place a thing */
enum { MOST_LOOKS = 4 };                /* at boxes of a frame, on a small machine */

void watch_to_world(const recording_camera *c, const double p[3], double out[3])
{
    if (c->placed)
        lt_rigid_apply(c->R, c->t, p, out);
    else
        memmove(out, p, 3 * sizeof(*out));
}

void watch_to_camera(const recording_camera *c, const double p[3], double out[3])
{
    double Rt[9], d[3];

    memcpy(d, p, sizeof(d));
    if (c->placed) {
        lt_mat3_transpose(c->R, Rt);
        lt_vec3_sub(p, c->t, d);
        lt_mat3_mulvec(Rt, d, d);
    }
    memcpy(out, d, sizeof(d));
}

/* ---- where a thing is ---- */

bool watch_shows(const predict_detection *d, int x, int y)
{
    const detection_pixels *w = &d->window;
    const float left = d->box.x1 - d->box.x0, top = d->box.y1 - d->box.y0;

    if (w->pixel)
        return x >= w->x0 && x < w->x1 && y >= w->y0 && y < w->y1 &&
            w->pixel[(y - w->y0) * (w->x1 - w->x0) + x - w->x0];
    return (float)x > d->box.x0 + left / 4 && (float)x < d->box.x1 - left / 4 && (float)y > d->box.y0 + top / 4 &&
           (float)y < d->box.y1 - top / 4;
}

/* Every so manieth row and column of a window, so that some 2,000 places stand for all */
static int stride_of(int64_t pixels)
{
    int stride = 1;

    while (pixels / ((int64_t)stride * stride) > ENOUGH_PIXELS)
        stride++;
    return stride;
}

/* The median depth of a thing's pixels, and the median of where they are seen; false: too few have depth */
static bool middle_of(const watch_world *w, const watch_eye *e, const recording_camera *c, const predict_detection *d,
                      double out[3])
{
    const int x0 = (int)lt_max_i64(0, (int64_t)d->box.x0), y0 = (int)lt_max_i64(0, (int64_t)d->box.y0);
    const int x1 = (int)lt_min_i64(c->width, (int64_t)d->box.x1 + 2);
    const int y1 = (int)lt_min_i64(c->height, (int64_t)d->box.y1 + 2);
    const int64_t most = x1 > x0 && y1 > y0 ? (int64_t)(x1 - x0) * (y1 - y0) : 0;
    const int stride = stride_of(most);
    double *z = lt_arena_array(w->arena, 3 * (size_t)most, sizeof(*z)), *u = z + most, *v = u + most, uv[2], p[3];
    int64_t n = 0;

    if (!e->metres || !z)
        return false;
    for (int y = y0; y < y1; y += stride)
        for (int x = x0; x < x1; x += stride)
            if (e->metres[(int64_t)y * c->width + x] > 0 && watch_shows(d, x, y)) {
                z[n] = (double)e->metres[(int64_t)y * c->width + x];
                u[n] = x;
                v[n++] = y;
            }
    if (n < FEW_PIXELS)
        return false;
    uv[0] = lt_median(n, u);
    uv[1] = lt_median(n, v);
    lt_camera_backproject(&c->K, uv, lt_median(n, z), p);
    watch_to_world(c, p, out);
    return true;
}

/* ---- looking ---- */

static lt_status open_eye(watch_world *w, int c)
{
    static const char *const detect[] = { "detect", NULL }, *const track[] = { "track", NULL };
    const watch_models *m = &w->o->models;
    watch_eye *e = &w->eye[c];
    lt_status st;

    e->arena = lt_arena_new();
    e->scratch = lt_arena_new();
    if (!e->arena || !e->scratch)
        return lt_error(LT_ENOMEM, "no memory for a camera");
    e->options = (predict_options){ .detector = m->detector, .embedder = m->embedder,
                                    .track = m->embedder ? TRACK_DEEPSORT : TRACK_BYTE,
                                    .most_looks = w->o->profile == WATCH_CPU ? MOST_LOOKS : 0 };
    e->film = (predict_followed){ .arena = e->arena, .which = c + 1, .dt = 1 / w->o->rig.fps };
    st = m->detector ? pipeline_open(&e->options, FRAME_SCENE, detect, &e->detect) : LT_OK;
    return st || !m->detector ? st : pipeline_open(&e->options, FRAME_DETECTIONS, track, &e->track);
}

lt_status watch_eyes_open(watch_world *w)
{
    lt_status st = LT_OK;

    for (int c = 0; c < w->o->rig.n && !st; c++)
        st = open_eye(w, c);
    return st;
}

void watch_eyes_close(watch_world *w)
{
    for (int c = 0; c < w->o->rig.n; c++) {
        pipeline_close(w->eye[c].track);
        pipeline_close(w->eye[c].detect);
        lt_arena_free(w->eye[c].arena);
        lt_arena_free(w->eye[c].scratch);
    }
}

static lt_status measure_depth(watch_world *w, const watch_set *set, int c)
{
    const recording_camera *camera = &w->o->rig.camera[c];
    const int64_t n = (int64_t)camera->width * camera->height;
    const uint16_t *steps = set->picture[c].depth;
    watch_eye *e = &w->eye[c];

    e->metres = NULL;
    if (!set->there[c] || !steps || !(camera->depth_scale > 0))
        return LT_OK;
    e->metres = lt_arena_array(w->arena, (size_t)n, sizeof(*e->metres));
    if (!e->metres)
        return lt_error(LT_ENOMEM, "no memory for depth");
    for (int64_t i = 0; i < n; i++)
        e->metres[i] = (float)(steps[i] * camera->depth_scale);
    return LT_OK;
}

/* Masks move to memory that lasts until the camera is searched again. */
static lt_status keep(watch_eye *e, const predict_detection *d, watch_sight *out)
{
    const detection_pixels *from = &d->window;
    const size_t n = from->pixel ? (size_t)(from->x1 - from->x0) * (size_t)(from->y1 - from->y0) : 0;

    *out = (watch_sight){ .seen = *d };
    if (!n)
        return LT_OK;
    out->seen.window.pixel = lt_arena_alloc(e->arena, n);
    if (!out->seen.window.pixel)
        return lt_error(LT_ENOMEM, "no memory for what is seen");
    memcpy(out->seen.window.pixel, from->pixel, n);
    return LT_OK;
}

static lt_status keep_all(watch_world *w, int c, const predict_frame *f)
{
    watch_eye *e = &w->eye[c];
    lt_status st = LT_OK;

    lt_arena_reset(e->arena);
    e->n = 0;
    e->sight = lt_arena_array(e->arena, (size_t)f->n_detections, sizeof(*e->sight));
    if (!e->sight)
        return lt_error(LT_ENOMEM, "no memory for what is seen");
    for (int i = 0; i < f->n_detections && !st; i++) {
        watch_sight *s = &e->sight[e->n++];

        st = keep(e, &f->detection[i], s);
        s->placed = !st && middle_of(w, e, &w->o->rig.camera[c], &s->seen, s->centre);
    }
    return st;
}

static lt_status search(watch_world *w, const watch_set *set, int c)
{
    const recording_camera *camera = &w->o->rig.camera[c];
    watch_eye *e = &w->eye[c];
    predict_frame f = {
        .o = &e->options, .arena = e->scratch, .film = &e->film, .has = FRAME_SCENE,
        .input = { .path = camera->name, .name = camera->name }, .notes = { .arena = e->scratch },
        .scene = { .path = camera->name, .name = camera->name, .rgb = set->picture[c].rgb.data, .width = camera->width,
                   .height = camera->height, .orientation = 1, .camera = camera->K, .camera_from = PREDICT_GIVEN },
    };
    double begin = lt_clock();
    lt_status st;

    lt_arena_reset(e->scratch);
    e->film.time = set->t;
    st = pipeline_run(e->detect, &f);
    watch_spent(w, 1, &begin);
    st = st ? st : pipeline_run(e->track, &f);
    st = st ? st : keep_all(w, c, &f);
    watch_spent(w, 2, &begin);
    return st;
}

/* Of several cameras on a small machine one is searched in each set, in turn; where that one has no frame, the next. */
static int whose_turn(const watch_world *w, const watch_set *set)
{
    for (int i = 0; i < w->o->rig.n; i++) {
        const int c = (int)((set->number + i) % w->o->rig.n);

        if (set->there[c])
            return c;
    }
    return set->reference;
}

lt_status watch_eyes_run(watch_world *w, const watch_set *set)
{
    const int turn = w->o->profile == WATCH_CPU ? whose_turn(w, set) : -1;
    lt_status st = LT_OK;

    for (int c = 0; c < w->o->rig.n && !st; c++) {
        w->eye[c].fresh = w->eye[c].detect && set->there[c] && (turn < 0 || turn == c);
        st = measure_depth(w, set, c);
        if (!st && w->eye[c].fresh)
            st = search(w, set, c);
    }
    return st;
}
