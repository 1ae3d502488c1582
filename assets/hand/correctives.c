/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pose correctives: what linear blend skinning loses at a bent joint is put back before skinning.
 *
 * Skin that follows a joint bent by t with share w lands at ((1 - w) + w e^it) r around the axis, where it
 * should land at e^iwt r: round the back of the joint it caves in by up to a third. The missing factor
 *     g(t) = e^iwt / ((1 - w) + w e^it) - 1   is fitted by   a sin t + b (1 - cos t)
 * with complex a, b. As sin t = <N, R - I> / 2 and 1 - cos t = <NN, R - I> / 2 for R the turn by t about the
 * axis n, N = [n]x, that is linear in R - I, as posedirs must be.
 */
#include "assets/hand/internal.h"

#include <complex.h>
#include <string.h>

typedef struct { double complex a, b; } bend_fit;

static const double BULGE_MM = 0.5;         /* knuckles stand out when bent */
static const double FOLD_MM = 0.8;          /* the skin inside the bend gives way */

/* Least squares over the bends that a finger makes. */
static bend_fit fit_bend(double w)
{
    static const double deg[] = { -20, 15, 30, 45, 60, 75, 90 };
    double ss = 0, sc = 0, cc = 0;
    double complex sg = 0, cg = 0;

    for (size_t i = 0; i < LT_COUNT(deg); i++) {
        const double t = deg[i] * M_PI / 180, si = sin(t), co = 1 - cos(t);
        const double complex g = cexp(I * w * t) / (1 - w + w * cexp(I * t)) - 1;

        ss += si * si;
        sc += si * co;
        cc += co * co;
        sg += si * g;
        cg += co * g;
    }
    const double det = ss * cc - sc * sc;
    return (bend_fit){ (sg * cc - cg * sc) / det, (cg * ss - sg * sc) / det };
}

/* The share of a point that turns with a joint: its own weight and those beyond it on the digit. */
static double turning_share(const double weight[LT_HAND_JOINTS], int digit, int k)
{
    double w = 0;

    for (int i = k; i < 3; i++)
        w += weight[digit_joint(digit, i)];
    return w;
}

static void add_feature(float (*dirs)[LT_HAND_POSE_FEATURES], int joint, int entry, vec3 d,
                        double factor)
{
    const int at = 9 * (joint - 1) + entry;

    dirs[0][at] += (float)(factor * d.x / 1000);
    dirs[1][at] += (float)(factor * d.y / 1000);
    dirs[2][at] += (float)(factor * d.z / 1000);
}

/* out += sin_dir sin t + cos_dir (1 - cos t), written on the nine entries of R - I */
static void add_bend(float (*dirs)[LT_HAND_POSE_FEATURES], int joint, vec3 n, vec3 sin_dir,
                     vec3 cos_dir)
{
    const double skew[9] = { 0, -n.z, n.y, n.z, 0, -n.x, -n.y, n.x, 0 };
    const double axis[3] = { n.x, n.y, n.z };

    for (int e = 0; e < 9; e++) {
        add_feature(dirs, joint, e, sin_dir, skew[e] / 2);
        add_feature(dirs, joint, e, cos_dir, (axis[e / 3] * axis[e % 3] - (e % 4 == 0)) / 2);
    }
}

static void correct(const hand_skeleton *s, int digit, int k, vec3 p, double w,
                    float (*dirs)[LT_HAND_POSE_FEATURES])
{
    const vec3 n = s->flex[digit], up = unit(reject(s->dorsal[digit], s->bone[digit][k]));
    const vec3 r = reject(sub(p, s->joint[digit][k]), n), turned = cross(n, r);
    const double height = clamp(dot(r, up) / s->radius[digit][k], -1, 1);
    const double gain = digit == DIGIT_THUMB && k == 0 ? 0.3 : 0.6 - 0.2 * height;
    const double puff = 4 * w * (1 - w) * (height > 0 ? BULGE_MM : FOLD_MM) * fabs(height);
    const bend_fit f = fit_bend(w);

    add_bend(dirs, digit_joint(digit, k), n,
             scale(madd(scale(r, creal(f.a)), turned, cimag(f.a)), gain),
             madd(scale(madd(scale(r, creal(f.b)), turned, cimag(f.b)), gain), up, puff));
}

void hand_correctives(const hand_skeleton *s, const hand_rig *rig,
                      float out[LT_HAND_VERTICES][3][LT_HAND_POSE_FEATURES])
{
    memset(out, 0, sizeof(float[LT_HAND_VERTICES][3][LT_HAND_POSE_FEATURES]));
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int d = 0; d < DIGITS; d++)
            for (int k = 0; k < 3; k++) {
                const double w = turning_share(rig->weight[v], d, k);

                if (w > 0.001 && w < 0.999)
                    correct(s, d, k, rig->vertex[v], w, out[v]);
            }
}
