/* SPDX-License-Identifier: Apache-2.0 */
/* What the avatar reads of a frame: how the hand is bent, and which frame it is. */
#include "tasks/hogs/feed.h"

#include "libtensor/geometry/mat3.h"

#include <math.h>

static const double ENTRY_NOISE = 0.1;          /* on a rotation's entries, in half of the steps */

/* Joints of the hand at rest, about its vertices' mean, where its smallest and largest coordinate, a twentieth of
 * their distance further out, are -1 and 1                                                         [3DGS-Avatar] */
static void rest_joints(const hogs_rig *r, double out[LT_HAND_JOINTS][3])
{
    const lt_mesh *mesh = &r->mesh;
    double mean[3] = { 0 }, lo = INFINITY, hi = -INFINITY;

    for (int i = 0; i < 3 * mesh->n_vertices; i++)
        mean[i % 3] += (double)mesh->vertex[i / 3][i % 3] / mesh->n_vertices;
    for (int i = 0; i < 3 * mesh->n_vertices; i++) {
        lo = fmin(lo, (double)mesh->vertex[i / 3][i % 3] - mean[i % 3]);
        hi = fmax(hi, (double)mesh->vertex[i / 3][i % 3] - mean[i % 3]);
    }
    for (int i = 0; i < 3 * LT_HAND_JOINTS; i++) {
        const double at = r->joint[i / 3][i % 3] - mean[i % 3];

        out[i / 3][i % 3] = 2 * ((at - lo + 0.05 * (hi - lo)) / (1.1 * (hi - lo)) - 0.5);
    }
}

/* Of each joint its rotation, the wrist's being none, its place at rest, and how far its parent is */
static void feed_articulation(feed_job *j)
{
    const bool shaken = j->by->stage != HOGS_RENDER && lt_rng_uniform(&j->rng) < 0.5;
    lt_real *x = feed_whole(j, "articulation");
    double at[LT_HAND_JOINTS][3], step[3];

    if (!x)
        return;
    rest_joints(j->placer.rig, at);
    for (int i = 0; i < LT_HAND_JOINTS; i++, x += AVATAR_JOINT) {
        const int parent = lt_hand_parent[i];

        for (int k = 0; k < 9; k++) {
            const double own = parent < 0 ? k % 4 == 0 : (double)j->f->initial.rotation[i][k];

            x[k] = (lt_real)(own + (shaken ? ENTRY_NOISE * lt_rng_normal(&j->rng) : 0));
        }
        for (int k = 0; k < 3; k++)
            x[9 + k] = (lt_real)at[i][k];
        lt_vec3_sub(at[i], at[parent < 0 ? i : parent], step);
        x[12] = (lt_real)lt_vec3_norm(step);
    }
}

void feed_avatar(feed_job *j)
{
    lt_real *started = feed_whole(j, "started");

    feed_articulation(j);
    feed_integer(j, "frame_code", j->f->number);
    if (started)
        *started = j->run->iteration < 0 || j->run->iteration >= j->run->schedule.bend_start;
}

