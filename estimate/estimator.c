/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/estimator.h"

#include "estimate/feed.h"
#include "estimate/protocol.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/depth_fit.h"
#include "libtensor/geometry/pnp/pnp.h"
#include "libtensor/graph/plan.h"
#include "vision/crop.h"

#include <math.h>
#include <string.h>

enum { POINTS = LT_BOX_POINTS, CELLS_PER_POINT = 10, MIN_PAIRS = 6 };

struct estimator {
    const model *m;
    model_record record;
    lt_plan *plan;
    const float *joints2d, *peak, *rotation, *beta, *vertices, *joints, *conf, *point_x, *point_y;
};

static const float *output(const estimator *e, const char *name)
{
    const lt_tensor *t = model_port_find(&e->record.outputs, name);

    return t ? lt_plan_data(e->plan, t) : NULL;
}

static void find_outputs(estimator *e)
{
    e->joints2d = output(e, "joints2d");
    e->peak = output(e, "peak");
    e->rotation = output(e, "rotation");
    e->beta = output(e, "beta");
    e->vertices = output(e, "vertices");
    e->joints = output(e, "joints");
    e->conf = output(e, "conf");
    e->point_x = output(e, "point_x");
    e->point_y = output(e, "point_y");
}

static lt_status make(const model *m, int batch, bool alone, estimator **out)
{
    const lt_compile_opts opts = { .consume_params = alone, .int8 = m->int8 };
    estimator *e = lt_alloc(sizeof(*e));

    if (!e)
        return lt_error(LT_ENOMEM, "no memory for an estimator");
    e->m = m;
    e->record = (model_record){ .g = lt_graph_new(), .batch = batch };
    if (e->record.g) {
        m->cls->record(m, false, &e->record);
        e->plan = lt_compile(e->record.g, &opts);
    }
    if (!e->plan) {
        estimator_free(e);
        return lt_last_status();
    }
    find_outputs(e);
    *out = e;
    return LT_OK;
}

lt_status estimator_new(const model *m, int batch, estimator **out)
{
    return make(m, batch, false, out);
}

lt_status estimator_new_alone(const model *m, int batch, estimator **out)
{
    return make(m, batch, true, out);
}

void estimator_free(estimator *e)
{
    if (!e)
        return;
    lt_plan_free(e->plan);
    lt_graph_free(e->record.g);
    lt_release(e);
}

/* ---- the object's pose from its control points ------------------------------------------------------- */

typedef struct {
    double X[POINTS * CELLS_PER_POINT * 3], uv[POINTS * CELLS_PER_POINT * 2];
    int n;
    float best;                     /* mean over points of the highest confidence */
} pairs;

/* Whether cell a is trusted more than cell b; ties go to the first. */
static bool before(const float *conf, int a, int b)
{
    return conf[a] > conf[b] || (conf[a] == conf[b] && a < b);
}

/* The most confident cell behind the last one; -1: there is none. What is not a number is no confidence. */
static int next_cell(const float *conf, int cells, int last)
{
    int best = -1;

    for (int i = 0; i < cells; i++)
        if (!isnan(conf[i]) && (last < 0 || before(conf, last, i)) && (best < 0 || before(conf, i, best)))
            best = i;
    return best;
}

/* X: the point in the object's frame; NULL: only where it is seen, the mean of its cells. */
static void collect_point(const estimator *e, const hand_object_batch *b, int s, int v, const float *X,
                          pairs *p, float mean[2])
{
    const int cells = e->m->cells * e->m->cells;
    const int64_t at = ((int64_t)s * POINTS + v) * cells;
    const float *box = b->object_box + 4 * s;
    float sum[2] = { 0, 0 }, n = 0;

    mean[0] = mean[1] = NAN;
    for (int k = 0, i = -1; k < CELLS_PER_POINT; k++) {
        i = next_cell(e->conf + at, cells, i);
        if (k == 0 && i >= 0)
            p->best += e->conf[at + i] / POINTS;
        if (i < 0 || !(e->conf[at + i] > 0.5f))
            return;
        const float uv[2] = { e->point_x[at + i] * (box[2] - box[0]) + box[0],
                              e->point_y[at + i] * (box[3] - box[1]) + box[1] };

        n++;
        for (int d = 0; d < 2; d++) {
            sum[d] += uv[d];
            mean[d] = sum[d] / n;
            p->uv[2 * p->n + d] = uv[d];
        }
        for (int d = 0; d < 3 && X; d++)
            p->X[3 * p->n + d] = X[d];
        p->n++;
    }
}

/* Points of the crop, in place, to where they are in its image. */
static void points_in_image(const float *affine, int n, double *uv)
{
    for (int i = 0; i < 2 * n; i++)
        uv[i] = (uv[i] - affine[3 * (i % 2) + 2]) / affine[4 * (i % 2)];
}

static lt_status solve_pairs(const estimator *e, const hand_object_batch *b, int s, pairs *p, lt_pnp_pose *pose)
{
    const float *K = b->K + 9 * s, *A = b->affine + 6 * s;
    const lt_camera crop = { .fx = K[0], .fy = K[4], .cx = K[2], .cy = K[5] }, image = crop_whole_camera(A, K);
    const lt_pnp_opts refined = lt_pnp_refined();

    if (protocol_of(e->m)->pose == POSE_OPENCV)
        return lt_pnp_ransac(&crop, p->n, p->X, p->uv, NULL, pose, NULL);
    points_in_image(A, p->n, p->uv);
    return lt_pnp_ransac(&image, p->n, p->X, p->uv, &refined, pose, NULL);
}

static void no_object(estimate *out)
{
    out->object = (lt_pose){ { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { 0, 0, 1 } };
    out->object_inliers = 0;
    out->object_error_px = out->object_confidence = 0;
    for (int v = 0; v < POINTS; v++)
        out->control2d[v][0] = out->control2d[v][1] = NAN;
}

/* The crop's pixels have whole numbers at their edges where it is sampled between pixels, else in their middle. */
static void fit_depth(const estimator *e, const hand_object_batch *b, int s, const lt_surface *surface, lt_pose *pose)
{
    const double half = protocol_of(e->m)->crop == HAND_OBJECT_UNION ? 0.5 : 0;
    const float *K = b->K + 9 * s;
    const lt_depth_map map = {
        .camera = { .fx = K[0], .fy = K[4], .cx = K[2] - half, .cy = K[5] - half }, .width = b->size, .height = b->size,
        .metres = b->metres + (int64_t)s * b->size * b->size,
    };

    lt_depth_fit(&map, surface, pose);
}

static void solve_object(const estimator *e, const hand_object_batch *b, int s, const object_shape *object,
                         estimate *out)
{
    const float (*control)[3] = object->control;
    lt_pnp_pose pose;
    pairs p = { .n = 0 };

    no_object(out);
    if (e->m->hand_alone)
        return;
    for (int v = 0; v < POINTS; v++)
        collect_point(e, b, s, v, control ? control[v] : NULL, &p, out->control2d[v]);
    out->object_confidence = p.best;
    if (!control || p.n < MIN_PAIRS || solve_pairs(e, b, s, &p, &pose))
        return;
    memcpy(out->object.R, pose.R, sizeof(pose.R));
    memcpy(out->object.t, pose.t, sizeof(pose.t));
    out->object_inliers = pose.n_inliers;
    out->object_error_px = (float)pose.mean_err_px;
    if (e->m->depth_fit)
        fit_depth(e, b, s, &object->surface, &out->object);
}

/* ---- the hand ------------------------------------------------------------------------------------------ */

static void place_points(const float *relative, const float wrist[3], int n, float (*out)[3])
{
    for (int i = 0; i < n; i++)
        for (int d = 0; d < 3; d++)
            out[i][d] = relative[3 * i + d] + wrist[d];
}

static void read_hand(const estimator *e, const hand_object_batch *b, int s, estimate *out)
{
    const float *box = b->hand_box + 4 * s, *wrist = b->wrist + 3 * s;

    place_points(e->joints + (int64_t)s * 3 * LT_HAND_KEYPOINTS, wrist, LT_HAND_KEYPOINTS, out->joints);
    place_points(e->vertices + (int64_t)s * 3 * LT_HAND_VERTICES, wrist, LT_HAND_VERTICES, out->vertices);
    memcpy(out->rotation, e->rotation + (int64_t)s * 9 * LT_HAND_JOINTS, sizeof(out->rotation));
    memcpy(out->beta, e->beta + (int64_t)s * LT_HAND_BETAS, sizeof(out->beta));
    memcpy(out->peak, e->peak + (int64_t)s * LT_HAND_KEYPOINTS, sizeof(out->peak));
    for (int j = 0; j < LT_HAND_KEYPOINTS; j++)
        for (int d = 0; d < 2; d++)
            out->joints2d[j][d] = e->joints2d[(s * LT_HAND_KEYPOINTS + j) * 2 + d] * (box[2 + d] - box[d])
                + box[d];
}

typedef struct {
    const estimator *e;
    const hand_object_batch *b;
    const object_shape *object;
    estimate *out;
} read_job;

static void read_sample(void *ctx, int64_t s)
{
    const read_job *j = ctx;

    read_hand(j->e, j->b, (int)s, &j->out[s]);
    solve_object(j->e, j->b, (int)s, &j->object[s], &j->out[s]);
}

void estimator_run(estimator *e, const hand_object_batch *b, const object_shape *object, estimate *out)
{
    read_job j = { e, b, object, out };

    feed_batch(e->plan, &e->record, b, 0);
    lt_run(e->plan);
    lt_parallel_for(b->count, read_sample, &j);
}
