/* SPDX-License-Identifier: Apache-2.0 */
/* Mesh questions, against brute force and against shapes whose answers are known. */
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/parts.h"
#include "libtensor/geometry/mesh/surface.h"
#include "tests/suite.h"

enum { RINGS = 24, SIDES = 32, TUBE = RINGS * SIDES, SOUP = 500 };

/* A torus about z: radius 1, tube 0.4, closed. */
static float tube_vertex[TUBE][3];
static int32_t tube_face[2 * TUBE][3];
static const lt_mesh tube = {
    .n_vertices = TUBE, .n_faces = 2 * TUBE, .vertex = tube_vertex, .face = tube_face,
};

static void make_tube(void)
{
    for (int i = 0; i < TUBE; i++) {
        const int r = i / SIDES, s = i % SIDES, r1 = (r + 1) % RINGS, s1 = (s + 1) % SIDES;
        const double a = 2 * M_PI * r / RINGS, b = 2 * M_PI * s / SIDES;
        const int quad[4] = { i, r1 * SIDES + s, r1 * SIDES + s1, r * SIDES + s1 };
        tube_vertex[i][0] = (float)((1 + .4 * cos(b)) * cos(a));
        tube_vertex[i][1] = (float)((1 + .4 * cos(b)) * sin(a));
        tube_vertex[i][2] = (float)(.4 * sin(b));
        for (int k = 0; k < 3; k++) {
            tube_face[2 * i][k] = quad[k];
            tube_face[2 * i + 1][k] = quad[(k + 2) % 4];
        }
    }
}

/* Triangles at random, every tenth a needle, every eleventh a point. */
static float soup_vertex[3 * SOUP][3];
static int32_t soup_face[SOUP][3];
static const lt_mesh soup = {
    .n_vertices = 3 * SOUP, .n_faces = SOUP, .vertex = soup_vertex, .face = soup_face,
};

static void make_soup(void)
{
    lt_rng r = lt_rng_make(1, 0);

    for (int i = 0; i < 3 * SOUP; i++)
        for (int a = 0; a < 3; a++) {
            const float centre = i % 3 ? soup_vertex[i - i % 3][a] : (float)lt_rng_normal(&r);
            soup_vertex[i][a] = centre + (i % 3 ? .2f * (float)lt_rng_normal(&r) : 0);
        }
    for (int f = 0; f < SOUP; f++)
        for (int k = 0; k < 3; k++)
            soup_face[f][k] = 3 * f + (f % 11 == 0 ? 0 : f % 10 == 0 ? k % 2 : k);
}

static double torus_distance(const double p[3])
{
    return hypot(hypot(p[0], p[1]) - 1, p[2]) - .4;
}

START_TEST(normals_point_outwards)
{
    static float normal[TUBE][3];

    lt_mesh_normals(&tube, normal);
    for (int i = 0; i < TUBE; i++) {
        const float *v = tube_vertex[i];
        const double ring = hypot(v[0], v[1]);
        const double want[3] = { v[0] * (1 - 1 / ring) / .4, v[1] * (1 - 1 / ring) / .4, v[2] / .4 };
        for (int a = 0; a < 3; a++)
            ck_assert_double_eq_tol(normal[i][a], want[a], .05);
    }
}
END_TEST

START_TEST(lonely_vertices_have_a_normal)
{
    float vertex[4][3] = { { 0, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 5, 5, 5 } }, normal[4][3];
    int32_t face[1][3] = { { 0, 1, 2 } };
    const lt_mesh mesh = { .n_vertices = 4, .n_faces = 1, .vertex = vertex, .face = face };

    lt_mesh_normals(&mesh, normal);
    ck_assert_float_eq(normal[0][0], 1);
    ck_assert_float_eq(normal[3][2], 1);
    ck_assert_double_eq_tol(lt_mesh_area(&mesh), .5, 1e-15);
}
END_TEST

START_TEST(area_of_a_torus)
{
    ck_assert_double_eq_tol(lt_mesh_area(&tube) / (4 * M_PI * M_PI * .4), 1, .02);
}
END_TEST

/* Against a fine grid of barycentric coordinates. */
START_TEST(closest_on_one_triangle)
{
    enum { GRID = 60 };
    lt_rng r = lt_rng_make(2, 0);

    for (int trial = 0; trial < 300; trial++) {
        double p[4][3], q[3], best = INFINITY, got;
        for (int i = 0; i < 12; i++)
            p[i / 3][i % 3] = lt_rng_normal(&r);
        if (trial % 5 == 0)
            memcpy(p[2], p[1], sizeof(p[1]));
        lt_closest_on_triangle(p[0], p[1], p[2], p[3], q);
        got = lt_vec3_distance(p[0], q);
        for (int i = 0; i <= GRID; i++)
            for (int j = 0; i + j <= GRID; j++) {
                const double u = (double)i / GRID, v = (double)j / GRID;
                double x[3];
                for (int a = 0; a < 3; a++)
                    x[a] = (1 - u - v) * p[1][a] + u * p[2][a] + v * p[3][a];
                best = fmin(best, lt_vec3_distance(p[0], x));
            }
        ck_assert_double_le(got, best + 1e-12);
        ck_assert_double_ge(got, best - .1);
    }
}
END_TEST

static lt_mesh_hit brute_force(const lt_mesh *m, const double p[3])
{
    lt_mesh_hit best = { .distance = INFINITY };

    for (int f = 0; f < m->n_faces; f++) {
        double c[3][3], q[3], d;
        for (int i = 0; i < 9; i++)
            c[i / 3][i % 3] = m->vertex[m->face[f][i / 3]][i % 3];
        lt_closest_on_triangle(p, c[0], c[1], c[2], q);
        d = lt_vec3_distance(p, q);
        if (d < best.distance)
            best = (lt_mesh_hit){ .point = { q[0], q[1], q[2] }, .distance = d, .face = f };
    }
    return best;
}

START_TEST(closest_is_closest)
{
    const lt_mesh *meshes[2] = { &tube, &soup };
    lt_arena *arena = lt_arena_new();
    lt_rng r = lt_rng_make(3, 0);

    for (int m = 0; m < 2; m++) {
        lt_mesh_index *index;
        ck_assert_int_eq(lt_mesh_index_new(arena, meshes[m], &index), LT_OK);
        for (int trial = 0; trial < 300; trial++) {
            double p[3];
            lt_mesh_hit got, want;
            for (int a = 0; a < 3; a++)
                p[a] = trial % 10 ? 1.5 * lt_rng_normal(&r) : meshes[m]->vertex[trial][a];
            got = lt_mesh_closest(index, p);
            want = brute_force(meshes[m], p);
            ck_assert_double_eq(got.distance, want.distance);
            ck_assert_int_eq(got.face, want.face);
            ck_assert_double_eq(got.point[2], want.point[2]);
        }
    }
    lt_arena_free(arena);
}
END_TEST

START_TEST(inside_a_torus)
{
    lt_arena *arena = lt_arena_new();
    lt_rng r = lt_rng_make(4, 0);
    const double hole[3] = { 0, 0, 0 }, on_edge[3] = { 1, 0, 0 };
    lt_mesh_index *index;
    int asked = 0;

    ck_assert_int_eq(lt_mesh_index_new(arena, &tube, &index), LT_OK);
    ck_assert(!lt_mesh_inside(index, hole));
    ck_assert(lt_mesh_inside(index, on_edge));
    for (int trial = 0; trial < 5000; trial++) {
        double p[3];
        for (int a = 0; a < 3; a++)
            p[a] = lt_rng_range(&r, -1.6, 1.6);
        if (fabs(torus_distance(p)) < .03)          /* between the torus and its facets */
            continue;
        ck_assert_int_eq(lt_mesh_inside(index, p), torus_distance(p) < 0);
        asked++;
    }
    ck_assert_int_gt(asked, 4000);
    lt_arena_free(arena);
}
END_TEST

/* The sum of all solid angles: Van Oosterom and Strackee's formula, written down anew. */
static double winding_by_all(const lt_mesh *m, const double p[3])
{
    double sum = 0;

    for (int f = 0; f < m->n_faces; f++) {
        double v[3][3], l[3], bc[3];
        for (int c = 0; c < 3; c++) {
            for (int k = 0; k < 3; k++)
                v[c][k] = m->vertex[m->face[f][c]][k] - p[k];
            l[c] = lt_vec3_norm(v[c]);
        }
        lt_vec3_cross(v[1], v[2], bc);
        sum += 2 * atan2(lt_vec3_dot(v[0], bc), l[0] * l[1] * l[2] + lt_vec3_dot(v[0], v[1]) * l[2] +
                                                lt_vec3_dot(v[1], v[2]) * l[0] + lt_vec3_dot(v[2], v[0]) * l[1]);
    }
    return sum / (4 * M_PI);
}

/* Against all faces one by one, on a closed mesh and on triangles in disorder. */
START_TEST(winding_is_the_sum)
{
    const lt_mesh *const meshes[] = { &tube, &soup };
    const lt_mesh *m = meshes[_i];
    lt_arena *arena = lt_arena_new();
    lt_mesh_index *index;
    lt_rng r = lt_rng_make(3, 0);
    double worst = 0;

    make_tube();
    make_soup();
    check_ok(lt_mesh_index_new(arena, m, &index));
    for (int i = 0; i < 2000; i++) {
        const double p[3] = { 1.2 * lt_rng_normal(&r), 1.2 * lt_rng_normal(&r), 0.5 * lt_rng_normal(&r) };
        const double w = lt_mesh_winding(index, p), all = winding_by_all(m, p);
        worst = fmax(worst, fabs(w - all));
        if (m == &tube)
            ck_assert_double_eq_tol(all, round(all), 1e-9);
    }
    ck_assert_msg(worst < 0.01, "off by %g", worst);
    lt_arena_free(arena);
}
END_TEST

/* Two tubes, one moved by half its width: 2 where they overlap; turned inside out -1; with holes, fractions. */
START_TEST(winding_of_parts_and_holes)
{
    static float vertex[2 * TUBE][3];
    static int32_t face[4 * TUBE][3];
    const lt_mesh both = { .n_vertices = 2 * TUBE, .n_faces = 4 * TUBE, .vertex = vertex, .face = face };
    lt_mesh part = { .n_vertices = TUBE, .n_faces = 2 * TUBE, .vertex = tube_vertex, .face = face };
    const double in_both[3] = { 1.1, 0, 0 }, in_one[3] = { -1.3, 0, 0 }, in_none[3] = { 0, 0, 0.3 };
    lt_arena *arena = lt_arena_new();
    lt_mesh_index *index;

    make_tube();
    for (int i = 0; i < 2 * TUBE; i++)
        for (int k = 0; k < 3; k++)
            vertex[i][k] = tube_vertex[i % TUBE][k] + (i >= TUBE && k == 0 ? 0.2f : 0);
    for (int f = 0; f < 4 * TUBE; f++)
        for (int k = 0; k < 3; k++)
            face[f][k] = tube_face[f % (2 * TUBE)][k] + (f >= 2 * TUBE ? TUBE : 0);
    check_ok(lt_mesh_index_new(arena, &both, &index));
    ck_assert_double_eq_tol(lt_mesh_winding(index, in_both), 2, 0.01);
    ck_assert_double_eq_tol(lt_mesh_winding(index, in_one), 1, 0.01);
    ck_assert_double_eq_tol(lt_mesh_winding(index, in_none), 0, 0.01);
    for (int f = 0; f < 2 * TUBE; f++)
        for (int k = 0; k < 3; k++)
            face[f][k] = tube_face[f][2 - k];
    check_ok(lt_mesh_index_new(arena, &part, &index));
    ck_assert_double_eq_tol(lt_mesh_winding(index, in_one), -1, 0.01);
    part.n_faces = 0;
    for (int f = 0; f < 2 * TUBE; f++)
        if (f % 10)
            memcpy(face[part.n_faces++], tube_face[f], sizeof(face[0]));
    check_ok(lt_mesh_index_new(arena, &part, &index));
    ck_assert(lt_mesh_winding(index, in_one) > 0.8 && lt_mesh_winding(index, in_one) < 0.99);
    ck_assert(fabs(lt_mesh_winding(index, in_none)) < 0.2);
    lt_arena_free(arena);
}
END_TEST

START_TEST(samples_are_uniform)
{
    enum { N = 20000 };
    static float points[N][3];
    static int face[N];
    lt_rng r = lt_rng_make(5, 0);
    int inner = 0;

    ck_assert_int_eq(lt_mesh_sample(&tube, &r, N, points, face), LT_OK);
    for (int i = 0; i < N; i++) {
        const double p[3] = { points[i][0], points[i][1], points[i][2] };
        ck_assert(face[i] >= 0 && face[i] < 2 * TUBE);
        ck_assert_double_eq_tol(torus_distance(p), 0, .02);
        inner += hypot(p[0], p[1]) < 1;
    }
    /* The inner half of a torus has 1/2 - r/(pi R) of its area. */
    ck_assert_double_eq_tol((double)inner / N, .5 - .4 / M_PI, .015);
}
END_TEST

START_TEST(farthest_points_spread)
{
    const float line[7][3] = { { 0 }, { 1, 0, 0 }, { 2, 0, 0 }, { 4, 0, 0 }, { 8, 0, 0 }, { 8, 0, 0 }, { 3, 0, 0 } };
    const int want[7] = { 0, 4, 3, 2, 1, 6, 5 };
    int chosen[7];

    ck_assert_int_eq(lt_farthest_points(7, line, 7, 0, chosen), LT_OK);
    ck_assert_mem_eq(chosen, want, sizeof(want));
    ck_assert_int_eq(lt_farthest_points(7, line, 0, 0, chosen), LT_OK);
    ck_assert_int_eq(lt_farthest_points(7, line, 8, 0, chosen), LT_EINVAL);
    ck_assert_int_eq(lt_farthest_points(7, line, 1, 7, chosen), LT_EINVAL);
    ck_assert_int_eq(lt_farthest_points(0, line, 0, 0, chosen), LT_EINVAL);
}
END_TEST

/* A torus is closed, but not without one of its faces, nor with one turned around, nor with one that is there twice. */
START_TEST(closed_and_open)
{
    int32_t face[2 * TUBE + 1][3];
    lt_mesh mesh = tube;
    lt_mesh_topology t;

    memcpy(face, tube_face, sizeof(tube_face));
    mesh.face = face;
    check_ok(lt_mesh_topology_of(&mesh, &t));
    ck_assert(t.watertight);
    ck_assert_int_eq(t.components, 1);
    mesh.n_faces--;
    check_ok(lt_mesh_topology_of(&mesh, &t));
    ck_assert(!t.watertight);
    mesh.n_faces++;
    face[7][0] = tube_face[7][1], face[7][1] = tube_face[7][0];
    check_ok(lt_mesh_topology_of(&mesh, &t));
    ck_assert(!t.watertight);
    memcpy(face, tube_face, sizeof(tube_face));
    memcpy(face[2 * TUBE], face[3], sizeof(face[3]));
    mesh.n_faces++;
    check_ok(lt_mesh_topology_of(&mesh, &t));
    ck_assert(!t.watertight);
    face[5][1] = TUBE;
    check_error(lt_mesh_topology_of(&mesh, &t), LT_EINVAL, "face 5 has vertex 768 of 768");
    check_ok(lt_mesh_topology_of(&soup, &t));
    ck_assert(!t.watertight);
    ck_assert_int_eq(t.components, SOUP);
}
END_TEST

/* Two toruses and a vertex of no face: the one a tenth as large has a hundredth of the area of the other. */
START_TEST(small_parts)
{
    static float vertex[2 * TUBE + 1][3];
    static int32_t face[4 * TUBE][3];
    const lt_mesh both = { .n_vertices = 2 * TUBE + 1, .n_faces = 4 * TUBE, .vertex = vertex, .face = face };
    lt_arena *arena = lt_arena_new();
    lt_mesh_topology t;
    lt_mesh out;

    for (int i = 0; i < TUBE; i++)
        for (int k = 0; k < 3; k++) {
            vertex[i][k] = 0.1f * tube_vertex[i][k];
            vertex[TUBE + 1 + i][k] = tube_vertex[i][k];
        }
    for (int f = 0; f < 2 * TUBE; f++)
        for (int k = 0; k < 3; k++) {
            face[2 * f][k] = tube_face[f][k];
            face[2 * f + 1][k] = TUBE + 1 + tube_face[f][k];
        }
    check_ok(lt_mesh_topology_of(&both, &t));
    ck_assert(t.watertight);
    ck_assert_int_eq(t.components, 2);
    check_ok(lt_mesh_without_small_parts(arena, &both, 0.0098, &out));
    ck_assert_int_eq(out.n_faces, 4 * TUBE);
    ck_assert_int_eq(out.n_vertices, 2 * TUBE);
    check_ok(lt_mesh_without_small_parts(arena, &both, 0.01, &out));
    ck_assert_int_eq(out.n_faces, 2 * TUBE);
    ck_assert_int_eq(out.n_vertices, TUBE);
    ck_assert_double_eq_tol(lt_mesh_area(&out), lt_mesh_area(&tube), 1e-6);
    lt_arena_free(arena);
}
END_TEST

START_TEST(bad_meshes)
{
    float vertex[3][3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, point[1][3];
    int32_t face[1][3] = { { 0, 1, 3 } };
    lt_mesh mesh = { .n_vertices = 3, .n_faces = 1, .vertex = vertex, .face = face };
    lt_arena *arena = lt_arena_new();
    lt_rng r = lt_rng_make(6, 0);
    lt_mesh_index *index = NULL;

    ck_assert_int_eq(lt_mesh_index_new(arena, &mesh, &index), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "mesh index: face 0 names vertex 3 of 3");
    face[0][2] = 1;
    ck_assert_int_eq(lt_mesh_sample(&mesh, &r, 1, point, NULL), LT_EINVAL);
    ck_assert_int_eq(lt_mesh_index_new(arena, &mesh, &index), LT_OK);       /* flat, but there */
    vertex[1][0] = NAN;
    ck_assert_int_eq(lt_mesh_index_new(arena, &mesh, &index), LT_EINVAL);
    mesh.n_faces = 0;
    ck_assert_int_eq(lt_mesh_index_new(arena, &mesh, &index), LT_EINVAL);
    ck_assert_int_eq(lt_mesh_sample(&mesh, &r, 1, point, NULL), LT_EINVAL);
    lt_arena_free(arena);
}
END_TEST

START_TEST(no_memory)
{
    const float point[1][3] = { { 0 } };
    lt_rng r = lt_rng_make(7, 0);
    float sample[1][3];
    int chosen[1];

    lt_alloc_fail_at(1);
    ck_assert_int_eq(lt_mesh_sample(&tube, &r, 1, sample, NULL), LT_ENOMEM);
    lt_alloc_fail_at(1);
    ck_assert_int_eq(lt_farthest_points(1, point, 1, 0, chosen), LT_ENOMEM);
    for (long nth = 1; nth < 10; nth++) {
        lt_arena *arena = lt_arena_new();
        lt_mesh_index *index;
        lt_status st;
        lt_alloc_fail_at(nth);
        st = lt_mesh_index_new(arena, &tube, &index);
        lt_alloc_fail_at(0);
        lt_arena_free(arena);
        ck_assert(st == LT_OK || st == LT_ENOMEM);
        if (!st)
            break;
    }
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, normals_point_outwards);
    tcase_add_test(c, lonely_vertices_have_a_normal);
    tcase_add_test(c, area_of_a_torus);
    tcase_add_test(c, closest_on_one_triangle);
    tcase_add_test(c, closest_is_closest);
    tcase_add_test(c, inside_a_torus);
    tcase_add_loop_test(c, winding_is_the_sum, 0, 2);
    tcase_add_test(c, winding_of_parts_and_holes);
    tcase_add_test(c, samples_are_uniform);
    tcase_add_test(c, farthest_points_spread);
    tcase_add_test(c, closed_and_open);
    tcase_add_test(c, small_parts);
    tcase_add_test(c, bad_meshes);
    tcase_add_test(c, no_memory);
}

int main(void)
{
    make_tube();
    make_soup();
    return run_suite("mesh_ops", add_tests);
}
