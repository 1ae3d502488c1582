/* SPDX-License-Identifier: Apache-2.0 */
/* What of a crop stays, and backgrounds drawn from random numbers. */
#include "data/background.h"

#include "vision/crop.h"

#include <math.h>

/* ---- what stays ---- */

/* 1 where hand or object is at whole place (x, y); 0 elsewhere and outside. */
static double mask_at(const dataset_sample *s, double x, double y)
{
    if (!(x >= 0 && x < s->segments_width && y >= 0 && y < s->segments_height))
        return 0;
    return s->segments[(size_t)y * (size_t)s->segments_width + (size_t)x] != 0;
}

/* Weights of the cells before, at and after u, whose centres are at half numbers: a quadratic B-spline. */
static void spline(double u, double w[3])
{
    const double f = u - floor(u);

    w[0] = (1 - f) * (1 - f) / 2;
    w[2] = f * f / 2;
    w[1] = 1 - w[0] - w[2];
}

/* The mask's steps smoothed away by the nine cells around (u, v), and its edge then made half as wide. */
static double mask_between(const dataset_sample *s, double u, double v)
{
    double wx[3], wy[3], sum = 0;

    spline(u, wx);
    spline(v, wy);
    for (int i = 0; i < 9; i++)
        sum += wy[i / 3] * wx[i % 3] * mask_at(s, floor(u) + i % 3 - 1, floor(v) + i / 3 - 1);
    return fmax(0, fmin(1, 2 * sum - 0.5));
}

static void keep_mask(const dataset_sample *s, const double back[6], float *out, int size)
{
    const double sx = (double)s->segments_width / s->width, sy = (double)s->segments_height / s->height;

    for (int y = 0; y < size; y++)
        for (int x = 0; x < size; x++) {
            double p[2];
            crop_place(back, x, y, p);
            out[(size_t)y * (size_t)size + (size_t)x] = (float)mask_between(s, p[0] * sx, p[1] * sy);
        }
}

static int clamp_int(double v, int lo, int hi)
{
    return v < lo ? lo : v > hi ? hi : (int)v;
}

/* A disc about (u, v) in crop pixels, its edge a pixel wide. */
static void keep_disc(double u, double v, double radius, float *out, int size)
{
    const int x0 = clamp_int(u - radius - 1, 0, size), x1 = clamp_int(u + radius + 1, 0, size);
    const int y0 = clamp_int(v - radius - 1, 0, size), y1 = clamp_int(v + radius + 1, 0, size);

    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++) {
            float *o = &out[(size_t)y * (size_t)size + (size_t)x];
            const double dx = x + 0.5 - u, dy = y + 0.5 - v, inside = radius + 0.5 - sqrt(dx * dx + dy * dy);
            *o = fmaxf(*o, inside > 1 ? 1 : (float)inside);
        }
}

/* A forearm: steps along it in metres, how far it reaches, its radius at the wrist and below the elbow, with a
 * sleeve. Nearer than NEAR the camera would be in it. */
static const double ARM_STEP = 0.015, ARM_LENGTH = 0.6, ARM_WRIST = 0.034, ARM_ELBOW = 0.058, ARM_SWELL = 0.2;
static const double NEAR = 0.1;

static void keep_arm(const dataset_sample *s, const double A[6], float *out, int size)
{
    const double scale = sqrt(fabs(A[0] * A[4] - A[1] * A[3]));

    for (double at = 0; at < ARM_LENGTH; at += ARM_STEP) {
        const double swell = fmin(1, at / ARM_SWELL), radius = ARM_WRIST + swell * (ARM_ELBOW - ARM_WRIST);
        double p[3], uv[2];

        for (int k = 0; k < 3; k++)
            p[k] = s->joints[0][k] + at * s->rotation[0][3 * k];
        if (p[2] < NEAR || !lt_camera_project(&s->camera, p, uv))
            return;
        lt_affine_apply(A, uv, uv);
        keep_disc(uv[0], uv[1], scale * s->camera.fx * radius / p[2], out, size);
    }
}

void background_keep(const dataset_sample *s, const double A[6], float *out, int size)
{
    double back[6];

    crop_inverse(A, back);
    keep_mask(s, back, out, size);
    if ((s->flags & SAMPLE_HAND_POSE) && (s->flags & SAMPLE_JOINTS))
        keep_arm(s, A, out, size);
}

/* ---- surfaces ---- */

/* A number in [0, 1) for a place of the grid. */
static double hash(uint32_t seed, int x, int y)
{
    uint32_t h = seed ^ (uint32_t)x * 0x85ebca6bu ^ (uint32_t)y * 0xc2b2ae35u;

    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (h ^ h >> 16) / 4294967296.0;
}

static double smooth(double t)
{
    return t * t * (3 - 2 * t);
}

/* Value noise: smooth between random numbers at whole places. */
static double noise(uint32_t seed, double x, double y)
{
    const int i = (int)floor(x), j = (int)floor(y);
    const double u = smooth(x - i), v = smooth(y - j);
    const double top = (1 - u) * hash(seed, i, j) + u * hash(seed, i + 1, j);
    const double low = (1 - u) * hash(seed, i, j + 1) + u * hash(seed, i + 1, j + 1);

    return (1 - v) * top + v * low;
}

typedef enum { CLOUDS, GRAIN, STRIPES, CHECKERS, PLAIN, PATTERNS } pattern;

/* Two colours and the pattern that they make, turned by an angle. Lengths are in sides of the crop. */
typedef struct {
    pattern kind;
    float colour[2][3];
    double c, s, scale, rough;      /* cells of the pattern in a side; how much of it is noise */
    uint32_t seed;
} surface;

static surface draw_surface(lt_rng *rng)
{
    surface f = { .kind = (pattern)lt_rng_below(rng, PATTERNS) };
    const double angle = lt_rng_range(rng, -M_PI, M_PI), spread = lt_rng_uniform(rng);
    const double level = lt_rng_range(rng, 0.05, 0.9), tint = lt_rng_range(rng, 0, 0.35);

    for (int k = 0; k < 3; k++) {
        const double first = level + tint * lt_rng_range(rng, -1, 1), other = lt_rng_uniform(rng);
        f.colour[0][k] = (float)first;
        f.colour[1][k] = (float)(first + spread * spread * (other - first));
    }
    f.c = cos(angle);
    f.s = sin(angle);
    f.scale = exp(lt_rng_range(rng, log(2.0), log(24.0)));
    f.rough = lt_rng_range(rng, 0, 0.5);
    f.seed = lt_rng_u32(rng);
    return f;
}

/* Where between its two colours the surface is at (x, y). */
static double pattern_at(const surface *f, double x, double y)
{
    const double u = f->scale * (f->c * x - f->s * y), v = f->scale * (f->s * x + f->c * y);

    switch (f->kind) {
    case CLOUDS: return 0.6 * noise(f->seed, u, v) + 0.4 * noise(f->seed + 1, 2.3 * u, 2.3 * v);
    case GRAIN: return 0.5 * noise(f->seed, 0.2 * u, 2 * v) + 0.5 * noise(f->seed + 1, 0.5 * u, 6 * v);
    case STRIPES: return u - floor(u) < 0.5;
    case CHECKERS: return ((int)floor(u) + (int)floor(v)) & 1;
    default: return 0.5;
    }
}

static void surface_at(const surface *f, double x, double y, float out[3])
{
    const double uneven = noise(f->seed + 2, 5 * x, 5 * y);
    const double t = (1 - f->rough) * pattern_at(f, x, y) + f->rough * uneven;

    for (int k = 0; k < 3; k++)
        out[k] = f->colour[0][k] + (float)t * (f->colour[1][k] - f->colour[0][k]);
}

/* ---- the scene ---- */

enum { MOST_THINGS = 8 };

/* A box or an ellipse, turned, with a surface of its own, lit from one side. */
typedef struct {
    surface look;
    double x, y, c, s, half_width, half_height, shade;
    bool round;
} thing;

/* Two surfaces that meet in a line, such as wall and table; things; light that falls off; the sensor's grain. */
typedef struct {
    surface wall, table;
    double nx, ny, edge;            /* table where nx x + ny y > edge */
    thing thing[MOST_THINGS];
    int n_things;
    double light[3], grain;         /* factor light[0] + light[1] x + light[2] y */
    uint32_t seed;
} scene;

static thing draw_thing(lt_rng *rng)
{
    thing t = { .look = draw_surface(rng) };
    const double angle = lt_rng_range(rng, 0, M_PI), size = exp(lt_rng_range(rng, log(0.03), log(0.3)));
    const double slim = lt_rng_range(rng, 0.3, 1);

    t.x = lt_rng_uniform(rng);
    t.y = lt_rng_uniform(rng);
    t.c = cos(angle);
    t.s = sin(angle);
    t.half_width = size;
    t.half_height = size * slim;
    t.shade = lt_rng_range(rng, -0.5, 0.5);
    t.round = lt_rng_below(rng, 2);
    return t;
}

static scene draw_scene(lt_rng *rng)
{
    const double angle = lt_rng_range(rng, -M_PI, M_PI), from = lt_rng_range(rng, -M_PI, M_PI);
    const double fall = lt_rng_range(rng, 0, 0.6);
    scene s;

    s.wall = draw_surface(rng);
    s.table = draw_surface(rng);
    s.nx = cos(angle);
    s.ny = sin(angle);
    s.edge = (s.nx + s.ny) / 2 + lt_rng_range(rng, -0.6, 0.6);
    s.n_things = (int)lt_rng_below(rng, MOST_THINGS + 1);
    for (int i = 0; i < s.n_things; i++)
        s.thing[i] = draw_thing(rng);
    s.light[0] = lt_rng_range(rng, 0.7, 1.2) - fall * (cos(from) + sin(from)) / 2;
    s.light[1] = fall * cos(from);
    s.light[2] = fall * sin(from);
    s.grain = lt_rng_range(rng, 0, 0.06);
    s.seed = lt_rng_u32(rng);
    return s;
}

/* The thing's colour where (x, y) is in it. */
static bool thing_at(const thing *t, double x, double y, float out[3])
{
    const double u = (t->c * (x - t->x) + t->s * (y - t->y)) / t->half_width;
    const double v = (t->c * (y - t->y) - t->s * (x - t->x)) / t->half_height;

    if (t->round ? u * u + v * v > 1 : fabs(u) > 1 || fabs(v) > 1)
        return false;
    surface_at(&t->look, x, y, out);
    for (int k = 0; k < 3; k++)
        out[k] *= (float)(1 + t->shade * u);
    return true;
}

static void scene_at(const scene *s, double x, double y, float out[3])
{
    const float light = (float)(s->light[0] + s->light[1] * x + s->light[2] * y);
    int i = s->n_things;

    while (i > 0 && !thing_at(&s->thing[i - 1], x, y, out))
        i--;
    if (i == 0)
        surface_at(s->nx * x + s->ny * y > s->edge ? &s->table : &s->wall, x, y, out);
    for (int k = 0; k < 3; k++)
        out[k] *= light;
}

void background_draw(const float *keep, int size, lt_rng *rng, float *image)
{
    const size_t plane = (size_t)size * (size_t)size;
    const scene s = draw_scene(rng);

    for (int y = 0; y < size; y++)
        for (int x = 0; x < size; x++) {
            const size_t i = (size_t)y * (size_t)size + (size_t)x;
            const float grain = (float)(s.grain * (hash(s.seed, x, y) - 0.5));
            float c[3];
            if (keep[i] >= 1)
                continue;
            scene_at(&s, (x + 0.5) / size, (y + 0.5) / size, c);
            for (size_t k = 0; k < 3; k++) {
                float *o = &image[k * plane + i];
                *o = keep[i] * *o + (1 - keep[i]) * fmaxf(0, fminf(1, c[k] + grain));
            }
        }
}
