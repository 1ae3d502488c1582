/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/body/target.h"

#include "libtensor/geometry/rotation.h"
#include "models/body/osx_losses.h"
#include "models/body/osx_parts.h"

#include <math.h>
#include <string.h>

enum { LEFT_WRIST = 12 };                       /* among the nodes */

static const double CELL = OSX_WIDTH / (double)OSX_COLUMNS;
static const double NEAREST = 0.1;              /* metres: what is nearer, or behind the camera, has no place; ... */
static const double FARTHEST = 2 * OSX_HEIGHT;  /* ... pixels from the middle: nor has what the picture is far from */

static void turn(const body_row *row, body_target *out)
{
    for (int i = 0; i < BODY_ROTATIONS; i++) {
        const float *aa = row->pose[body_graph_joint(i)];
        double R[9];

        lt_rot_from_axis_angle((double[]){ aa[0], aa[1], aa[2] }, R);
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
        double uv[2], ray[3] = { 0, 0, OSX_FOCAL }, bearing[2];

        for (int k = 0; k < 3; k++)
            out->nodes[i][k] = row->nodes_3d[i][k] - row->nodes_3d[0][k];
        for (int k = 0; k < 2; k++)
            uv[k] = w->scale * row->nodes_2d[i][k] + w->shift[k];
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
        double centre[2];

        for (int k = 0; k < 2; k++) {
            centre[k] = w->scale * (b[k] + b[2 + k]) / 2 + w->shift[k];
            out->box_centre[i][k] = (float)(centre[k] / CELL);
            out->box_size[i][k] = (float)(fmin(w->scale * (b[2 + k] - b[k]), OSX_WIDTH) / CELL);
        }
        out->box_known[i] = b[2] > b[0] && within(centre);
    }
}

void body_target_make(const body_row *row, const person_window *w, body_target *out)
{
    turn(row, out);
    place_nodes(row, w, out);
    place_boxes(row, w, out);
}
