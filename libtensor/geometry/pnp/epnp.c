/* SPDX-License-Identifier: Apache-2.0 */
/* EPnP, after Lepetit, Moreno-Noguer and Fua 2009; equation numbers are that paper's. */
#include "libtensor/geometry/pnp/pnp.h"

#include "libtensor/geometry/eigen.h"
#include "libtensor/geometry/pnp/input.h"
#include "libtensor/geometry/principal.h"
#include "libtensor/geometry/rotation.h"

enum { PAIRS = 6, BETAS = 4, GAUSS_NEWTON_STEPS = 5 };

/* The pairs of control points, and the order of the ten products beta_a beta_b. */
static const int pair[PAIRS][2] = { { 0, 1 }, { 0, 2 }, { 0, 3 }, { 1, 2 }, { 1, 3 }, { 2, 3 } };
static const int product[10][2] = {
    { 0, 0 }, { 0, 1 }, { 1, 1 }, { 0, 2 }, { 1, 2 }, { 2, 2 }, { 0, 3 }, { 1, 3 }, { 2, 3 }, { 3, 3 },
};

typedef struct {
    lt_principal shape;         /* control points: the centre, and centre + spread[k] axis[k] */
    double v[BETAS][12];        /* eigenvectors: four control points in the camera, up to scale */
    double L[PAIRS][10];        /* (13): squared distances as a linear function of the products */
    double rho[PAIRS];          /* squared distances in the object */
} epnp;

/* (2): x = sum of alpha_j control point j, the alphas summing to 1 */
static void barycentric(const lt_principal *shape, const double x[3], double alpha[4])
{
    double d[3];

    lt_vec3_sub(x, shape->centre, d);
    alpha[0] = 1;
    for (int k = 0; k < 3; k++) {
        alpha[k + 1] = lt_vec3_dot(shape->axis[k], d) / shape->spread[k];
        alpha[0] -= alpha[k + 1];
    }
}

static void add_row(double MtM[144], const double row[12])
{
    for (int i = 0; i < 12; i++)
        for (int j = 0; j < 12; j++)
            MtM[12 * i + j] += row[i] * row[j];
}

/* (5), (6), (7): every point gives two rows of M x = 0 */
static void fill_MtM(const lt_principal *shape, const lt_camera *cam, int n, const double *X,
                     const double *uv, double MtM[144])
{
    memset(MtM, 0, 144 * sizeof(MtM[0]));
    for (int i = 0; i < n; i++) {
        double alpha[4], row_u[12] = { 0 }, row_v[12] = { 0 };
        barycentric(shape, X + 3 * i, alpha);
        for (int j = 0; j < 4; j++) {
            row_u[3 * j] = alpha[j] * cam->fx;
            row_u[3 * j + 2] = alpha[j] * (cam->cx - uv[2 * i]);
            row_v[3 * j + 1] = alpha[j] * cam->fy;
            row_v[3 * j + 2] = alpha[j] * (cam->cy - uv[2 * i + 1]);
        }
        add_row(MtM, row_u);
        add_row(MtM, row_v);
    }
}

static void fill_distances(epnp *e)
{
    for (int p = 0; p < PAIRS; p++) {
        const int a = pair[p][0], b = pair[p][1];
        const double *s = e->shape.spread;
        double d[BETAS][3];
        for (int i = 0; i < BETAS; i++)
            lt_vec3_sub(e->v[i] + 3 * a, e->v[i] + 3 * b, d[i]);
        for (int k = 0; k < 10; k++) {
            const int i = product[k][0], j = product[k][1];
            e->L[p][k] = (i == j ? 1 : 2) * lt_vec3_dot(d[i], d[j]);
        }
        e->rho[p] = s[b - 1] * s[b - 1] + (a > 0 ? s[a - 1] * s[a - 1] : 0);   /* axes are orthogonal */
    }
}

/* x = argmin |A x - b| for PAIRS rows and n <= 5 columns, by Householder; b is column n of A, which is used
 * up. A column that adds nothing new gets x = 0. */
static void least_squares(int n, double A[PAIRS][6], double *x)
{
    double diagonal[5], top = 0;

    for (int k = 0; k < n; k++) {
        double norm = 0;
        for (int i = k; i < PAIRS; i++)
            norm += A[i][k] * A[i][k];
        diagonal[k] = norm = -copysign(sqrt(norm), A[k][k]);
        top = fmax(top, fabs(norm));
        if (norm == 0)
            continue;
        A[k][k] -= norm;                            /* the column now holds the reflector v, */
        for (int j = k + 1; j <= n; j++) {
            double dot = 0;
            for (int i = k; i < PAIRS; i++)
                dot += A[i][k] * A[i][j];
            dot /= norm * A[k][k];                  /* and this is -v.v/2 */
            for (int i = k; i < PAIRS; i++)
                A[i][j] += dot * A[i][k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        double rest = A[k][n];
        for (int j = k + 1; j < n; j++)
            rest -= A[k][j] * x[j];
        x[k] = fabs(diagonal[k]) > 1e-14 * top ? rest / diagonal[k] : 0;
    }
}

/* Least squares over some of the ten products, the others taken as zero. */
static void solve_products(const epnp *e, int n, const int *columns, double *x)
{
    double A[PAIRS][6];

    for (int p = 0; p < PAIRS; p++) {
        for (int k = 0; k < n; k++)
            A[p][k] = e->L[p][columns[k]];
        A[p][n] = e->rho[p];
    }
    least_squares(n, A, x);
    if (x[0] < 0)                                   /* betas are known up to a common sign */
        for (int k = 0; k < n; k++)
            x[k] = -x[k];
}

static double safe_divide(double a, double b)
{
    return b != 0 ? a / b : 0;
}

/* One guess from products 11 12 13 14: four betas */
static void guess_from_4(const epnp *e, double beta[BETAS])
{
    static const int columns[] = { 0, 1, 3, 6 };
    double x[4];

    solve_products(e, 4, columns, x);
    beta[0] = sqrt(x[0]);
    for (int i = 1; i < 4; i++)
        beta[i] = safe_divide(x[i], beta[0]);
}

/* One from 11 12 22: two betas; the sign of 12 tells theirs apart */
static void guess_from_3(const epnp *e, double beta[BETAS])
{
    static const int columns[] = { 0, 1, 2 };
    double x[3];

    solve_products(e, 3, columns, x);
    beta[0] = copysign(sqrt(x[0]), x[1]);
    beta[1] = sqrt(fmax(x[2], 0));
    beta[2] = beta[3] = 0;
}

/* One from 11 12 22 13 23: three betas */
static void guess_from_5(const epnp *e, double beta[BETAS])
{
    static const int columns[] = { 0, 1, 2, 3, 4 };
    double x[5];

    solve_products(e, 5, columns, x);
    beta[0] = copysign(sqrt(x[0]), x[1]);
    beta[1] = sqrt(fmax(x[2], 0));
    beta[2] = safe_divide(x[3], beta[0]);
    beta[3] = 0;
}

/* (15): the betas that make the six distances right */
static void gauss_newton(const epnp *e, double beta[BETAS])
{
    for (int step = 0; step < GAUSS_NEWTON_STEPS; step++) {
        double A[PAIRS][6] = { { 0 } }, x[BETAS];   /* Jacobian, residual */
        for (int p = 0; p < PAIRS; p++) {
            A[p][BETAS] = e->rho[p];
            for (int k = 0; k < 10; k++) {
                const int i = product[k][0], j = product[k][1];
                A[p][BETAS] -= e->L[p][k] * beta[i] * beta[j];
                A[p][i] += e->L[p][k] * beta[j];
                A[p][j] += e->L[p][k] * beta[i];
            }
        }
        least_squares(BETAS, A, x);
        for (int i = 0; i < BETAS; i++)
            beta[i] += x[i];
    }
}

/* What the betas' control points in the camera come to. */
typedef struct {
    double H[9];                    /* R, but for the noise, by Procrustes over all points */
    double centre[3];               /* of the points */
} seen_shape;

/* Of the n points nothing is needed: along principal axes the alphas' second moments are n on the diagonal and 0
 * elsewhere. */
static seen_shape shape_from_betas(const epnp *e, const double beta[BETAS])
{
    const lt_principal *s = &e->shape;
    double control[12] = { 0 };
    seen_shape out = { .H = { 0 } };

    for (int i = 0; i < 12; i++)
        for (int k = 0; k < BETAS; k++)
            control[i] += beta[k] * e->v[k][i];
    if (control[2] < 0)                             /* what is seen is in front */
        for (int i = 0; i < 12; i++)
            control[i] = -control[i];
    for (int j = 0; j < 3; j++)
        for (int k = 0; k < 9; k++)
            out.H[k] += (control[3 * j + 3 + k / 3] - control[k / 3]) * s->spread[j] * s->axis[j][k % 3];
    memcpy(out.centre, control, sizeof(out.centre));
    return out;
}

/* A pose found and its reprojection error. */
typedef struct { double R[9], t[3], error; } solution;

static void keep_better(solution *best, const lt_principal *shape, const seen_shape *seen, const lt_camera *cam, int n,
                        const double *X, const double *uv)
{
    double turned[3];
    solution s;

    lt_rot_nearest(seen->H, s.R);
    lt_mat3_mulvec(s.R, shape->centre, turned);
    lt_vec3_sub(seen->centre, turned, s.t);
    s.error = lt_pnp_error(cam, n, X, uv, s.R, s.t);
    if (s.error < best->error)
        *best = s;
}

static void prepare(epnp *e, const lt_camera *cam, int n, const double *X, const double *uv)
{
    double MtM[144], w[12];

    fill_MtM(&e->shape, cam, n, X, uv, MtM);
    lt_eigen_small(12, MtM, w);
    memcpy(e->v, MtM, sizeof(e->v));                /* eigenvalues ascend: the first four */
    fill_distances(e);
}

lt_status lt_epnp(const lt_camera *cam, int n, const double *X, const double *uv, double R[9], double t[3])
{
    static void (*const guess[])(const epnp *, double *) = { guess_from_4, guess_from_3, guess_from_5 };
    const lt_status st = lt_pnp_check("epnp", cam, n, 4, X, uv);
    solution best = { .error = INFINITY };
    epnp e;

    if (st)
        return st;
    lt_principal_of(n, X, &e.shape);
    if (e.shape.spread[2] <= LT_PNP_FLAT * e.shape.spread[0])
        return lt_pnp_planar(cam, n, X, uv, R, t);
    prepare(&e, cam, n, X, uv);
    for (size_t g = 0; g < LT_COUNT(guess); g++) {
        double beta[BETAS];
        seen_shape seen;

        guess[g](&e, beta);
        gauss_newton(&e, beta);
        seen = shape_from_betas(&e, beta);
        keep_better(&best, &e.shape, &seen, cam, n, X, uv);
        if (lt_mat3_det(seen.H) >= 0)
            continue;
        for (int k = 6; k < 9; k++)                 /* a mirror image: near and far changed places */
            seen.H[k] = -seen.H[k];
        keep_better(&best, &e.shape, &seen, cam, n, X, uv);
    }
    if (best.error == INFINITY)
        return lt_error(LT_ENUMERIC, "epnp: no pose has all %d points in front of the camera", n);
    memcpy(R, best.R, sizeof(best.R));
    memcpy(t, best.t, sizeof(best.t));
    return LT_OK;
}
