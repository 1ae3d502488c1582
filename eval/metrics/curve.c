/* SPDX-License-Identifier: Apache-2.0 */
/* Means, shares, PCK curves and areas over the samples of a dataset. */
#include "eval/metrics/curve.h"

#include "eval/metrics/metrics.h"
#include "libtensor/base/arena.h"
#include "libtensor/base/order.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

void eval_mean_add(eval_mean_of *m, double error)
{
    m->n++;
    if (isfinite(error))
        m->sum += error;
    else
        m->failed++;
}

double eval_mean_value(const eval_mean_of *m)
{
    return m->n > 0 && m->failed == 0 ? m->sum / (double)m->n : NAN;
}

double eval_share_value(const eval_share *s)
{
    return s->n > 0 ? (double)s->hits / (double)s->n : NAN;
}

double eval_class_mean(int n_classes, const double *value)
{
    double sum = 0;
    int n = 0;

    for (int i = 0; i < n_classes; i++) {
        if (!isnan(value[i])) {
            sum += value[i];
            n++;
        }
    }
    return n > 0 ? sum / n : NAN;
}

/* ---- PCK --------------------------------------------------------------------------------- */

struct eval_pck {
    int n_points, n_thresholds;
    int64_t n_samples, failed;
    double *threshold;              /* (n_thresholds) */
    double *sum;                    /* (n_points) distances */
    int64_t *first;                 /* (n_points, n_thresholds) samples whose first hit is there */
    lt_arena *arena;
};

eval_pck *eval_pck_new(int n_points, double lo, double hi, int n_thresholds)
{
    lt_arena *arena = lt_arena_new();
    eval_pck *pck = arena ? lt_arena_alloc(arena, sizeof(*pck)) : NULL;

    assert(n_points > 0 && n_thresholds >= 2 && lo < hi);
    if (!pck)
        goto fail;
    *pck = (eval_pck){ .n_points = n_points, .n_thresholds = n_thresholds, .arena = arena };
    pck->threshold = lt_arena_array(arena, (size_t)n_thresholds, sizeof(double));
    pck->sum = lt_arena_array(arena, (size_t)n_points, sizeof(double));
    pck->first = lt_arena_array(arena, (size_t)n_points * (size_t)n_thresholds, sizeof(int64_t));
    if (!pck->threshold || !pck->sum || !pck->first)
        goto fail;
    for (int i = 0; i < n_thresholds; i++)                      /* as numpy.linspace rounds */
        pck->threshold[i] = i * ((hi - lo) / (n_thresholds - 1)) + lo;
    pck->threshold[n_thresholds - 1] = hi;
    return pck;
fail:
    lt_arena_free(arena);
    return NULL;
}

void eval_pck_free(eval_pck *pck)
{
    if (pck)
        lt_arena_free(pck->arena);
}

/* The index of the smallest threshold >= d; n_thresholds when d is beyond all, or NaN. */
static int first_hit(const eval_pck *pck, double d)
{
    int lo = 0, hi = pck->n_thresholds;

    while (lo < hi) {
        const int mid = (lo + hi) / 2;

        if (d <= pck->threshold[mid])
            hi = mid;
        else
            lo = mid + 1;
    }
    return lo;
}

void eval_pck_add(eval_pck *pck, const double *distance)
{
    bool failed = false;

    for (int k = 0; k < pck->n_points; k++) {
        const int hit = first_hit(pck, distance[k]);

        if (hit < pck->n_thresholds)
            pck->first[(int64_t)k * pck->n_thresholds + hit]++;
        pck->sum[k] += distance[k];
        failed |= !isfinite(distance[k]);
    }
    pck->failed += failed;
    pck->n_samples++;
}

double eval_pck_mean(const eval_pck *pck)
{
    double sum = 0;

    if (pck->n_samples == 0 || pck->failed > 0)
        return NAN;
    for (int k = 0; k < pck->n_points; k++)
        sum += pck->sum[k] / (double)pck->n_samples;
    return sum / pck->n_points;
}

static double point_auc(const eval_pck *pck, int k)
{
    const int64_t *first = pck->first + (int64_t)k * pck->n_thresholds;
    const double *t = pck->threshold;
    int64_t hits = first[0];
    double area = 0;

    for (int i = 1; i < pck->n_thresholds; i++) {
        const int64_t before = hits;

        hits += first[i];
        area += (t[i] - t[i - 1]) * (double)(before + hits) / 2;
    }
    return area / (t[pck->n_thresholds - 1] - t[0]) / (double)pck->n_samples;
}

double eval_pck_auc(const eval_pck *pck)
{
    double sum = 0;

    if (pck->n_samples == 0)
        return NAN;
    for (int k = 0; k < pck->n_points; k++)
        sum += point_auc(pck, k);
    return sum / pck->n_points;
}

double eval_pck_threshold(const eval_pck *pck, int i)
{
    return pck->threshold[i];
}

double eval_pck_at(const eval_pck *pck, int i)
{
    int64_t hits = 0;

    if (pck->n_samples == 0)
        return NAN;
    for (int k = 0; k < pck->n_points; k++) {
        for (int j = 0; j <= i; j++)
            hits += pck->first[(int64_t)k * pck->n_thresholds + j];
    }
    return (double)hits / (double)pck->n_samples / pck->n_points;
}

int64_t eval_pck_failed(const eval_pck *pck)
{
    return pck->failed;
}

lt_status eval_median_of_points(int64_t n_samples, int n_points, const double *d, double *out)
{
    double *column, sum = 0;

    *out = NAN;
    if (n_samples <= 0 || n_points <= 0)
        return LT_OK;
    column = lt_alloc((size_t)n_samples * sizeof(double));
    if (!column)
        return lt_error(LT_ENOMEM, "median of %lld samples: no memory", (long long)n_samples);
    for (int k = 0; k < n_points; k++) {
        for (int64_t i = 0; i < n_samples; i++)
            column[i] = d[i * n_points + k];
        sum += lt_median(n_samples, column);
    }
    lt_release(column);
    *out = sum / n_points;
    return LT_OK;
}

/* ---- YCB-Video --------------------------------------------------------------------------- */

double eval_auc_ycb(int64_t n, double *error, double limit)
{
    double area = 0, last = 0;
    int64_t k = 0;

    if (n <= 0)
        return NAN;
    qsort(error, (size_t)n, sizeof(*error), lt_ascending);
    for (; k < n && error[k] <= limit; k++) {
        area += (error[k] - last) * (double)(k + 1) / (double)n;
        last = error[k];
    }
    area += (limit - last) * (double)k / (double)n;
    return area / limit;
}

double eval_auc_exact(int64_t n, const double *error, double limit)
{
    double sum = 0;

    for (int64_t i = 0; i < n; i++) {
        if (error[i] <= limit)
            sum += 1 - error[i] / limit;
    }
    return n > 0 ? sum / (double)n : NAN;
}
