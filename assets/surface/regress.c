/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Joints as weighted means of the skin around them.
 *
 * The weights w of a joint are the ones nearest to a smooth bump that are not negative, sum to 1, give
 * the designed joint on the template, and follow the joint along the directions of shape:
 *     minimise |w - bump|^2 + follow * |D w - dj|^2   under   C w = c, w >= 0
 * solved by its Karush-Kuhn-Tucker system; weights that come out negative are dropped and it is solved again.
 */
#include "assets/surface/surface.h"

#include <string.h>

enum { RING = SURFACE_RING, CONSTRAINTS = 4, SYSTEM = RING + CONSTRAINTS };

static double cost_of(const vec3 *vertex, const double *cost, vec3 p, int v)
{
    return cost ? cost[v] : dist(vertex[v], p);
}

/* The RING vertices, in the order of their ids. */
void surface_ring_near(const vec3 *vertex, const double *cost, int n_vertices, vec3 p, surface_ring *r)
{
    double sum = 0, far = 0;

    r->n = 0;
    for (int i = 0; i < RING; i++) {
        int best = -1, at = 0;

        for (int v = 0; v < n_vertices; v++) {
            bool taken = best >= 0 && cost_of(vertex, cost, p, v) >= cost_of(vertex, cost, p, best);

            for (int k = 0; k < r->n && !taken; k++)
                taken = r->id[k] == v;
            best = taken ? best : v;
        }
        far = cost_of(vertex, cost, p, best);
        while (at < r->n && r->id[at] < best)
            at++;
        memmove(r->id + at + 1, r->id + at, (size_t)(r->n++ - at) * sizeof(*r->id));
        r->id[at] = best;
    }
    for (int i = 0; i < RING; i++) {
        const double q = cost_of(vertex, cost, p, r->id[i]) / far;

        sum += r->bump[i] = exp(-2 * q * q);
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
static void solve_ring(const vec3 *vertex, const vec3 *const *motion, vec3 joint, const vec3 *joint_motion,
                       int directions, double follow, surface_ring *r)
{
    double a[SYSTEM][SYSTEM] = { { 0 } }, b[SYSTEM] = { 0 };
    const int n = r->n;

    for (int i = 0; i < n; i++) {
        a[i][i] = 1;
        b[i] = r->bump[i];
    }
    for (int e = 0; e < 3 * directions; e++) {
        const vec3 *m = motion[e / 3];
        const double want = component(joint_motion[e / 3], e % 3);

        for (int i = 0; i < n; i++) {
            const double di = component(m[r->id[i]], e % 3);

            b[i] += follow * di * want;
            for (int k = 0; k < n; k++)
                a[i][k] += follow * di * component(m[r->id[k]], e % 3);
        }
    }
    for (int c = 0; c < CONSTRAINTS; c++) {
        for (int i = 0; i < n; i++)
            a[i][n + c] = a[n + c][i] = c == 3 ? 1 : component(sub(vertex[r->id[i]], joint), c) / 10;
        b[n + c] = c == 3;
    }
    solve(a, b, n + CONSTRAINTS);
    memcpy(r->w, b, (size_t)n * sizeof(double));
}

/* Drop what came out negative; whether anything did. */
static bool drop_negative(surface_ring *r)
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

void surface_regress(const vec3 *vertex, const vec3 *const *motion, vec3 joint, const vec3 *joint_motion,
                     int directions, double follow, surface_ring *r)
{
    do
        solve_ring(vertex, motion, joint, joint_motion, directions, follow, r);
    while (drop_negative(r));
}
