/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/point_pairs/shapes.h"

#include "libtensor/geometry/mesh/surface.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <stdlib.h>

enum { ROWS = 16, COLUMNS = 24, PARTS = 3, KNOTS = 5 };
#define PI 3.14159265358979323846

/* ---- shapes ---- */

typedef enum { BALL, RING, BOTTLE, PROFILES } profile;

/* A profile (radius and height) that goes round an outline, a superellipse. */
typedef struct {
    profile kind;
    double power, outline;          /* exponents: 1 is round, 0.2 almost square, 2 almost a diamond */
    double ring;                    /* from the axis to the middle of a ring */
    double knot[KNOTS];             /* radii of a bottle, from its bottom on */
    double size[3], taper, bend;
    double R[9], t[3];
} part;

static void turn_at_random(lt_rng *rng, double R[9])
{
    double q[4];

    for (int i = 0; i < 4; i++)
        q[i] = lt_rng_normal(rng);
    lt_rot_from_quat(q, R);
}

/* The first part is as large as the shape; others stick to it. */
static part draw_part(lt_rng *rng, bool first)
{
    const double share = first ? 1 : lt_rng_range(rng, 0.25, 0.7);
    part p = { .kind = (profile)lt_rng_below(rng, PROFILES) };

    p.power = exp(lt_rng_range(rng, log(0.15), log(1.8)));
    p.outline = exp(lt_rng_range(rng, log(0.15), log(1.8)));
    p.ring = lt_rng_range(rng, 1.2, 4);
    for (int i = 0; i < KNOTS; i++)
        p.knot[i] = lt_rng_range(rng, 0.25, 1);
    for (int k = 0; k < 3; k++)
        p.size[k] = share * exp(lt_rng_range(rng, log(0.25), 0));
    p.taper = lt_rng_range(rng, -0.6, 0.6);
    p.bend = lt_rng_range(rng, -0.4, 0.4);
    turn_at_random(rng, p.R);
    for (int k = 0; k < 3 && !first; k++)
        p.t[k] = 0.5 * lt_rng_normal(rng);
    return p;
}

/* |x|^power with the sign of x */
static double signed_power(double x, double power)
{
    return copysign(pow(fabs(x), power), x);
}

/* Radius and height at u in [0, 1]: from pole to pole, or once around for a ring. */
static void profile_at(const part *p, double u, double *r, double *z)
{
    const double angle = PI * (u - 0.5), along = u * (KNOTS - 1);
    const int i = along < KNOTS - 2 ? (int)along : KNOTS - 2;

    switch (p->kind) {
    case BALL:
        *r = signed_power(cos(angle), p->power);
        *z = signed_power(sin(angle), p->power);
        break;
    case RING:
        *r = (p->ring + signed_power(cos(2 * PI * u), p->power)) / (p->ring + 1);
        *z = signed_power(sin(2 * PI * u), p->power);
        break;
    default:
        *r = u > 0 && u < 1 ? p->knot[i] + (along - i) * (p->knot[i + 1] - p->knot[i]) : 0;
        *z = 2 * u - 1;
    }
}

static void place(const part *p, double u, double v, float out[3])
{
    double r, z, x[3], y[3];

    profile_at(p, u, &r, &z);
    x[0] = p->size[0] * r * signed_power(cos(2 * PI * v), p->outline) * (1 + p->taper * z) + p->bend * z * z;
    x[1] = p->size[1] * r * signed_power(sin(2 * PI * v), p->outline) * (1 + p->taper * z);
    x[2] = p->size[2] * z;
    lt_rigid_apply(p->R, p->t, x, y);
    for (int k = 0; k < 3; k++)
        out[k] = (float)y[k];
}

/* A grid of ROWS x COLUMNS cells behind what the mesh has. */
static void add_part(const part *p, lt_mesh *mesh)
{
    const int base = mesh->n_vertices;

    for (int i = 0; i <= ROWS; i++)
        for (int j = 0; j <= COLUMNS; j++)
            place(p, (double)i / ROWS, (double)j / COLUMNS, mesh->vertex[mesh->n_vertices++]);
    for (int i = 0; i < ROWS; i++)
        for (int j = 0; j < COLUMNS; j++) {
            const int32_t at = base + i * (COLUMNS + 1) + j, up = at + COLUMNS + 1;
            const int32_t cell[2][3] = { { at, at + 1, up }, { up, at + 1, up + 1 } };
            memcpy(mesh->face[mesh->n_faces], cell, sizeof(cell));
            mesh->n_faces += 2;
        }
}

lt_status shape_draw(lt_arena *arena, lt_rng *rng, lt_mesh *out)
{
    const int parts = 1 + (int)lt_rng_below(rng, PARTS);

    *out = (lt_mesh){ .vertex = lt_arena_array(arena, PARTS * (ROWS + 1) * (COLUMNS + 1), sizeof(*out->vertex)),
                      .face = lt_arena_array(arena, 2 * PARTS * ROWS * COLUMNS, sizeof(*out->face)) };
    if (!out->vertex || !out->face)
        return lt_error(LT_ENOMEM, "no memory for a shape");
    for (int i = 0; i < parts; i++) {
        const part p = draw_part(rng, i == 0);
        add_part(&p, out);
    }
    return LT_OK;
}

/* ---- views ---- */

/* Centre at 0, the farthest point at 1. */
static void to_unit_sphere(float (*p)[3], int n)
{
    double centre[3] = { 0 }, far = 0;

    for (int i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            centre[k] += p[i][k] / (double)n;
    for (int i = 0; i < n; i++) {
        const double d[3] = { p[i][0] - centre[0], p[i][1] - centre[1], p[i][2] - centre[2] };
        far = fmax(far, lt_vec3_norm(d));
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            p[i][k] = (float)((p[i][k] - centre[k]) / far);
}

static double along(const float p[3], const double axis[3])
{
    return p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2];
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* Of 2 n points the first n on the near side of a plane that has at least half of them there. */
static lt_status cut(lt_arena *scratch, float (*p)[3], int n, lt_rng *rng)
{
    double axis[3] = { lt_rng_normal(rng), lt_rng_normal(rng), lt_rng_normal(rng) };
    double *height = lt_arena_array(scratch, 2 * (size_t)n, sizeof(*height)), limit;
    int kept = 0;

    if (!height)
        return lt_error(LT_ENOMEM, "no memory for a view");
    lt_vec3_unit(axis);
    for (int i = 0; i < 2 * n; i++)
        height[i] = along(p[i], axis);
    qsort(height, 2 * (size_t)n, sizeof(*height), ascending);
    limit = height[n - 1 + (int)lt_rng_below(rng, (uint32_t)n + 1)];
    for (int i = 0; kept < n; i++)
        if (along(p[i], axis) <= limit)
            memcpy(p[kept++], p[i], sizeof(*p));
    return LT_OK;
}

lt_status shape_view(lt_arena *scratch, const lt_mesh *mesh, lt_rng *rng, int n, lt_real (*out)[3])
{
    static const double JITTER = 0.01;
    float (*p)[3] = lt_arena_array(scratch, 2 * (size_t)n, sizeof(*p));
    lt_status st = p ? lt_mesh_sample(mesh, rng, 2 * n, p, NULL) : lt_error(LT_ENOMEM, "no memory for a view");
    double R[9], scale;

    if (st)
        return st;
    to_unit_sphere(p, 2 * n);
    st = cut(scratch, p, n, rng);
    if (st)
        return st;
    turn_at_random(rng, R);
    scale = lt_rng_range(rng, 0.8, 1.25);
    for (int i = 0; i < n; i++) {
        const double x[3] = { p[i][0], p[i][1], p[i][2] };
        double y[3];

        lt_mat3_mulvec(R, x, y);
        for (int k = 0; k < 3; k++)
            out[i][k] = (lt_real)(scale * y[k] + JITTER * lt_rng_normal(rng));
    }
    return LT_OK;
}
