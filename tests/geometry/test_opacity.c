/* SPDX-License-Identifier: Apache-2.0 */
/* The opacity field against NumPy's, and its surface: closed, where it should be, the same bits on 1 to 4 threads. */
#include "libtensor/geometry/opacity/opacity.h"

#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/parts.h"
#include "libtensor/io/array/npz.h"
#include "tests/suite.h"

enum { SPHERE = 240 };
static const double RADIUS = 0.05;

static lt_arena *arena;

static void setup(void)
{
    arena = lt_arena_new();
}

static void teardown(void)
{
    lt_set_threads(0);
    lt_arena_free(arena);
}

/* ---- values --------------------------------------------------------------------------------------------------- */

/* Single precision sees Gaussians of half a millimetre from a hand's breadth. */
static const double BOUND = 2e-5;

START_TEST(as_numpy)
{
    const char *srcdir = getenv("srcdir");
    const lt_array *centre, *axes, *alpha, *place, *want;
    lt_opacity_field *f;
    lt_gaussian *g;
    lt_npz npz;
    double *got, worst = 0;
    int64_t n, places;

    check_ok(lt_npz_read(arena, lt_arena_printf(arena, "%s/tests/vectors/opacity.npz", srcdir ? srcdir : ".."), &npz));
    centre = lt_npz_find(&npz, "centre"), axes = lt_npz_find(&npz, "axes"), alpha = lt_npz_find(&npz, "opacity");
    place = lt_npz_find(&npz, "places"), want = lt_npz_find(&npz, lt_opacity_rule_name((lt_opacity_rule)_i));
    n = centre->shape[0], places = place->shape[0];
    g = lt_arena_array(arena, (size_t)n, sizeof(*g));
    got = lt_arena_array(arena, (size_t)places, sizeof(*got));
    for (int64_t i = 0; i < n; i++) {
        memcpy(g[i].centre, (const double *)centre->data + 3 * i, sizeof(g[i].centre));
        memcpy(g[i].axes, (const double *)axes->data + 9 * i, sizeof(g[i].axes));
        g[i].opacity = ((const double *)alpha->data)[i];
    }
    check_ok(lt_opacity_field_new(arena, n, g, &f));
    check_ok(lt_opacity_at(f, (lt_opacity_rule)_i, places, place->data, got));
    for (int64_t i = 0; i < places; i++)
        worst = fmax(worst, fabs(got[i] - ((const double *)want->data)[i]));
    ck_assert_msg(worst < BOUND, "off by %g", worst);
}
END_TEST

/* Far away and where places are no numbers there is nothing. */
START_TEST(nowhere)
{
    const double place[3][3] = { { 10, 0, 0 }, { NAN, 0, 0 }, { 0, 0, INFINITY } };
    const lt_gaussian g = { .axes = { 0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01 }, .opacity = 1 };
    lt_opacity_field *f;
    double opacity[3];

    check_ok(lt_opacity_field_new(arena, 1, &g, &f));
    for (int rule = 0; rule < LT_OPACITY_RULES; rule++) {
        check_ok(lt_opacity_at(f, (lt_opacity_rule)rule, 3, place, opacity));
        for (int i = 0; i < 3; i++)
            ck_assert_double_eq(opacity[i], 0);
    }
}
END_TEST

/* ---- surfaces ------------------------------------------------------------------------------------------------- */

/* Flat Gaussians on a sphere; a few of them, off it and hardly there, belong to no surface */
static double make_sphere(lt_gaussian g[SPHERE])
{
    const double sigma = 0.8 * RADIUS * sqrt(4 * M_PI / SPHERE), golden = M_PI * (3 - sqrt(5));

    for (int i = 0; i < SPHERE; i++) {
        const double z = 1 - (2 * i + 1.0) / SPHERE, r = sqrt(1 - z * z);
        const double out[3] = { r * cos(golden * i), r * sin(golden * i), z };
        const double up[3] = { 0, fabs(z) > 0.7, fabs(z) <= 0.7 };
        double axis[3][3];

        lt_vec3_cross(up, out, axis[0]);
        lt_vec3_unit(axis[0]);
        lt_vec3_cross(out, axis[0], axis[1]);
        memcpy(axis[2], out, sizeof(out));
        g[i].opacity = 0.9;
        for (int k = 0; k < 3; k++) {
            g[i].centre[k] = RADIUS * out[k] + 0.3;
            for (int a = 0; a < 3; a++)
                g[i].axes[3 * k + a] = axis[a][k] * sigma * (a == 2 ? 0.2 : 1);
        }
    }
    for (int i = 0; i < SPHERE; i += SPHERE / 3) {
        g[i].centre[0] += 0.04;
        g[i].opacity = 0.03;
    }
    return sigma;
}

static double volume_of(const lt_mesh *m)
{
    double six = 0;

    for (int f = 0; f < m->n_faces; f++) {
        double x[3][3], n[3];

        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++)
                x[i][k] = (double)m->vertex[m->face[f][i]][k] - 0.3;
        lt_vec3_cross(x[1], x[2], n);
        six += lt_vec3_dot(x[0], n);
    }
    return six / 6;
}

START_TEST(sphere)
{
    const lt_opacity_rule rule = (lt_opacity_rule)_i;
    lt_gaussian g[SPHERE];
    float color[SPHERE][3];
    const double sigma = make_sphere(g);
    lt_mesh_topology t;
    lt_mesh m;
    double worst = 0;

    for (int i = 0; i < SPHERE; i++)
        for (int k = 0; k < 3; k++)
            color[i][k] = g[i].centre[2] > 0.3 ? 1 : 0.25f;
    check_ok(lt_opacity_mesh(arena, SPHERE, g, (const float (*)[3])color, rule, rule == LT_OPACITY_MIN ? 0.5 : 0.6,
                             &m));
    check_ok(lt_mesh_topology_of(&m, &t));
    ck_assert(t.watertight);
    ck_assert_int_eq(t.components, 1);
    for (int i = 0; i < m.n_vertices; i++) {
        double d[3];

        for (int k = 0; k < 3; k++)
            d[k] = (double)m.vertex[i][k] - 0.3;
        worst = fmax(worst, fabs(lt_vec3_norm(d) - RADIUS));
        if (fabs(d[2]) > 2 * sigma)
            ck_assert_float_eq(m.color[i][1], d[2] > 0 ? 1 : 0.25f);
    }
    ck_assert_msg(worst < sigma, "%s: a radius is off by %g mm, a deviation is %g", lt_opacity_rule_name(rule),
                  1e3 * worst, 1e3 * sigma);
    ck_assert(volume_of(&m) > 4 * M_PI / 3 * pow(RADIUS - sigma, 3));          /* and faces look outwards */
}
END_TEST

START_TEST(same_on_any_threads)
{
    lt_gaussian g[SPHERE];
    lt_mesh first, m;

    make_sphere(g);
    for (int threads = 1; threads <= 4; threads++) {
        lt_set_threads(threads);
        check_ok(lt_opacity_mesh(arena, SPHERE, g, NULL, LT_OPACITY_MEAN, 0.6, &m));
        if (threads == 1)
            first = m;
        ck_assert_int_eq(m.n_vertices, first.n_vertices);
        ck_assert_int_eq(m.n_faces, first.n_faces);
        ck_assert_int_eq(memcmp(m.vertex, first.vertex, (size_t)m.n_vertices * sizeof(*m.vertex)), 0);
        ck_assert_int_eq(memcmp(m.face, first.face, (size_t)m.n_faces * sizeof(*m.face)), 0);
    }
}
END_TEST

START_TEST(bad_gaussians)
{
    lt_gaussian g[2] = { { .axes = { 0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01 }, .opacity = 0.3 } };
    lt_mesh m;

    check_error(lt_opacity_mesh(arena, 0, g, NULL, LT_OPACITY_MEAN, 0.6, &m), LT_EINVAL, "0 Gaussians, want at least");
    check_error(lt_opacity_mesh(arena, 1, g, NULL, LT_OPACITY_MEAN, 1, &m), LT_EINVAL, "iso is 1, want a number");
    check_error(lt_opacity_mesh(arena, 1, g, NULL, LT_OPACITY_MEAN, NAN, &m), LT_EINVAL, "iso is nan");
    check_error(lt_opacity_mesh(arena, 1, g, NULL, LT_OPACITY_MIN, 0.6, &m), LT_EINVAL,
                "no place is as opaque as 0.6 by the rule min");
    g[1] = g[0];
    g[1].opacity = 1.5;
    check_error(lt_opacity_mesh(arena, 2, g, NULL, LT_OPACITY_MEAN, 0.6, &m), LT_EINVAL, "Gaussian 1 has opacity 1.5");
    g[1].axes[4] = NAN;
    check_error(lt_opacity_mesh(arena, 2, g, NULL, LT_OPACITY_MEAN, 0.6, &m), LT_EINVAL, "Gaussian 1 is not finite");
    g[0].opacity = 0.01;
    check_error(lt_opacity_mesh(arena, 1, g, NULL, LT_OPACITY_MEAN, 0.6, &m), LT_EINVAL, "none of 1 Gaussians");
}
END_TEST

/* Fails the first, the second .. block asked for; never a leak or a crash. */
START_TEST(no_memory)
{
    lt_gaussian g[SPHERE];
    lt_status st = LT_ENOMEM;
    lt_mesh m;

    make_sphere(g);
    for (long at = 1; st == LT_ENOMEM; at++) {
        lt_arena *own = lt_arena_new();

        lt_alloc_fail_at(at);
        st = lt_opacity_mesh(own, 12, g, NULL, LT_OPACITY_MEAN, 0.6, &m);
        lt_alloc_fail_at(0);
        lt_arena_free(own);
    }
    ck_assert_int_eq(st, LT_OK);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_set_timeout(t, 120);
    tcase_add_loop_test(t, as_numpy, 0, LT_OPACITY_RULES);
    tcase_add_test(t, nowhere);
    tcase_add_loop_test(t, sphere, 0, LT_OPACITY_RULES);
    tcase_add_test(t, same_on_any_threads);
    tcase_add_test(t, bad_gaussians);
    tcase_add_test(t, no_memory);
}

int main(void)
{
    return run_suite("opacity", add_tests);
}
