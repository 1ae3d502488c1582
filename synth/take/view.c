/* SPDX-License-Identifier: Apache-2.0 */
/* Draws cameras and keeps the one with the fewest faults. */
#include "synth/take/view.h"

#include "libtensor/base/rng.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/mat3.h"

#include <math.h>

enum { WIDTH = 640, HEIGHT = 480, DRAWS = 160, DEAL = 0x4445414c };

static const double NEAREST = 0.40, FARTHEST = 0.90;        /* of the wrist, metres */
static const double SMALLEST = 90, LARGEST = 260;           /* of the joints' box, pixels */
static const double MIDDLE = 0.7;                           /* of the picture */
static const double LOWEST = 0.08;                          /* of the camera above the table */
static const double APART = 0.35;                           /* radians between two cameras */
static const double ARM = 0.6, ARM_CLEAR = 0.25;            /* the arm's length; its distance from the camera */

/* Shares of cameras that look over the hand, and over the object at the hand; the rest may be anywhere.
 * So that each hides much of the other in a part of the pictures, as in HO3D. */
static const double OVER_HAND = 0.43, OVER_OBJECT = 0.44;
static const double OVER_HAND_COSINE = 0.8, OVER_OBJECT_COSINE = -0.35;  /* of camera and hand from the object */

typedef struct { double eye[3], target[3]; synth_camera camera; } candidate;
typedef struct { double lo, hi; } range;

/* ---- drawing ---- */

static void mean_target(const synth_sight *s, int n, double out[3])
{
    for (int k = 0; k < 3; k++) {
        out[k] = 0;
        for (int i = 0; i < n; i++)
            out[k] += (s[i].keypoints[4][k] + s[i].keypoints[0][k] + s[i].object[k]) / (3.0 * n);
    }
}

void synth_view_look(const double eye[3], const double target[3], double roll, synth_camera *out)
{
    static const double up[3] = { 0, 0, 1 };
    double f[3], x[3], y[3], n, *R = out->R_cam_world;

    lt_vec3_sub(target, eye, f);
    n = lt_vec3_norm(f);
    for (int k = 0; k < 3; k++)
        f[k] /= n;
    lt_vec3_cross(f, up, x);
    n = lt_vec3_norm(x);
    for (int k = 0; k < 3; k++)
        x[k] /= n;
    lt_vec3_cross(f, x, y);
    for (int k = 0; k < 3; k++) {
        R[k] = cos(roll) * x[k] + sin(roll) * y[k];
        R[3 + k] = -sin(roll) * x[k] + cos(roll) * y[k];
        R[6 + k] = f[k];
    }
    for (int k = 0; k < 3; k++)
        out->t_cam_world[k] = -lt_vec3_dot(R + 3 * k, eye);
}

static candidate draw(lt_rng *rng, const double target[3])
{
    const double around = lt_rng_range(rng, -1.4, 1.4), above = lt_rng_range(rng, 0.15, 1.1);
    const double away = fmax(0.46, fmin(0.85, 0.58 + 0.09 * lt_rng_normal(rng)));
    const double f = lt_rng_range(rng, 600, 620);
    candidate c = { .camera = { .fx = f, .fy = f * 1.001, .cx = 320 + lt_rng_range(rng, -10, 10),
                                .cy = 240 + lt_rng_range(rng, -10, 10), .width = WIDTH, .height = HEIGHT } };

    c.eye[0] = target[0] + away * sin(around) * cos(above);
    c.eye[1] = target[1] - away * cos(around) * cos(above);
    c.eye[2] = target[2] + away * sin(above);
    for (int k = 0; k < 3; k++)
        c.target[k] = target[k] + lt_rng_range(rng, -0.05, 0.05);
    synth_view_look(c.eye, c.target, fmax(-0.2, fmin(0.2, 0.08 * lt_rng_normal(rng))), &c.camera);
    return c;
}

/* ---- judging ---- */

static double beyond(double x, double lo, double hi)
{
    return x < lo ? lo - x : x > hi ? x - hi : 0;
}

/* The extent of the joints in the picture; false when one is behind the camera. */
static bool joints_box(const candidate *c, const synth_sight *s, double lo[2], double hi[2])
{
    const lt_camera cam = { c->camera.fx, c->camera.fy, c->camera.cx, c->camera.cy };

    lo[0] = lo[1] = INFINITY;
    hi[0] = hi[1] = -INFINITY;
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        double p[3], uv[2];
        lt_rigid_apply(c->camera.R_cam_world, c->camera.t_cam_world, s->keypoints[i], p);
        if (!lt_camera_project(&cam, p, uv) || p[2] < 0.2)
            return false;
        for (int k = 0; k < 2; k++) {
            lo[k] = fmin(lo[k], uv[k]);
            hi[k] = fmax(hi[k], uv[k]);
        }
    }
    return true;
}

/* Cosine of the angle at the object between the camera and the middle of the hand. */
static double hand_before_object(const candidate *c, const synth_sight *s)
{
    double hand[3], eye[3], middle[3];

    for (int k = 0; k < 3; k++)
        middle[k] = (s->keypoints[0][k] + s->keypoints[4][k] + s->keypoints[5][k] * 2) / 4;
    lt_vec3_sub(middle, s->object, hand);
    lt_vec3_sub(c->eye, s->object, eye);
    return lt_vec3_dot(hand, eye) / fmax(1e-9, lt_vec3_norm(hand) * lt_vec3_norm(eye));
}

/* Faults of one moment, each about 1 when it is plain to see. */
static double faults_at(const candidate *c, const synth_sight *s, range side)
{
    static const double size[2] = { WIDTH, HEIGHT };
    double lo[2], hi[2], view[3], away, sum = 0;

    if (!joints_box(c, s, lo, hi))
        return 100;
    for (int k = 0; k < 2; k++) {
        const double edge = (1 - MIDDLE) / 2 * size[k];
        sum += beyond((lo[k] + hi[k]) / 2, edge, size[k] - edge) / 50;
        sum += (beyond(lo[k], 0, size[k]) + beyond(hi[k], 0, size[k])) / 50;
    }
    sum += beyond(fmax(hi[0] - lo[0], hi[1] - lo[1]), SMALLEST, LARGEST) / 50;
    lt_vec3_sub(c->eye, s->keypoints[0], view);
    away = lt_vec3_norm(view);
    sum += beyond(away, NEAREST, FARTHEST) / 0.05;
    sum += fmax(0, lt_vec3_dot(view, s->elbow) / away - 0.6) / 0.1;     /* the arm would hide the hand */
    return sum + beyond(hand_before_object(c, s), side.lo, side.hi) / 0.2;
}

/* How far the camera is from the middle line of the forearm. */
static double arm_distance(const candidate *c, const synth_sight *s)
{
    double view[3], along, d[3];

    lt_vec3_sub(c->eye, s->keypoints[0], view);
    along = fmax(0, fmin(ARM, lt_vec3_dot(view, s->elbow)));
    for (int k = 0; k < 3; k++)
        d[k] = view[k] - along * s->elbow[k];
    return lt_vec3_norm(d);
}

/* Faults of all moments: their mean, but one moment with the arm in the lens is one too many. */
static double faults(const candidate *c, const synth_sight *s, int n, range side,
                     const candidate *others, int n_others, const double target[3])
{
    double sum = beyond(c->eye[2], LOWEST, 10) / 0.01, a[3], b[3];

    for (int i = 0; i < n; i++)
        sum += faults_at(c, &s[i], side) / n + fmax(0, ARM_CLEAR - arm_distance(c, &s[i])) / 0.05;
    lt_vec3_sub(c->eye, target, a);
    for (int i = 0; i < n_others; i++) {
        double angle;
        lt_vec3_sub(others[i].eye, target, b);
        angle = acos(fmax(-1, fmin(1, lt_vec3_dot(a, b) / lt_vec3_norm(a) / lt_vec3_norm(b))));
        sum += fmax(0, APART - angle) * 10;
    }
    return sum;
}

/* Multiples of the golden ratio: any few of them in a row are evenly spread over 0..1. */
static range deal_side(uint64_t seed, int number)
{
    lt_rng rng = lt_rng_make(seed, DEAL);
    const double turn = lt_rng_uniform(&rng) + number * 0.6180339887498949, u = turn - floor(turn);

    if (u < OVER_HAND)
        return (range){ OVER_HAND_COSINE, 1 };
    return u < OVER_HAND + OVER_OBJECT ? (range){ -1, OVER_OBJECT_COSINE } : (range){ -1, 1 };
}

void synth_view_choose(const synth_sight *sight, int n, uint64_t seed, uint64_t stream, int number,
                       int n_cameras, synth_camera *out)
{
    lt_rng rng = lt_rng_make(seed, stream);
    candidate chosen[8];
    double target[3];

    mean_target(sight, n, target);
    for (int i = 0; i < n_cameras; i++) {
        const range side = deal_side(seed, number + i);
        double best = INFINITY;
        for (int k = 0; k < DRAWS && best > 0; k++) {
            const candidate c = draw(&rng, target);
            const double f = faults(&c, sight, n, side, chosen, i, target);
            if (f < best) {
                best = f;
                chosen[i] = c;
            }
        }
        out[i] = chosen[i].camera;
    }
}
