/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/detect/batch.h"

#include <string.h>

/* ---- memory ---- */

static size_t image_numbers(const detect_batch *b)
{
    return 3 * (size_t)b->size * (size_t)b->size;
}

enum { OBJECTS = DETECT_MAX_OBJECTS * OBJECT_NUMBERS };

static size_t mask_words(const detect_batch *b)
{
    return (size_t)DETECT_MAX_OBJECTS * (size_t)picture_words(b->size);
}

static void batch_free(void *batch)
{
    detect_batch *b = batch;

    if (b)
        lt_arena_free(b->memory);
    lt_release(b);
}

static void *slots(detect_batch *b, size_t per, size_t size, bool *ok)
{
    void *p = lt_arena_array(b->memory, (size_t)b->capacity * per, size);

    *ok = *ok && p;
    return p;
}

static void *batch_new(const void *ctx, int capacity)
{
    const detect_feed *feed = ctx;
    detect_batch *b = lt_alloc(sizeof(*b));
    bool ok = b && (b->memory = lt_arena_new()) != NULL;

    if (ok) {
        b->capacity = capacity;
        b->size = feed->size;
        b->there = slots(b, 1, sizeof(*b->there), &ok);
        b->index = slots(b, 1, sizeof(*b->index), &ok);
        b->width = slots(b, 1, sizeof(*b->width), &ok);
        b->height = slots(b, 1, sizeof(*b->height), &ok);
        b->image = slots(b, image_numbers(b), sizeof(*b->image), &ok);
        b->objects = slots(b, OBJECTS, sizeof(*b->objects), &ok);
        b->masks = slots(b, mask_words(b), sizeof(*b->masks), &ok);
    }
    if (ok)
        return b;
    batch_free(b);
    return NULL;
}

static void batch_start(void *batch, int count)
{
    ((detect_batch *)batch)->count = count;
}

static void batch_skip(void *batch, int slot, int64_t index)
{
    detect_batch *b = batch;

    b->there[slot] = false;
    b->index[slot] = index;
}

/* ---- samples ---- */

static lt_status batch_fill(const void *ctx, uint64_t epoch, int64_t index, lt_arena *scratch, void *batch, int slot)
{
    const detect_feed *f = ctx;
    detect_batch *b = batch;
    picture p = { .size = b->size, .image = b->image + (size_t)slot * image_numbers(b),
                  .objects = b->objects + (size_t)slot * OBJECTS, .masks = b->masks + (size_t)slot * mask_words(b) };
    lt_rng rng = lt_rng_make(f->seed, lt_rng_mix(epoch, (uint64_t)index));

    b->there[slot] = true;
    b->index[slot] = index;
    if (f->how && f->how->augment)
        return picture_augmented(f->set, index, f->how, (int64_t)epoch < f->epochs - f->how->close_mosaic, &rng,
                                 scratch, &p);
    return picture_plain(f->set, index, scratch, &p, &b->width[slot], &b->height[slot]);
}

static const char *sample_name(const void *ctx, int64_t index)
{
    return ((const detect_feed *)ctx)->set->image[index].name;
}

loader_source detect_source(const detect_feed *feed)
{
    return (loader_source){ .ctx = feed, .count = feed->count, .name = sample_name, .batch_new = batch_new,
                            .batch_free = batch_free, .start = batch_start, .fill = batch_fill, .skip = batch_skip };
}

/* ---- into a graph ---- */

/* The slot itself, or the next one round that has a sample; -1: none has */
static int sample_for(const detect_batch *b, int first, int n, int slot)
{
    for (int k = 0; k < n; k++) {
        const int s = first + (slot - first + k) % n;

        if (s < b->count && b->there[s])
            return s;
    }
    return -1;
}

static void copy(const lt_plan *p, const model_record *r, const char *name, int i, const void *from, size_t bytes)
{
    const lt_tensor *t = model_port_find(&r->inputs, name);
    char *to = t ? lt_plan_data(p, t) : NULL;

    if (to)
        memcpy(to + (size_t)i * bytes, from, bytes);
}

double detect_batch_feed(const lt_plan *p, const model_record *r, const detect_batch *b, int first, int part, int n)
{
    for (int i = 0; i < r->batch; i++) {
        const int s = sample_for(b, first, n * r->batch, first + part * r->batch + i);

        if (s < 0)
            return 0;
        copy(p, r, "image", i, b->image + (size_t)s * image_numbers(b), image_numbers(b) * sizeof(*b->image));
        copy(p, r, "objects", i, b->objects + (size_t)s * OBJECTS, OBJECTS * sizeof(*b->objects));
        copy(p, r, "masks", i, b->masks + (size_t)s * mask_words(b), mask_words(b) * sizeof(*b->masks));
    }
    return r->batch;
}
