/* SPDX-License-Identifier: Apache-2.0 */
/* Eigenvectors of small symmetric matrices, and the principal axes of a point set. */
#include "libtensor/geometry/principal.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/svd3.h"

#include <assert.h>
#include <cblas.h>
#include <lapacke.h>
#include <pthread.h>

/* Left to itself OpenBLAS cuts work by cores, and the bits of the result with it. */
static void hold_blas(void)
{
    openblas_set_num_threads(1);
}

bool lt_eigen_small(int n, double *A, double *w)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    double work[64 * LT_EIGEN_MAX];

    assert(n <= LT_EIGEN_MAX);
    pthread_once(&once, hold_blas);
    return LAPACKE_dsyev_work(LAPACK_COL_MAJOR, 'V', 'U', n, A, n, w, work, LT_COUNT(work)) == 0;
}

void lt_principal_of(int n, const double *X, lt_principal *out)
{
    double cov[9] = { 0 }, U[9], s[3], V[9];

    memset(out->centre, 0, sizeof(out->centre));
    for (int i = 0; i < 3 * n; i++)
        out->centre[i % 3] += X[i] / n;
    for (int i = 0; i < n; i++) {
        double d[3];
        lt_vec3_sub(X + 3 * i, out->centre, d);
        for (int k = 0; k < 9; k++)
            cov[k] += d[k / 3] * d[k % 3] / n;
    }
    lt_svd3(cov, U, s, V);
    for (int k = 0; k < 3; k++) {
        out->spread[k] = sqrt(s[k]);
        for (int i = 0; i < 3; i++)
            out->axis[k][i] = U[3 * i + k];
    }
}
