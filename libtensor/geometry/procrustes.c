/* SPDX-License-Identifier: Apache-2.0 */
/* Alignments of corresponding points: all three come from the SVD of one 3 x 3 cross matrix. */
#include "libtensor/geometry/procrustes.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/svd3.h"

#include <float.h>

typedef struct {
    double mean_x[3], mean_y[3];
    double sq_x, sq_y;              /* sums of squares about the means */
    double H[9];                    /* sum of (y - mean_y)(x - mean_x)^T */
} moments;

static lt_status check_points(int n, const double *x, const double *y)
{
    if (n < 1)
        return lt_error(LT_EINVAL, "procrustes: %d points, want at least 1", n);
    for (int i = 0; i < 3 * n; i++)
        if (!isfinite(x[i]) || !isfinite(y[i]))
            return lt_error(LT_EINVAL, "procrustes: point %d of %d has a coordinate that is not finite",
                            i / 3, n);
    return LT_OK;
}

static void mean_point(int n, const double *x, double mean[3])
{
    mean[0] = mean[1] = mean[2] = 0;
    for (int i = 0; i < 3 * n; i++)
        mean[i % 3] += x[i];
    for (int i = 0; i < 3; i++)
        mean[i] /= n;
}

static moments measure(int n, const double *x, const double *y)
{
    moments m = { .sq_x = 0 };

    mean_point(n, x, m.mean_x);
    mean_point(n, y, m.mean_y);
    for (int i = 0; i < n; i++) {
        double cx[3], cy[3];
        lt_vec3_sub(x + 3 * i, m.mean_x, cx);
        lt_vec3_sub(y + 3 * i, m.mean_y, cy);
        m.sq_x += lt_vec3_dot(cx, cx);
        m.sq_y += lt_vec3_dot(cy, cy);
        for (int k = 0; k < 9; k++)
            m.H[k] += cy[k / 3] * cx[k % 3];
    }
    return m;
}

/* R = U D V^T with H = U diag(s) V^T; D = I, or diag(1, 1, -1) where a rotation wants it. Returns tr(D s). */
static double best_rotation(const double H[9], bool reflect, double R[9])
{
    double U[9], s[3], V[9], Vt[9];
    double sign = 1;

    lt_svd3(H, U, s, V);
    if (!reflect && lt_mat3_det(U) * lt_mat3_det(V) < 0)
        sign = -1;
    for (int i = 0; i < 3; i++)
        U[3 * i + 2] *= sign;
    lt_mat3_transpose(V, Vt);
    lt_mat3_mul(U, Vt, R);
    return s[0] + s[1] + sign * s[2];
}

/* Whether all x are the same: what is left of them about their mean is that mean's rounding. */
static bool all_equal(const moments *m, int n)
{
    const double rounding = n * DBL_EPSILON * lt_vec3_norm(m->mean_x);

    return m->sq_x <= n * rounding * rounding;
}

/* t = mean_y - scale R mean_x */
static void set_translation(const moments *m, lt_similarity *out)
{
    double turned[3];

    lt_mat3_mulvec(out->R, m->mean_x, turned);
    for (int i = 0; i < 3; i++)
        out->t[i] = m->mean_y[i] - out->scale * turned[i];
}

lt_status lt_procrustes_ho3d(int n, const double *x, const double *y, lt_similarity *out)
{
    const lt_status st = check_points(n, x, y);
    double norm_x, norm_y, H[9];
    moments m;

    if (st)
        return st;
    m = measure(n, x, y);
    norm_x = sqrt(m.sq_x) + 1e-8;
    norm_y = sqrt(m.sq_y) + 1e-8;
    for (int k = 0; k < 9; k++)
        H[k] = m.H[k] / norm_x / norm_y;
    out->scale = best_rotation(H, true, out->R) * norm_y / norm_x;
    set_translation(&m, out);
    return LT_OK;
}

lt_status lt_procrustes_umeyama(int n, const double *x, const double *y, lt_similarity *out)
{
    const lt_status st = check_points(n, x, y);
    double trace;
    moments m;

    if (st)
        return st;
    m = measure(n, x, y);
    trace = best_rotation(m.H, false, out->R);
    out->scale = all_equal(&m, n) ? 0 : trace / m.sq_x;
    set_translation(&m, out);
    return LT_OK;
}

lt_status lt_procrustes_rigid(int n, const double *x, const double *y, lt_similarity *out)
{
    const lt_status st = check_points(n, x, y);
    moments m;

    if (st)
        return st;
    m = measure(n, x, y);
    best_rotation(m.H, false, out->R);
    out->scale = 1;
    set_translation(&m, out);
    return LT_OK;
}

lt_status lt_align_scale_translation(int n, const double *x, const double *y, int root, int other,
                                     double *out)
{
    const lt_status st = check_points(n, x, y);
    double length, scale, x0[3], y0[3];

    if (st)
        return st;
    if (root < 0 || root >= n || other < 0 || other >= n)
        return lt_error(LT_EINVAL, "procrustes: points %d and %d to scale by, of %d", root, other, n);
    memcpy(x0, x + 3 * root, sizeof(x0));
    memcpy(y0, y + 3 * root, sizeof(y0));
    length = lt_vec3_distance(x + 3 * other, x0);
    scale = lt_vec3_distance(y + 3 * other, y0) / (length > 0 ? length : 1);
    for (int i = 0; i < 3 * n; i++)
        out[i] = scale * (x[i] - x0[i % 3]) + y0[i % 3];
    return LT_OK;
}

void lt_similarity_apply(const lt_similarity *s, int n, const double *x, double *out)
{
    for (int i = 0; i < n; i++) {
        double turned[3];
        lt_mat3_mulvec(s->R, x + 3 * i, turned);
        for (int k = 0; k < 3; k++)
            out[3 * i + k] = s->scale * turned[k] + s->t[k];
    }
}
