/* SPDX-License-Identifier: Apache-2.0 */
/* The zero predictor and the mean of a training set. */
#include "tasks/hand_object/predictors.h"

#include "libtensor/base/arena.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

enum {
    J = LT_HAND_KEYPOINTS, V = LT_HAND_VERTICES, POSE = 9 * LT_HAND_JOINTS, BETA = LT_HAND_BETAS,
};

typedef struct {
    double rotation[POSE], beta[BETA];
    double R[PREDICTOR_OBJECTS][9], t[PREDICTOR_OBJECTS][3];
    int64_t n_object[PREDICTOR_OBJECTS];
} sums;

static bool all_finite(int n, const float *x)
{
    for (int i = 0; i < n; i++) {
        if (!isfinite(x[i]))
            return false;
    }
    return true;
}

static lt_status check_hand(const predictor_labels *l, int64_t i)
{
    if (all_finite(3 * J, l->joints + i * 3 * J) && all_finite(POSE, l->rotation + i * POSE)
        && all_finite(BETA, l->beta + i * BETA))
        return LT_OK;
    return lt_error(LT_EINVAL, "mean pose: hand of training sample %lld is not finite", (long long)i);
}

static lt_status check_object(const predictor_labels *l, int64_t i)
{
    if (l->object[i] >= PREDICTOR_OBJECTS)
        return lt_error(LT_EINVAL, "mean pose: training sample %lld has object %d, want one below %d",
                        (long long)i, (int)l->object[i], PREDICTOR_OBJECTS);
    if (!all_finite(9, l->R + 9 * i) || !all_finite(3, l->t + 3 * i))
        return lt_error(LT_EINVAL, "mean pose: object of training sample %lld is not finite",
                        (long long)i);
    return LT_OK;
}

static void add(int n, const float *x, double *sum)
{
    for (int k = 0; k < n; k++)
        sum[k] += x[k];
}

static void add_hand(const predictor_labels *l, int64_t i, sums *s)
{
    add(POSE, l->rotation + i * POSE, s->rotation);
    add(BETA, l->beta + i * BETA, s->beta);
}

static void add_object(const predictor_labels *l, int64_t i, sums *s)
{
    const int o = l->object[i];
    const float *wrist = l->joints + i * 3 * J;

    add(9, l->R + 9 * i, s->R[o]);
    for (int k = 0; k < 3; k++)
        s->t[o][k] += (double)l->t[3 * i + k] - wrist[k];
    s->n_object[o]++;
}

static lt_status add_all(const predictor_labels *l, sums *s)
{
    for (int64_t i = 0; i < l->n; i++) {
        lt_status st = check_hand(l, i);

        if (st)
            return st;
        add_hand(l, i, s);
        if (!l->object || l->object[i] < 0)
            continue;
        st = check_object(l, i);
        if (st)
            return st;
        add_object(l, i, s);
    }
    return LT_OK;
}

static lt_status mean_mesh(const sums *s, int64_t n, const lt_hand_model *model, const int tips[5],
                           mean_predictor *out)
{
    double R[POSE], beta[BETA], joints[3 * LT_HAND_JOINTS], keypoints[3 * J];
    double *vertices = lt_alloc(3 * V * sizeof(double));

    if (!vertices)
        return lt_error(LT_ENOMEM, "mean pose: no memory");
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        lt_rot_nearest(s->rotation + 9 * j, R + 9 * j);         /* of the sum: as of the mean */
    for (int k = 0; k < BETA; k++)
        beta[k] = s->beta[k] / (double)n;
    lt_hand_pose(model, R, beta, NULL, vertices, joints);
    for (int k = 0; k < 3 * V; k++)
        out->vertices[k / 3][k % 3] = (float)(vertices[k] - joints[k % 3]);
    lt_hand_keypoints(vertices, joints, tips, LT_HAND_SIMPLE_ORDER, keypoints);
    for (int k = 0; k < 3 * J; k++)
        out->joints[k / 3][k % 3] = (float)(keypoints[k] - joints[k % 3]);
    lt_release(vertices);
    return LT_OK;
}

static void mean_objects(const sums *s, mean_predictor *out)
{
    for (int o = 0; o < PREDICTOR_OBJECTS; o++) {
        out->object[o].n = s->n_object[o];
        if (s->n_object[o] == 0)
            continue;
        lt_rot_nearest(s->R[o], out->object[o].pose.R);
        for (int k = 0; k < 3; k++)
            out->object[o].pose.t[k] = s->t[o][k] / (double)s->n_object[o];
    }
}

lt_status mean_predictor_fit(const predictor_labels *labels, const lt_hand_model *model, const int tips[5],
                             mean_predictor *out)
{
    sums s = { 0 };
    lt_status st;

    memset(out, 0, sizeof(*out));
    if (labels->n <= 0)
        return lt_error(LT_EINVAL, "mean pose: no training samples");
    st = add_all(labels, &s);
    if (st)
        return st;
    mean_objects(&s, out);
    return mean_mesh(&s, labels->n, model, tips, out);
}

void mean_predictor_hand(const mean_predictor *m, const float wrist[3], float *joints,
                         float *vertices)
{
    for (int k = 0; k < 3 * J; k++)
        joints[k] = m->joints[k / 3][k % 3] + wrist[k % 3];
    for (int k = 0; k < 3 * V; k++)
        vertices[k] = m->vertices[k / 3][k % 3] + wrist[k % 3];
}

lt_pose mean_predictor_object(const mean_predictor *m, int object, const float wrist[3])
{
    lt_pose pose;

    if (object < 0 || object >= PREDICTOR_OBJECTS || m->object[object].n == 0)
        return zero_predictor_object();
    pose = m->object[object].pose;
    for (int k = 0; k < 3; k++)
        pose.t[k] += wrist[k];
    return pose;
}

void zero_predictor_hand(float *joints, float *vertices)
{
    memset(joints, 0, 3 * J * sizeof(*joints));
    memset(vertices, 0, 3 * V * sizeof(*vertices));
}

lt_pose zero_predictor_object(void)
{
    return (lt_pose){ .R = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, .t = { 0, 0, 1 } };
}
