/* SPDX-License-Identifier: Apache-2.0 */
/* What a graph is timed with: a hand and an object as they are before training, side by side half a metre away. */
#include "models/hogs/hogs.h"

#include "libtensor/base/rng.h"

#include <math.h>
#include <string.h>

static const double DEPTH = 0.55, APART = 0.05;                 /* metres */

static void fill_camera(const hogs *m, lt_real *x)
{
    x[0] = x[1] = (lt_real)m->config.width;                     /* as wide as a webcam sees */
    x[2] = (lt_real)(m->config.width / 2.0);
    x[3] = (lt_real)(m->config.height / 2.0);
}

/* n identities (3, columns), so far to the right */
static void fill_frames(lt_real *x, int64_t n, int columns, double right, double depth)
{
    for (int64_t i = 0; i < n; i++)
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < columns; c++)
                x[(i * 3 + r) * columns + c] = (lt_real)(c < 3 ? r == c : r == 0 ? right : r == 2 ? depth : 0);
}

/* Each a little further to the right */
static void fill_bones(lt_real *x)
{
    for (int b = 0; b < SKIN_FIELD_BONES; b++)
        fill_frames(x + 12 * b, 1, 4, -APART + 0.001 * b, DEPTH);
}

static void fill_uniform(lt_real *x, int64_t n, double lo, double hi)
{
    lt_rng rng = lt_rng_make(1, (uint64_t)n);

    for (int64_t i = 0; i < n; i++)
        x[i] = (lt_real)lt_rng_range(&rng, lo, hi);
}

static void fill_integers(lt_real *x, int64_t n, int32_t value, int32_t step)
{
    int32_t *i = (int32_t *)x;

    for (int64_t k = 0; k < n; k++)
        i[k] = value + (int32_t)k * step;
}

/* Rows in use, of the first hand and the first object */
static void fill_alive(const hogs *m, bool object, lt_real *x)
{
    const int64_t N = gaussians_capacity(&m->gaussians);
    const int64_t n = gaussians_count(&m->gaussians, object ? m->config.hands : 0);

    for (int64_t i = 0; i < N; i++)
        x[i] = i < n;
}

/* Each with the four behind it; rows that are not in use with themselves */
static void fill_near(const hogs *m, bool object, lt_real *x)
{
    const int64_t N = gaussians_capacity(&m->gaussians);
    const int64_t n = gaussians_count(&m->gaussians, object ? m->config.hands : 0);
    int32_t *near = (int32_t *)x;

    for (int64_t i = 0; i < N; i++)
        for (int64_t k = 0; k < HOGS_NEIGHBOURS; k++)
            near[i * HOGS_NEIGHBOURS + k] = (int32_t)(i < n ? (i + 1 + k) % n : i);
}

static void fill_boxes(const hogs *m, lt_real *x)
{
    const double side = m->config.small ? 75 : 150;             /* what hands take of such frames */

    for (int i = 0; i < HOGS_IMAGES; i++) {
        x[4 * i] = x[4 * i + 1] = 20;
        x[4 * i + 2] = x[4 * i + 3] = (lt_real)(20 + side);
    }
}

static void fill_grid(lt_real *x)
{
    for (int k = 0; k < 3; k++) {
        x[k] = (lt_real)-0.055;
        x[3 + k] = (lt_real)(OCCUPANCY_SIDE / 0.11);
    }
}

typedef enum {
    ZEROS, UNIT, CAMERA, BONES, VIEW, POSE, TRANSLATION, ALIVE_HAND, ALIVE_OBJECT, PLACES, ROW_OBJECT, DEGREE, DRAWN,
    COUNT, POINTS, JOINTS, NEAR_HAND, NEAR_OBJECT, BOXES, ONES, SMALL, GRID, NO_CELLS,
} filling;

static const struct { const char *input; filling by; int64_t n; } table[] = {
    { "camera", CAMERA, 0 }, { "bones", BONES, 0 }, { "view", VIEW, 0 }, { "rotation", POSE, 0 },
    { "true_rotation", POSE, 0 }, { "translation", TRANSLATION, 0 }, { "true_translation", TRANSLATION, 0 },
    { "hand_alive", ALIVE_HAND, 0 }, { "object_alive", ALIVE_OBJECT, 0 }, { "hand_place", PLACES, 2 },
    { "object_place", PLACES, 2 }, { "hand_set", ZEROS, 1 }, { "object_set", ZEROS, 1 }, { "hand_row", ZEROS, 1 },
    { "object_row", ROW_OBJECT, 1 }, { "degree", DEGREE, 1 }, { "drawn", DRAWN, 0 }, { "count", COUNT, 1 },
    { "start", ZEROS, 1 }, { "root", TRANSLATION, 0 }, { "started", ONES, 1 },
    { "frame_code", ZEROS, 1 }, { "articulation", JOINTS, 0 },
    { "hand_near", NEAR_HAND, 0 }, { "object_near", NEAR_OBJECT, 0 },
    { "lpips_boxes", BOXES, 0 }, { "pose_weight", ONES, 1 }, { "offset", SMALL, 3 },
    { "corners", SMALL, 3 * HOGS_CORNERS }, { "hand_points", POINTS, HOGS_CONTACT_POINTS },
    { "zones", ZEROS, HOGS_CONTACT_POINTS }, { "surface", SMALL, 3 * HOGS_SURFACE_POINTS }, { "grid", GRID, 0 },
    { "inside", NO_CELLS, 0 }, { "skin_points", SMALL, 3 * HOGS_SKIN_POINTS },
    { "skin_weights", SMALL, SKIN_FIELD_BONES * HOGS_SKIN_POINTS }, { "hand_offset", ZEROS, -2 },
    { "object_offset", ZEROS, -2 }, { "points", POINTS, -1 }, { "rgb", UNIT, -3 }, { "image", UNIT, 0 },
    { "target", UNIT, 0 },
};

static int64_t size_of(const hogs *m, const char *input, int64_t n)
{
    const int64_t crop = m->sizes.crop;

    if (strcmp(input, "image") == 0)
        return 3 * crop * crop;
    if (strcmp(input, "target") == 0)
        return (int64_t)HOGS_TARGETS * m->config.width * m->config.height;
    return n < 0 ? -n * m->sizes.gpm_points : n;
}

static void fill_points(lt_real *x, int64_t n)
{
    fill_uniform(x, 3 * n, -APART, APART);
    for (int64_t i = 0; i < n; i++)
        x[3 * i + 2] += (lt_real)DEPTH;
}

static void fill_by(const hogs *m, filling by, int64_t n, lt_real *x)
{
    const int64_t N = gaussians_capacity(&m->gaussians), P = m->sizes.gpm_points;

    switch (by) {
    case ZEROS: memset(x, 0, (size_t)n * sizeof(*x)); break;
    case UNIT: fill_uniform(x, n, 0, 1); break;
    case CAMERA: fill_camera(m, x); break;
    case BONES: fill_bones(x); break;
    case VIEW: fill_frames(x, 1, 4, 0, 0); break;
    case POSE: fill_frames(x, 1, 3, 0, 0); break;
    case TRANSLATION: x[0] = (lt_real)APART, x[1] = 0, x[2] = (lt_real)DEPTH; break;
    case ALIVE_HAND: fill_alive(m, false, x); break;
    case ALIVE_OBJECT: fill_alive(m, true, x); break;
    case PLACES: fill_uniform(x, n * N, 0, m->sizes.map - 1); break;
    case ROW_OBJECT: fill_integers(x, 1, (int32_t)gaussians_first(&m->gaussians, m->config.hands), 0); break;
    case DEGREE: fill_integers(x, 1, 3, 0); break;
    case DRAWN: fill_integers(x, P, 0, 1); break;
    case COUNT: fill_integers(x, 1, (int32_t)P, 0); break;
    case POINTS: fill_points(x, n); break;
    case JOINTS: fill_uniform(x, AVATAR_JOINTS * AVATAR_JOINT, -1, 1); break;
    case NEAR_HAND: fill_near(m, false, x); break;
    case NEAR_OBJECT: fill_near(m, true, x); break;
    case BOXES: fill_boxes(m, x); break;
    case ONES: x[0] = 1; break;
    case SMALL: fill_uniform(x, n, -0.05, 0.05); break;
    case GRID: fill_grid(x); break;
    case NO_CELLS: memset(x, 0, OCCUPANCY_CELLS); break;
    }
}

void hogs_fill(const model *self, const char *input, lt_real *x)
{
    const hogs *m = self->self;

    for (size_t i = 0; i < LT_COUNT(table); i++)
        if (strcmp(input, table[i].input) == 0)
            fill_by(m, table[i].by, size_of(m, input, table[i].n), x);
}
