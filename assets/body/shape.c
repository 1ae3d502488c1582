/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The skin of the synthetic body as a signed distance: a smooth union of rounded cones, flattened in the trunk, and
 * ellipsoids for what lies on them. Points of the left half are looked up in the right one.
 */
#include "assets/body/internal.h"
#include "assets/surface/solids.h"

/* A cone whose sections are `wide` times as broad (x) as deep (z), or, over `wide` in y, as high; never too large. */
static double broad_cone(vec3 p, vec3 a, vec3 b, double ra, double rb, double wide)
{
    return round_cone(vec(p.x / wide, p.y, p.z), vec(a.x / wide, a.y, a.z), vec(b.x / wide, b.y, b.z), ra, rb);
}

static double ball(vec3 p, vec3 centre, vec3 radii)
{
    return ellipsoid(p, centre, vec(1, 0, 0), vec(0, 1, 0), radii);
}

static double smooth_max(double a, double b, double k) { return -smooth_min(-a, -b, k); }

/* ---- head -------------------------------------------------------------------------------------------- */

static double ear(vec3 p)
{
    return ellipsoid(p, vec(-80, 1578, -12), vec(0.85, 0, 0.5), vec(0, 1, -0.15), vec(10, 33, 19));
}

static double nose(vec3 p)
{
    const double ridge = round_cone(p, vec(0, 1588, 88), vec(0, 1555, 112), 7.5, 10.5);
    const double wing = round_cone(p, vec(0, 1553, 106), vec(-12, 1550, 97), 8.5, 7.5);

    return smooth_min(ridge, wing, 6);
}

static double lips(vec3 p)
{
    const double upper = round_cone(p, vec(0, 1523, 96), vec(-25, 1518, 83), 6.2, 3.5);
    const double lower = round_cone(p, vec(0, 1512.5, 94), vec(-23, 1517, 83), 7, 3.5);

    return fmin(upper, lower);
}

static double head(vec3 p)
{
    double d = ball(p, vec(0, 1615, -8), vec(77, 88, 98));

    d = smooth_min(d, ball(p, vec(0, 1560, 20), vec(66, 80, 76)), 30);          /* face */
    d = smooth_min(d, round_cone(p, vec(-50, 1528, 18), vec(0, 1492, 72), 20, 19), 26);     /* jaw */
    d = smooth_min(d, ball(p, vec(-40, 1560, 62), vec(24, 20, 20)), 20);        /* cheek */
    d = smooth_min(d, round_cone(p, vec(-6, 1612, 80), vec(-46, 1612, 62), 12, 12), 16);    /* brow */
    d = smooth_min(d, nose(p), 7);
    d = smooth_min(d, lips(p), 5);
    d = smooth_max(d, -ball(p, vec(-32, 1591, 99), vec(19, 11, 12)), 9);        /* socket */
    d = smooth_min(d, ball(p, vec(-32, 1591, 73), vec(18, 15, 16.5)), 3);       /* lids */
    return smooth_min(d, ear(p), 5);
}

static double neck(vec3 p)
{
    const double tube = round_cone(p, vec(0, 1425, -24), vec(0, 1535, -8), 59, 54);
    const double nape = round_cone(p, vec(0, 1445, -45), vec(-115, 1408, -34), 38, 30);      /* trapezius */

    return smooth_min(tube, nape, 40);
}

/* ---- trunk ------------------------------------------------------------------------------------------- */

static double trunk(vec3 p)
{
    double d = broad_cone(p, vec(0, 930, -8), vec(0, 1010, -4), 104, 100, 1.45);

    d = smooth_min(d, broad_cone(p, vec(0, 1010, 0), vec(0, 1120, 2), 98, 90, 1.42), 50);
    d = smooth_min(d, broad_cone(p, vec(0, 1120, 0), vec(0, 1275, 0), 90, 96, 1.42), 50);
    d = smooth_min(d, broad_cone(p, vec(0, 1275, -4), vec(0, 1375, -18), 96, 66, 1.5), 50);
    d = smooth_min(d, round_cone(p, vec(-40, 1392, -20), vec(-172, 1390, -20), 48, 56), 50);  /* shoulder girdle */
    d = smooth_min(d, ball(p, vec(-64, 1305, 56), vec(60, 50, 32)), 60);       /* chest */
    return smooth_min(d, ball(p, vec(-72, 915, -58), vec(72, 78, 66)), 60);    /* seat */
}

/* ---- limbs ------------------------------------------------------------------------------------------- */

static double leg(const body_skeleton *s, vec3 p)
{
    const vec3 hip = s->joint[BODY_HIP + 1], knee = s->joint[BODY_KNEE + 1], ankle = s->joint[BODY_ANKLE + 1];
    double d = round_cone(p, add(hip, vec(-2, -20, -4)), add(knee, vec(0, 60, -4)), 86, 58);

    d = smooth_min(d, round_cone(p, add(knee, vec(0, 70, -4)), add(knee, vec(0, -60, -8)), 57, 50), 60);
    d = smooth_min(d, round_cone(p, add(knee, vec(0, -70, -16)), add(ankle, vec(0, 190, -2)), 52, 46), 60);
    return smooth_min(d, round_cone(p, add(ankle, vec(0, 230, -2)), ankle, 46, 35), 40);
}

static double foot(const body_skeleton *s, vec3 p)
{
    const vec3 ankle = s->joint[BODY_ANKLE + 1];
    double d = round_cone(p, ankle, vec(-101, 34, -52), 35, 34);

    d = smooth_min(d, round_cone(p, add(ankle, vec(0, -10, 20)), vec(-106, 22, 95), 38, 24), 24);
    d = smooth_min(d, round_cone(p, vec(-106, 26, -45), vec(-132, 16, 80), 31, 21), 24);      /* outer edge */
    d = smooth_min(d, round_cone(p, vec(-108, 22, 95), vec(-99, 15, 156), 23, 16), 14);       /* big toe */
    d = smooth_min(d, round_cone(p, vec(-128, 17, 85), vec(-139, 12, 128), 20, 12), 18);      /* small toes */
    d = smooth_min(d, round_cone(p, vec(-115, 17, 120), vec(-122, 13, 145), 16, 13), 12);
    return smooth_max(d, -p.y, 8);                                              /* sole */
}

static double arm(const body_skeleton *s, vec3 p)
{
    const vec3 shoulder = s->joint[BODY_SHOULDER + 1], elbow = s->joint[BODY_ELBOW + 1];
    const vec3 wrist = s->joint[BODY_WRIST + 1];
    double d = round_cone(p, add(shoulder, vec(0, -2, 0)), add(shoulder, vec(-80, -6, 0)), 57, 49);

    d = smooth_min(d, round_cone(p, add(shoulder, vec(-80, -6, 0)), elbow, 48, 40), 40);
    d = smooth_min(d, round_cone(p, add(elbow, vec(20, 0, 0)), add(elbow, vec(-65, 0, 0)), 38, 41), 30);
    d = smooth_min(d, round_cone(p, add(elbow, vec(-65, 0, 0)), add(wrist, vec(-10, -0.5, -2)), 41, 18), 30);
    return smooth_min(d, ball(p, add(wrist, vec(14, -0.5, -2)), vec(150, 19, 28)), 12);       /* as the hand begins */
}

static double body_shape_distance(const body_skeleton *s, vec3 p)
{
    double d;

    p.x = -fabs(p.x);
    if (p.x < -330)
        return arm(s, p);
    if (p.y < 700)
        return smooth_min(leg(s, p), foot(s, p), 20);
    if (p.y > 1480)
        d = smooth_min(head(p), neck(p), 18);
    else
        d = p.y > 1330 ? smooth_min(smooth_min(head(p), neck(p), 18), trunk(p), 40) : trunk(p);
    if (p.y < 1200)
        d = smooth_min(d, leg(s, p), 36);
    return p.y < 1480 && p.y > 1100 ? smooth_min(d, arm(s, p), 28) : d;
}

/* ---- as a skin --------------------------------------------------------------------------------------- */

static double skin_distance(const void *ctx, vec3 p) { return body_shape_distance(ctx, p); }

/* By differences at the corners of a tetrahedron. */
static vec3 gradient(const body_skeleton *s, vec3 p)
{
    static const vec3 corner[4] = { { 1, 1, 1 }, { 1, -1, -1 }, { -1, 1, -1 }, { -1, -1, 1 } };
    const double h = 0.1;
    vec3 g = { 0, 0, 0 };

    for (int i = 0; i < 4; i++)
        g = madd(g, corner[i], body_shape_distance(s, madd(p, corner[i], h)) / (4 * h));
    return g;
}

static vec3 skin_normal(const void *ctx, vec3 p) { return unit(gradient(ctx, p)); }

static const double LID_WIDE = 15, LID_HIGH = 8;        /* half of the opening */

static double in_lids(const body_skeleton *s, vec3 p)
{
    return hypot((p.x - s->eye.x) / LID_WIDE, (p.y - s->eye.y) / LID_HIGH);
}

bool body_shape_in_eye(const void *skeleton, vec3 p)
{
    const body_skeleton *s = skeleton;

    return p.z > s->eye.z && in_lids(s, p) < 1;
}

static vec3 to_rim(const body_skeleton *s, vec3 p, int rim)
{
    if (rim == RIM_MIDDLE)
        p.x = 0;
    else if (rim == RIM_WRIST)
        p.x = s->wrist_cut;
    else if (rim == RIM_EYE) {
        const double k = 1 / fmax(in_lids(s, p), 0.05);

        p.x = s->eye.x + k * (p.x - s->eye.x);
        p.y = s->eye.y + k * (p.y - s->eye.y);
    }
    return p;
}

static vec3 skin_snap(const void *ctx, vec3 p, int rim)
{
    const body_skeleton *s = ctx;

    for (int i = 0; i < 5; i++) {               /* Newton; the field is no distance where it is flattened */
        double d;
        vec3 g;

        p = to_rim(s, p, rim);
        d = body_shape_distance(s, p);
        if (fabs(d) < 1e-3)
            break;
        g = gradient(s, p);
        if (rim == RIM_MIDDLE || rim == RIM_WRIST)
            g.x = 0;
        if (rim == RIM_EYE)
            g.x = g.y = 0;
        p = madd(p, g, -d / fmax(dot(g, g), 0.1));
    }
    return to_rim(s, p, rim);
}

/* Short in the face, at the wrist, which has the hand's edges, and at the feet. */
static double skin_spacing(const void *ctx, vec3 p)
{
    const body_skeleton *s = ctx;
    const double face = dist(p, vec(0, 1560, 100)), wrist = fabs(p.x) - fabs(s->wrist_cut);
    double h = 22;

    h = fmin(h, fmax(5.5, 5.5 + 0.06 * (face - 60)));
    h = fmin(h, 7.5 - 0.09 * wrist);
    h = fmin(h, fmax(9, 9 + 0.05 * (p.y - 60)));
    return h;
}

surface_skin body_shape_skin(const body_skeleton *s)
{
    return (surface_skin){ "synthetic body", s, skin_distance, skin_normal, skin_snap, skin_spacing };
}
