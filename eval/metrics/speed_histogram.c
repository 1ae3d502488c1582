/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/metrics/speed_histogram.h"

#include <math.h>
#include <string.h>

static const double FPS = 30, SLOWEST = 0.02, FASTEST = 4;
static const int joints[SPEED_JOINTS] = { 12, 13, 10, 11, 24, 0 };

static int bin_of(double speed)
{
    const double at = SPEED_BINS * log(fmax(speed, 1e-9) / SLOWEST) / log(FASTEST / SLOWEST);

    return (int)fmin(SPEED_BINS - 1, fmax(0, floor(at)));
}

void speed_histogram(const float *body, int T, double out[SPEED_FEATURES])
{
    memset(out, 0, SPEED_FEATURES * sizeof(*out));
    for (int j = 0; j < SPEED_JOINTS; j++)
        for (int k = 1; k < T; k++) {
            double sum = 0;

            for (int c = 0; c < 3; c++) {
                const float *x = body + ((int64_t)c * T + k) * ACTION_BODY + joints[j];
                const double step = (double)x[0] - (double)x[-ACTION_BODY];

                sum += step * step;
            }
            out[j * SPEED_BINS + bin_of(FPS * sqrt(sum))] += 1.0 / (T - 1);
        }
}

void speed_means_add(speed_means *m, int cls, const double histogram[SPEED_FEATURES])
{
    for (int i = 0; i < SPEED_FEATURES; i++)
        m->sum[cls][i] += histogram[i];
    m->n[cls]++;
}

int speed_means_nearest(const speed_means *m, const double histogram[SPEED_FEATURES])
{
    double least = INFINITY;
    int nearest = -1;

    for (int cls = 0; cls < ACTION_CLASSES; cls++) {
        double sum = 0;

        for (int i = 0; i < SPEED_FEATURES && m->n[cls]; i++) {
            const double d = m->sum[cls][i] / (double)m->n[cls] - histogram[i];

            sum += d * d;
        }
        if (m->n[cls] && sum < least) {
            least = sum;
            nearest = cls;
        }
    }
    return nearest;
}
