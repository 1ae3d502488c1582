/* SPDX-License-Identifier: Apache-2.0 */
/* The filter of a point: its axes know nothing of each other, so each has 2 x 2 numbers of its own. */
#include "libtensor/geometry/kalman/kalman.h"

#include "libtensor/geometry/mat3.h"

static const double ACCELERATION = 8;           /* m/s^2 */
static const double DEVIATION = 0.008;          /* m, of a measurement */
static const double START = 0.02, SPEED = 1;    /* m and m/s, deviations at the first measurement */
static const double GATE = 11.345;              /* squared deviations: 99 % of chi squared with 3 degrees of freedom */
enum { REJECTIONS = 3 };                        /* in a row, then the filter starts anew */

static void start(lt_point_filter *f, const double *measured)
{
    *f = (lt_point_filter){ .started = true };
    for (int i = 0; i < 3; i++) {
        f->x[i] = measured[i];
        f->P[i][0] = START * START;
        f->P[i][2] = SPEED * SPEED;
    }
}

/* x += v dt;  P = F P F^T + Q, F = [1 dt; 0 1], Q = a^2 [dt^4/4 dt^3/2; dt^3/2 dt^2] */
static void predict(lt_point_filter *f, double dt)
{
    const double a = ACCELERATION * dt;

    for (int i = 0; i < 3; i++) {
        double *P = f->P[i];

        f->x[i] += f->v[i] * dt;
        P[0] += dt * (2 * P[1] + dt * P[2]) + a * a * dt * dt / 4;
        P[1] += dt * P[2] + a * a * dt / 2;
        P[2] += a * a;
    }
}

static void update(lt_point_filter *f, const double *measured)
{
    for (int i = 0; i < 3; i++) {
        double *P = f->P[i];
        const double S = P[0] + DEVIATION * DEVIATION, y = measured[i] - f->x[i];
        const double kx = P[0] / S, kv = P[1] / S;

        f->x[i] += kx * y;
        f->v[i] += kv * y;
        P[2] -= kv * P[1];
        P[1] -= kx * P[1];
        P[0] -= kx * P[0];
    }
}

static double distance(const lt_point_filter *f, const double *measured)
{
    double sum = 0;

    for (int i = 0; i < 3; i++) {
        const double y = measured[i] - f->x[i];

        sum += y * y / (f->P[i][0] + DEVIATION * DEVIATION);
    }
    return sum;
}

bool lt_point_filter_step(lt_point_filter *f, double dt, const double *measured)
{
    const double *m = measured && lt_all_finite(3, measured) ? measured : NULL;

    if (!f->started) {
        if (m)
            start(f, m);
        return m;
    }
    predict(f, dt);
    if (!m)
        return false;
    if (distance(f, m) <= GATE) {
        f->rejected = 0;
        update(f, m);
        return true;
    }
    if (++f->rejected < REJECTIONS)
        return false;
    start(f, m);
    return true;
}
