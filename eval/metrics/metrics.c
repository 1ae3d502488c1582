/* SPDX-License-Identifier: Apache-2.0 */
/* Distances between a predicted and a true point set: plain, aligned, and to the nearest
 * neighbour. */
#include "eval/metrics/metrics.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/order.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/kd_tree.h"
#include "libtensor/geometry/procrustes.h"

#include <math.h>
#include <stdlib.h>

void eval_widen(int64_t n, const float *x, double *out)
{
    for (int64_t i = 0; i < n; i++)
        out[i] = x[i];
}

static double distance(const double *p, const double *g)
{
    const double d = lt_vec3_distance(p, g);

    return isfinite(d) ? d : INFINITY;
}

void eval_distances(int n, const double *p, const double *g, double *d)
{
    for (int i = 0; i < n; i++)
        d[i] = distance(p + 3 * i, g + 3 * i);
}

double eval_mean(int64_t n, const double *d)
{
    double sum = 0;

    for (int64_t i = 0; i < n; i++)
        sum += d[i];
    return n > 0 ? sum / (double)n : NAN;
}

double eval_mpjpe(int n, const double *p, const double *g)
{
    double sum = 0;

    for (int i = 0; i < n; i++)
        sum += distance(p + 3 * i, g + 3 * i);
    return n > 0 ? sum / n : NAN;
}

/* ---- alignment --------------------------------------------------------------------------- */

void eval_align_root(int n, const double *p, const double *g, int root, double *out)
{
    double shift[3];

    for (int k = 0; k < 3; k++)
        shift[k] = g[3 * root + k] - p[3 * root + k];
    for (int i = 0; i < 3 * n; i++)
        out[i] = p[i] + shift[i % 3];
}

static void fill_nan(int n, double *out)
{
    for (int i = 0; i < 3 * n; i++)
        out[i] = NAN;
}

void eval_align_procrustes(eval_procrustes_kind kind, int n, const double *p, const double *g,
                           double *out)
{
    lt_similarity fit;
    const lt_status st = kind == EVAL_REFLECT ? lt_procrustes_ho3d(n, p, g, &fit)
                                              : lt_procrustes_umeyama(n, p, g, &fit);

    if (st)
        fill_nan(n, out);
    else
        lt_similarity_apply(&fit, n, p, out);
}

void eval_align_scale(int n, const double *p, const double *g, int base, int tip, double *out)
{
    if (lt_align_scale_translation(n, p, g, base, tip, out))
        fill_nan(n, out);
}

/* ---- nearest neighbours ------------------------------------------------------------------ */

/* d[i]: from point i of p to the nearest one of g */
static lt_status distances_to(int ng, const double *g, int np, const double *p, double *d)
{
    lt_kd_tree tree;
    const lt_status st = lt_kd_tree_new(ng, g, &tree);

    if (st)
        return st;
    for (int i = 0; i < np; i++)
        d[i] = lt_kd_tree_distance(&tree, p + 3 * i);
    lt_kd_tree_free(&tree);
    return LT_OK;
}

lt_status eval_nearest(int np, const double *p, int ng, const double *g, double *d_p, double *d_g)
{
    lt_status st = d_p ? distances_to(ng, g, np, p, d_p) : LT_OK;

    if (!st && d_g)
        st = distances_to(np, p, ng, g, d_g);
    return st;
}

static double share_within(int n, const double *d, double within)
{
    int hits = 0;

    for (int i = 0; i < n; i++)
        hits += d[i] < within;
    return n > 0 ? (double)hits / n : 0;
}

eval_f eval_f_score(int np, const double *d_p, int ng, const double *d_g, double within)
{
    eval_f s = {
        .precision = share_within(np, d_p, within), .recall = share_within(ng, d_g, within),
    };
    const double sum = s.precision + s.recall;

    s.f = sum > 0 ? 2 * s.precision * s.recall / sum : 0;
    return s;
}

static double mean_square_cm(int n, const double *d)
{
    double sum = 0;

    for (int i = 0; i < n; i++)
        sum += (100 * d[i]) * (100 * d[i]);
    return n > 0 ? sum / n : NAN;
}

double eval_chamfer_cm2(int np, const double *d_p, int ng, const double *d_g)
{
    return mean_square_cm(ng, d_g) + mean_square_cm(np, d_p);
}
