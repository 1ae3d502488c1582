/* SPDX-License-Identifier: Apache-2.0 */
/* The DexYCB hand score: samples in parallel, sums in the order of the list. */
#include "eval/scorers/dexycb_score.h"

#include "eval/metrics/curve.h"
#include "eval/metrics/metrics.h"
#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/hand/model.h"

#include <stdlib.h>
#include <string.h>

enum { J = LT_HAND_KEYPOINTS, KINDS = DEXYCB_SCORES / 2, BLOCK = 256 };

const char *dexycb_score_name(dexycb_score score)
{
    static const char *const name[DEXYCB_SCORES] = {
        "mpjpe_mm", "auc", "relative_mpjpe_mm", "relative_auc", "pa_mpjpe_mm", "pa_auc",
        "pa_rigid_mpjpe_mm", "pa_rigid_auc",
    };

    return name[score];
}

typedef struct { double kind[KINDS][J]; } distances;

struct dexycb_scorer {
    eval_pck *pck[KINDS];
    distances *block;               /* (BLOCK) */
};

dexycb_scorer *dexycb_scorer_new(void)
{
    dexycb_scorer *s = calloc(1, sizeof(*s));
    bool whole;

    if (!s)
        return NULL;
    s->block = lt_alloc(BLOCK * sizeof(*s->block));
    whole = s->block;
    for (int k = 0; k < KINDS; k++) {
        s->pck[k] = eval_pck_new(J, 0, .05, 100);
        whole = whole && s->pck[k];
    }
    if (whole)
        return s;
    dexycb_scorer_free(s);
    return NULL;
}

void dexycb_scorer_free(dexycb_scorer *s)
{
    if (!s)
        return;
    for (int k = 0; k < KINDS; k++)
        eval_pck_free(s->pck[k]);
    lt_release(s->block);
    free(s);
}

typedef struct {
    const float *p, *g;
    distances *out;
} job;

static void measure(void *ctx, int64_t i)
{
    const job *j = ctx;
    distances *d = &j->out[i];
    double p[3 * J], g[3 * J], aligned[3 * J];

    eval_widen(3 * J, j->p + i * 3 * J, p);
    eval_widen(3 * J, j->g + i * 3 * J, g);
    eval_distances(J, p, g, d->kind[0]);
    eval_align_root(J, p, g, 0, aligned);
    eval_distances(J, aligned, g, d->kind[1]);
    eval_align_procrustes(EVAL_REFLECT, J, p, g, aligned);
    eval_distances(J, aligned, g, d->kind[2]);
    eval_align_procrustes(EVAL_RIGID, J, p, g, aligned);
    eval_distances(J, aligned, g, d->kind[3]);
}

static dexycb_sample_errors summarise(const distances *d)
{
    return (dexycb_sample_errors){
        .absolute = eval_mean(J, d->kind[0]), .relative = eval_mean(J, d->kind[1]),
        .pa = eval_mean(J, d->kind[2]), .rigid = eval_mean(J, d->kind[3]),
    };
}

void dexycb_scorer_add(dexycb_scorer *s, int64_t n, const float *p, const float *g,
                       dexycb_sample_errors *each)
{
    for (int64_t at = 0; at < n; at += BLOCK) {
        const int64_t m = lt_min_i64(BLOCK, n - at);
        job j = { p + at * 3 * J, g + at * 3 * J, s->block };

        lt_parallel_for(m, measure, &j);
        for (int64_t i = 0; i < m; i++) {
            for (int k = 0; k < KINDS; k++)
                eval_pck_add(s->pck[k], s->block[i].kind[k]);
            if (each)
                each[at + i] = summarise(&s->block[i]);
        }
    }
}

void dexycb_scorer_scores(const dexycb_scorer *s, double scores[DEXYCB_SCORES])
{
    for (int k = 0; k < KINDS; k++) {
        scores[2 * k] = 1000 * eval_pck_mean(s->pck[k]);
        scores[2 * k + 1] = eval_pck_auc(s->pck[k]);
    }
}

void dexycb_hpe_line(FILE *f, int64_t index, const float *joints)
{
    fprintf(f, "%lld", (long long)index);
    for (int k = 0; k < 3 * J; k++) {
        char number[32], *comma;

        snprintf(number, sizeof(number), ",%.7g", 1000 * (double)joints[k]);
        comma = strchr(number + 1, ',');            /* in some locales */
        if (comma)
            *comma = '.';
        fputs(number, f);
    }
    fputc('\n', f);
}
