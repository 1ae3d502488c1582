/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/body/target.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "models/body/osx_losses.h"
#include "models/body/osx_parts.h"

#include <math.h>
#include <string.h>

enum { LEFT_WRIST = 12 };                       /* among the nodes */

static const double CELL = OSX_WIDTH / (double)OSX_COLUMNS;
static const double NEAREST = 0.1;              /* metres: what is nearer, or behind the camera, has no place; ... */
static const double FARTHEST = 2 * OSX_HEIGHT;  /* ... pixels from the middle: nor has what the picture is far from */

/* About the camera's axis, as the picture is; out may be p */
static void roll(const person_window *w, const double p[3], double out[3])
{
    const double c = cos(w->turn), s = sin(w->turn), x = c * p[0] - s * p[1];

    out[1] = s * p[0] + c * p[1];
    out[0] = x;
    out[2] = p[2];
}

/* The whole body is turned with the pelvis. */
static void turn(const body_row *row, const person_window *w, body_target *out)
{
    const double whole[3] = { 0, 0, w->turn };

    for (int i = 0; i < BODY_ROTATIONS; i++) {
        const float *aa = row->pose[body_graph_joint(i)];
        double R[9];

        lt_rot_from_axis_angle((double[]){ aa[0], aa[1], aa[2] }, R);
        if (i == 0) {
            double turned[9];

            lt_rot_from_axis_angle(whole, turned);
            lt_mat3_mul(turned, R, R);
        }
        for (int k = 0; k < 9; k++)
            out->rotation[i][k] = (float)R[k];
    }
    memcpy(out->shape, row->shape, sizeof(out->shape));
    memcpy(out->expression, row->expression, sizeof(out->expression));
}

static bool within(const double uv[2])
{
    return uv[0] >= 0 && uv[0] <= OSX_WIDTH - 1 && uv[1] >= 0 && uv[1] <= OSX_HEIGHT - 1;
}

/* Places of the body's nodes are from the pelvis, of a hand's from its wrist. */
static void place(const body_row *row, int i, const double uv[2], body_target *out)
{
    const bool hand = i >= BODY_OF_BODY;
    const int from = !hand ? 0 : i < BODY_OF_BODY + OSX_HAND_JOINTS ? LEFT_WRIST : LEFT_WRIST + 1;
    const double depth = row->nodes_3d[i][2] - row->nodes_3d[from][2], half = hand ? OSX_HAND_DEPTH : OSX_BODY_DEPTH;
    float *to = hand ? out->hand_place[i - BODY_OF_BODY] : out->body_place[i];
    float *known = hand ? &out->hand_known[i - BODY_OF_BODY] : &out->body_known[i];

    *known = (row->seen[i] & BODY_IN_PICTURE) && within(uv);
    to[0] = (float)(uv[0] / CELL);
    to[1] = (float)(uv[1] / CELL);
    to[2] = (float)(OSX_DEPTHS / 2 * (1 + depth / half));
}

static void place_nodes(const body_row *row, const person_window *w, body_target *out)
{
    for (int i = 0; i < BODY_NODES; i++) {
        const double pixel[2] = { row->nodes_2d[i][0], row->nodes_2d[i][1] };
        double uv[2], ray[3] = { 0, 0, OSX_FOCAL }, bearing[2], from_pelvis[3];

        for (int k = 0; k < 3; k++)
            from_pelvis[k] = (double)row->nodes_3d[i][k] - (double)row->nodes_3d[0][k];
        roll(w, from_pelvis, from_pelvis);
        for (int k = 0; k < 3; k++)
            out->nodes[i][k] = (float)from_pelvis[k];
        person_window_place(w, pixel, uv);
        ray[0] = uv[0] - OSX_WIDTH / 2.0;
        ray[1] = uv[1] - OSX_HEIGHT / 2.0;
        osx_bearing(ray, bearing);
        out->node_known[i] = row->nodes_3d[i][2] > NEAREST && fabs(ray[0]) < FARTHEST && fabs(ray[1]) < FARTHEST;
        for (int k = 0; k < 2; k++)
            out->bearing[i][k] = (float)bearing[k];
        place(row, i, uv, out);
    }
}

static void place_boxes(const body_row *row, const person_window *w, body_target *out)
{
    for (int i = 0; i < BODY_BOXES; i++) {
        const float *b = row->boxes[i];
        const double middle[2] = { (double)(b[0] + b[2]) / 2, (double)(b[1] + b[3]) / 2 };
        const double c = fabs(cos(w->turn)), s = fabs(sin(w->turn)), wide = (double)(b[2] - b[0]),
            high = (double)(b[3] - b[1]);
        const double side[2] = { c * wide + s * high, s * wide + c * high };        /* of the turned box's own */
        double centre[2];

        person_window_place(w, middle, centre);
        for (int k = 0; k < 2; k++) {
            out->box_centre[i][k] = (float)(centre[k] / CELL);
            out->box_size[i][k] = (float)(fmin(w->scale * side[k], OSX_WIDTH) / CELL);
        }
        out->box_known[i] = b[2] > b[0] && within(centre);
    }
}

void body_target_make(const body_row *row, const person_window *w, body_target *out)
{
    turn(row, w, out);
    place_nodes(row, w, out);
    place_boxes(row, w, out);
}
