/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/geometry/solve6.h"

#include <math.h>

bool lt_cholesky6(double S[6][6])
{
    for (int i = 0; i < 6; i++)
        for (int j = 0; j <= i; j++) {
            double sum = S[i][j];

            for (int k = 0; k < j; k++)
                sum -= S[i][k] * S[j][k];
            if (i == j && !(sum > 0))
                return false;
            S[i][j] = i == j ? sqrt(sum) : sum / S[j][j];
        }
    return true;
}

void lt_solve6(double L[6][6], double b[6])
{
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < i; k++)
            b[i] -= L[i][k] * b[k];
        b[i] /= L[i][i];
    }
    for (int i = 5; i >= 0; i--) {
        for (int k = i + 1; k < 6; k++)
            b[i] -= L[k][i] * b[k];
        b[i] /= L[i][i];
    }
}
