/* SPDX-License-Identifier: Apache-2.0 */
/* estimate: each crop through the network. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

#include <math.h>

static lt_status open_estimator(const predict_options *o, void **state)
{
    estimator *e;
    const lt_status st = o->alone ? estimator_new_alone(o->m, 1, &e) : estimator_new(o->m, 1, &e);

    if (!st)
        *state = e;
    return st;
}

static void close_estimator(void *state)
{
    estimator_free(state);
}

static bool finite_hand(const estimate *e)
{
    float sum = 0;

    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        sum += e->joints[i][0] + e->joints[i][1] + e->joints[i][2] + e->joints2d[i][0] + e->joints2d[i][1];
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        sum += e->vertices[i][0] + e->vertices[i][1] + e->vertices[i][2];
    return isfinite(sum);
}

static object_shape shape_of(const predict_view *v)
{
    const predict_object *o = v->object;

    if (!o)
        return (object_shape){ 0 };
    return v->left ? (object_shape){ o->mirrored, o->mirrored_surface } : (object_shape){ o->control, o->surface };
}

/* One hand at a time: the numbers of one do not depend on which others are in the picture. */
static lt_status run(void *state, predict_frame *f)
{
    predict_result *r = lt_arena_array(f->arena, (size_t)f->n, sizeof(*r));

    if (!r)
        return lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
    for (int i = 0; i < f->n; i++) {
        const predict_view *v = &f->view[i];
        const object_shape shape = shape_of(v);
        const hand_object_batch crop = hand_object_batch_slot(f->crops, i);

        estimator_run(state, &crop, &shape, &r[i].e);
        if (!finite_hand(&r[i].e))
            return lt_error(LT_ENUMERIC, "%s: the model's answer is not finite: its weights are damaged", v->path);
    }
    f->result = r;
    return LT_OK;
}

const stage estimate_stage = {
    .name = "estimate", .needs = FRAME_VIEWS | FRAME_CROPS, .gives = FRAME_ESTIMATES,
    .open = open_estimator, .run = run, .close = close_estimator,
};
