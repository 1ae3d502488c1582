/* SPDX-License-Identifier: Apache-2.0 */
/* Skinning against the generic entry, bit by bit, and against plain sums: groups that no joint moves, one, all. */
#include "tests/kernels/checkasm.h"

enum { GROUPS = 4, VERTICES = GROUPS * LT_SKIN_GROUP, LD = VERTICES + 3, ROWS = LT_SKIN_FRAME };

typedef const float (*frames)[LT_SKIN_FRAME];

static void make_groups(lt_skin *g)
{
    static const int n[GROUPS] = { 3, 0, LT_SKIN_JOINTS, 1 };
    float *weight = random_array(GROUPS * LT_SKIN_JOINTS * LT_SKIN_GROUP, 1);

    for (int i = 0; i < GROUPS; i++) {
        g[i].n = n[i];
        for (int k = 0; k < n[i]; k++) {
            g[i].joint[k] = LT_SKIN_JOINTS - n[i] + k;
            for (int v = 0; v < LT_SKIN_GROUP; v++)
                g[i].weight[k][v] = weight[(i * LT_SKIN_JOINTS + k) * LT_SKIN_GROUP + v];
        }
    }
    free_array(weight);
}

static void expect_plainly(const float *t, const float *x, const lt_skin *groups, frames frame)
{
    for (int i = 0; i < VERTICES; i++) {
        const lt_skin *g = &groups[i / LT_SKIN_GROUP];
        double want[ROWS] = { 0 };

        for (int r = 0; r < ROWS; r++)
            for (int k = 0; k < g->n; k++)
                want[r] += (double)g->weight[k][i % LT_SKIN_GROUP] * (double)frame[g->joint[k]][r];
        for (int r = 0; r < 9; r++)
            want[9 + r / 3] += want[r] * (double)x[r % 3 * LD + i];
        for (int r = 0; r < ROWS; r++)
            expect_near((double)t[r * LD + i], want[r], 1e-5, "skin", "vertex", (size_t)i);
    }
}

void check_skin(const lt_kernels *k, const lt_kernels *generic)
{
    const size_t all = (ROWS - 1) * LD + VERTICES;
    float *x = random_array(2 * LD + VERTICES, 2), *frame = random_array(LT_SKIN_JOINTS * LT_SKIN_FRAME, 3);
    float *want = zero_array(all), *got = zero_array(all);
    lt_skin groups[GROUPS];

    make_groups(groups);
    generic->skin(want, x, LD, groups, GROUPS, (frames)frame);
    k->skin(got, x, LD, groups, GROUPS, (frames)frame);
    expect_bits(got, want, all, "skin");
    expect_plainly(got, x, groups, (frames)frame);
    free_array(x), free_array(frame), free_array(want), free_array(got);
}
