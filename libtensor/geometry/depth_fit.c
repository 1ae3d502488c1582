/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/geometry/depth_fit.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/surface.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/geometry/solve6.h"

#include <limits.h>

enum { POINTS = 800, STARTS = 7, STEPS = 15, ROUNDS = 12, FEWEST = 30 };

static const double TURN = 25 * M_PI / 180;
static const double STEP = 0.01, NEAR = 0.01;           /* metres */
static const double WIDEST = 0.04, NARROWEST = 0.008;   /* bound of a pair's distance, first and last */
static const double STIFFNESS = 1e-3;                   /* of motions that no pair speaks of, in parts of the pairs' */
static const double LEVER = 0.05;           /* metres that a radian moves a point by, roughly */

/* ---- the surface ------------------------------------------------------------------------------------------------ */

lt_status lt_surface_of(lt_arena *arena, const lt_mesh *mesh, lt_surface *out, lt_surface *mirrored)
{
    const int n = (int)lt_min_i64(POINTS, mesh->n_vertices);
    float (*normal)[3] = lt_arena_array(arena, (size_t)mesh->n_vertices, sizeof(*normal));
    float (*copy)[3] = lt_arena_array(arena, 4 * (size_t)n, sizeof(*copy));

    if (!normal || !copy)
        return lt_error(LT_ENOMEM, "no memory for a surface of %d vertices", mesh->n_vertices);
    lt_mesh_normals(mesh, normal);
    *out = (lt_surface){ n, copy, copy + n };
    *mirrored = (lt_surface){ n, copy + 2 * n, copy + 3 * n };
    for (int i = 0; i < n; i++) {
        const int64_t v = (int64_t)i * mesh->n_vertices / n;

        for (int k = 0; k < 3; k++) {
            const float sign = k ? 1 : -1;

            out->point[i][k] = mesh->vertex[v][k];
            out->normal[i][k] = normal[v][k];
            mirrored->point[i][k] = sign * mesh->vertex[v][k];
            mirrored->normal[i][k] = sign * normal[v][k];
        }
    }
    return LT_OK;
}

/* A point as the camera sees it, and how far behind it is what its pixel measures */
typedef struct { double at[3], normal[3], behind; } sight;

/* Whether the point faces the camera and its pixel has measured something */
static bool see(const lt_depth_map *d, const lt_surface *s, const lt_pose *pose, int i, sight *out)
{
    const double x[3] = { s->point[i][0], s->point[i][1], s->point[i][2] };
    const double n[3] = { s->normal[i][0], s->normal[i][1], s->normal[i][2] };
    double uv[2], z;

    lt_pose_apply(pose, 1, x, out->at);
    lt_mat3_mulvec(pose->R, n, out->normal);
    if (!(lt_vec3_dot(out->normal, out->at) < 0) || !lt_camera_project(&d->camera, out->at, uv))
        return false;
    if (!(uv[0] > -0.5 && uv[0] < d->width - 0.5 && uv[1] > -0.5 && uv[1] < d->height - 0.5))
        return false;
    z = (double)d->metres[lrint(uv[1]) * d->width + lrint(uv[0])];
    out->behind = z - out->at[2];
    return z > 0;
}

/* ---- how well a pose agrees ------------------------------------------------------------------------------------- */

typedef struct { int facing, near, before; } agreement;

static agreement agree(const lt_depth_map *d, const lt_surface *s, const lt_pose *pose)
{
    agreement a = { 0 };

    for (int i = 0; i < s->n; i++) {
        sight v;

        if (!see(d, s, pose, i, &v))
            continue;
        a.facing++;
        a.near += fabs(v.behind) <= NEAR;
        a.before += v.behind > NEAR;
    }
    return a;
}

/* The pose moved along the line of sight to where it agrees best, of equal ones the nearest */
static lt_pose at_best_distance(const lt_depth_map *d, const lt_surface *s, const lt_pose *pose)
{
    const double distance = lt_vec3_norm(pose->t);
    lt_pose best = *pose;
    int most = INT_MIN;

    for (int k = 0; k <= 2 * STEPS; k++) {
        const double by = STEP * (k % 2 ? (k + 1) / 2 : -k / 2);
        lt_pose moved = *pose;
        agreement a;

        for (int i = 0; i < 3; i++)
            moved.t[i] *= 1 + by / distance;
        a = agree(d, s, &moved);
        if (a.near - a.before > most) {
            most = a.near - a.before;
            best = moved;
        }
    }
    return best;
}

/* ---- iterated closest points ------------------------------------------------------------------------------------ */

/* S m = b of a motion m: a turn about the model's origin, radians times LEVER, and a shift */
typedef struct { double S[6][6], b[6], weight; int pairs; } equations;

static void add_pair(const lt_pose *pose, const sight *s, double within, equations *e)
{
    double gap[3], arm[3], J[6], square, left, weight;

    for (int k = 0; k < 3; k++)
        gap[k] = s->at[k] * s->behind / s->at[2];               /* to what was measured, along the line of sight */
    square = lt_vec3_dot(gap, gap) / (within * within);
    if (!(square < 1))
        return;
    weight = (1 - square) * (1 - square);                       /* Tukey's */
    left = lt_vec3_dot(s->normal, gap);
    lt_vec3_sub(s->at, pose->t, arm);
    lt_vec3_cross(arm, s->normal, J);
    for (int k = 0; k < 3; k++) {
        J[k] /= LEVER;
        J[3 + k] = s->normal[k];
    }
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j <= i; j++)
            e->S[i][j] += weight * J[i] * J[j];
        e->b[i] += weight * J[i] * left;
    }
    e->weight += weight;
    e->pairs++;
}

static bool move(equations *e, lt_pose *pose)
{
    double turn[3], R[9], turned[9];

    for (int i = 0; i < 6; i++)
        e->S[i][i] += STIFFNESS * e->weight;
    if (e->pairs < FEWEST || !lt_cholesky6(e->S))
        return false;
    lt_solve6(e->S, e->b);
    for (int k = 0; k < 3; k++) {
        turn[k] = e->b[k] / LEVER;
        pose->t[k] += e->b[3 + k];
    }
    lt_rot_from_axis_angle(turn, R);
    lt_mat3_mul(R, pose->R, turned);
    memcpy(pose->R, turned, sizeof(turned));
    return lt_pose_finite(pose);
}

static bool settle(const lt_depth_map *d, const lt_surface *s, lt_pose *pose)
{
    for (int round = 0; round < ROUNDS; round++) {
        const double within = WIDEST * pow(NARROWEST / WIDEST, (double)round / (ROUNDS - 1));
        equations e = { .pairs = 0 };

        for (int i = 0; i < s->n; i++) {
            sight v;

            if (see(d, s, pose, i, &v))
                add_pair(pose, &v, within, &e);
        }
        if (!move(&e, pose))
            return false;
    }
    return true;
}

/* ---- all together ----------------------------------------------------------------------------------------------- */

/* 0: the guess itself; then turned about each axis either way */
static lt_pose start_of(const lt_pose *guess, int which)
{
    const double origin[3] = { 0 };
    double axis[3] = { 0 };
    lt_pose turn;

    if (which == 0)
        return *guess;
    axis[(which - 1) / 2] = 1;
    turn = lt_pose_turn(origin, axis, which % 2 ? TURN : -TURN);
    return lt_pose_compose(guess, &turn);
}

bool lt_depth_fit(const lt_depth_map *depth, const lt_surface *surface, lt_pose *pose)
{
    const lt_pose guess = *pose;
    double best = -INFINITY;

    if (!lt_pose_finite(&guess) || !(lt_vec3_norm(guess.t) > 0) || agree(depth, surface, &guess).facing < FEWEST)
        return false;
    for (int k = 0; k < STARTS; k++) {
        const lt_pose start = start_of(&guess, k);
        lt_pose p = at_best_distance(depth, surface, &start);
        agreement a;

        if (!settle(depth, surface, &p))
            continue;
        a = agree(depth, surface, &p);
        if (a.facing < FEWEST || !((double)(a.near - a.before) / a.facing > best))
            continue;
        best = (double)(a.near - a.before) / a.facing;
        *pose = p;
    }
    return isfinite(best);
}
