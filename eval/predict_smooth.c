/* SPDX-License-Identifier: Apache-2.0 */
/* The frames of a film: joints and object pose through Kalman filters, which also bridge frames without. */
#include "eval/predict_internal.h"

#include "libtensor/geometry/rotation.h"

#include <string.h>

enum { COAST = 15 };                    /* frames that a hand is predicted without being seen */

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

static void smooth_hand(predict_smoother *s, const predict_view *v, predict_result *r)
{
    const bool seen = predict_trusted(v, r);

    s->missed = seen ? 0 : s->missed + 1;
    if (s->missed > COAST)
        memset(s->joint, 0, sizeof(s->joint));
    for (int j = 0; j < LT_HAND_KEYPOINTS; j++) {
        const double at[3] = { r->e.joints[j][0], r->e.joints[j][1], r->e.joints[j][2] };

        lt_point_filter_step(&s->joint[j], s->dt, seen ? at : NULL);
    }
    if (s->joint[0].started)
        move_hand(s, r);
}

static void smooth_object(predict_smoother *s, predict_result *r)
{
    lt_pose_measurement m = { .R_world_cam = { 1, 0, 0, 0, 1, 0, 0, 0, 1 } };

    memcpy(m.p, r->e.object.t, sizeof(m.p));
    lt_rot_to_quat(r->e.object.R, m.q);
    r->object_found = lt_pose_filter_step(&s->object, s->dt, r->object_found ? &m : NULL) != LT_FILTER_OFF;
    if (!r->object_found)
        return;
    memcpy(r->e.object.t, s->object.p, sizeof(m.p));
    lt_rot_from_quat(s->object.q, r->e.object.R);
}

void predict_smooth(predict_smoother *s, const predict_view *v, predict_result *r)
{
    smooth_hand(s, v, r);
    smooth_object(s, r);
    predict_reproject(v, r);
}
