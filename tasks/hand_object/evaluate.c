/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Scoring: batches of a split through the model and the two predictors that see no image.
 */
#include "tasks/hand_object/each_batch.h"
#include "tasks/hand_object/internal.h"
#include "tasks/hand_object/mean_labels.h"
#include "vision/crop.h"

#include "data/hand_pose.h"
#include "data/kind.h"
#include "data/mirror.h"
#include "eval/metrics/metrics.h"
#include "libtensor/base/parallel.h"

#include <math.h>
#include <string.h>

static void *array(evaluation *e, size_t n, size_t size)
{
    return lt_arena_array(e->arena, n, size);
}

static lt_status set_new(evaluation *e, int row, const char *label)
{
    score_set *s = &e->set[row];

    s->label = label;
    s->ho3d = ho3d_scorer_new();
    s->dexycb = dexycb_scorer_new();
    s->adds = array(e, (size_t)e->samples, sizeof(*s->adds));
    return s->ho3d && s->dexycb && s->adds ? LT_OK : lt_error(LT_ENOMEM, "no memory to score");
}

static bool rows_new(evaluation *e, batch_rows *r, int n)
{
    const size_t B = (size_t)n;

    r->joints = array(e, B, sizeof(*r->joints));
    r->vertices = array(e, B, sizeof(*r->vertices));
    r->gl_joints = array(e, B, sizeof(*r->gl_joints));
    r->gl_vertices = array(e, B, sizeof(*r->gl_vertices));
    r->object = array(e, B, sizeof(*r->object));
    r->hand_errors = array(e, B, sizeof(*r->hand_errors));
    r->relative_errors = array(e, B, sizeof(*r->relative_errors));
    r->object_errors = array(e, B, sizeof(*r->object_errors));
    return r->joints && r->vertices && r->gl_joints && r->gl_vertices && r->object && r->hand_errors
        && r->relative_errors && r->object_errors;
}

static bool objects_new(evaluation *e)
{
    const dataset *d = e->o.data;

    e->object = array(e, (size_t)d->n_objects, sizeof(*e->object));
    for (int i = 0; e->object && i < d->n_objects; i++) {
        const dataset_object *o = &d->objects[i];
        double *points = array(e, (size_t)o->n_points * 3, sizeof(*points));

        if (!points)
            return false;
        for (int k = 0; k < 3 * o->n_points; k++)
            points[k] = o->point[k / 3][k % 3];
        e->object[i] = (eval_object){
            .n_points = o->n_points, .point = points, .symmetric = eval_is_symmetric(EVAL_SYM_HFL, o->ycb_id),
        };
    }
    return e->object;
}

static void find_object_tables(evaluation *e)
{
    const eval_table *t;

    for (int i = 0; (t = eval_table_at(i)); i++)
        if (eval_table_of(t, e->o.m->cls->name) && eval_table_by_object(t) && e->n_by_object < EVALUATE_OBJECT_TABLES)
            e->by_object[e->n_by_object++] = t;
}

static lt_status prepare(evaluation *e)
{
    const int B = e->o.batch;
    bool ok = rows_new(e, &e->rows, B) && rows_new(e, &e->truth, B) && objects_new(e);

    e->shape = array(e, (size_t)B, sizeof(*e->shape));
    e->estimates = array(e, (size_t)B, sizeof(*e->estimates));
    e->camera = array(e, (size_t)B, sizeof(*e->camera));
    e->which = array(e, (size_t)B, sizeof(*e->which));
    e->flags = array(e, (size_t)B, sizeof(*e->flags));
    e->per_sample = array(e, (size_t)e->samples, sizeof(*e->per_sample));
    e->names = array(e, (size_t)e->samples, sizeof(*e->names));
    e->breakdown = eval_breakdown_new(e->arena);
    find_object_tables(e);
    ok = ok && e->shape && e->estimates && e->camera && e->which && e->flags && e->per_sample && e->names
        && e->breakdown;
    if (!ok || set_new(e, EVALUATE_MODEL, e->o.m->cls->name) || set_new(e, EVALUATE_ZERO, "zero predictor"))
        return lt_error(LT_ENOMEM, "no memory to score %d images at a time", B);
    return e->has_mean ? set_new(e, EVALUATE_MEAN_POSE, "mean-pose predictor") : LT_OK;
}

/* ---- one batch ------------------------------------------------------------------------------------------ */

/* The mesh of the annotated pose, where the dataset has the pose instead of the mesh. */
static void pose_vertices(const evaluation *e, const hand_object_batch *b, int s, float (*out)[3])
{
    double vertices[LT_HAND_VERTICES][3];

    hand_pose_at(e->o.hand, b->rotation + 9 * LT_HAND_JOINTS * s, b->beta + LT_HAND_BETAS * s, b->wrist + 3 * s,
                 vertices);
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int d = 0; d < 3; d++)
            out[v][d] = (float)vertices[v][d];
}

/* Of the image on DexYCB, of the crop on HO3D, as HFL-Net counts pixels. */
static lt_camera camera_of(const evaluation *e, const hand_object_batch *b, int s)
{
    const float *K = b->K + 9 * s;

    if (e->o.data->kind->image_pixels)
        return crop_whole_camera(b->affine + 6 * s, K);
    return (lt_camera){ .fx = K[0], .fy = K[4], .cx = K[2], .cy = K[5] };
}

static lt_status read_truth(evaluation *e, const hand_object_batch *b)
{
    for (int s = 0; s < b->count; s++) {
        if (!(b->flags[s] & SAMPLE_JOINTS) || (!b->vertices[s] && !(b->flags[s] & SAMPLE_HAND_POSE)))
            return lt_error(LT_EINVAL, "%s: no ground truth for %s; want evaluation_xyz.json and "
                            "evaluation_verts.json beside evaluation.txt", e->o.data->root,
                            dataset_name(e->o.data, b->index[s]));
        memcpy(e->truth.joints[s], b->joints + 63 * (int64_t)s, sizeof(e->truth.joints[s]));
        if (b->vertices[s])
            memcpy(e->truth.vertices[s], b->vertices[s], sizeof(e->truth.vertices[s]));
        else
            pose_vertices(e, b, s, e->truth.vertices[s]);
        e->truth.object[s] = lt_pose_of(b->R + 9 * s, b->t + 3 * s);
        mirror_model(e->truth.object[s].R, b->flags[s] & SAMPLE_MIRRORED);
        e->flags[s] = b->flags[s];
        e->which[s] = e->o.m->hand_alone ? -1 : b->object[s];
        e->shape[s] = e->which[s] < 0 ? (object_shape){ 0 }
                                      : dataset_shape(&e->o.data->objects[e->which[s]], b->flags[s]);
        e->camera[s] = camera_of(e, b, s);
    }
    return LT_OK;
}

static void to_opengl(void *ctx, int64_t s)
{
    batch_rows *r = ctx;

    ho3d_joints_from_camera(r->joints[s][0], r->gl_joints[s][0]);
    ho3d_vertices_from_camera(r->vertices[s][0], r->gl_vertices[s][0]);
}

/* Too few pairs are no pose, which no distance is near enough for [Bandi and Thomas 2025, section 3]; HOCAT's pose
 * then is R = I, t = (0, 0, 1), and scored as that. */
static bool without_pose(const evaluation *e, const score_set *set, int s)
{
    return set == &e->set[EVALUATE_MODEL] && protocol_of(e->o.m)->pose == POSE_REFINED &&
           e->estimates[s].object_inliers == 0;
}

/* Whether sample s of the batch is right by ADD-0.1D, which takes HFL-Net's symmetric objects by ADD-S on DexYCB */
static bool within_tenth(const evaluation *e, int s)
{
    const eval_object_errors *err = &e->rows.object_errors[s];
    const double error = e->o.data->kind->symmetric_adds ? err->add_or_adds : err->add;

    return error <= 0.1 * e->o.data->objects[e->which[s]].diagonal;
}

static void count_objects(evaluation *e, score_set *set, int n)
{
    const dataset_object *objects = e->o.data->objects;

    for (int s = 0; s < n; s++) {
        const eval_object_errors *err = &e->rows.object_errors[s];
        const int i = e->which[s];

        if (i < 0)
            continue;
        for (int k = 0; k < e->n_by_object; k++)
            eval_object_shares_add(e->by_object[k], &set->shares[k], objects[i].name,
                                   e->by_object[k]->hfl_symmetry ? err->add_or_adds : err->add, objects[i].diagonal);
        set->adds[set->n_adds++] = without_pose(e, set, s) ? INFINITY : err->adds_true;
        eval_share_add(&set->add01, within_tenth(e, s));
        eval_share_add(&set->rep5, err->reprojection_px <= 5 && !without_pose(e, set, s));
        eval_mean_add(&set->add, err->add);
        eval_mean_add(&set->oce, err->oce);
        eval_mean_add(&set->mce, err->mce);
        eval_mean_add(&set->mean_adds, err->adds_estimate);
    }
}

static lt_status score_rows(evaluation *e, score_set *set, int n)
{
    batch_rows *p = &e->rows, *g = &e->truth;
    lt_status st;

    for (int s = 0; s < n; s++)
        mirror_model(p->object[s].R, e->flags[s] & SAMPLE_MIRRORED);
    lt_parallel_for(n, to_opengl, p);
    st = ho3d_scorer_add(set->ho3d, n, p->gl_joints[0][0], p->gl_vertices[0][0], g->gl_joints[0][0],
                         g->gl_vertices[0][0], p->hand_errors);
    if (st)
        return st;
    dexycb_scorer_add(set->dexycb, n, p->joints[0][0], g->joints[0][0], p->relative_errors);
    st = eval_object_measure(e->object, n, e->which, p->object, g->object, e->camera, p->object_errors);
    if (st == LT_OK)
        count_objects(e, set, n);
    return st;
}

/* Sample s of the batch: where the model errs. */
static lt_status break_down(evaluation *e, int64_t done, int s)
{
    const dataset_object *object = e->which[s] < 0 ? NULL : &e->o.data->objects[e->which[s]];
    double joints[3 * LT_HAND_KEYPOINTS], truth[3 * LT_HAND_KEYPOINTS];
    const eval_breakdown_sample sample = {
        .name = e->names[done + s], .object = object ? object->name : NULL, .joints = joints, .truth = truth,
        .add = e->rows.object_errors[s].add,
        .add01 = object && within_tenth(e, s),
    };

    eval_widen(3 * LT_HAND_KEYPOINTS, e->rows.joints[s][0], joints);
    eval_widen(3 * LT_HAND_KEYPOINTS, e->truth.joints[s][0], truth);
    return eval_breakdown_add(e->breakdown, &sample);
}

static lt_status score_model(evaluation *e, int64_t done, int n)
{
    lt_status st;

    for (int s = 0; s < n; s++) {
        memcpy(e->rows.joints[s], e->estimates[s].joints, sizeof(e->rows.joints[s]));
        memcpy(e->rows.vertices[s], e->estimates[s].vertices, sizeof(e->rows.vertices[s]));
        e->rows.object[s] = e->estimates[s].object;
        e->set[EVALUATE_MODEL].no_pose += e->which[s] >= 0 && e->estimates[s].object_inliers == 0;
    }
    st = score_rows(e, &e->set[EVALUATE_MODEL], n);
    for (int s = 0; st == LT_OK && s < n; s++) {
        const double errors[] = {
            1e3 * e->rows.hand_errors[s].xyz_pa, 1e3 * e->rows.hand_errors[s].mesh_pa,
            1e3 * e->rows.relative_errors[s].relative, 1e3 * e->rows.object_errors[s].add,
            e->rows.object_errors[s].rotation_deg,
        };

        memcpy(e->per_sample[done + s], errors, sizeof(errors));
    }
    for (int s = 0; st == LT_OK && s < n; s++)
        st = break_down(e, done, s);
    return st;
}

static lt_status score_mean(evaluation *e, const hand_object_batch *b)
{
    for (int s = 0; s < b->count; s++) {
        const float *wrist = b->wrist + 3 * s;

        mean_predictor_hand(&e->mean, wrist, e->rows.joints[s][0], e->rows.vertices[s][0]);
        e->rows.object[s] = mean_predictor_object(&e->mean, b->object[s], wrist);
    }
    return score_rows(e, &e->set[EVALUATE_MEAN_POSE], b->count);
}

static lt_status score_zero(evaluation *e, const hand_object_batch *b)
{
    for (int s = 0; s < b->count; s++) {
        zero_predictor_hand(e->rows.joints[s][0], e->rows.vertices[s][0]);
        e->rows.object[s] = zero_predictor_object();
    }
    return score_rows(e, &e->set[EVALUATE_ZERO], b->count);
}

static lt_status score_batch(evaluation *e, estimator *est, const hand_object_batch *b, int64_t done)
{
    lt_status st = read_truth(e, b);

    if (st)
        return st;
    lt_parallel_for(b->count, to_opengl, &e->truth);
    estimator_run(est, b, e->shape, e->estimates);
    for (int s = 0; s < b->count; s++)
        e->names[done + s] = dataset_name(e->o.data, b->index[s]);
    st = score_model(e, done, b->count);
    if (st == LT_OK && e->has_mean)
        st = score_mean(e, b);
    return st ? st : score_zero(e, b);
}

/* ---- the whole split -------------------------------------------------------------------------------------- */

typedef struct {
    evaluation *e;
    estimator *estimator;
} score_job;

static lt_status score_one(void *ctx, const hand_object_batch *b, int64_t done)
{
    const score_job *j = ctx;

    return score_batch(j->e, j->estimator, b, done);
}

static lt_status run(evaluation *e)
{
    score_job job = { .e = e };
    lt_status st = LT_OK;
    int tips[5];

    lt_hand_layer_tips(e->o.m->hand, tips);
    if (e->o.training)
        st = mean_labels_fit(e->o.training, e->o.hand, tips, &e->mean, &e->has_mean);
    if (st == LT_OK)
        st = prepare(e);
    if (st == LT_OK)
        st = estimator_new(e->o.m, e->o.batch, &job.estimator);
    if (st == LT_OK)
        st = eval_each_batch(&e->o, score_one, &job);
    estimator_free(job.estimator);
    return st;
}

lt_status evaluate(const evaluate_options *o, evaluation **out)
{
    lt_arena *arena = lt_arena_new();
    evaluation *e = arena ? lt_arena_alloc(arena, sizeof(*e)) : NULL;
    lt_status st;

    if (!e) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "no memory to score");
    }
    e->arena = arena;
    e->o = *o;
    e->o.batch = (int)lt_max_i64(1, lt_min_i64(o->batch, 256));
    e->samples = o->limit > 0 ? lt_min_i64(o->limit, o->data->count) : o->data->count;
    st = e->samples ? run(e) : lt_error(LT_EINVAL, "%s: the split has no samples", o->data->root);
    if (st) {
        evaluation_free(e);
        return st;
    }
    *out = e;
    return LT_OK;
}

void evaluation_free(evaluation *e)
{
    if (!e)
        return;
    for (int i = 0; i < EVALUATE_ROWS; i++) {
        ho3d_scorer_free(e->set[i].ho3d);
        dexycb_scorer_free(e->set[i].dexycb);
    }
    lt_arena_free(e->arena);
}
