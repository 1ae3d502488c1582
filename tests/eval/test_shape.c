/* SPDX-License-Identifier: Apache-2.0 */
/* Chamfer distances, F-scores and alignments against SciPy's; a surface against itself, moved. */
#include "eval/metrics/shape.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/icp.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/array/npz.h"
#include "tests/suite.h"

enum { BLOCKS = 3, CORNERS = 8, BLOCK_FACES = 12 };

static const lt_icp_opts opts = { .within = 0.01, .rounds = 30, .tolerance = 1e-6 };

static lt_arena *arena;
static const lt_array *p, *g;
static lt_npz npz;

static void setup(void)
{
    const char *srcdir = getenv("srcdir");

    arena = lt_arena_new();
    check_ok(lt_npz_read(arena, lt_arena_printf(arena, "%s/tests/vectors/shape.npz", srcdir ? srcdir : ".."), &npz));
    p = lt_npz_find(&npz, "p"), g = lt_npz_find(&npz, "g");
}

static void teardown(void)
{
    lt_set_threads(0);
    lt_arena_free(arena);
}

/* ---- SciPy ---------------------------------------------------------------------------------------------------- */

static void check_scores(const char *name, const double (*x)[3])
{
    const double *want = lt_npz_find(&npz, name)->data;
    eval_shape_score s;

    check_ok(eval_shape_of_points((int)p->shape[0], x, (int)g->shape[0], g->data, &s));
    ck_assert_double_eq_tol(s.cd_cm2, want[0], 1e-6);
    ck_assert_double_eq_tol(s.f_1mm, want[1], 1e-6);
    ck_assert_double_eq_tol(s.f_5mm, want[2], 1e-6);
    ck_assert_double_eq_tol(s.f_10mm, want[3], 1e-6);
}

static double (*moved(const lt_similarity *s))[3]
{
    double (*x)[3] = lt_arena_array(arena, (size_t)p->shape[0], sizeof(*x));

    lt_similarity_apply(s, (int)p->shape[0], p->data, x[0]);
    return x;
}

START_TEST(as_it_is)
{
    check_scores("raw", p->data);
}
END_TEST

START_TEST(similarity)
{
    const double *want = lt_npz_find(&npz, "similarity")->data;
    const int n = (int)p->shape[0], m = (int)g->shape[0];
    lt_similarity start = { .scale = 1 }, s;

    lt_mat3_identity(start.R);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < m; i++)
            start.t[k] += ((const double (*)[3])g->data)[i][k] / m;
        for (int i = 0; i < n; i++)
            start.t[k] -= ((const double (*)[3])p->data)[i][k] / n;
    }
    check_ok(lt_icp_similarity(n, p->data, m, g->data, &start, &opts, &s));
    ck_assert_double_eq_tol(s.scale, want[0], 1e-9);
    for (int k = 0; k < 9; k++)
        ck_assert_double_eq_tol(s.R[k], want[1 + k], 1e-9);
    for (int k = 0; k < 3; k++)
        ck_assert_double_eq_tol(s.t[k], want[10 + k], 1e-9);
    check_scores("similar", (const double (*)[3])moved(&s));
}
END_TEST

START_TEST(no_rotation)
{
    const double *want = lt_npz_find(&npz, "no_rotation")->data;
    lt_similarity s;

    check_ok(lt_icp_scale_translation((int)p->shape[0], p->data, (int)g->shape[0], g->data, &s));
    ck_assert_double_eq_tol(s.scale, want[0], 1e-9);
    for (int k = 0; k < 3; k++)
        ck_assert_double_eq_tol(s.t[k], want[1 + k], 1e-9);
    check_scores("moved", (const double (*)[3])moved(&s));
}
END_TEST

/* Four points, half as large and far away: nothing is left.                                       [data.md 8.8's] */
START_TEST(scale_and_translation_of_four)
{
    const double want[4][3] = { { 0, 0, 0 }, { 0.1, 0, 0 }, { 0, 0.2, 0 }, { 0, 0, 0.3 } };
    double x[4][3];
    lt_similarity s;

    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            x[i][k] = 0.5 * want[i][k] + k + 1;
    check_ok(lt_icp_scale_translation(4, (const double (*)[3])x, 4, want, &s));
    ck_assert_double_eq_tol(s.scale, 2, 1e-12);
    for (int k = 0; k < 3; k++)
        ck_assert_double_eq_tol(s.t[k], -2 * (k + 1), 1e-12);
}
END_TEST

/* ---- itself --------------------------------------------------------------------------------------------------- */

/* Blocks of a hand's size that no rotation takes to themselves */
static lt_mesh make_blocks(void)
{
    static const float at[BLOCKS][2][3] = {
        { { 0, 0, 0 }, { 0.09f, 0.03f, 0.02f } }, { { 0, 0.03f, 0 }, { 0.025f, 0.08f, 0.015f } },
        { { 0.07f, 0, 0.02f }, { 0.09f, 0.02f, 0.05f } },
    };
    static const int face[BLOCK_FACES][3] = {
        { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
        { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 },
    };
    lt_mesh m = { .n_vertices = BLOCKS * CORNERS, .n_faces = BLOCKS * BLOCK_FACES };

    m.vertex = lt_arena_array(arena, BLOCKS * CORNERS, sizeof(*m.vertex));
    m.face = lt_arena_array(arena, BLOCKS * BLOCK_FACES, sizeof(*m.face));
    for (int i = 0; i < BLOCKS * CORNERS; i++)
        for (int k = 0; k < 3; k++)
            m.vertex[i][k] = at[i / CORNERS][i >> k & 1][k];
    for (int i = 0; i < BLOCKS * BLOCK_FACES; i++)
        for (int k = 0; k < 3; k++)
            m.face[i][k] = i / BLOCK_FACES * CORNERS + face[i % BLOCK_FACES][k];
    return m;
}

static lt_mesh randomly_moved(const lt_mesh *from, uint64_t draw)
{
    lt_rng rng = lt_rng_make(8, draw);
    const double scale = lt_rng_range(&rng, 0.5, 2);
    lt_mesh m = *from;
    double q[4], R[9], t[3];

    for (int k = 0; k < 4; k++)
        q[k] = lt_rng_normal(&rng);
    for (int k = 0; k < 3; k++)
        t[k] = lt_rng_range(&rng, -1, 1);
    lt_rot_from_quat(q, R);
    m.vertex = lt_arena_array(arena, (size_t)m.n_vertices, sizeof(*m.vertex));
    for (int i = 0; i < m.n_vertices; i++) {
        const double x[3] = { (double)from->vertex[i][0], (double)from->vertex[i][1], (double)from->vertex[i][2] };
        double y[3];

        lt_mat3_mulvec(R, x, y);
        for (int k = 0; k < 3; k++)
            m.vertex[i][k] = (float)(scale * y[k] + t[k]);
    }
    return m;
}

START_TEST(undone)
{
    const lt_mesh m = make_blocks(), other = randomly_moved(&m, (uint64_t)_i);
    eval_shape_score first = { 0 }, s;

    for (int threads = 1; threads <= 4; threads += 3) {
        lt_set_threads(threads);
        check_ok(eval_shape(EVAL_BY_SIMILARITY, &other, &m, &s));
        ck_assert_msg(s.cd_cm2 < 1e-4, "CD %g cm^2", s.cd_cm2);
        ck_assert_double_eq(s.f_1mm, 1);
        if (threads > 1)
            ck_assert_int_eq(memcmp(&first, &s, sizeof(s)), 0);
        first = s;
    }
    check_ok(eval_shape(EVAL_AS_IT_IS, &m, &m, &s));
    ck_assert_double_eq(s.cd_cm2, 0);
    check_ok(eval_shape_of_vertices(&other, &m, &s));
    ck_assert_msg(s.cd_cm2 < 1e-4, "CD %g cm^2", s.cd_cm2);
}
END_TEST

/* A vertex that one of two meshes has besides is the furthest from the other's, and no sample of a surface is there. */
START_TEST(vertices_alone)
{
    lt_mesh m = make_blocks(), more = make_blocks();
    float (*vertex)[3] = lt_arena_array(arena, (size_t)m.n_vertices + 1, sizeof(*vertex));
    eval_shape_score s, of_surface;

    memcpy(vertex, m.vertex, (size_t)m.n_vertices * sizeof(*vertex));
    memcpy(vertex[m.n_vertices], (float[]){ 0.09f, 0.03f, 0.05f }, sizeof(*vertex));
    more.vertex = vertex;
    more.n_vertices++;
    check_ok(eval_shape_of_vertices(&more, &m, &s));
    check_ok(eval_shape(EVAL_BY_SIMILARITY, &more, &m, &of_surface));
    ck_assert(of_surface.cd_cm2 < 1e-4);
    ck_assert_msg(fabs(s.cd_cm2 - 1 / (double)more.n_vertices) < 1e-3, "CD %g cm^2", s.cd_cm2);  /* 1 cm off */
    ck_assert_double_lt(s.f_5mm, 1);
}
END_TEST

/* Vertices of two meshes that are alike, whose wrists are 2 cm apart: CD is at most twice the square of that */
START_TEST(with_pose)
{
    const lt_mesh m = make_blocks();
    const float here[3] = { 0 }, there[3] = { 0.02f, 0, 0 };
    double cd;

    check_ok(eval_pose_chamfer_cm2(&m, here, &m, here, &cd));
    ck_assert_double_eq(cd, 0);
    check_ok(eval_pose_chamfer_cm2(&m, here, &m, there, &cd));
    ck_assert(cd > 0.5 && cd <= 8 + 1e-5);
}
END_TEST

START_TEST(bad_shapes)
{
    const double one[1][3] = { { 0 } }, none[1][3] = { { NAN, 0, 0 } };
    float vertex[3][3] = { { 0 } };
    int32_t face[1][3] = { { 0, 1, 2 } };
    const lt_mesh flat = { .n_vertices = 3, .n_faces = 1, .vertex = vertex, .face = face };
    eval_shape_score s;
    lt_similarity to;

    check_error(eval_shape(EVAL_AS_IT_IS, &flat, &flat, &s), LT_EINVAL, "want more than 0");
    check_error(lt_icp_scale_translation(1, one, 1, one, &to), LT_EINVAL, "all of a set's points are one");
    check_error(lt_icp_best_similarity(0, one, 1, one, &opts, &to), LT_EINVAL, "a set of 0 points");
    check_error(lt_icp_best_similarity(1, none, 1, one, &opts, &to), LT_EINVAL, "a coordinate is not finite");
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_set_timeout(t, 120);
    tcase_add_test(t, as_it_is);
    tcase_add_test(t, similarity);
    tcase_add_test(t, no_rotation);
    tcase_add_test(t, scale_and_translation_of_four);
    tcase_add_test(t, vertices_alone);
    tcase_add_loop_test(t, undone, 0, 3);
    tcase_add_test(t, with_pose);
    tcase_add_test(t, bad_shapes);
}

int main(void)
{
    return run_suite("shape", add_tests);
}
