/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures and cameras of a scene: read once, kept as bytes, fed one at a time. */
#include "tasks/splats/run.h"

#include "libtensor/base/rng.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SOME_GAUSSIANS = 5000 };
static const double WIDER = 1.1;                    /* than the farthest camera: the scene      [Kerbl et al. 2023] */
/* What a Gaussian takes: its numbers with gradients, moments, a rearranged copy, and what a graph makes of them */
enum { GAUSSIAN_NUMBERS = 59, GAUSSIAN_BYTES = 4 * (7 * GAUSSIAN_NUMBERS + 100), TILE_BYTES = 8 * 48 };

static lt_status no_memory(const char *what)
{
    return lt_error(LT_ENOMEM, "no memory for %s", what);
}

/* ---- opening --------------------------------------------------------------------------------------------- */

/* Outside of an object's mask there is background. */
static void paint(transforms_picture *p, bool white)
{
    for (int64_t i = 0; p->mask && i < 3 * (int64_t)p->width * p->height; i++)
        if (!p->mask[i / 3])
            p->rgb[i] = white ? 255 : 0;
    p->mask = NULL;
}

static lt_status keep(lt_arena *arena, uint8_t **x, int64_t n)
{
    uint8_t *copy = *x ? lt_arena_array(arena, (size_t)n, 1) : NULL;

    if (*x && !copy)
        return no_memory("pictures");
    if (copy)
        memcpy(copy, *x, (size_t)n);
    *x = copy;
    return LT_OK;
}

/* An alpha channel is no mask of what to ignore: the picture lies over the background already. */
static lt_status read_view(task_run *r, const splats_data_config *d, int i, bool white)
{
    lt_arena *scratch = lt_arena_new();
    transforms_picture p;
    lt_status st = scratch ? transforms_read(scratch, &r->set.view[i], d->downscale, white, &p)
                           : no_memory("pictures");

    if (!st && d->mask == SPLATS_BACKGROUND)
        paint(&p, white);
    else if (!st && !r->set.view[i].mask)
        p.mask = NULL;
    if (!st)
        st = keep(r->arena, &p.rgb, 3 * (int64_t)p.width * p.height);
    if (!st)
        st = keep(r->arena, &p.mask, (int64_t)p.width * p.height);
    if (!st)
        r->picture[i] = p;
    lt_arena_free(scratch);
    return st;
}

static lt_status divide(task_run *r)
{
    int *view = lt_arena_array(r->arena, (size_t)r->set.n, sizeof(*view)), n = 0;

    if (!view)
        return no_memory("views");
    for (int held_out = 0; held_out < 2; held_out++) {
        splats_source *s = held_out ? &r->held_out : &r->train;

        *s = (splats_source){ .run = r, .view = view + n };
        for (int i = 0; i < r->set.n; i++)
            if (r->set.view[i].held_out == held_out) {
                view[n++] = i;
                s->count++;
            }
    }
    return LT_OK;
}

lt_status splats_open_views(task_run *r, const train_config *c, bool white)
{
    const splats_data_config *d = splats_data_of(c);
    lt_status st;

    if (!*d->common.dir)
        return lt_error(LT_EUSAGE, "%s: data.dir: no folder of pictures given; name it with --data or --set "
                        "data.dir=FOLDER", c->path);
    st = transforms_open(r->arena, d->common.dir, d->holdout, &r->set);
    if (st)
        return st;
    r->picture = lt_arena_array(r->arena, (size_t)r->set.n, sizeof(*r->picture));
    st = r->picture ? divide(r) : no_memory("pictures");
    for (int i = 0; i < r->set.n && !st; i++)
        st = read_view(r, d, i, white);
    return st;
}

static int whole_number(const cJSON *keys, const char *name, int otherwise)
{
    const cJSON *x = cJSON_GetObjectItemCaseSensitive(keys, name);

    return cJSON_IsNumber(x) && x->valuedouble > 0 ? x->valueint : otherwise;
}

/* The first picture speaks for all; what is wrong with the folder is said when it is opened. */
size_t splats_bytes(const train_config *c, const char **less)
{
    const splats_data_config *d = splats_data_of(c);
    lt_arena *arena = lt_arena_new();
    transforms_set set = { .n = 0 };
    transforms_picture p = { .width = 0 };
    const double most = (double)whole_number(c->model_keys, "cap", 50000) * (GAUSSIAN_BYTES + TILE_BYTES);
    double pictures = 0;

    if (arena && !transforms_open(arena, d->common.dir, d->holdout, &set)
        && !transforms_read(arena, &set.view[0], d->downscale, false, &p))
        pictures = 4.0 * set.n * p.width * p.height;
    lt_arena_free(arena);
    *less = pictures > most ? "picture" : "model.cap";
    return (size_t)(pictures + most);
}

/* ---- the scene ------------------------------------------------------------------------------------------- */

static void camera_place(const transforms_view *v, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = -(v->R_cam_world[k] * v->t_cam_world[0] + v->R_cam_world[3 + k] * v->t_cam_world[1]
                   + v->R_cam_world[6 + k] * v->t_cam_world[2]);
}

/* How far the farthest camera is from the middle of those that are learnt from */
static double radius_of(const task_run *r, double middle[3])
{
    double most = 0, at[3];

    memset(middle, 0, 3 * sizeof(*middle));
    for (int64_t i = 0; i < r->train.count; i++) {
        camera_place(&r->set.view[r->train.view[i]], at);
        for (int k = 0; k < 3; k++)
            middle[k] += at[k] / (double)r->train.count;
    }
    for (int64_t i = 0; i < r->train.count; i++) {
        camera_place(&r->set.view[r->train.view[i]], at);
        most = fmax(most, hypot(hypot(at[0] - middle[0], at[1] - middle[1]), at[2] - middle[2]));
    }
    return most;
}

/* Of n points as many as are wanted, spread over their order; where there are none, anywhere between the cameras */
static lt_status choose_places(task_run *r, int n, const double middle[3], double radius, uint64_t seed)
{
    float (*place)[3] = lt_arena_array(r->arena, (size_t)n, sizeof(*place));
    float (*colour)[3] = lt_arena_array(r->arena, (size_t)n, sizeof(*colour));
    const transforms_set *s = &r->set;
    lt_rng rng = lt_rng_make(seed, 0x53434e);

    if (!place || !colour)
        return no_memory("Gaussians");
    for (int i = 0; i < n; i++) {
        const int64_t from = s->n_points >= n ? (int64_t)i * s->n_points / n : -1;

        for (int k = 0; k < 3; k++) {
            place[i][k] = from >= 0 ? s->point[from][k] : (float)(middle[k] + radius * lt_rng_range(&rng, -1, 1));
            colour[i][k] = from >= 0 && s->colour ? s->colour[from][k] : 0.5f;
        }
    }
    r->scene = (splats_scene){ (const float (*)[3])place, (const float (*)[3])colour };
    return LT_OK;
}

static bool leave_to_data(cJSON *keys, const char *name, double value)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(keys, name);

    if (cJSON_IsNumber(item) && item->valuedouble != 0)
        return true;
    cJSON_DeleteItemFromObjectCaseSensitive(keys, name);
    return cJSON_AddNumberToObject(keys, name, value);
}

lt_status splats_find_scene(task_run *r, train_config *c)
{
    const int cap = whole_number(c->model_keys, "cap", 50000);
    int width = 0, height = 0, n = whole_number(c->model_keys, "gaussians", 0);
    double middle[3], radius = radius_of(r, middle);

    for (int i = 0; i < r->set.n; i++) {
        width = (int)lt_max_i64(width, r->picture[i].width);
        height = (int)lt_max_i64(height, r->picture[i].height);
    }
    n = n ? n : (int)lt_min_i64(cap, r->set.n_points ? r->set.n_points : SOME_GAUSSIANS);
    if (!(radius > 0))
        return lt_error(LT_EINVAL, "%s: all cameras stand in one place: nothing tells how far away things are",
                        r->set.path);
    if (!leave_to_data(c->model_keys, "gaussians", n) || !leave_to_data(c->model_keys, "width", width)
        || !leave_to_data(c->model_keys, "height", height)
        || !leave_to_data(c->model_keys, "extent", WIDER * radius))
        return no_memory("the configuration");
    if (whole_number(c->model_keys, "width", 0) < width || whole_number(c->model_keys, "height", 0) < height)
        return lt_error(LT_EINVAL, "%s: pictures of up to %d x %d, but model.width and .height say %d x %d; leave them "
                        "out of the configuration", r->set.path, width, height,
                        whole_number(c->model_keys, "width", 0), whole_number(c->model_keys, "height", 0));
    return choose_places(r, n, middle, radius, (uint64_t)c->loop.seed);
}

/* ---- batches --------------------------------------------------------------------------------------------- */

static void *batch_new(const void *ctx, int capacity)
{
    splats_batch *b = calloc(1, sizeof(*b));

    (void)ctx;
    if (b)
        b->view = calloc((size_t)capacity, sizeof(*b->view));
    if (b && b->view)
        return b;
    free(b);
    return NULL;
}

static void batch_free(void *batch)
{
    splats_batch *b = batch;

    if (b)
        free(b->view);
    free(b);
}

static void batch_start(void *b, int count)
{
    ((splats_batch *)b)->count = count;
}

static lt_status batch_fill(const void *ctx, uint64_t epoch, int64_t index, lt_arena *scratch, void *b, int slot)
{
    (void)ctx, (void)epoch, (void)scratch;
    ((splats_batch *)b)->view[slot] = index;
    return LT_OK;
}

static void batch_skip(void *b, int slot, int64_t index)
{
    (void)index;
    ((splats_batch *)b)->view[slot] = -1;
}

static const char *view_name(const void *ctx, int64_t index)
{
    const splats_source *s = ctx;

    return s->run->set.view[s->view[index]].name;
}

loader_source splats_views_loader(const splats_source *s)
{
    return (loader_source){ .ctx = s, .count = s->count, .name = view_name, .batch_new = batch_new,
                            .batch_free = batch_free, .start = batch_start, .fill = batch_fill, .skip = batch_skip };
}

/* ---- into a graph ---------------------------------------------------------------------------------------- */

static void *input(const lt_plan *p, const model_record *r, const char *name)
{
    const lt_tensor *t = model_port_find(&r->inputs, name);

    return t ? lt_plan_data(p, t) : NULL;
}

/* A picture into the canvas's upper left */
static void feed_picture(const task_run *r, int view, lt_real *target, lt_real *weight)
{
    const splats *m = splats_of(r->m);
    const transforms_picture *v = &r->picture[view];
    const int64_t W = m->config.width, plane = W * m->config.height;

    if (v->width < W || v->height < m->config.height) {
        memset(target, 0, 3 * (size_t)plane * sizeof(*target));
        memset(weight, 0, (size_t)plane * sizeof(*weight));
    }
    for (int64_t i = 0; i < (int64_t)v->width * v->height; i++) {
        const int64_t to = i / v->width * W + i % v->width;
        const bool counts = splats_counts(r, view, i);

        weight[to] = counts;
        for (int k = 0; k < 3; k++)
            target[k * plane + to] = counts ? (lt_real)v->rgb[3 * i + k] / 255 : 0;
    }
}

void splats_feed(const task_run *r, const lt_plan *p, const model_record *record, int view, int degree)
{
    const splats *m = splats_of(r->m);
    const int64_t N = gaussians_capacity(&m->gaussians), n = gaussians_count(&m->gaussians, 0);
    const transforms_view *v = &r->set.view[view];
    const lt_camera *c = &r->picture[view].camera;
    const double camera[4] = { c->fx, c->fy, c->cx, c->cy };
    lt_real *to = input(p, record, "camera"), *place = input(p, record, "view"), *alive = input(p, record, "alive");
    lt_real *offset = input(p, record, "offset"), *target = input(p, record, "target");

    for (int k = 0; k < 4; k++)
        to[k] = (lt_real)camera[k];
    for (int k = 0; k < 12; k++)
        place[k] = (lt_real)(k % 4 == 3 ? v->t_cam_world[k / 4] : v->R_cam_world[3 * (k / 4) + k % 4]);
    for (int64_t i = 0; i < N; i++)
        alive[i] = i < n;
    *(int32_t *)input(p, record, "row") = 0;
    *(int32_t *)input(p, record, "degree") = degree;
    if (offset)
        memset(offset, 0, 2 * (size_t)N * sizeof(*offset));
    if (target)
        feed_picture(r, view, target, input(p, record, "weight"));
}
