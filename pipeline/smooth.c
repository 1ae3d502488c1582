/* SPDX-License-Identifier: Apache-2.0 */
/* The frames of a film: joints and object pose through Kalman filters, which also bridge frames without. */
#include "pipeline/internal.h"

#include "libtensor/geometry/rotation.h"

#include <string.h>

/* From here on the hand is where its filters say; its mesh goes along. */
static void move_hand(const predict_smoother *s, predict_result *r)
{
    double shift[3] = { 0 };

    for (int j = 0; j < LT_HAND_KEYPOINTS; j++)
        for (int d = 0; d < 3; d++) {
            shift[d] += (s->joint[j].x[d] - r->e.joints[j][d]) / LT_HAND_KEYPOINTS;
            r->e.joints[j][d] = (float)s->joint[j].x[d];
        }
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int d = 0; d < 3; d++)
            r->e.vertices[i][d] += (float)shift[d];
    r->placed = true;
}

/* joints: where the hand is seen; NULL: it is not */
static void step_hand(predict_smoother *s, const float (*joints)[3])
{
    s->missed = joints ? 0 : s->missed + 1;
    if (s->missed > PREDICT_COAST)
        memset(s->joint, 0, sizeof(s->joint));
    for (int j = 0; j < LT_HAND_KEYPOINTS; j++) {
        double at[3];

        for (int d = 0; joints && d < 3; d++)
            at[d] = joints[j][d];
        lt_point_filter_step(&s->joint[j], s->dt, joints ? at : NULL);
    }
}

static void smooth_hand(predict_smoother *s, const predict_view *v, predict_result *r)
{
    if (v->left != s->left) {                   /* another hand, which begins anew */
        memset(s->joint, 0, sizeof(s->joint));
        s->missed = 0;
        s->left = v->left;
    }
    step_hand(s, predict_trusted(v, r) ? r->e.joints : NULL);
    if (s->joint[0].started)
        move_hand(s, r);
}

/* The object's frame moved to the middle of its box and back: turns that leave it as it is are about that. */
static void to_middle(const predict_object *object, double sign, lt_pose *pose)
{
    const float *c = object->control[LT_BOX_POINTS - 1];

    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            pose->t[i] += sign * pose->R[3 * i + k] * (double)c[k];
}

static void smooth_object(predict_smoother *s, const predict_object *object, predict_result *r)
{
    lt_pose_measurement m = {
        .R_world_cam = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, .reprojection_px = (double)r->e.object_error_px,
        .symmetry = (const double (*)[4])object->symmetry, .n_symmetries = object->n_symmetries,
    };

    if (s->held != object) {                    /* another one, which begins anew */
        s->object = (lt_pose_filter){ 0 };
        s->held = object;
    }
    to_middle(object, 1, &r->e.object);
    memcpy(m.p, r->e.object.t, sizeof(m.p));
    lt_rot_to_quat(r->e.object.R, m.q);
    r->object_found = lt_pose_filter_step(&s->object, s->dt, r->object_found ? &m : NULL) != LT_FILTER_OFF;
    if (!r->object_found)
        return;
    memcpy(r->e.object.t, s->object.p, sizeof(m.p));
    lt_rot_from_quat(s->object.q, r->e.object.R);
    to_middle(object, -1, &r->e.object);
}

void predict_smooth(predict_smoother *s, const predict_view *v, const predict_object *object, predict_result *r)
{
    smooth_hand(s, v, r);
    if (object)
        smooth_object(s, object, r);
    predict_reproject(v, r);
}

void predict_smooth_missed(predict_smoother *s)
{
    step_hand(s, NULL);
    lt_pose_filter_step(&s->object, s->dt, NULL);
}
