/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The stand-in objects against the table: size, diameter, closed surfaces, texture, samples.
 */
#include "assets/ycb/objects.h"
#include "assets/ycb/ycb.h"
#include "libtensor/geometry/mesh/surface.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static lt_arena *arena;
static lt_mesh mesh;
static const ycb_object *object;

static void setup(void)
{
    arena = lt_arena_new();
    ck_assert_ptr_nonnull(arena);
}

static void teardown(void)
{
    lt_arena_free(arena);
}

static void make(int id)
{
    object = synth_object_find(id);
    ck_assert_ptr_nonnull(object);
    check_ok(synth_object_new(arena, id, &mesh));
}

START_TEST(table)
{
    const ycb_object *o = ycb_find(_i);

    ck_assert_int_eq(o->id, _i);
    ck_assert_ptr_eq(ycb_find_name(o->name), o);
    ck_assert_int_eq(atoi(o->name) > 1, 1);
    ck_assert(o->diameter < o->diagonal);
    ck_assert(o->diameter >= fmax(o->size[0], fmax(o->size[1], o->size[2])) - 4e-4);
}
END_TEST

START_TEST(table_sets)
{
    int posecnn = 0, bop = 0, hfl = 0;

    for (int id = 1; id <= YCB_COUNT; id++) {
        posecnn += !!(ycb_find(id)->adds & YCB_ADDS_POSECNN);
        bop += !!(ycb_find(id)->adds & YCB_ADDS_BOP);
        hfl += !!(ycb_find(id)->adds & YCB_ADDS_HFL);
    }
    ck_assert_int_eq(posecnn, 5);
    ck_assert_int_eq(bop, 8);
    ck_assert_int_eq(hfl, 4);
    ck_assert_ptr_null(ycb_find(0));
    ck_assert_ptr_null(ycb_find(YCB_COUNT + 1));
    ck_assert_ptr_null(ycb_find_name("022_nothing"));
}
END_TEST

START_TEST(box)
{
    make(_i);
    for (int k = 0; k < 3; k++) {
        double lo = INFINITY, hi = -INFINITY;
        for (int i = 0; i < mesh.n_vertices; i++) {
            lo = fmin(lo, mesh.vertex[i][k]);
            hi = fmax(hi, mesh.vertex[i][k]);
        }
        ck_assert_double_eq_tol(hi - lo, object->size[k], 1.51e-3);
        ck_assert_double_eq_tol((hi + lo) / 2, object->centre[k], 1e-6);
    }
}
END_TEST

static double distance(const float a[3], const float b[3])
{
    return sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
}

START_TEST(diameter)
{
    double d = 0;

    make(_i);
    for (int i = 0; i < mesh.n_vertices; i++)
        for (int j = 0; j < i; j++)
            d = fmax(d, distance(mesh.vertex[i], mesh.vertex[j]));
    ck_assert_double_eq_tol(d / object->diameter, 1, 0.02);
}
END_TEST

/* Every edge is walked once in each direction: closed, manifold, consistently oriented. */
START_TEST(closed)
{
    unsigned char *walked;
    int wrong = 0;                  /* ck_assert is too slow for ten million pairs */
    size_t n;

    make(_i);
    n = (size_t)mesh.n_vertices;
    ck_assert_int_ge(mesh.n_vertices, 1000);
    ck_assert_int_le(mesh.n_vertices, 3000);
    walked = calloc(n, n);
    for (int f = 0; f < mesh.n_faces; f++)
        for (int k = 0; k < 3; k++)
            walked[(size_t)mesh.face[f][k] * n + (size_t)mesh.face[f][(k + 1) % 3]]++;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++)
            wrong += walked[i * n + j] != walked[j * n + i] || walked[i * n + j] > 1;
    free(walked);
    ck_assert_int_eq(wrong, 0);
}
END_TEST

/* Twice the area vector of a face. */
static void face_normal(int f, double n[3])
{
    const float *p = mesh.vertex[mesh.face[f][0]], *q = mesh.vertex[mesh.face[f][1]];
    const float *r = mesh.vertex[mesh.face[f][2]];

    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        n[k] = ((double)q[i] - p[i]) * ((double)r[j] - p[j]) - ((double)q[j] - p[j]) * ((double)r[i] - p[i]);
    }
}

START_TEST(outwards)
{
    double volume = 0, n[3];

    make(_i);
    for (int f = 0; f < mesh.n_faces; f++) {
        const float *p = mesh.vertex[mesh.face[f][0]];
        face_normal(f, n);
        ck_assert_double_gt(sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), 1e-10);
        volume += (p[0] * n[0] + p[1] * n[1] + p[2] * n[2]) / 6;
    }
    ck_assert_double_gt(volume, 0.01 * object->size[0] * object->size[1] * object->size[2]);
}
END_TEST

/* Behind each face is the inside, of each of the parts that an object is made of. */
START_TEST(parts_outwards)
{
    lt_mesh_index *index;

    make(_i);
    check_ok(lt_mesh_index_new(arena, &mesh, &index));
    for (int f = 0; f < mesh.n_faces; f++) {
        double behind[3], n[3], length;

        face_normal(f, n);
        length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int k = 0; k < 3; k++)
            behind[k] = ((double)mesh.vertex[mesh.face[f][0]][k] + (double)mesh.vertex[mesh.face[f][1]][k]
                         + (double)mesh.vertex[mesh.face[f][2]][k]) / 3 - 1e-5 * n[k] / length;
        ck_assert_msg(lt_mesh_winding(index, behind) > 0.5, "%s: face %d looks inwards", object->name, f);
    }
}
END_TEST

START_TEST(uv)
{
    make(_i);
    for (int i = 0; i < mesh.n_vertices; i++)
        for (int k = 0; k < 2; k++)
            ck_assert(mesh.uv[i][k] >= 0 && mesh.uv[i][k] <= 1);
}
END_TEST

START_TEST(same_again)
{
    uint8_t (*a)[3], (*b)[3];
    const size_t bytes = (size_t)SYNTH_TEXTURE * SYNTH_TEXTURE * 3;
    lt_mesh first;

    make(_i);
    first = mesh;
    make(_i);
    ck_assert_int_eq(first.n_vertices, mesh.n_vertices);
    ck_assert_mem_eq(first.vertex, mesh.vertex, sizeof(*mesh.vertex) * (size_t)mesh.n_vertices);
    ck_assert_int_eq(synth_object_texture(arena, _i, &a), LT_OK);
    ck_assert_int_eq(synth_object_texture(arena, _i, &b), LT_OK);
    ck_assert_mem_eq(a, b, bytes);
}
END_TEST

/* No two samples are much closer than an even spread allows, and no part of the surface is left out. */
START_TEST(points)
{
    float (*p)[3];
    double closest = INFINITY, hole = 0, spacing, area = 0, n[3];

    make(_i);
    ck_assert_int_eq(synth_object_points(arena, &mesh, &p), LT_OK);
    for (int f = 0; f < mesh.n_faces; f++) {
        face_normal(f, n);
        area += sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
    }
    spacing = sqrt(area / SYNTH_POINTS);
    for (int i = 0; i < SYNTH_POINTS; i++)
        for (int j = 0; j < i; j++)
            closest = fmin(closest, distance(p[i], p[j]));
    for (int i = 0; i < mesh.n_vertices; i += 7) {
        double d = INFINITY;
        for (int j = 0; j < SYNTH_POINTS; j++)
            d = fmin(d, distance(mesh.vertex[i], p[j]));
        hole = fmax(hole, d);
    }
    ck_assert_double_gt(closest, 0.55 * spacing);
    ck_assert_double_lt(hole, 1.6 * spacing);
}
END_TEST

/* Real datasets have no such object, and nobody may take it for one of theirs. */
START_TEST(jug_is_ours)
{
    ck_assert_str_eq(synth_object_find(SYNTH_JUG)->name, "jug");
    ck_assert_ptr_null(ycb_find_name("jug"));
    ck_assert_ptr_eq(synth_object_find(14), ycb_find(14));
    ck_assert_ptr_null(synth_object_find(SYNTH_OBJECTS + 1));
}
END_TEST

START_TEST(bad_id)
{
    uint8_t (*rgb)[3];

    ck_assert_int_eq(synth_object_new(arena, 0, &mesh), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "object 0: ids are 1 to 22");
    ck_assert_int_eq(synth_object_texture(arena, 23, &rgb), LT_EINVAL);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_set_timeout(t, 0);
    tcase_add_loop_test(t, table, 1, YCB_COUNT + 1);
    tcase_add_test(t, table_sets);
    tcase_add_loop_test(t, box, 1, SYNTH_OBJECTS + 1);
    tcase_add_loop_test(t, diameter, 1, SYNTH_OBJECTS + 1);
    tcase_add_loop_test(t, closed, 1, SYNTH_OBJECTS + 1);
    tcase_add_loop_test(t, outwards, 1, SYNTH_OBJECTS + 1);
    tcase_add_loop_test(t, parts_outwards, 1, SYNTH_OBJECTS + 1);
    tcase_add_loop_test(t, uv, 1, SYNTH_OBJECTS + 1);
    tcase_add_loop_test(t, same_again, 1, SYNTH_OBJECTS + 1);
    tcase_add_loop_test(t, points, 1, SYNTH_OBJECTS + 1);
    tcase_add_test(t, jug_is_ours);
    tcase_add_test(t, bad_id);
}

int main(void)
{
    return run_suite("objects", add_tests);
}
