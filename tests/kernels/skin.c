/* SPDX-License-Identifier: Apache-2.0 */
/* Skinning against the generic entry, bit by bit, and against plain sums: groups that no joint moves, one, all. */
#include "tests/kernels/checkasm.h"

enum { GROUPS = 4, JOINTS = 16, VERTICES = GROUPS * LT_SKIN_GROUP, LD = VERTICES + 3, ROWS = LT_SKIN_FRAME };

typedef const float (*frames)[LT_SKIN_FRAME];

static int joint[JOINTS];

/* The last n joints move a group. */
static void make_groups(lt_skin_group *g, const float (*weight)[LT_SKIN_GROUP])
{
    static const int n[GROUPS] = { 3, 0, JOINTS, 1 };

    for (int k = 0; k < JOINTS; k++)
        joint[k] = k;
    for (int i = 0; i < GROUPS; i++)
        g[i] = (lt_skin_group){ n[i], joint + JOINTS - n[i], weight + i * JOINTS };
}

static void expect_plainly(const float *y, const float *t, const float *x, const lt_skin_group *groups, frames frame)
{
    for (int i = 0; i < VERTICES; i++) {
        const lt_skin_group *g = &groups[i / LT_SKIN_GROUP];
        double want[ROWS] = { 0 };

        for (int r = 0; r < ROWS; r++)
            for (int k = 0; k < g->n; k++)
                want[r] += (double)g->weight[k][i % LT_SKIN_GROUP] * (double)frame[g->joint[k]][r];
        for (int r = 0; r < 9; r++)
            want[9 + r / 3] += want[r] * (double)x[(i / LT_SKIN_GROUP * 3 + r % 3) * LT_SKIN_GROUP + i % LT_SKIN_GROUP];
        for (int r = 0; r < 9; r++)
            expect_near((double)t[r * LD + i], want[r], 1e-5, "skin", "matrix", (size_t)i);
        for (int a = 0; a < 3; a++)
            expect_near((double)y[3 * i + a], want[9 + a], 1e-5, "skin", "vertex", (size_t)i);
    }
}

/* So many vertices, with matrices or without */
static void check_vertices(const lt_kernels *k, const lt_kernels *generic, int n, bool plainly)
{
    const size_t all = 8 * LD + VERTICES;
    float *x = random_array(3 * VERTICES, 2), *frame = random_array(JOINTS * LT_SKIN_FRAME, 3);
    float *want = zero_array(all), *got = zero_array(all), *want_y = zero_array(3 * (size_t)n);
    float *y = zero_array(3 * (size_t)n), *bare = zero_array(3 * (size_t)n);
    float *weight = random_array(GROUPS * JOINTS * LT_SKIN_GROUP, 1);
    lt_skin_group groups[GROUPS];

    make_groups(groups, (const float (*)[LT_SKIN_GROUP])weight);
    generic->skin(want_y, want, LD, x, groups, n, (frames)frame);
    k->skin(y, got, LD, x, groups, n, (frames)frame);
    k->skin(bare, NULL, LD, x, groups, n, (frames)frame);
    expect_bits(got, want, all, "skin, matrices of %d", n);
    expect_bits(y, want_y, 3 * (size_t)n, "skin, %d vertices", n);
    expect_bits(bare, want_y, 3 * (size_t)n, "skin, %d vertices without matrices", n);
    if (plainly)
        expect_plainly(y, got, x, groups, (frames)frame);
    free_array(x), free_array(frame), free_array(want), free_array(got), free_array(y), free_array(bare);
    free_array(want_y), free_array(weight);
}

void check_skin(const lt_kernels *k, const lt_kernels *generic)
{
    check_vertices(k, generic, VERTICES, true);
    for (int n = VERTICES - LT_SKIN_GROUP; n < VERTICES; n++)
        check_vertices(k, generic, n, false);
}
