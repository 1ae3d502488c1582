/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Joints as weighted means of the skin around them.
 *
 * The weights w of a joint are the ones nearest to a smooth bump that are not negative, sum to 1, give
 * the designed joint on the template, and follow the joint along the ten shape directions:
 *     minimise |w - bump|^2 + follow * |D w - dj|^2   under   C w = c, w >= 0
 * solved by its Karush-Kuhn-Tucker system; weights that come out negative are dropped and it is solved again.
 */
#include "assets/hand/internal.h"

#include <string.h>

enum { RING = 44, CONSTRAINTS = 4, SYSTEM = RING + CONSTRAINTS };

static const double FOLLOW = 1;     /* per square millimetre */

typedef struct {
    int n;
    int32_t id[RING];
    double bump[RING], w[RING];
} ring;

/* The RING vertices nearest to the joint, in the order of their ids. */
static void nearest_ring(const hand_rig *rig, vec3 joint, ring *r)
{
    bool taken[LT_HAND_VERTICES] = { false };
    double sum = 0, far = 0;

    for (int i = 0; i < RING; i++) {
        int best = -1;

        for (int v = 0; v < LT_HAND_VERTICES; v++)
            if (!taken[v]
                && (best < 0 || dist(rig->vertex[v], joint) < dist(rig->vertex[best], joint)))
                best = v;
        taken[best] = true;
        far = dist(rig->vertex[best], joint);
    }
    r->n = 0;
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        if (taken[v]) {
            const double q = dist(rig->vertex[v], joint) / far;

            r->id[r->n] = v;
            sum += r->bump[r->n++] = exp(-2 * q * q);
        }
    for (int i = 0; i < RING; i++)
        r->bump[i] /= sum;
}

/* Solve a x = b in place by elimination with pivoting; a is n x n in rows of SYSTEM. */
static void solve(double a[SYSTEM][SYSTEM], double *b, int n)
{
    for (int k = 0; k < n; k++) {
        int pivot = k;

        for (int i = k + 1; i < n; i++)
            pivot = fabs(a[i][k]) > fabs(a[pivot][k]) ? i : pivot;
        for (int j = 0; j < n; j++) {
            const double t = a[k][j];
            a[k][j] = a[pivot][j];
            a[pivot][j] = t;
        }
        const double t = b[k];
        b[k] = b[pivot];
        b[pivot] = t;
        for (int i = k + 1; i < n; i++) {
            const double f = a[i][k] / a[k][k];

            for (int j = k; j < n; j++)
                a[i][j] -= f * a[k][j];
            b[i] -= f * b[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++)
            b[k] -= a[k][j] * b[j];
        b[k] /= a[k][k];
    }
}

static double component(vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/* One solution without regard to signs, over the vertices still in the ring. */
static void solve_ring(const hand_rig *rig, const hand_motion *motion, int j, vec3 joint, ring *r)
{
    double a[SYSTEM][SYSTEM] = { { 0 } }, b[SYSTEM] = { 0 };
    const int n = r->n;

    for (int i = 0; i < n; i++) {
        a[i][i] = 1;
        b[i] = r->bump[i];
    }
    for (int e = 0; e < 3 * LT_HAND_BETAS; e++) {
        const hand_motion *m = &motion[e / 3];
        const double want = component(m->joint[j], e % 3);

        for (int i = 0; i < n; i++) {
            const double di = component(m->vertex[r->id[i]], e % 3);

            b[i] += FOLLOW * di * want;
            for (int k = 0; k < n; k++)
                a[i][k] += FOLLOW * di * component(m->vertex[r->id[k]], e % 3);
        }
    }
    for (int c = 0; c < CONSTRAINTS; c++) {
        for (int i = 0; i < n; i++)
            a[i][n + c] = a[n + c][i] =
                c == 3 ? 1 : component(sub(rig->vertex[r->id[i]], joint), c) / 10;
        b[n + c] = c == 3;
    }
    solve(a, b, n + CONSTRAINTS);
    memcpy(r->w, b, (size_t)n * sizeof(double));
}

/* Drop what came out negative; whether anything did. */
static bool drop_negative(ring *r)
{
    int n = 0;

    for (int i = 0; i < r->n; i++)
        if (r->w[i] >= 0) {
            r->id[n] = r->id[i];
            r->bump[n] = r->bump[i];
            r->w[n++] = r->w[i];
        }
    const bool any = n < r->n;
    r->n = n;
    return any;
}

void hand_regressor(const hand_skeleton *s, const hand_rig *rig,
                    const hand_motion motion[LT_HAND_BETAS],
                    float out[LT_HAND_JOINTS][LT_HAND_VERTICES])
{
    memset(out, 0, sizeof(float[LT_HAND_JOINTS][LT_HAND_VERTICES]));
    for (int j = 0; j < LT_HAND_JOINTS; j++) {
        const vec3 joint = j ? s->joint[(j - 1) / 3][(j - 1) % 3] : s->wrist;
        ring r;

        nearest_ring(rig, joint, &r);
        do
            solve_ring(rig, motion, j, joint, &r);
        while (drop_negative(&r));
        for (int i = 0; i < r.n; i++)
            out[j][r.id[i]] = (float)r.w[i];
    }
}
