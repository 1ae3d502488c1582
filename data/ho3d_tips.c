/* SPDX-License-Identifier: Apache-2.0 */
/* Finds out which vertices a copy of HO3D calls finger tips: four conventions have been in use. */
#include "data/ho3d_internal.h"

#include "libtensor/geometry/hand_layer.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

enum { FRAMES = 50, CONVENTIONS = 4 };
static const double LIMIT_MM = 3;

/* thumb, index, middle, ring, little */
static const int convention[CONVENTIONS][5] = {
    { 728, 353, 442, 576, 694 },        /* July 2020 to March 2022: v2 as it is now, v3 */
    { 745, 320, 444, 555, 657 },        /* January to July 2020 */
    { 744, 333, 444, 555, 672 },        /* since March 2022 */
    { 745, 317, 444, 556, 673 },        /* manopth, whose users re-export the labels */
};

static const int simple_tip[5] = { 4, 8, 12, 16, 20 };

typedef struct {
    double vertices[LT_HAND_VERTICES][3], joints[LT_HAND_JOINTS][3];
} posed;

/* Adds up, for each convention, the squared distances of the tips from the annotated ones. */
static void add_errors(const lt_hand_model *hand, const dataset_sample *s, posed *p, double sum[CONVENTIONS])
{
    double R[LT_HAND_JOINTS * 9], beta[LT_HAND_BETAS];

    for (int i = 0; i < LT_HAND_JOINTS * 9; i++)
        R[i] = s->rotation[i / 9][i % 9];
    for (int i = 0; i < LT_HAND_BETAS; i++)
        beta[i] = s->beta[i];
    lt_hand_pose(hand, R, beta, NULL, &p->vertices[0][0], &p->joints[0][0]);
    for (int c = 0; c < CONVENTIONS; c++)
        for (int f = 0; f < 5; f++)
            for (int k = 0; k < 3; k++) {
                const double ours = p->vertices[convention[c][f]][k] - p->joints[0][k];
                const double theirs = (double)s->joints[simple_tip[f]][k] - s->root[k];
                sum[c] += (ours - theirs) * (ours - theirs);
            }
}

static lt_status add_frames(const ho3d *h, const lt_hand_model *hand, int64_t n, posed *p,
                            double sum[CONVENTIONS])
{
    for (int64_t i = 0; i < n; i++) {
        lt_arena *arena = lt_arena_new();
        dataset_sample s;
        lt_status st = arena ? ho3d_read_annotation(h, i * h->base.count / n, arena, &s)
                             : lt_error(LT_ENOMEM, "%s: no memory", h->base.root);
        if (!st)
            add_errors(hand, &s, p, sum);
        lt_arena_free(arena);
        if (st)
            return st;
    }
    return LT_OK;
}

lt_status ho3d_check_tips(dataset *d, const lt_hand_model *hand, double *rms_mm)
{
    const int64_t n = lt_min_i64(FRAMES, d->count);
    double sum[CONVENTIONS] = { 0 }, mm;
    posed *p = malloc(sizeof(*p));
    int best = 0;
    lt_status st;

    assert(!((const ho3d *)d)->evaluation);     /* whose annotation has no pose */
    if (!p)
        return lt_error(LT_ENOMEM, "%s: no memory", d->root);
    st = add_frames((const ho3d *)d, hand, n, p, sum);
    free(p);
    if (st)
        return st;
    for (int c = 1; c < CONVENTIONS; c++)
        if (sum[c] < sum[best])
            best = c;
    mm = 1000 * sqrt(sum[best] / (double)(5 * n));
    if (rms_mm)
        *rms_mm = mm;
    if (!(mm <= LIMIT_MM))
        return lt_error(LT_EFORMAT, "%s: the finger tips of the hand model are %.1f mm from the annotated "
                        "ones, expected at most %.0f: these data were made with another hand", d->root, mm,
                        LIMIT_MM);
    d->tips = convention[best];
    return LT_OK;
}
