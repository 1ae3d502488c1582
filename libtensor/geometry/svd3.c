/* SPDX-License-Identifier: Apache-2.0 */
/* One-sided Jacobi: turn pairs of columns of A until all are orthogonal; then A V = U diag(s). */
#include "libtensor/geometry/svd3.h"

#include "libtensor/geometry/mat3.h"

#include <float.h>

enum { MAX_SWEEPS = 40 };       /* 6 suffice; the bound is for what we have not thought of */

/* Rows of W and V are the columns of A V and V: contiguous, and swapped with ease. */
static void turn(double a[3], double b[3], double c, double s)
{
    for (int i = 0; i < 3; i++) {
        const double ai = a[i], bi = b[i];
        a[i] = c * ai - s * bi;
        b[i] = s * ai + c * bi;
    }
}

/* Makes columns p and q orthogonal; false when they already were. */
static bool orthogonalise(double W[9], double V[9], int p, int q)
{
    double *wp = W + 3 * p, *wq = W + 3 * q;
    const double pp = lt_vec3_dot(wp, wp), qq = lt_vec3_dot(wq, wq), pq = lt_vec3_dot(wp, wq);
    double zeta, t, c;

    if (fabs(pq) <= DBL_EPSILON * sqrt(pp * qq) || pq == 0)
        return false;
    zeta = (qq - pp) / (2 * pq);
    t = copysign(1, zeta) / (fabs(zeta) + hypot(1, zeta));
    c = 1 / sqrt(1 + t * t);
    turn(wp, wq, c, c * t);
    turn(V + 3 * p, V + 3 * q, c, c * t);
    return true;
}

static void swap_rows(double M[9], int p, int q)
{
    for (int i = 0; i < 3; i++) {
        const double x = M[3 * p + i];
        M[3 * p + i] = M[3 * q + i];
        M[3 * q + i] = x;
    }
}

static void sort_descending(double W[9], double V[9], double s[3])
{
    static const int pair[3][2] = { { 0, 1 }, { 1, 2 }, { 0, 1 } };

    for (int i = 0; i < 3; i++)
        s[i] = lt_vec3_norm(W + 3 * i);
    for (int k = 0; k < 3; k++) {
        const int p = pair[k][0], q = pair[k][1];
        const double sp = s[p];
        if (sp >= s[q])
            continue;
        s[p] = s[q];
        s[q] = sp;
        swap_rows(W, p, q);
        swap_rows(V, p, q);
    }
}

/* out = the unit vector along w - (u.w) u */
static void unit_across(const double u[3], const double w[3], double out[3])
{
    const double along = lt_vec3_dot(u, w);
    double norm;

    for (int i = 0; i < 3; i++)
        out[i] = w[i] - along * u[i];
    norm = lt_vec3_norm(out);
    for (int i = 0; i < 3; i++)
        out[i] /= norm;
}

/* The coordinate axis least along u, which is never parallel to it. */
static void some_axis(const double u[3], double out[3])
{
    int least = 0;

    for (int i = 1; i < 3; i++)
        if (fabs(u[i]) < fabs(u[least]))
            least = i;
    for (int i = 0; i < 3; i++)
        out[i] = i == least;
}

/* Columns of U (as rows) out of the columns of W. Where A has no rank left W is rounding noise, so the
 * first is W's, the second made orthogonal to it, the third their product with W's sign. */
static void complete_basis(const double W[9], const double s[3], double Ut[9])
{
    double axis[3];

    lt_mat3_identity(Ut);
    if (s[0] == 0)
        return;
    for (int i = 0; i < 3; i++)
        Ut[i] = W[i] / s[0];
    some_axis(Ut, axis);
    unit_across(Ut, s[1] > 1e-14 * s[0] ? W + 3 : axis, Ut + 3);
    lt_vec3_cross(Ut, Ut + 3, Ut + 6);
    if (lt_vec3_dot(Ut + 6, W + 6) < 0)
        for (int i = 6; i < 9; i++)
            Ut[i] = -Ut[i];
}

/* The power of two that brings A's largest entry near 1, so that no square over- or underflows. */
static double balance(const double A[9])
{
    double top = 0;
    int exponent;

    for (int i = 0; i < 9; i++)
        top = fmax(top, fabs(A[i]));
    if (top == 0)
        return 1;
    frexp(top, &exponent);
    return ldexp(1, exponent < -1000 ? -1000 : exponent > 1000 ? 1000 : exponent);
}

void lt_svd3(const double A[9], double U[9], double s[3], double V[9])
{
    double W[9], Vt[9], Ut[9];
    const double scale = balance(A);
    bool turned = true;

    if (!lt_all_finite(9, A)) {
        lt_mat3_identity(U);
        lt_mat3_identity(V);
        s[0] = s[1] = s[2] = NAN;
        return;
    }
    lt_mat3_transpose(A, W);
    for (int i = 0; i < 9; i++)
        W[i] /= scale;
    lt_mat3_identity(Vt);
    for (int sweep = 0; sweep < MAX_SWEEPS && turned; sweep++) {
        turned = orthogonalise(W, Vt, 0, 1);
        turned |= orthogonalise(W, Vt, 0, 2);
        turned |= orthogonalise(W, Vt, 1, 2);
    }
    sort_descending(W, Vt, s);
    complete_basis(W, s, Ut);
    lt_mat3_transpose(Ut, U);
    lt_mat3_transpose(Vt, V);
    for (int i = 0; i < 3; i++)
        s[i] *= scale;
}
