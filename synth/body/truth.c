/* SPDX-License-Identifier: Apache-2.0 */
/* What is written of a picture: pose in the camera's axes, nodes, boxes. */
#include "synth/body/picture.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

/* In the camera's axes: x_cam = R (x_world) + t, of a body that turns about its pelvis. */
static void write_pose(const body_picture *p, body_row *out)
{
    double root[3], moved[3], trans[3], R[9], aa[3];

    lt_rig_root(&p->rig, p->stance.shape, root);
    for (int k = 0; k < 3; k++)
        moved[k] = root[k] + p->stance.trans[k];
    lt_rigid_apply(p->camera.R_cam_world, p->camera.t_cam_world, moved, trans);
    for (int j = 0; j < BODY_JOINTS; j++) {
        memcpy(R, p->stance.R[j], sizeof(R));
        if (j == 0)
            lt_mat3_mul(p->camera.R_cam_world, p->stance.R[0], R);
        lt_rot_to_axis_angle(R, aa);
        for (int k = 0; k < 3; k++)
            out->pose[j][k] = (float)aa[k];
    }
    for (int k = 0; k < 3; k++)
        out->trans[k] = (float)(trans[k] - root[k]);
    for (int k = 0; k < BODY_SHAPES; k++) {
        out->shape[k] = (float)p->stance.shape[k];
        out->expression[k] = (float)p->stance.shape[BODY_SHAPES + k];
    }
}

static void write_nodes(const body_picture *p, const synth_frame *f, body_row *out)
{
    double node[BODY_NODES][3];

    body_nodes(p->vertex[0], p->joint[0], node);
    for (int i = 0; i < BODY_NODES; i++) {
        double x[3], uv[2];
        bool in = picture_project(&p->camera, node[i], uv);
        const int u = (int)lround(fmax(-9, fmin(9999, uv[0]))), v = (int)lround(fmax(-9, fmin(9999, uv[1])));

        lt_rigid_apply(p->camera.R_cam_world, p->camera.t_cam_world, node[i], x);
        in = in && u >= 0 && u < f->width && v >= 0 && v < f->height && !picture_outside(p, uv[0], uv[1]);
        out->seen[i] = (uint8_t)((in ? BODY_IN_PICTURE : 0) |
                                 (in && f->label[v * f->width + u] == 1 ? BODY_UNHIDDEN : 0));
        for (int k = 0; k < 3; k++)
            out->nodes_3d[i][k] = (float)x[k];
        for (int k = 0; k < 2; k++)
            out->nodes_2d[i][k] = (float)uv[k];
    }
}

static void add_to_box(const body_picture *p, int vertex, float box[4])
{
    double uv[2];

    if (!picture_project(&p->camera, p->vertex[vertex], uv))
        return;
    for (int k = 0; k < 2; k++) {
        box[k] = fminf(box[k], (float)uv[k]);
        box[2 + k] = fmaxf(box[2 + k], (float)uv[k]);
    }
}

/* Of hands all; the face is what is before the ears, from the chin to the brows and a little up. */
static void write_boxes(const body_picture *p, body_row *out)
{
    const body_model *m = p->place->body->model;

    for (int i = 0; i < BODY_BOXES; i++) {
        const float none[4] = { INFINITY, INFINITY, -INFINITY, -INFINITY };

        memcpy(out->boxes[i], none, sizeof(none));
    }
    for (int side = 0; side < 2; side++)
        for (int v = 0; v < LT_HAND_VERTICES; v++)
            add_to_box(p, p->place->body->hand[side][v], out->boxes[side]);
    for (int v = 0; v < BODY_VERTICES; v++) {
        const float *at = m->v_template[v];

        if (at[2] > 0.02f && at[1] > 0.52f && at[1] < 0.70f && fabsf(at[0]) < 0.1f)
            add_to_box(p, v, out->boxes[2]);
    }
    for (int i = 0; i < BODY_BOXES; i++)
        if (out->boxes[i][0] > out->boxes[i][2])        /* all of it is behind the camera */
            memset(out->boxes[i], 0, sizeof(out->boxes[i]));
}

void picture_truth(const body_picture *p, const synth_frame *f, body_row *out)
{
    const synth_camera *c = &p->camera;
    const float K[3][3] = { { (float)c->fx, 0, (float)c->cx }, { 0, (float)c->fy, (float)c->cy }, { 0, 0, 1 } };

    *out = (body_row){ .subject = (int32_t)(p->place->number * SYNTH_BODY_PEOPLE + p->who), .cut = p->cut,
                               .sits = p->stance.sits };
    memcpy(out->K, K, sizeof(K));
    for (int side = 0; side < 2; side++)
        out->holds[side] = p->stance.grip[side] && p->stance.grip[side]->prop
                               ? (uint8_t)p->stance.grip[side]->prop->id : 0;
    write_pose(p, out);
    write_nodes(p, f, out);
    write_boxes(p, out);
}
