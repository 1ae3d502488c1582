/* SPDX-License-Identifier: Apache-2.0 */
/* How far joints turn, and their angles. */
#include "assets/body/body.h"

#include <math.h>

#define DEG(a) ((a) * 0.017453292519943295)
#define LIMIT(x0, x1, y0, y1, z0, z1) { { DEG(x0), DEG(y0), DEG(z0) }, { DEG(x1), DEG(y1), DEG(z1) } }
/* A left joint and its mirror image. */
#define PAIR(x0, x1, y0, y1, z0, z1) LIMIT(x0, x1, y0, y1, z0, z1), LIMIT(x0, x1, -(y1), -(y0), -(z1), -(z0))

/* Bending forward is +x of the trunk, -x of the hip, +x of the knee; of a left arm that is out, raising it is +z,
 * swinging it forward -y, bending the elbow -y; turning the palm up is -x. */
const synth_body_limit synth_body_limits[BODY_FINGERS] = {
    LIMIT(-90, 90, -180, 180, -180, 180),               /* pelvis: the whole body */
    PAIR(-125, 25, -45, 45, -25, 50),                   /* hips */
    LIMIT(-15, 30, -20, 20, -15, 15),                   /* spine */
    PAIR(0, 145, -12, 12, -5, 5),                       /* knees */
    LIMIT(-12, 25, -20, 20, -15, 15),
    PAIR(-25, 45, -25, 25, -20, 20),                    /* ankles */
    LIMIT(-12, 20, -20, 20, -15, 15),
    PAIR(-40, 30, -5, 5, -5, 5),                        /* toes */
    LIMIT(-30, 35, -40, 40, -25, 25),                   /* neck */
    PAIR(-12, 12, -25, 20, -12, 30),                    /* collars */
    LIMIT(-25, 30, -40, 40, -20, 20),                   /* head */
    PAIR(-89, 89, -150, 90, -100, 95),                  /* shoulders */
    PAIR(-85, 85, -150, 3, -3, 3),                      /* elbows; turning the forearm */
    PAIR(-45, 45, -30, 30, -70, 70),                    /* wrists */
    LIMIT(0, 25, -8, 8, -3, 3),                         /* jaw */
    PAIR(-25, 25, -35, 35, -3, 3),                      /* eyes */
};

void synth_body_rotation(const double angle[3], double R[9])
{
    const double cx = cos(angle[0]), sx = sin(angle[0]), cy = cos(angle[1]), sy = sin(angle[1]);
    const double cz = cos(angle[2]), sz = sin(angle[2]);

    R[0] = cy * cz + sy * sx * sz;
    R[1] = sy * sx * cz - cy * sz;
    R[2] = sy * cx;
    R[3] = cx * sz;
    R[4] = cx * cz;
    R[5] = -sx;
    R[6] = cy * sx * sz - sy * cz;
    R[7] = sy * sz + cy * sx * cz;
    R[8] = cy * cx;
}

void synth_body_angles(const double R[9], double angle[3])
{
    angle[0] = asin(fmax(-1, fmin(1, -R[5])));
    angle[1] = atan2(R[2], R[8]);
    angle[2] = atan2(R[3], R[4]);
}

static bool is_within(const synth_body_limit *l, const double angle[3])
{
    for (int k = 0; k < 3; k++)
        if (!(angle[k] >= l->lo[k] - 1e-5 && angle[k] <= l->hi[k] + 1e-5))
            return false;
    return true;
}

/* R has two triples of angles: turning by 180 degrees about all axes but with x on its other side is the same. */
bool synth_body_within(int joint, const double R[9])
{
    double a[3], other[3];

    synth_body_angles(R, a);
    other[0] = copysign(M_PI, a[0]) - a[0];
    for (int k = 1; k < 3; k++)
        other[k] = a[k] - copysign(M_PI, a[k]);
    return is_within(&synth_body_limits[joint], a) || is_within(&synth_body_limits[joint], other);
}
