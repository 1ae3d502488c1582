/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/geometry/eigen.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { SWEEPS = 30 };           /* six to ten are enough for any matrix that has been met */
static const double NOTHING = 1e-18;    /* times the largest diagonal element: not worth a turn */

/* Turn rows and columns p and q of the symmetric A so that A[p][q] is 0; the rows of V go along. */
static void turn(int n, double *A, double *V, int p, int q)
{
    const double theta = (A[q * n + q] - A[p * n + p]) / (2 * A[p * n + q]);
    const double t = copysign(1, theta) / (fabs(theta) + sqrt(theta * theta + 1));
    const double c = 1 / sqrt(t * t + 1), s = t * c;
    double *Ap = A + p * n, *Aq = A + q * n, *Vp = V + p * n, *Vq = V + q * n;

    for (int k = 0; k < n; k++) {
        const double kp = A[k * n + p], kq = A[k * n + q];
        A[k * n + p] = c * kp - s * kq;
        A[k * n + q] = s * kp + c * kq;
    }
    for (int k = 0; k < n; k++) {
        const double pk = Ap[k], qk = Aq[k], vp = Vp[k], vq = Vq[k];
        Ap[k] = c * pk - s * qk;
        Aq[k] = s * pk + c * qk;
        Vp[k] = c * vp - s * vq;
        Vq[k] = s * vp + c * vq;
    }
}

static double largest_diagonal(int n, const double *A)
{
    double most = 0;

    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(A[i * n + i]));
    return most;
}

void lt_eigen_symmetric(int n, double *A, double *V)
{
    const double nothing = NOTHING * largest_diagonal(n, A);
    int turns = 1;

    memset(V, 0, (size_t)n * (size_t)n * sizeof(*V));
    for (int i = 0; i < n; i++)
        V[i * n + i] = 1;
    for (int sweep = 0; sweep < SWEEPS && turns; sweep++) {
        turns = 0;
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++)
                if (fabs(A[p * n + q]) > nothing) {
                    turn(n, A, V, p, q);
                    turns++;
                }
    }
}

void lt_eigen_small(int n, double *A, double *w)
{
    double V[LT_EIGEN_MAX * LT_EIGEN_MAX], value[LT_EIGEN_MAX];
    bool used[LT_EIGEN_MAX] = { false };

    assert(n <= LT_EIGEN_MAX);
    lt_eigen_symmetric(n, A, V);
    for (int i = 0; i < n; i++)
        value[i] = A[i * n + i];
    for (int r = 0; r < n; r++) {
        int least = -1;

        for (int i = 0; i < n; i++)
            if (!used[i] && (least < 0 || value[i] < value[least]))
                least = i;
        used[least] = true;
        w[r] = value[least];
        memcpy(A + r * n, V + least * n, (size_t)n * sizeof(*A));
    }
}
