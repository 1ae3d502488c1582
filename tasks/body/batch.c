/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/body/batch.h"

#include "tasks/body/target.h"
#include "vision/augment.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { W = BODY_PICTURE_WIDTH, H = BODY_PICTURE_HEIGHT, IMAGE = BODY_PICTURE_FLOATS };

static void batch_free(void *batch)
{
    body_batch *b = batch;

    if (!b)
        return;
    free(b->index);
    free(b->image);
    free(b->target);
    free(b->weight);
    free(b);
}

static void *batch_new(const void *ctx, int capacity)
{
    const size_t n = (size_t)capacity;
    body_batch *b = calloc(1, sizeof(*b));

    (void)ctx;
    if (!b)
        return NULL;
    b->index = calloc(n, sizeof(*b->index));
    b->image = calloc(n * IMAGE, sizeof(*b->image));
    b->target = calloc(n, sizeof(*b->target));
    b->weight = calloc(n, sizeof(*b->weight));
    if (b->index && b->image && b->target && b->weight)
        return b;
    batch_free(b);
    return NULL;
}

static void batch_start(void *b, int count)
{
    ((body_batch *)b)->count = count;
}

static void batch_skip(void *batch, int slot, int64_t index)
{
    body_batch *b = batch;

    b->index[slot] = index;
    b->weight[slot] = 0;
}

/* ---- one picture ---- */

/* Three pictures of five are turned. Source: Lin et al. 2023; IDEA-Research/OSX common/utils/preprocessing.py. */
static double draw_turn(const body_feed *f, lt_rng *rng)
{
    const double n = lt_rng_normal(rng);
    const bool turned = lt_rng_uniform(rng) < 0.6;

    return turned ? M_PI / 180 * f->rotation_deg * fmax(-2, fmin(2, n)) : 0;
}

/* Larger or smaller and turned about the middle, and moved */
static person_window draw_window(const body_feed *f, lt_rng *rng)
{
    const double middle[2] = { (W - 1) / 2.0, (H - 1) / 2.0 };
    person_window w = { .scale = 1 + lt_rng_range(rng, -f->scale, f->scale) };
    double there[2];

    for (int k = 0; k < 2; k++)
        w.shift[k] = middle[k] + W * lt_rng_range(rng, -f->shift, f->shift);
    w.turn = draw_turn(f, rng);
    person_window_place(&w, middle, there);
    for (int k = 0; k < 2; k++)
        w.shift[k] -= there[k] - w.shift[k];
    return w;
}

/* Picture and truth, now and then as a mirror shows them */
static void draw_mirror(const body_feed *f, lt_rng *rng, lt_image *picture, body_row *row)
{
    if (lt_rng_uniform(rng) >= f->flip)
        return;
    body_row_mirror(row, picture->width);
    for (int y = 0; y < picture->height; y++)
        for (int x = 0; x < picture->width / 2; x++) {
            uint8_t *a = picture->data + 3 * (y * picture->width + x);
            uint8_t *b = picture->data + 3 * (y * picture->width + picture->width - 1 - x);

            for (int c = 0; c < 3; c++) {
                const uint8_t kept = a[c];

                a[c] = b[c];
                b[c] = kept;
            }
        }
}

static lt_status batch_fill(const void *ctx, uint64_t epoch, int64_t i, lt_arena *scratch, void *batch, int slot)
{
    const body_feed *f = ctx;
    const int64_t index = body_feed_index(f, i);
    const augment_limits limits = { .brightness = f->colour, .contrast = f->colour, .saturation = f->colour };
    lt_rng rng = lt_rng_make(f->seed, lt_rng_mix(epoch, (uint64_t)index));
    const person_window window = draw_window(f, &rng);
    body_row row = f->set->row[index];
    body_batch *b = batch;
    float *image = b->image + (size_t)slot * IMAGE, *room = lt_arena_array(scratch, H * W, sizeof(*room));
    lt_image picture;
    lt_status st = room ? body_set_picture(f->set, index, scratch, &picture)
                        : lt_error(LT_ENOMEM, "no memory for a picture");

    if (st)
        return st;
    draw_mirror(f, &rng, &picture, &row);
    person_window_cut(&window, &picture, W, H, image);
    if (f->colour > 0)
        augment_colour(image, H, W, &limits, &rng, room);
    body_target_make(&row, &window, &b->target[slot]);
    b->index[slot] = index;
    b->weight[slot] = 1;
    return LT_OK;
}

int64_t body_feed_index(const body_feed *f, int64_t i)
{
    return i * f->set->n / f->count;
}

static const char *picture_name(const void *ctx, int64_t i)
{
    const body_feed *f = ctx;

    return f->set->name[body_feed_index(f, i)];
}

loader_source body_source(const body_feed *feed)
{
    return (loader_source){ .ctx = feed, .count = feed->count, .name = picture_name, .batch_new = batch_new,
                            .batch_free = batch_free, .start = batch_start, .fill = batch_fill, .skip = batch_skip };
}

/* ---- into the graph ---- */

#define TARGET(field) { #field, offsetof(body_target, field), sizeof(((body_target *)NULL)->field) / sizeof(float) }

static const struct {
    const char *name;
    size_t offset, n;
} targets[] = {
    TARGET(rotation), TARGET(shape), TARGET(expression), TARGET(body_place), TARGET(hand_place), TARGET(box_centre),
    TARGET(box_size), TARGET(nodes), TARGET(bearing), TARGET(body_known), TARGET(hand_known), TARGET(box_known),
    TARGET(node_known),
};

static void copy(const lt_plan *p, const model_record *r, const char *name, int slot, const float *from, size_t n)
{
    const lt_tensor *t = model_port_find(&r->inputs, name);
    lt_real *to = t ? (lt_real *)lt_plan_data(p, t) + (size_t)slot * n : NULL;

    for (size_t k = 0; to && k < n; k++)
        to[k] = (lt_real)from[k];
}

/* The first place from `first` on that could be read, in turn; -1: none */
static int whole_place(const body_batch *b, int first)
{
    for (int i = 0; i < b->count; i++)
        if (b->weight[(first + i) % b->count] > 0)
            return (first + i) % b->count;
    return -1;
}

/* A place without a picture has a neighbour's, and counts for nothing. */
static double feed_batch(const lt_plan *p, const model_record *r, const body_batch *b, int first)
{
    double sum = 0;

    for (int i = 0; i < r->batch; i++) {
        const bool there = first + i < b->count && b->weight[first + i] > 0;
        const int from = b->count ? whole_place(b, (first + i) % b->count) : -1;
        const float weight = there;

        if (from < 0)
            return 0;
        copy(p, r, "image", i, b->image + (size_t)from * IMAGE, IMAGE);
        for (size_t k = 0; k < LT_COUNT(targets); k++)
            copy(p, r, targets[k].name, i, (const float *)((const char *)&b->target[from] + targets[k].offset),
                 targets[k].n);
        copy(p, r, "weight", i, &weight, 1);
        sum += there;
    }
    return sum;
}

static double feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch, int first, int part,
                   int n)
{
    (void)ctx, (void)part, (void)n;
    return feed_batch(p, r, batch, first);
}

recipe body_batch_recipe(const body_graph *g, bool losses)
{
    recipe by = body_graph_recipe(g, losses);

    by.feed = feed;
    return by;
}
