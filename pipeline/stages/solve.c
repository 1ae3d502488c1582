/* SPDX-License-Identifier: Apache-2.0 */
/* solve: hand and object where the camera saw them, upright and out of the mirror. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

#include "data/mirror.h"
#include "libtensor/geometry/rotation.h"

static void read_theta(predict_result *r)
{
    for (int j = 0; j < LT_HAND_JOINTS; j++) {
        double R[9];

        for (int k = 0; k < 9; k++)
            R[k] = r->e.rotation[j][k];
        lt_rot_to_axis_angle(R, r->theta + 3 * j);
    }
}

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

static void solve(const predict_frame *f, int i)
{
    predict_result *r = &f->result[i];

    r->object_found = r->e.object_inliers > 0 && lt_pose_finite(&r->e.object) && r->e.object.t[2] > PREDICT_NEAREST &&
                      r->e.object.t[2] < PREDICT_FARTHEST;
    r->object_far = r->e.object_inliers > 0 && !r->object_found;
    predict_place_hand(&f->seen[i], r);
    predict_turn_back(&f->turn[i], r);
    read_theta(r);
    if (f->view[i].left)
        unmirror(f->view[i].width, r);
    predict_reproject(&f->view[i], r);
}

static lt_status run(void *state, predict_frame *f)
{
    (void)state;
    for (int i = 0; i < f->n; i++)
        solve(f, i);
    return LT_OK;
}

const stage solve_stage = {
    .name = "solve", .needs = FRAME_VIEWS | FRAME_ESTIMATES, .gives = FRAME_POSES, .run = run,
};
