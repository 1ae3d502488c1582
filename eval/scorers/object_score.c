/* SPDX-License-Identifier: Apache-2.0 */
/* All object errors of many samples: a task a sample, each with its own place for the result. */
#include "eval/scorers/object_score.h"

#include "libtensor/base/parallel.h"

#include <math.h>
#include <stdatomic.h>

typedef struct {
    const eval_object *objects;
    const int32_t *which;
    const lt_pose *e, *g;
    const lt_camera *camera;
    eval_object_errors *out;
    atomic_bool no_memory;
} job;

static const eval_object_errors nothing = { NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN };

static void measure(void *ctx, int64_t i)
{
    job *j = ctx;
    const lt_pose *e = &j->e[i], *g = &j->g[i];
    const eval_object *o;
    eval_object_errors *r = &j->out[i];

    *r = nothing;
    if (j->which[i] < 0)
        return;
    o = &j->objects[j->which[i]];
    r->add = eval_add(o->n_points, o->point, e, g);
    if (eval_adds(EVAL_FROM_TRUE, o->n_points, o->point, e, g, &r->adds_true)
        || eval_adds(EVAL_FROM_ESTIMATE, o->n_points, o->point, e, g, &r->adds_estimate))
        atomic_store(&j->no_memory, true);
    r->add_or_adds = o->symmetric ? r->adds_estimate : r->add;
    r->rotation_deg = eval_rotation_error_deg(e, g);
    r->reprojection_px = eval_reprojection_px(o->n_points, o->point, e, g, &j->camera[i], 1e-5);
    r->oce = eval_oce(e, g);
    r->mce = eval_mce(o->n_points, o->point, e, g);
}

lt_status eval_object_measure(const eval_object *objects, int64_t n, const int32_t *which,
                              const lt_pose *e, const lt_pose *g, const lt_camera *camera,
                              eval_object_errors *out)
{
    job j = { .objects = objects, .which = which, .e = e, .g = g, .camera = camera, .out = out };

    lt_parallel_for(n, measure, &j);
    if (atomic_load(&j.no_memory))
        return lt_error(LT_ENOMEM, "object errors of %lld samples: no memory", (long long)n);
    return LT_OK;
}
