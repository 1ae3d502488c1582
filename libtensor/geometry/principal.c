/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/geometry/principal.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/svd3.h"

#include <math.h>
#include <string.h>

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
