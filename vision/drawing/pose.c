/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/drawing/pose.h"

#include "libtensor/geometry/box21.h"
#include "vision/silhouette.h"

#include <math.h>
#include <string.h>

static const draw_color HAND = { 90, 200, 250 }, OBJECT = { 255, 150, 40 };

void pose_project(const lt_camera *cam, const float (*point)[3], int n, float (*uv)[2])
{
    for (int i = 0; i < n; i++) {
        const double p[3] = { point[i][0], point[i][1], point[i][2] };
        double q[2];
        const bool seen = lt_camera_project(cam, p, q);

        uv[i][0] = seen ? (float)q[0] : NAN;
        uv[i][1] = seen ? (float)q[1] : NAN;
    }
}

/* The mesh's silhouette: a line around it, and inside a tint of this opacity. */
static lt_status draw_shape(lt_arena *scratch, draw_canvas *c, const lt_camera *cam, const lt_mesh *mesh,
                            const lt_pose *pose, draw_color color, float opacity, float width)
{
    float R[9], t[3];
    uint8_t *mask;
    lt_status st = lt_arena_try(scratch, (size_t)c->width * (size_t)c->height, (void **)&mask);

    for (int k = 0; k < 9; k++)
        R[k] = (float)pose->R[k];
    for (int k = 0; k < 3; k++)
        t[k] = (float)pose->t[k];
    st = st ? st : silhouette_draw(mesh, R, t, cam, mask, c->width, c->height, scratch);
    if (st)
        return st;
    draw_mask(c, mask, color, opacity);
    draw_outline(c, mask, (int)ceilf(width), color);
    return LT_OK;
}

/* Whether the outer side is seen: its normal points back along z. */
static bool faces_camera(const float a[2], const float b[2], const float c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < 0;
}

static void draw_front(draw_canvas *c, const float (*uv)[2], const int32_t (*face)[3])
{
    for (int f = 0; f < LT_HAND_FACES; f++)
        if (faces_camera(uv[face[f][0]], uv[face[f][1]], uv[face[f][2]]))
            draw_wire(c, uv, LT_HAND_VERTICES, face + f, 1, HAND, 0.18f);
}

static lt_status draw_hand_mesh(lt_arena *scratch, draw_canvas *c, const lt_camera *cam,
                                const pose_drawing *p, float width)
{
    static const lt_pose here = { { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { 0, 0, 0 } };
    lt_mesh mesh = { .n_vertices = LT_HAND_VERTICES, .n_faces = LT_HAND_FACES };
    float uv[LT_HAND_VERTICES][2];

    mesh.vertex = lt_arena_array(scratch, LT_HAND_VERTICES, sizeof(*mesh.vertex));
    mesh.face = lt_arena_array(scratch, LT_HAND_FACES, sizeof(*mesh.face));
    if (!mesh.vertex || !mesh.face)
        return lt_error(LT_ENOMEM, "no memory to draw a hand");
    memcpy(mesh.vertex, p->vertices, LT_HAND_VERTICES * sizeof(*mesh.vertex));
    memcpy(mesh.face, p->faces, LT_HAND_FACES * sizeof(*mesh.face));
    pose_project(cam, p->vertices, LT_HAND_VERTICES, uv);
    draw_front(c, uv, p->faces);
    return draw_shape(scratch, c, cam, &mesh, &here, HAND, 0.12f, width);
}

static lt_status draw_object(lt_arena *scratch, draw_canvas *c, const lt_camera *cam, const pose_drawing *p,
                             float width)
{
    float corner[LT_BOX_CORNERS][3], uv[LT_BOX_CORNERS][2];
    lt_status st = LT_OK;

    for (int i = 0; i < LT_BOX_CORNERS; i++)
        for (int d = 0; d < 3; d++)
            corner[i][d] = (float)(p->object->R[3 * d] * p->control[i][0] + p->object->R[3 * d + 1] *
                                   p->control[i][1] + p->object->R[3 * d + 2] * p->control[i][2] +
                                   p->object->t[d]);
    if (p->mesh)
        st = draw_shape(scratch, c, cam, p->mesh, p->object, OBJECT, 0.12f, width);
    pose_project(cam, corner, LT_BOX_CORNERS, uv);
    draw_box(c, uv, 1.5f * width, OBJECT);
    return st;
}

/* The edges between the corners that are there, and every point. */
static void draw_control(draw_canvas *c, const float (*uv)[2], float width)
{
    draw_box(c, uv, width, OBJECT);
    for (int i = 0; i < LT_BOX_POINTS; i++)
        draw_disc(c, uv[i], 2 * width, OBJECT, 1);
}

lt_status pose_draw(lt_arena *scratch, draw_canvas *c, const lt_camera *cam, const pose_drawing *p,
                    float width)
{
    float uv[LT_HAND_KEYPOINTS][2];
    lt_status st = LT_OK;

    if (p->object)
        st = draw_object(scratch, c, cam, p, width);
    else if (p->control2d)
        draw_control(c, p->control2d, width);
    if (!st && p->vertices)
        st = draw_hand_mesh(scratch, c, cam, p, width);
    if (!st && p->joints) {
        pose_project(cam, p->joints, LT_HAND_KEYPOINTS, uv);
        draw_skeleton(c, uv, 4 * width);
    }
    return st;
}
