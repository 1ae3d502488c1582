/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One picture: shadow maps, then tile by tile visibility and light, then crevices.
 *
 * Hand, target object and all the rest are drawn into three layers of 2 x 2 samples per pixel; the
 * nearest layer wins, and the first two are at once the amodal masks. A pixel is lit once for each
 * triangle that its four samples see; four pixels that all see the same one, out of penumbrae, share their light.
 */
#include "libtensor/base/parallel.h"
#include "synth/render/frame.h"
#include "synth/render/occlusion.h"
#include "synth/render/shade.h"
#include "synth/render/small.h"

#include <string.h>

enum { SAMPLES = 4 };               /* of a pixel */
enum { SQUARE = 4 };                /* samples along a side of two by two pixels */

enum { REST, HAND, OBJECT, LAYERS };

typedef struct {
    float inv_z[TILE * TILE];
    uint32_t id[TILE * TILE];       /* triangle + 1; 0: nothing */
    bool used;
} layer;

typedef struct {
    const synth_scene *scene;
    synth_frame *frame;
    struct synth_scratch *s;
} render_job;

/* ---- checks ---------------------------------------------------------------------------------- */

static lt_status check_mesh(const lt_mesh *m, int index)
{
    if (m->n_vertices < 0 || m->n_faces < 0)
        return lt_error(LT_EINVAL, "render: instance %d has a negative count", index);
    for (int f = 0; f < m->n_faces; f++)
        for (int i = 0; i < 3; i++)
            if (m->face[f][i] < 0 || m->face[f][i] >= m->n_vertices)
                return lt_error(LT_EINVAL, "render: instance %d: face %d names vertex %d of %d", index, f,
                                (int)m->face[f][i], m->n_vertices);
    return LT_OK;
}

static lt_status check(const synth_scene *scene, const synth_frame *frame)
{
    const synth_camera *c = &scene->camera;

    if (c->width != frame->width || c->height != frame->height)
        return lt_error(LT_EINVAL, "render: camera is %d x %d, frame is %d x %d", c->width, c->height,
                        frame->width, frame->height);
    if (!(c->fx > 0 && c->fy > 0 && isfinite(c->fx + c->fy + c->cx + c->cy)))
        return lt_error(LT_EINVAL, "render: focal lengths %g and %g, want positive ones", c->fx, c->fy);
    if (scene->n_lights < 0 || scene->n_lights > SYNTH_MAX_LIGHTS)
        return lt_error(LT_EINVAL, "render: %d lights, want 0 to %d", scene->n_lights, SYNTH_MAX_LIGHTS);
    if (scene->n_lights > 0 && !(scene->focus_radius > 0))
        return lt_error(LT_EINVAL, "render: focus radius is %g, want a positive one", scene->focus_radius);
    for (int i = 0; i < scene->n_instances; i++) {
        const lt_status st = check_mesh(scene->instance[i].mesh, i);

        if (st)
            return st;
    }
    return LT_OK;
}

/* ---- visibility ------------------------------------------------------------------------------ */

static int layer_of(const synth_scene *scene, const synth_instance *in)
{
    if (in->label == SYNTH_LABEL_HAND)
        return HAND;
    return in->label != SYNTH_LABEL_BACKGROUND && in->label == scene->target ? OBJECT : REST;
}

static void draw_layers(const render_job *job, int tile, layer *layers)
{
    const raster_list *l = &job->s->list;
    const int tx = tile % l->tiles_x, ty = tile / l->tiles_x;

    layers[HAND].used = layers[OBJECT].used = false;
    memset(&layers[REST], 0, sizeof(layers[REST]));
    for (uint32_t i = l->tile_start[tile]; i < l->tile_start[tile + 1]; i++) {
        const uint32_t index = l->tile_item[i];
        const raster_triangle *t = &l->triangle[index];
        layer *to = &layers[layer_of(job->scene, &job->scene->instance[t->instance])];

        if (!to->used)
            memset(to, 0, sizeof(*to));
        to->used = true;
        raster_draw(t, tx, ty, index + 1, to->inv_z, to->id);
    }
}

/* The nearest layer, into the first one. */
static void merge_layers(layer *layers)
{
    for (int k = HAND; k <= OBJECT; k++)
        for (int i = 0; layers[k].used && i < TILE * TILE; i++)
            if (layers[k].inv_z[i] > layers[REST].inv_z[i]) {
                layers[REST].inv_z[i] = layers[k].inv_z[i];
                layers[REST].id[i] = layers[k].id[i];
            }
}

/* ---- one pixel ------------------------------------------------------------------------------- */

/* A pixel's four samples: where they lie in the tile, and in the grid. */
static const int sample_at[SAMPLES] = { 0, 1, TILE, TILE + 1 };
static const float sample_x[SAMPLES] = { 0, 1, 0, 1 }, sample_y[SAMPLES] = { 0, 0, 1, 1 };

typedef struct {
    int at;                         /* its first sample in the tile */
    float x, y;                     /* and in the grid */
    size_t i;                       /* its place in the frame */
} pixel;

static const raster_triangle *triangle_of(const render_job *job, uint32_t id)
{
    return &job->s->list.triangle[id - 1];
}

static bool same_triangle(const layer *l, int at)
{
    const uint32_t id = l->id[at];

    return id == l->id[at + 1] && id == l->id[at + TILE] && id == l->id[at + TILE + 1];
}

/* Depth at the pixel's centre: of a triangle that covers it, else the mean of the samples that show
 * wanted (as instance labels; -1: all). */
static float center_depth(const render_job *job, const layer *l, const pixel *p, int wanted)
{
    const float x = p->x + 0.5f, y = p->y + 0.5f;
    const int at = p->at;
    float sum = 0, best = 0;
    v4 b;
    int n = 0;

    if (same_triangle(l, at))
        return l->id[at] ? 1 / raster_corner(triangle_of(job, l->id[at]), x, y, &b) : 0;
    for (int k = 0; k < SAMPLES; k++) {
        const uint32_t id = l->id[at + sample_at[k]];
        const raster_triangle *t = id ? triangle_of(job, id) : NULL;
        float w;

        if (!t || (wanted >= 0 && job->scene->instance[t->instance].label != wanted))
            continue;
        w = raster_corner(t, x, y, &b);
        if (b[0] >= 0 && b[1] >= 0 && b[2] >= 0 && w > best)
            best = w;
        sum += l->inv_z[at + sample_at[k]];
        n++;
    }
    return best > 0 ? 1 / best : n ? (float)n / sum : 0;
}

/* The sample whose instance's label covers most of the pixel; of equals the nearest. -1: nothing does. */
static int find_winner(const render_job *job, const layer *l, int at)
{
    int label[SAMPLES], best = 0, best_count = 0;

    if (same_triangle(l, at))
        return l->id[at] ? 0 : -1;
    for (int k = 0; k < SAMPLES; k++) {
        const uint32_t id = l->id[at + sample_at[k]];

        label[k] = id ? job->scene->instance[triangle_of(job, id)->instance].label : -1;
    }
    for (int k = 0; k < SAMPLES; k++) {
        int count = 0;

        for (int j = 0; j < SAMPLES; j++)
            count += label[j] == label[k];
        if (count > best_count ||
            (count == best_count && l->inv_z[at + sample_at[k]] > l->inv_z[at + sample_at[best]])) {
            best = k;
            best_count = count;
        }
    }
    return label[best] < 0 ? -1 : best;
}

static void amodal_pixel(const render_job *job, const layer *l, const pixel *p, uint8_t *mask, float *depth)
{
    int n = 0;

    for (int k = 0; l->used && k < SAMPLES; k++)
        n += l->id[p->at + sample_at[k]] != 0;
    mask[p->i] = n >= SAMPLES / 2 ? 255 : 0;
    depth[p->i] = mask[p->i] ? center_depth(job, l, p, -1) : 0;
}

/* What is seen and what would be seen agree: the depth is the one of the whole surface, and a label
 * that won with one sample of four is in its mask all the same. */
static void agree(float *depth, uint8_t *mask, float *alone)
{
    if (*mask)
        *depth = *alone;
    *mask = 255;
    *alone = *depth;
}

static void label_pixel(const render_job *job, const layer *l, const pixel *p)
{
    synth_frame *f = job->frame;
    const int winner = find_winner(job, l, p->at);
    const size_t i = p->i;
    const synth_instance *in;

    f->depth[i] = 0;
    f->label[i] = f->moving[i] = 0;
    if (winner < 0)
        return;
    in = &job->scene->instance[triangle_of(job, l->id[p->at + sample_at[winner]])->instance];
    f->depth[i] = center_depth(job, l, p, in->label);
    f->label[i] = in->label;
    f->moving[i] = in->moving;
    if (layer_of(job->scene, in) == HAND)
        agree(&f->depth[i], &f->hand_mask[i], &f->hand_depth[i]);
    else if (layer_of(job->scene, in) == OBJECT)
        agree(&f->depth[i], &f->object_mask[i], &f->object_depth[i]);
}

/* ---- light ----------------------------------------------------------------------------------- */

/* A hash of the pixel in 0..1 whose neighbours differ evenly.           [Jimenez 2014] */
static float dither(const pixel *p)
{
    const float f = 0.06711056f * (p->x / 2) + 0.00583715f * (p->y / 2);
    const float g = 52.9829189f * (f - (float)floor_int(f));

    return g - (float)floor_int(g);
}

/* What crevices dim goes into radiance, the rest into work. */
static void put(const render_job *job, size_t i, shade_sent light)
{
    v4_to3(light.ambient, job->frame->radiance[i]);
    v4_to3(light.direct, job->frame->work[0][i]);
}

/* Light of each triangle seen, taken at the middle of its samples and weighted by their number. */
static void light_pixel(const render_job *job, const layer *l, const pixel *p)
{
    shade_sent sum = { v4_all(0), v4_all(0) };
    shade_shadow shadow = { .instance = -1 };
    bool done[SAMPLES] = { false };

    for (int k = 0; k < SAMPLES; k++) {
        const uint32_t id = l->id[p->at + sample_at[k]];
        float mx = 0, my = 0, n = 0;

        if (done[k] || id == 0)
            continue;
        for (int j = k; j < SAMPLES; j++)
            if (l->id[p->at + sample_at[j]] == id) {
                done[j] = true;
                mx += sample_x[j];
                my += sample_y[j];
                n++;
            }
        const shade_sent one = shade(&job->s->shade, triangle_of(job, id), p->x + mx / n, p->y + my / n, 2,
                                     dither(p), &shadow);

        sum.ambient += one.ambient * v4_all(n / SAMPLES);
        sum.direct += one.direct * v4_all(n / SAMPLES);
    }
    put(job, p->i, sum);
}

/* The triangle that all samples of two by two pixels show; NULL: they show several, or none. */
static const raster_triangle *only_triangle(const render_job *job, const layer *l, int at)
{
    const uint32_t id = l->id[at];
    bool same = id != 0;

    for (int row = 0; row < SQUARE; row++)
        for (int k = 0; k < SQUARE; k++)
            same &= l->id[at + row * TILE + k] == id;
    return same ? triangle_of(job, id) : NULL;
}

/* Two by two pixels at once, false where each needs a light of its own. */
static bool light_square(const render_job *job, const layer *l, const pixel *p)
{
    const raster_triangle *t = only_triangle(job, l, p->at);
    const size_t below = p->i + (size_t)job->frame->width;
    shade_sent light[4];

    if (!t || !shade_square(&job->s->shade, t, p->x + 0.5f, p->y + 0.5f, 2, dither(p), light))
        return false;
    put(job, p->i, light[0]);
    put(job, p->i + 1, light[1]);
    put(job, below, light[2]);
    put(job, below + 1, light[3]);
    return true;
}

/* ---- a tile ---------------------------------------------------------------------------------- */

/* Its pixels in the frame, the ends excluded. */
typedef struct { int x0, y0, x1, y1; } area;

static area area_of(const render_job *job, int tile)
{
    const synth_frame *f = job->frame;
    const int tiles_x = job->s->list.tiles_x, x = tile % tiles_x * TILE / 2, y = tile / tiles_x * TILE / 2;

    return (area){ x, y, x + TILE / 2 < f->width ? x + TILE / 2 : f->width,
                   y + TILE / 2 < f->height ? y + TILE / 2 : f->height };
}

static pixel pixel_of(const render_job *job, const area *a, int x, int y)
{
    return (pixel){ .at = 2 * ((y - a->y0) * TILE + x - a->x0), .x = 2 * (float)x, .y = 2 * (float)y,
                    .i = (size_t)y * (size_t)job->frame->width + (size_t)x };
}

static void label_area(const render_job *job, const area *a, layer *layers)
{
    synth_frame *f = job->frame;

    for (int y = a->y0; y < a->y1; y++)
        for (int x = a->x0; x < a->x1; x++) {
            const pixel p = pixel_of(job, a, x, y);

            amodal_pixel(job, &layers[HAND], &p, f->hand_mask, f->hand_depth);
            amodal_pixel(job, &layers[OBJECT], &p, f->object_mask, f->object_depth);
        }
    merge_layers(layers);
    for (int y = a->y0; y < a->y1; y++)
        for (int x = a->x0; x < a->x1; x++) {
            const pixel p = pixel_of(job, a, x, y);

            label_pixel(job, &layers[REST], &p);
        }
}

static void light_area(const render_job *job, const area *a, const layer *l)
{
    for (int y = a->y0; y < a->y1; y += 2)
        for (int x = a->x0; x < a->x1; x += 2) {
            const pixel first = pixel_of(job, a, x, y);

            if (light_square(job, l, &first))
                continue;
            for (int k = 0; k < 4; k++) {
                const pixel p = pixel_of(job, a, x + k % 2, y + k / 2);

                if (x + k % 2 < a->x1 && y + k / 2 < a->y1)
                    light_pixel(job, l, &p);
            }
        }
}

static void render_tile(void *ctx, int64_t tile)
{
    const render_job *job = ctx;
    const area a = area_of(job, (int)tile);
    layer layers[LAYERS];

    draw_layers(job, (int)tile, layers);
    label_area(job, &a, layers);
    light_area(job, &a, &layers[REST]);
}

/* ---- the whole picture ----------------------------------------------------------------------- */

static void add_direct_row(void *ctx, int64_t y)
{
    const render_job *job = ctx;
    synth_frame *f = job->frame;

    for (int x = 0; x < f->width; x++) {
        const size_t i = (size_t)y * (size_t)f->width + (size_t)x;
        const float open = occlusion_at(&job->scene->camera, f->depth, job->s->open, x, (int)y);

        for (int c = 0; c < 3; c++)
            f->radiance[i][c] = open * f->radiance[i][c] + (0.4f + 0.6f * open) * f->work[0][i][c];
    }
}

/* Samples at a quarter pixel either side of the centre: sample s lies at pixel (s - 0.5) / 2. */
static raster_view sample_view(const synth_camera *c)
{
    raster_view v = { .fx = 2 * c->fx, .fy = 2 * c->fy, .cx = 2 * c->cx + 0.5, .cy = 2 * c->cy + 0.5,
                      .width = 2 * c->width, .height = 2 * c->height };

    memcpy(v.R, c->R_cam_world, sizeof(v.R));
    memcpy(v.t, c->t_cam_world, sizeof(v.t));
    return v;
}

lt_status synth_render(const synth_scene *scene, synth_frame *frame)
{
    struct synth_scratch *s = frame->scratch;
    render_job job = { scene, frame, s };
    const raster_view view = sample_view(&scene->camera);
    lt_status st = check(scene, frame);

    for (int i = 0; !st && i < scene->n_lights; i++)
        st = shadow_draw(&s->shadow[i], &s->shadow_list, scene, &scene->light[i]);
    if (!st)
        st = raster_collect(&s->list, scene, &view, false);
    if (st)
        return st;
    if (!shade_prepare(&s->shade, scene, s->shadow))
        return lt_error(LT_ENOMEM, "render: no memory for the scene's vertices");
    lt_parallel_for((int64_t)s->list.tiles_x * s->list.tiles_y, render_tile, &job);
    occlusion_find(&scene->camera, frame->depth, s->open, s->half);
    lt_parallel_for(frame->height, add_direct_row, &job);
    return LT_OK;
}
