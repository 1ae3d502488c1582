/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/reid/looks.h"

#include "libtensor/base/rng.h"
#include "libtensor/io/file.h"
#include "models/reid/reid.h"
#include "vision/picture.h"
#include "vision/track/look.h"

#include <stdlib.h>
#include <string.h>

enum { PIXELS = REID_HEIGHT * REID_WIDTH };

bool looks_person(const mot_sequence *s)
{
    return !lt_ends_with(s->name, "_hand") && !lt_ends_with(s->name, "_object");
}

/* ---- opening ---- */

/* Ids are told apart within a group. */
typedef struct { const char *group; int64_t id; } identity;

typedef struct {
    lt_arena *arena;
    looks *to;
    look *list;
    identity *who;
    size_t n, room, n_who, room_who;
} collecting;

static const char *group_of(const collecting *c, const mot_sequence *s)
{
    const char *kind = c->to->set.synthetic ? strrchr(s->name, '_') : NULL;

    return kind ? kind : s->name;
}

static lt_status no_memory(const collecting *c)
{
    return lt_error(LT_ENOMEM, "%s: no memory", c->to->set.root);
}

static lt_status number_of(collecting *c, const char *group, int64_t id, int *out)
{
    for (size_t i = 0; i < c->n_who; i++)
        if (c->who[i].id == id && strcmp(c->who[i].group, group) == 0) {
            *out = (int)i;
            return LT_OK;
        }
    c->who = lt_arena_grow(c->arena, c->who, c->n_who, &c->room_who, sizeof(*c->who));
    if (!c->who)
        return no_memory(c);
    c->who[c->n_who] = (identity){ group, id };
    *out = (int)c->n_who++;
    return LT_OK;
}

static lt_status add(collecting *c, int sequence, int64_t frame, const mot_box *b)
{
    look l = { .sequence = sequence, .frame = frame };
    lt_status st = number_of(c, group_of(c, &c->to->set.sequence[sequence]), b->id, &l.identity);

    if (st)
        return st;
    for (int k = 0; k < 4; k++)
        l.box[k] = (float)b->box[k];
    c->list = lt_arena_grow(c->arena, c->list, c->n, &c->room, sizeof(*c->list));
    if (!c->list)
        return no_memory(c);
    c->list[c->n++] = l;
    return LT_OK;
}

static bool in_picture(const mot_sequence *s, const mot_box *b)
{
    return b->box[2] > 1 && b->box[3] > 1 && b->box[0] < s->width - 1 && b->box[1] < s->height - 1 &&
        b->box[2] > b->box[0] && b->box[3] > b->box[1];
}

static lt_status add_sequence(collecting *c, int k, int every, double visible)
{
    const mot_sequence *s = &c->to->set.sequence[k];
    lt_arena *scratch = lt_arena_new();
    mot_frame *frame;
    lt_status st = !scratch ? no_memory(c)
                   : !s->truth ? lt_error(LT_EIO, "%s: has no gt/gt.txt to learn identities from", s->folder)
                   : mot_read(scratch, s->truth, MOT_TRUTH, s->frames, &frame);

    for (int64_t f = 0; !st && f < s->frames; f += every)
        for (int i = 0; !st && i < frame[f].n; i++) {
            const mot_box *b = &frame[f].box[i];

            if (b->scored && b->cls == MOT_PEDESTRIAN && b->visible >= visible && in_picture(s, b))
                st = add(c, k, f, b);
        }
    lt_arena_free(scratch);
    return st;
}

lt_status looks_open(lt_arena *arena, const char *root, const char *split, int every, double visible, looks *out)
{
    collecting c = { .arena = arena, .to = out };
    lt_status st = mot_open(arena, root, split, &out->set);

    for (int k = 0; !st && k < out->set.n; k++)
        st = add_sequence(&c, k, every, visible);
    if (!st && !c.n)
        st = lt_error(LT_EINVAL, "%s: no box of the %s split is scored and seen to %g", root, split, visible);
    out->look = c.list;
    out->n = (int64_t)c.n;
    out->identities = (int)c.n_who;
    return st;
}

/* ---- batches ---- */

static void batch_free(void *batch)
{
    look_batch *b = batch;

    if (!b)
        return;
    free(b->index);
    free(b->there);
    free(b->image);
    free(b);
}

static void *batch_new(const void *ctx, int capacity)
{
    const size_t n = (size_t)capacity;
    look_batch *b = calloc(1, sizeof(*b));

    (void)ctx;
    if (!b)
        return NULL;
    b->index = calloc(n, sizeof(*b->index));
    b->there = calloc(n, sizeof(*b->there));
    b->image = calloc(n * 3 * PIXELS, sizeof(*b->image));
    if (b->index && b->there && b->image)
        return b;
    batch_free(b);
    return NULL;
}

static void batch_start(void *b, int count)
{
    ((look_batch *)b)->count = count;
}

static void batch_skip(void *batch, int slot, int64_t index)
{
    look_batch *b = batch;

    b->index[slot] = index;
    b->there[slot] = false;
}

static void mirror(float *image)
{
    for (int row = 0; row < 3 * REID_HEIGHT; row++)
        for (int x = 0; x < REID_WIDTH / 2; x++) {
            float *a = image + row * REID_WIDTH + x, *b = image + (row + 1) * REID_WIDTH - 1 - x, keep = *a;

            *a = *b;
            *b = keep;
        }
}

static void shake(float box[4], double noise, lt_rng *rng)
{
    const double side[2] = { (double)(box[2] - box[0]), (double)(box[3] - box[1]) };

    for (int k = 0; k < 4; k++)
        box[k] += (float)(noise * side[k % 2] * lt_rng_normal(rng));
}

static lt_status batch_fill(const void *ctx, uint64_t epoch, int64_t index, lt_arena *scratch, void *batch, int slot)
{
    const look_feed *f = ctx;
    const look *l = &f->of->look[index];
    const mot_sequence *s = &f->of->set.sequence[l->sequence];
    const bool person = looks_person(s);
    look_batch *b = batch;
    float *image = b->image + (size_t)slot * 3 * PIXELS, box[4];
    lt_rng rng = lt_rng_make(f->seed, lt_rng_mix(epoch, (uint64_t)index));
    lt_image rgb;
    lt_status st = picture_read_rgb(scratch, mot_picture(scratch, s, l->frame), s->width, s->height, &rgb);

    b->index[slot] = index;
    if (st)
        return st;
    memcpy(box, l->box, sizeof(box));
    if (f->how)
        shake(box, f->how->noise, &rng);
    /* A person's box at the picture's border may be beyond it once it is narrower. */
    b->there[slot] = look_cut(&rgb, box, person, REID_WIDTH, REID_HEIGHT, image);
    if (f->how && person && lt_rng_uniform(&rng) < f->how->flip)
        mirror(image);
    return LT_OK;
}

static const char *look_name(const void *ctx, int64_t index)
{
    const looks *of = ((const look_feed *)ctx)->of;

    return of->set.sequence[of->look[index].sequence].name;
}

loader_source look_source(const look_feed *feed)
{
    return (loader_source){ .ctx = feed, .count = feed->count, .name = look_name, .batch_new = batch_new,
                            .batch_free = batch_free, .start = batch_start, .fill = batch_fill, .skip = batch_skip };
}
