/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hand_object/pictures.h"

#include "estimate/feed.h"
#include "tasks/hand_object/sheet.h"

typedef struct {
    const evaluate_options *o;
    int n;
    lt_arena *arena;                /* of the samples and what is seen in them */
    hand_object_batch *batch;
    dataset_sample *sample;         /* (n) */
    object_shape *shape;            /* (n) */
    estimate *seen;                 /* (n) */
    sheet_item *item;               /* (n) */
} pictures;

static lt_status allocate(pictures *p)
{
    const size_t n = (size_t)p->n;

    p->batch = hand_object_batch_new(p->n, p->o->m->image_size, p->o->m->cells);
    p->sample = lt_arena_array(p->arena, n, sizeof(*p->sample));
    p->shape = lt_arena_array(p->arena, n, sizeof(*p->shape));
    p->seen = lt_arena_array(p->arena, n, sizeof(*p->seen));
    p->item = lt_arena_array(p->arena, n, sizeof(*p->item));
    if (!p->batch || !p->sample || !p->shape || !p->seen || !p->item)
        return lt_error(LT_ENOMEM, "no memory for pictures of %d samples", p->n);
    p->batch->count = p->n;
    return LT_OK;
}

static lt_status read_one(pictures *p, const hand_object_options *options, int i)
{
    const dataset *d = p->o->data;
    const int64_t index = i * d->count / p->n;
    dataset_sample *s = &p->sample[i];
    lt_status st = dataset_read(d, index, hand_object_want(options), p->arena, s);

    if (st == LT_OK)
        st = hand_object_prepare(s, options, 0, index, p->batch, i);
    if (st)
        return st;
    p->item[i] = (sheet_item){ .sample = s, .estimate = &p->seen[i] };
    if (s->object >= 0 && !p->o->m->hand_alone) {
        p->item[i].object = &d->objects[s->object];
        p->shape[i] = dataset_shape(&d->objects[s->object], s->flags);
    }
    return LT_OK;
}

static lt_status read_all(pictures *p)
{
    hand_object_options options = hand_object_defaults(false, 0);
    lt_status st = LT_OK;

    feed_options(p->o->m, &options);
    options.bilinear = p->o->bilinear;
    for (int i = 0; i < p->n && st == LT_OK; i++)
        st = read_one(p, &options, i);
    return st;
}

static lt_status look(pictures *p)
{
    estimator *e;
    const lt_status st = estimator_new(p->o->m, p->n, &e);

    if (st)
        return st;
    estimator_run(e, p->batch, p->shape, p->seen);
    estimator_free(e);
    return LT_OK;
}

lt_status evaluate_pictures(const evaluate_options *o, int n, const char *path)
{
    pictures p = { .o = o, .n = (int)lt_min_i64(n, o->data->count), .arena = lt_arena_new() };
    lt_status st = p.arena ? allocate(&p) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (st == LT_OK)
        st = read_all(&p);
    if (st == LT_OK)
        st = look(&p);
    if (st == LT_OK)
        st = predict_sheet(path, p.item, p.n, o->hand->faces);
    hand_object_batch_free(p.batch);
    lt_arena_free(p.arena);
    return st;
}
