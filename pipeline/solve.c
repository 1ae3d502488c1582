/* SPDX-License-Identifier: Apache-2.0 */
/* One view through the network, and its hand and object put where the camera saw them. */
#include "pipeline/internal.h"

#include "data/hand_object.h"
#include "data/mirror.h"
#include "estimate/feed.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

static const double AGREEMENT = 0.1;                /* of the hand box's side */

/* ---- through the network -------------------------------------------------------------------------------- */

struct predict_solver {
    estimator *estimator;
    hand_object_batch *batch;
    hand_object_options options;
};

lt_status predict_solver_new(const predict_options *o, predict_solver **out)
{
    predict_solver *s = lt_alloc(sizeof(*s));
    lt_status st;

    if (!s)
        return lt_error(LT_ENOMEM, "no memory to predict with");
    s->options = hand_object_defaults(false, 0);
    feed_options(o->m, &s->options);
    s->options.bilinear = o->bilinear;
    s->batch = hand_object_batch_new(1, o->m->image_size, o->m->cells);
    st = !s->batch ? lt_error(LT_ENOMEM, "no memory for a batch")
         : o->alone ? estimator_new_alone(o->m, 1, &s->estimator) : estimator_new(o->m, 1, &s->estimator);
    if (st) {
        predict_solver_free(s);
        return st;
    }
    *out = s;
    return LT_OK;
}

void predict_solver_free(predict_solver *s)
{
    if (!s)
        return;
    estimator_free(s->estimator);
    hand_object_batch_free(s->batch);
    lt_release(s);
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

/* Points from the crop back to the image. */
static void points_in_image(const hand_object_batch *b, const float (*crop)[2], int n, float (*out)[2])
{
    double A[6];

    for (int k = 0; k < 6; k++)
        A[k] = b->affine[k];
    if (lt_affine_inverse(A, A))
        memcpy(out, crop, (size_t)n * sizeof(*out));
    else
        crop_points(A, crop, n, out);
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

static lt_status run(predict_solver *s, const predict_view *v, const float (*control)[3], predict_result *r)
{
    dataset_sample sample;
    lt_status st;

    sample_of(v, &sample);
    s->batch->count = 1;
    st = hand_object_prepare(&sample, &s->options, 0, 0, s->batch, 0);
    if (st)
        return st;
    estimator_run(s->estimator, s->batch, &control, &r->e);
    if (!finite_hand(&r->e))
        return lt_error(LT_ENUMERIC, "%s: the model's answer is not finite: its weights are damaged", v->path);
    points_in_image(s->batch, (const float (*)[2])r->e.joints2d, LT_HAND_KEYPOINTS, r->heatmap2d);
    points_in_image(s->batch, (const float (*)[2])r->e.control2d, LT_BOX_POINTS, r->control2d);
    r->object_found = r->e.object_inliers > 0 && lt_pose_finite(&r->e.object) && r->e.object.t[2] > PREDICT_NEAREST &&
                      r->e.object.t[2] < PREDICT_FARTHEST;
    r->object_far = r->e.object_inliers > 0 && !r->object_found;
    return LT_OK;
}

/* ---- back out of the mirror ----------------------------------------------------------------------------- */

static void unmirror(int width, predict_result *r)
{
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        r->e.joints[i][0] = -r->e.joints[i][0];
        r->heatmap2d[i][0] = (float)(width - 1) - r->heatmap2d[i][0];
    }
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        r->e.vertices[i][0] = -r->e.vertices[i][0];
    for (int i = 0; i < LT_BOX_POINTS; i++)
        r->control2d[i][0] = (float)(width - 1) - r->control2d[i][0];
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        lt_mirror_axis_angle(r->theta + 3 * j);
    mirror_pose(r->e.object.R, r->e.object.t);
}

static void read_theta(predict_result *r)
{
    for (int j = 0; j < LT_HAND_JOINTS; j++) {
        double R[9];

        for (int k = 0; k < 9; k++)
            R[k] = r->e.rotation[j][k];
        lt_rot_to_axis_angle(R, r->theta + 3 * j);
    }
}

void predict_reproject(const predict_view *v, predict_result *r)
{
    double sum = 0;

    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const double p[3] = { r->e.joints[i][0], r->e.joints[i][1], r->e.joints[i][2] };
        double uv[2];

        lt_camera_project(&v->camera, p, uv);
        r->joints2d[i][0] = (float)uv[0];
        r->joints2d[i][1] = (float)uv[1];
        sum += hypot(uv[0] - r->heatmap2d[i][0], uv[1] - r->heatmap2d[i][1]);
    }
    r->agreement_px = sum / LT_HAND_KEYPOINTS;
}

bool predict_trusted(const predict_view *v, const predict_result *r)
{
    const crop_box b = v->hand_box;

    return r->placed && r->agreement_px <= AGREEMENT * (double)fmaxf(b.x1 - b.x0, b.y1 - b.y0);
}

lt_status predict_solve(predict_solver *s, lt_arena *arena, const predict_view *v, predict_result *out)
{
    const float (*control)[3] = !v->object ? NULL : v->left ? v->object->mirrored : v->object->control;
    predict_view seen = *v;
    lt_status st = v->left ? predict_view_mirror(arena, v, &seen) : LT_OK;

    st = st ? st : run(s, &seen, control, out);
    if (st)
        return st;
    predict_place_hand(&seen, out);
    read_theta(out);
    if (v->left)
        unmirror(v->width, out);
    predict_reproject(v, out);
    return LT_OK;
}
