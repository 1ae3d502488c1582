/* SPDX-License-Identifier: Apache-2.0 */
/* A pose laid on depth: of an ellipsoid whose depth image is worked out ray by ray, not drawn from its mesh. */
#include "libtensor/geometry/depth_fit.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

enum { SIDE = 160, RINGS = 40, SPOKES = 40, VERTICES = RINGS * SPOKES, FACES = 2 * (RINGS - 1) * SPOKES };

static const double radius[3] = { 0.03, 0.05, 0.09 };
static const lt_camera camera = { 600, 600, 80, 80 };
static const double WALL = 0.9;

static float vertex[VERTICES][3], metres[SIDE * SIDE];
static int32_t face[FACES][3];
static const lt_mesh mesh = { .n_vertices = VERTICES, .n_faces = FACES, .vertex = vertex, .face = face };
static const lt_depth_map map = { camera, SIDE, SIDE, metres };
static lt_pose truth;
static lt_arena *arena;
static lt_surface surface, mirrored;

static void make_mesh(void)
{
    for (int i = 0; i < RINGS; i++)
        for (int j = 0; j < SPOKES; j++) {
            const double a = M_PI * (i + 0.5) / RINGS, b = 2 * M_PI * j / SPOKES;
            const double x[3] = { sin(a) * cos(b), sin(a) * sin(b), cos(a) };

            for (int k = 0; k < 3; k++)
                vertex[i * SPOKES + j][k] = (float)(radius[k] * x[k]);
        }
    for (int i = 0; i < RINGS - 1; i++)
        for (int j = 0; j < SPOKES; j++) {
            const int32_t a = i * SPOKES + j, b = i * SPOKES + (j + 1) % SPOKES, down = SPOKES;
            int32_t (*f)[3] = &face[2 * a];

            memcpy(f[0], (const int32_t[]){ a, a + down, b }, sizeof(f[0]));
            memcpy(f[1], (const int32_t[]){ b, a + down, b + down }, sizeof(f[1]));
        }
}

/* How far along the ray through a pixel the ellipsoid is: |S^-1 R^T (z ray - t)| = 1, S = diag(radius) */
static double ellipsoid_at(const double ray[3])
{
    double back[9], o[3], d[3], a, b, c;

    lt_mat3_transpose(truth.R, back);
    lt_mat3_mulvec(back, truth.t, o);
    lt_mat3_mulvec(back, ray, d);
    for (int k = 0; k < 3; k++) {
        o[k] /= -radius[k];
        d[k] /= radius[k];
    }
    a = lt_vec3_dot(d, d), b = lt_vec3_dot(o, d), c = lt_vec3_dot(o, o) - 1;
    return b * b < a * c ? INFINITY : (-b - sqrt(b * b - a * c)) / a;
}

static void measure(void)
{
    for (int v = 0; v < SIDE; v++)
        for (int u = 0; u < SIDE; u++) {
            const double uv[2] = { u, v };
            double ray[3];

            lt_camera_backproject(&camera, uv, 1, ray);
            metres[v * SIDE + u] = (float)fmin(WALL, ellipsoid_at(ray));
        }
}

static lt_pose guess(double degrees, double farther, double aside)
{
    const double centre[3] = { 0 }, axis[3] = { 0.6, 0, 0.8 };
    lt_pose turn = lt_pose_turn(centre, axis, degrees * M_PI / 180), p = lt_pose_compose(&truth, &turn);

    for (int k = 0; k < 3; k++)
        p.t[k] *= 1 + farther / lt_vec3_norm(truth.t);
    p.t[0] += aside;
    return p;
}

static void setup(void)
{
    const double aa[3] = { 0.9, -0.4, 0.5 };

    make_mesh();
    truth = (lt_pose){ .t = { 0.01, -0.02, 0.6 } };
    lt_rot_from_axis_angle(aa, truth.R);
    measure();
    arena = lt_arena_new();
    ck_assert_int_eq(lt_surface_of(arena, &mesh, &surface, &mirrored), LT_OK);
}

static void teardown(void)
{
    lt_arena_free(arena);
}

static void expect_truth(const lt_pose *p, double degrees, double metre)
{
    ck_assert_double_lt(lt_rot_angle(truth.R, p->R) * 180 / M_PI, degrees);
    ck_assert_double_lt(lt_vec3_distance(truth.t, p->t), metre);
}

/* A third of a radian off, some centimetres too near or too far, and beside it */
START_TEST(finds_the_pose)
{
    static const double off[][3] = { { 12, 0.06, 0.008 }, { -18, -0.09, 0 }, { 20, 0.13, -0.008 }, { 0, 0, 0 } };
    lt_pose p = guess(off[_i][0], off[_i][1], off[_i][2]);

    ck_assert(lt_depth_fit(&map, &surface, &p));
    expect_truth(&p, 1.5, 0.002);
}
END_TEST

/* A hand before a third of it, two centimetres from it, and noise where nothing was measured */
START_TEST(sees_past_what_hides_it)
{
    lt_pose p = guess(12, 0.05, 0);

    for (int i = 0; i < SIDE * SIDE; i++) {
        if (i % SIDE < 75)
            metres[i] = fminf(metres[i] - 0.02f, 0.55f);
        if (i % 7 == 0)
            metres[i] = 0;
    }
    ck_assert(lt_depth_fit(&map, &surface, &p));
    expect_truth(&p, 3, 0.004);
}
END_TEST

/* In the mirror x -> -x the surface, the picture and the pose are those of a mirrored thing. */
START_TEST(mirror)
{
    static float flipped[SIDE * SIDE];
    const lt_depth_map other = { { 600, 600, SIDE - 1 - 80, 80 }, SIDE, SIDE, flipped };
    lt_pose p = guess(12, 0.06, 0);

    for (int i = 0; i < SIDE * SIDE; i++)
        flipped[i] = metres[i - i % SIDE + SIDE - 1 - i % SIDE];
    for (int k = 1; k < 9; k++)
        p.R[k] *= k % 3 == 0 || k < 3 ? -1 : 1;             /* M R M, M = diag(-1, 1, 1) */
    p.t[0] = -p.t[0];
    ck_assert(lt_depth_fit(&other, &mirrored, &p));
    for (int k = 1; k < 9; k++)
        p.R[k] *= k % 3 == 0 || k < 3 ? -1 : 1;
    p.t[0] = -p.t[0];
    expect_truth(&p, 1.5, 0.002);
}
END_TEST

/* No fit, and the guess to the last bit: nothing measured; beside the picture; a pose, a camera that is not finite */
START_TEST(nothing_to_fit)
{
    const lt_depth_map lost = { { NAN, 600, 80, 80 }, SIDE, SIDE, metres };
    static float nothing[SIDE * SIDE];
    const lt_depth_map dark = { camera, SIDE, SIDE, nothing };
    lt_pose p[] = { truth, truth, truth, truth };
    lt_pose before[4];

    p[1].t[0] = 2;
    p[2].t[2] = NAN;
    memcpy(before, p, sizeof(p));
    ck_assert(!lt_depth_fit(&dark, &surface, &p[0]));
    ck_assert(!lt_depth_fit(&map, &surface, &p[1]));
    ck_assert(!lt_depth_fit(&map, &surface, &p[2]));
    ck_assert(!lt_depth_fit(&lost, &surface, &p[3]));
    ck_assert_mem_eq(before, p, sizeof(p));
}
END_TEST

/* 800 of 1,600, with unit normals that look outwards; of fewer all; of none, which no fit is found for, none */
START_TEST(points_of_a_mesh)
{
    lt_mesh few = mesh;
    lt_surface a, b;
    lt_pose p = truth;

    ck_assert_int_eq(surface.n, 800);
    for (int i = 0; i < surface.n; i++) {
        const double x[3] = { surface.point[i][0], surface.point[i][1], surface.point[i][2] };
        const double n[3] = { surface.normal[i][0], surface.normal[i][1], surface.normal[i][2] };

        ck_assert_double_eq_tol(lt_vec3_norm(n), 1, 1e-6);
        ck_assert_double_gt(lt_vec3_dot(x, n), 0);
        ck_assert_float_eq(mirrored.point[i][0], -surface.point[i][0]);
        ck_assert_float_eq(mirrored.normal[i][1], surface.normal[i][1]);
    }
    few.n_vertices = SPOKES, few.n_faces = 0;
    ck_assert_int_eq(lt_surface_of(arena, &few, &a, &b), LT_OK);
    ck_assert_int_eq(a.n, SPOKES);
    few.n_vertices = 0;
    ck_assert_int_eq(lt_surface_of(arena, &few, &a, &b), LT_OK);
    ck_assert_int_eq(a.n, 0);
    ck_assert(!lt_depth_fit(&map, &a, &p));
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_add_loop_test(c, finds_the_pose, 0, 4);
    tcase_add_test(c, sees_past_what_hides_it);
    tcase_add_test(c, mirror);
    tcase_add_test(c, nothing_to_fit);
    tcase_add_test(c, points_of_a_mesh);
}

int main(void)
{
    return run_suite("depth fit", add_tests);
}
