/* SPDX-License-Identifier: Apache-2.0 */
/* Finds out which vertices a dataset calls finger tips: five conventions have been in use. */
#include "data/dataset.h"

#include "data/hand_pose.h"

#include <math.h>
#include <stdlib.h>

enum { FRAMES = 50, CONVENTIONS = 5 };
static const double LIMIT_MM = 3;

/* thumb, index, middle, ring, little */
static const int convention[CONVENTIONS][5] = {
    { 728, 353, 442, 576, 694 },        /* HO3D July 2020 to March 2022: v2 as it is now, v3 */
    { 745, 320, 444, 555, 657 },        /* HO3D January to July 2020 */
    { 744, 333, 444, 555, 672 },        /* HO3D since March 2022 */
    { 745, 317, 444, 556, 673 },        /* manopth: DexYCB, and users who re-export labels */
    { 744, 320, 443, 554, 671 },        /* smplx, manotorch */
};

static const int simple_tip[5] = { 4, 8, 12, 16, 20 };

typedef struct {
    double vertices[LT_HAND_VERTICES][3], joints[LT_HAND_JOINTS][3];
} posed;

/* Adds up, for each convention, the squared distances of the tips from the annotated ones. */
static void add_errors(const lt_hand_model *hand, const dataset_sample *s, posed *p, double sum[CONVENTIONS])
{
    hand_pose_label(hand, s->rotation[0], s->beta, p->vertices, p->joints);
    for (int c = 0; c < CONVENTIONS; c++)
        for (int f = 0; f < 5; f++)
            for (int k = 0; k < 3; k++) {
                const double ours = p->vertices[convention[c][f]][k] - p->joints[0][k];
                const double theirs = (double)s->joints[simple_tip[f]][k] - s->root[k];
                sum[c] += (ours - theirs) * (ours - theirs);
            }
}

typedef struct {
    double sum[CONVENTIONS];
    int used, left;
    lt_status unreadable;           /* the last that could not be read; the loader will name each */
} tally;

static void add_frame(const dataset *d, int64_t index, const lt_hand_model *hand, posed *p, tally *t)
{
    lt_arena *arena = lt_arena_new();
    dataset_sample s;
    const lt_status st = arena ? dataset_annotation(d, index, arena, &s)
                               : lt_error(LT_ENOMEM, "%s: no memory", d->root);

    if (st) {
        t->unreadable = st;
    } else if (s.flags & SAMPLE_MIRRORED) {
        t->left++;
    } else if ((s.flags & SAMPLE_HAND_POSE) && (s.flags & SAMPLE_JOINTS)) {
        add_errors(hand, &s, p, t->sum);
        t->used++;
    }
    lt_arena_free(arena);
}

lt_status dataset_check_tips(dataset *d, const lt_hand_model *hand, double *rms_mm)
{
    const int64_t n = lt_min_i64(FRAMES, d->count);
    posed *p = malloc(sizeof(*p));
    tally t = { .used = 0 };
    double mm;
    int best = 0;

    if (!p)
        return lt_error(LT_ENOMEM, "%s: no memory", d->root);
    for (int64_t i = 0; i < n; i++)
        add_frame(d, i * d->count / n, hand, p, &t);
    free(p);
    if (!t.used && t.unreadable)
        return t.unreadable;
    if (!t.used && !t.left)
        return lt_error(LT_EINVAL, "%s: split %s has no hand poses to compare with", d->root, d->split);
    for (int c = 1; c < CONVENTIONS; c++)
        if (t.sum[c] < t.sum[best])
            best = c;
    mm = t.used ? 1000 * sqrt(t.sum[best] / (5 * t.used)) : 0;
    if (rms_mm)
        *rms_mm = mm;
    if (!(mm <= LIMIT_MM))
        return lt_error(LT_EFORMAT, "%s: the finger tips of the hand model are %.1f mm from the annotated "
                        "ones, expected at most %.0f: these data were made with another hand", d->root, mm,
                        LIMIT_MM);
    if (t.used)
        d->tips = convention[best];
    return LT_OK;
}
