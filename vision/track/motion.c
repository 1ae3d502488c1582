/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/track/motion.h"

#include <math.h>
#include <stdbool.h>

/* Deviations of a position and of a velocity, as shares of the height; an aspect has none, and a few of its own */
static const double POSITION = 1.0 / 20, VELOCITY = 1.0 / 160;
static const double ASPECT_PROCESS = 1e-2, ASPECT_VELOCITY = 1e-5, ASPECT_MEASURED = 1e-1;

static void measure(const float box[4], double z[MOTION_AXES])
{
    const double w = (double)box[2] - (double)box[0], h = (double)box[3] - (double)box[1];

    z[MOTION_X] = (double)box[0] + w / 2;
    z[MOTION_Y] = (double)box[1] + h / 2;
    z[MOTION_ASPECT] = w / h;
    z[MOTION_HEIGHT] = h;
}

static double square(double x)
{
    return x * x;
}

static double innovation_variance(const box_motion *m, int axis)
{
    const double noise = axis == MOTION_ASPECT ? ASPECT_MEASURED : POSITION * m->axis[MOTION_HEIGHT].x;

    return m->axis[axis].P[0] + square(noise);
}

void motion_begin(box_motion *m, const float box[4])
{
    double z[MOTION_AXES];

    measure(box, z);
    for (int i = 0; i < MOTION_AXES; i++) {
        const bool aspect = i == MOTION_ASPECT;
        const double position = aspect ? ASPECT_PROCESS : 2 * POSITION * z[MOTION_HEIGHT];
        const double velocity = aspect ? ASPECT_VELOCITY : 10 * VELOCITY * z[MOTION_HEIGHT];

        m->axis[i] = (motion_axis){ .x = z[i], .P = { square(position), 0, square(velocity) } };
    }
}

void motion_predict(box_motion *m)
{
    const double h = m->axis[MOTION_HEIGHT].x;

    for (int i = 0; i < MOTION_AXES; i++) {
        motion_axis *a = &m->axis[i];
        const bool aspect = i == MOTION_ASPECT;

        a->x += a->v;
        a->P[0] += 2 * a->P[1] + a->P[2] + square(aspect ? ASPECT_PROCESS : POSITION * h);
        a->P[1] += a->P[2];
        a->P[2] += square(aspect ? ASPECT_VELOCITY : VELOCITY * h);
    }
}

double motion_distance(const box_motion *m, const float box[4])
{
    double z[MOTION_AXES], sum = 0;

    measure(box, z);
    for (int i = 0; i < MOTION_AXES; i++)
        sum += square(z[i] - m->axis[i].x) / innovation_variance(m, i);
    return isnan(sum) ? INFINITY : sum;
}

void motion_update(box_motion *m, const float box[4])
{
    double z[MOTION_AXES], S[MOTION_AXES];

    measure(box, z);
    for (int i = 0; i < MOTION_AXES; i++)
        S[i] = innovation_variance(m, i);
    for (int i = 0; i < MOTION_AXES; i++) {
        motion_axis *a = &m->axis[i];
        const double gain = a->P[0] / S[i], gain_v = a->P[1] / S[i], off = z[i] - a->x;

        a->x += gain * off;
        a->v += gain_v * off;
        a->P[0] -= gain * S[i] * gain;
        a->P[1] -= gain * S[i] * gain_v;
        a->P[2] -= gain_v * S[i] * gain_v;
    }
}

void motion_box(const box_motion *m, double box[4])
{
    const double h = m->axis[MOTION_HEIGHT].x, w = m->axis[MOTION_ASPECT].x * h;

    box[0] = m->axis[MOTION_X].x - w / 2;
    box[1] = m->axis[MOTION_Y].x - h / 2;
    box[2] = box[0] + w;
    box[3] = box[1] + h;
}
