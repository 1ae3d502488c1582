/* SPDX-License-Identifier: Apache-2.0 */
/* From frames to a graph's inputs. */
#include "tasks/hogs/feed.h"

#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

#define DEGREES (M_PI / 180)

/* ---- where Gaussians are under the initial poses --------------------------------------------------------- */

hogs_placer hogs_placer_of(const hogs *m, const hogs_lists *lists, const hogs_rig *rigs, const hogs_frame *f)
{
    hogs_placer p = { .m = m, .lists = lists, .rig = &rigs[f->subject], .frame = f };

    hogs_rig_bones(p.rig, f->initial.rotation[0], f->initial.root, p.bone);
    return p;
}

int64_t feed_first_row(const hogs_placer *p, bool object)
{
    return gaussians_first(&p->m->gaussians, object ? p->m->config.hands + p->frame->object : p->frame->subject);
}

int64_t feed_count(const hogs_placer *p, bool object)
{
    return gaussians_count(&p->m->gaussians, object ? p->m->config.hands + p->frame->object : p->frame->subject);
}

void hogs_posed_at(const hogs_placer *p, bool object, int64_t i, double out[3])
{
    const int64_t row = feed_first_row(p, object) + i;
    const lt_real *c = p->m->gaussians.centre->data + 3 * row;
    const double x[3] = { (double)c[0], (double)c[1], (double)c[2] };
    const hogs_poses *pose = &p->frame->initial;
    const int vertex = p->lists->vertex[row];
    hogs_bone T;

    if (object) {
        for (int k = 0; k < 3; k++)
            out[k] = (double)pose->R[3 * k] * x[0] + (double)pose->R[3 * k + 1] * x[1]
                     + (double)pose->R[3 * k + 2] * x[2] + (double)pose->t[k];
        return;
    }
    hogs_rig_blend(p->rig, p->bone, vertex < 0 ? 0 : vertex, T);
    hogs_bone_apply(T, x, out);
}

/* ---- helpers --------------------------------------------------------------------------------------------- */

void *feed_at(const feed_job *j, const char *name)
{
    const lt_tensor *t = model_port_find(&j->r->inputs, name);
    char *x = t ? lt_plan_data(j->plan, t) : NULL;

    return x ? x + lt_nbytes(t) / (size_t)j->batch * (size_t)j->slot : NULL;
}

void *feed_whole(const feed_job *j, const char *name)
{
    const lt_tensor *t = model_port_find(&j->r->inputs, name);

    return t ? lt_plan_data(j->plan, t) : NULL;
}

int32_t *feed_integers(const feed_job *j, const char *name)
{
    char own[32];

    snprintf(own, sizeof(own), "%s%d", name, j->slot);
    return feed_whole(j, j->batch > 1 ? own : name);
}

void feed_integer(const feed_job *j, const char *name, int64_t value)
{
    int32_t *x = feed_integers(j, name);

    if (x)
        *x = (int32_t)value;
}

void feed_floats(const feed_job *j, const char *name, const float *from, int64_t n)
{
    lt_real *x = feed_at(j, name);

    for (int64_t i = 0; x && i < n; i++)
        x[i] = (lt_real)from[i];
}

/* ---- a set ----------------------------------------------------------------------------------------------- */

bool feed_in_crop(const hogs_frame *f, const double x[3], double out[2])
{
    double uv[2];

    if (!lt_camera_project(&f->camera, x, uv))
        return false;
    uv[0] += 0.5, uv[1] += 0.5;             /* from pixels' middles to their edges, as crops have it */
    lt_affine_apply(f->crop, uv, out);
    return true;
}

typedef struct {
    const feed_job *j;
    bool object;
    lt_real *place;                 /* (N, 2) */
} place_job;

enum { ROWS = 256 };

static void place_rows(void *ctx, int64_t block)
{
    const place_job *p = ctx;
    const feed_job *j = p->j;
    const int64_t n = feed_count(&j->placer, p->object), capacity = gaussians_capacity(&j->m->gaussians);
    const double cells = j->m->sizes.map - 1, S = j->m->sizes.crop;

    for (int64_t i = block * ROWS; i < lt_min_i64((block + 1) * ROWS, capacity); i++) {
        double x[3], uv[2] = { -S, -S };                /* nowhere: outside of the map */

        if (i < n) {
            hogs_posed_at(&j->placer, p->object, i, x);
            feed_in_crop(j->f, x, uv);
        }
        for (int k = 0; k < 2; k++)
            p->place[2 * i + k] = (lt_real)(uv[k] / S * cells);
    }
}

static void feed_set(const feed_job *j, bool object)
{
    const int64_t capacity = gaussians_capacity(&j->m->gaussians), n = feed_count(&j->placer, object);
    lt_real *alive = feed_at(j, object ? "object_alive" : "hand_alive");
    place_job places = { j, object, feed_at(j, object ? "object_place" : "hand_place") };

    feed_integer(j, object ? "object_set" : "hand_set", object ? j->f->object : j->f->subject);
    feed_integer(j, object ? "object_row" : "hand_row", feed_first_row(&j->placer, object));
    for (int64_t i = 0; alive && i < capacity; i++)
        alive[i] = i < n;
    if (places.place)
        lt_parallel_for(lt_ceil_div(capacity, ROWS), place_rows, &places);
}

static void feed_neighbours(const feed_job *j, bool object)
{
    int32_t *near = feed_whole(j, object ? "object_near" : "hand_near");
    lt_real *offset = feed_whole(j, object ? "object_offset" : "hand_offset");
    const int64_t capacity = gaussians_capacity(&j->m->gaussians);

    if (near)
        memcpy(near, j->run->lists.near[feed_first_row(&j->placer, object)],
               (size_t)capacity * sizeof(*j->run->lists.near));
    if (offset)
        memset(offset, 0, 2 * (size_t)capacity * sizeof(*offset));
}

/* ---- camera and poses ------------------------------------------------------------------------------------ */

/* Which way colours are seen from, shaken in training: roll and yaw normal, pitch uniform          [3DGS-Avatar] */
static void feed_view(feed_job *j)
{
    lt_real *x = feed_whole(j, "view");
    double R[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 };

    if (!x)
        return;
    if (j->by->stage != HOGS_RENDER) {
        const double roll = fmax(-90, fmin(90, 45 * lt_rng_normal(&j->rng)));
        const double yaw = fmax(-90, fmin(90, 45 * lt_rng_normal(&j->rng))), pitch = lt_rng_range(&j->rng, 0, 45);
        double X[9], Y[9], Z[9];

        lt_rot_from_axis_angle((double[]){ pitch * DEGREES, 0, 0 }, X);
        lt_rot_from_axis_angle((double[]){ 0, yaw * DEGREES, 0 }, Y);
        lt_rot_from_axis_angle((double[]){ 0, 0, roll * DEGREES }, Z);
        lt_mat3_mul(Y, X, R);
        lt_mat3_mul(Z, R, R);
    }
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            x[4 * r + c] = (lt_real)(c < 3 ? R[3 * r + c] : 0);
}

static void feed_camera(const feed_job *j)
{
    lt_real *camera = feed_whole(j, "camera"), *bones = feed_whole(j, "bones");
    int32_t *degree = feed_whole(j, "degree");
    const lt_camera *c = &j->f->camera;

    if (camera) {
        camera[0] = (lt_real)c->fx, camera[1] = (lt_real)c->fy;
        camera[2] = (lt_real)c->cx, camera[3] = (lt_real)c->cy;
    }
    for (int i = 0; bones && i < 12 * LT_HAND_JOINTS; i++)
        bones[i] = (lt_real)j->placer.bone[i / 12][i % 12];
    if (degree)
        *degree = j->by->stage == HOGS_RENDER ? 3 : j->run->degree;
}

static void feed_truth(const feed_job *j)
{
    const hogs_frame *f = j->f;
    const lt_real *box = j->m->box[1]->data + 6 * f->object;
    lt_real *corners = feed_at(j, "corners"), *offset = feed_at(j, "offset"), *weight = feed_at(j, "pose_weight");

    feed_floats(j, "rotation", f->initial.R, 9);
    feed_floats(j, "translation", f->initial.t, 3);
    feed_floats(j, "true_rotation", f->known ? f->truth.R : f->initial.R, 9);
    feed_floats(j, "true_translation", f->known ? f->truth.t : f->initial.t, 3);
    if (weight)
        *weight = f->known;
    for (int k = 0; offset && k < 3; k++) {     /* each from its own hand's root */
        const float was = f->initial.t[k] - f->initial.root[k];

        offset[k] = f->known ? f->truth.t[k] - f->truth.root[k] - was : 0;
    }
    for (int i = 0; corners && i < HOGS_CORNERS; i++)
        for (int k = 0; k < 3; k++)
            corners[3 * i + k] = box[k] + (i >> k & 1 ? 1 : -1) / box[3 + k];
}

/* ---- images ---------------------------------------------------------------------------------------------- */

/* What the ViT sees, of graphs that it is not in */
static void feed_seen(const feed_job *j)
{
    lt_real *feature = feed_at(j, "feature"), *patches = feed_at(j, "patches");

    if (feature && patches)
        vit_cache_look(j->run->vit_cache, j->f->number, j->f->image, feature, patches);
}

static void feed_images(const feed_job *j)
{
    const int64_t S = j->m->sizes.crop, pixels = (int64_t)j->m->config.width * j->m->config.height;
    lt_real *boxes = feed_whole(j, "lpips_boxes");
    const bool is_due = j->run->iteration % j->run->schedule.lpips_every == 0;

    feed_floats(j, "image", j->f->image, 3 * S * S);
    feed_floats(j, "target", j->f->target, HOGS_TARGETS * pixels);
    for (int i = 0; boxes && i < 4 * HOGS_IMAGES; i++)
        boxes[i] = (lt_real)(is_due ? j->f->box[i / 4][i % 4] : 0);
}

static void feed_skin(feed_job *j)
{
    lt_real *points = feed_whole(j, "skin_points"), *weights = feed_whole(j, "skin_weights");

    if (points)             /* lt_real is float in a program that trains */
        hogs_rig_samples(j->placer.rig, &j->rng, HOGS_SKIN_POINTS, (float (*)[3])(void *)points,
                         (float (*)[SKIN_FIELD_BONES])(void *)weights);
    if (!model_port_find(&j->r->inputs, "hand_row"))
        feed_integer(j, "hand_set", j->f->subject);
}

static void feed_frame(feed_job *j)
{
    hogs_frame own = *j->f;

    if (j->by->stage == HOGS_POSES) {
        feed_shake(j, &own);
        j->f = &own;
    }
    j->placer = hogs_placer_of(j->m, &j->run->lists, j->run->rig, j->f);
    feed_skin(j);
    if (j->by->stage == HOGS_SKIN)
        return;
    feed_images(j);
    feed_seen(j);
    for (int object = 0; object < 2; object++) {
        feed_set(j, object);
        feed_neighbours(j, object);
    }
    if (j->slot == 0)
        feed_view(j);
    feed_camera(j);
    feed_avatar(j);
    feed_truth(j);
    feed_points(j);
    feed_contact(j);
}

double hogs_feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch, int first, int part,
                 int n)
{
    const hogs_feeder *by = ctx;
    const hogs_batch *b = batch;
    feed_job j = { .by = by, .run = by->run, .m = hogs_of(by->run->m), .plan = p, .r = r, .batch = r->batch };
    const hogs_frame *some = NULL;
    double weight = 0;

    (void)part, (void)n;
    for (int i = 0; i < r->batch && first + i < b->count; i++)
        some = !some && b->frame[first + i].there ? &b->frame[first + i] : some;
    for (int i = 0; i < r->batch && some; i++) {
        const bool there = first + i < b->count && b->frame[first + i].there;

        j.f = there ? &b->frame[first + i] : some;          /* in the place of what is not there, for a weight of 0 */
        j.slot = i;
        j.rng = lt_rng_make((uint64_t)by->run->config->loop.seed, lt_rng_mix(j.f->draw, (uint64_t)by->stage));
        feed_frame(&j);
        if (!there && feed_at(&j, "pose_weight"))
            *(lt_real *)feed_at(&j, "pose_weight") = 0;
        weight += there;
    }
    return weight;
}

static lt_status record(const void *ctx, model_record *r)
{
    const hogs_feeder *by = ctx;

    hogs_record(by->run->m, by->stage, r);
    return LT_OK;
}

recipe hogs_recipe(const task_run *r, hogs_stage stage)
{
    return (recipe){ .ctx = &r->feeder[stage], .batch = 1, .record = record, .feed = hogs_feed };
}
