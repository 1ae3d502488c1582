/* SPDX-License-Identifier: Apache-2.0 */
/* crop: each hand's view, a left one in the mirror, as a slot of a batch. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

#include "estimate/feed.h"

#include <string.h>

typedef struct {
    hand_object_options options;
    hand_object_batch *batch;           /* of as many slots as a frame had hands */
} crops;

static lt_status grow(crops *c, int n)
{
    hand_object_batch *b;

    if (c->batch && c->batch->capacity >= n)
        return LT_OK;
    b = hand_object_batch_new(n, c->options.size, c->options.cells);
    if (!b)
        return lt_error(LT_ENOMEM, "no memory for a batch");
    hand_object_batch_free(c->batch);
    c->batch = b;
    return LT_OK;
}

static void close_crops(void *state)
{
    crops *c = state;

    hand_object_batch_free(c->batch);
    lt_release(c);
}

static lt_status open_crops(const predict_options *o, void **state)
{
    crops *c = lt_alloc(sizeof(*c));
    lt_status st;

    if (!c)
        return lt_error(LT_ENOMEM, "no memory to predict with");
    c->options = hand_object_defaults(false, 0);
    feed_options(o->m, &c->options);
    c->options.bilinear = o->bilinear;
    st = grow(c, 1);
    if (st)
        close_crops(c);
    else
        *state = c;
    return st;
}

/* A view as a sample of a dataset: boxes, and nothing that would have to be known. The object's box is
 * the extent of its control points, so two of its corners stand in for all. */
static void sample_of(const predict_view *v, dataset_sample *s)
{
    const float corner[2][2] = { { v->object_box.x0, v->object_box.y0 }, { v->object_box.x1, v->object_box.y1 } };

    *s = (dataset_sample){
        .name = v->path, .flags = SAMPLE_HAND_BOX | SAMPLE_OBJECT, .width = v->width, .height = v->height,
        .rgb = v->rgb, .depth = v->depth, .camera = v->camera, .object = -1,
        .hand_box = { v->hand_box.x0, v->hand_box.y0, v->hand_box.x1, v->hand_box.y1 },
    };
    for (int i = 0; i < LT_BOX_POINTS; i++)
        memcpy(s->control2d[i], corner[i & 1], sizeof(s->control2d[i]));
}

static lt_status run(void *state, predict_frame *f)
{
    crops *c = state;
    lt_status st = grow(c, f->n);

    f->seen = lt_arena_array(f->arena, (size_t)f->n, sizeof(*f->seen));
    if (!st && !f->seen)
        st = lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
    for (int i = 0; i < f->n && !st; i++) {
        dataset_sample sample;

        f->seen[i] = f->view[i];
        st = f->view[i].left ? predict_view_mirror(f->arena, &f->view[i], &f->seen[i]) : LT_OK;
        sample_of(&f->seen[i], &sample);
        st = st ? st : hand_object_prepare(&sample, &c->options, 0, 0, c->batch, i);
    }
    f->crops = c->batch;
    return st;
}

const stage crop_stage = {
    .name = "crop", .needs = FRAME_VIEWS, .gives = FRAME_CROPS, .open = open_crops, .run = run, .close = close_crops,
};
