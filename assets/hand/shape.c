/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The skin of the synthetic hand as a signed distance: a smooth union of rounded cones for bones and
 * flesh, ellipsoids for the eminences of thumb and little finger, thin sheets for the webs.
 */
#include "assets/hand/internal.h"
#include "assets/surface/solids.h"

/* Vertices lie this far outside, for the flat triangles between them lie as far inside. */
static const double SKIN_MM = 0.25;

static double triangle(vec3 p, vec3 a, vec3 b, vec3 c)
{
    const vec3 n = cross(sub(b, a), sub(c, a)), pa = sub(p, a), pb = sub(p, b), pc = sub(p, c);
    const bool over = dot(cross(sub(b, a), n), pa) <= 0 && dot(cross(sub(c, b), n), pb) <= 0
        && dot(cross(sub(a, c), n), pc) <= 0;

    if (over)
        return fabs(dot(n, pa)) / norm(n);
    return fmin(segment_distance(p, a, b),
                fmin(segment_distance(p, b, c), segment_distance(p, c, a)));
}

/* What is added to a phalanx: pads on the palm side between joints, a flat nail, knuckles. */
static double relief(const hand_skeleton *s, int digit, int k, vec3 p)
{
    const vec3 a = s->joint[digit][k], b = s->joint[digit][k + 1];
    const double t = along(p, a, b), mid = 4 * t * (1 - t);
    const vec3 off = sub(p, mix(a, b, t));
    const double up =
        dot(off, s->dorsal[digit]) / (norm(off) + 1); /* 1 on the back, -1 on the pad */

    if (up < 0)
        return -up * (k == 2 ? 1.2 * smoothstep(0.0, 0.5, t) * (1 - 0.6 * t) : 0.9 * mid);
    if (k == 2)
        return -1.1 * up * smoothstep(0.25, 0.7, t);
    return up * (k == 0 ? -0.6 * mid + 0.5 * smoothstep(0.8, 1, t) : 0.5 * smoothstep(0.3, 0, t));
}

static double digit_distance(const hand_skeleton *s, int digit, vec3 p)
{
    const vec3 *j = s->joint[digit];
    const double *r = s->radius[digit];
    const vec3 tip = madd(j[3], s->bone[digit][2], -r[3]);      /* centre of the tip's own ball */
    double d = 1e9;

    for (int k = digit == DIGIT_THUMB ? 1 : 0; k < 3; k++) {
        const double phalanx = round_cone(p, j[k], k == 2 ? tip : j[k + 1], r[k], r[k + 1]);
        d = phalanx > 12 ? fmin(d, phalanx) : smooth_min(d, phalanx - relief(s, digit, k, p), 2.5);
    }
    return d;
}

/* Four metacarpals under one skin, thinner at the wrist side of the hollow of the hand. */
static double metacarpals(const hand_skeleton *s, vec3 p)
{
    static const double spread[DIGITS] = { [DIGIT_INDEX] = 13, [DIGIT_MIDDLE] = 4, [DIGIT_RING] = -5,
                                           [DIGIT_LITTLE] = -13 };
    double d = 1e9;

    for (int i = 0; i < DIGIT_THUMB; i++) {
        const vec3 carpus = add(s->wrist, vec(-20, -0.5, spread[i] - 1));
        const vec3 head = add(s->joint[i][0], vec(3, -0.5, 0));
        d = smooth_min(d, round_cone(p, carpus, head, 13.5, s->radius[i][0] + 0.6), 8);
    }
    return d;
}

/* The pad under the heads of the metacarpals, and the skin between neighbouring fingers. */
static double finger_webs(const hand_skeleton *s, vec3 p)
{
    static const int row[4] = { DIGIT_INDEX, DIGIT_MIDDLE, DIGIT_RING, DIGIT_LITTLE };
    double d = 1e9;

    for (int i = 0; i < 3; i++) {
        const int a = row[i], b = row[i + 1];
        const vec3 wa = add(madd(s->joint[a][0], s->bone[a][0], 1), vec(0, -4, 0));
        const vec3 wb = add(madd(s->joint[b][0], s->bone[b][0], 1), vec(0, -4, 0));
        d = smooth_min(d, round_cone(p, wa, wb, 6.5, 6.5), 4);
    }
    return d;
}

/* The thumb's metacarpal, the muscles at its foot, and the web to the index finger. */
static double thenar(const hand_skeleton *s, vec3 p)
{
    const vec3 *t = s->joint[DIGIT_THUMB];
    const double *r = s->radius[DIGIT_THUMB];
    const vec3 belly = add(mix(t[0], t[1], 0.35), vec(-4, -1, -7));
    const vec3 index = s->joint[DIGIT_INDEX][0];
    double d = round_cone(p, add(t[0], vec(4, 3, -4)), t[1], r[0] - 1.5, r[1]);

    d = smooth_min(d, ellipsoid(p, belly, vec(-0.86, -0.1, 0.5), vec(0, 1, 0), vec(28, 14.5, 16)),
                   8);
    return smooth_min(d, triangle(p, add(t[0], vec(-8, 6, -2)), mix(t[1], t[2], 0.05),
                                  add(index, vec(16, -3, 3))) - 5.0, 10);
}

static double hypothenar(const hand_skeleton *s, vec3 p)
{
    const vec3 heel = add(s->wrist, vec(-22, -9, -14));
    const vec3 head = add(s->joint[DIGIT_LITTLE][0], vec(15, -7, 2));

    return round_cone(p, heel, head, 12.5, 9.0);
}

static double wrist(const hand_skeleton *s, vec3 p)
{
    return ellipsoid(p, add(s->wrist, vec(14, -0.5, -2)), vec(1, 0, 0), vec(0, 1, 0),
                     vec(120, 19, 28));
}

static double palm_distance(const hand_skeleton *s, vec3 p)
{
    double d = smooth_min(metacarpals(s, p), wrist(s, p), 12);

    d = smooth_min(d, hypothenar(s, p), 9);
    d = smooth_min(d, thenar(s, p), 11);
    return smooth_min(d, finger_webs(s, p), 7);
}

/* Whether the digit's skin is surely more than 15 mm away, so that it cannot matter where others are near. */
static bool far_from_digit(const hand_skeleton *s, int digit, vec3 p)
{
    const vec3 a = s->joint[digit][0], b = s->joint[digit][3];
    return segment_distance(p, a, b) > s->radius[digit][0] + 18;
}

double hand_shape_distance(const hand_skeleton *s, vec3 p)
{
    const double palm = palm_distance(s, p);
    double d = palm;

    for (int i = 0; i < DIGITS; i++) { /* a digit grows out of the palm, not out of another */
        if (d < 10 && far_from_digit(s, i, p))
            continue;
        d = fmin(d, smooth_min(palm, digit_distance(s, i, p), i == DIGIT_THUMB ? 6 : 4));
    }
    return d - SKIN_MM;
}

/* By differences at the corners of a tetrahedron. */
static vec3 gradient(const hand_skeleton *s, vec3 p)
{
    static const vec3 corner[4] = { { 1, 1, 1 }, { 1, -1, -1 }, { -1, 1, -1 }, { -1, -1, 1 } };
    const double h = 0.05;
    vec3 g = { 0, 0, 0 };

    for (int i = 0; i < 4; i++)
        g = madd(g, corner[i], hand_shape_distance(s, madd(p, corner[i], h)) / (4 * h));
    return g;
}

static double skin_distance(const void *ctx, vec3 p) { return hand_shape_distance(ctx, p); }
static vec3 skin_normal(const void *ctx, vec3 p) { return unit(gradient(ctx, p)); }

/* The rim of the wrist lies in its plane. */
static vec3 skin_snap(const void *ctx, vec3 p, int rim)
{
    const hand_skeleton *s = ctx;

    if (rim)
        p.x = s->cut_x;
    for (int i = 0; i < 4; i++) { /* Newton; the field is a distance but for the fillets */
        const double d = hand_shape_distance(s, p);
        vec3 g;

        if (fabs(d) < 1e-3)
            break;
        g = gradient(s, p);
        if (rim)
            g.x = 0;
        p = madd(p, g, -d / fmax(dot(g, g), 0.1));
    }
    return p;
}

/* Short at finger tips. */
static double skin_spacing(const void *ctx, vec3 p)
{
    const hand_skeleton *s = ctx;
    double tip = 1e9;

    for (int i = 0; i < DIGITS; i++)
        tip = fmin(tip, dist(p, s->joint[i][3]));
    return fmin(fmin(4.3 + 0.05 * tip, 8.2), 7.3 + 0.03 * (s->cut_x - p.x));
}

surface_skin hand_shape_skin(const hand_skeleton *s)
{
    return (surface_skin){ "synthetic hand", s, skin_distance, skin_normal, skin_snap, skin_spacing };
}
