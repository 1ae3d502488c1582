/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Distance fields and grasps, held against brute force on the meshes themselves.
 */
#include "assets/hand/hand.h"
#include "assets/ycb/objects.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mesh/surface.h"
#include "libtensor/geometry/rotation.h"
#include "synth/grasp/grasp.h"
#include "synth/grasp/sdf.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

static const int grasped[] = { 3, 5, 10, 13 };          /* one part each, so that inside is plain */
static lt_arena *arena;
static lt_hand_model *hand;

static void setup_hand(void)
{
    arena = lt_arena_new();
    ck_assert_int_eq(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand), LT_OK);
}

static void teardown_hand(void)
{
    lt_arena_free(arena);
}

/* ---- distance fields ------------------------------------------------------------------------------ */

static void near_surface(const lt_mesh *m, lt_rng *rng, double p[3])
{
    const float *v = m->vertex[lt_rng_below(rng, (uint32_t)m->n_vertices)];

    for (int k = 0; k < 3; k++)
        p[k] = v[k] + 3e-3 * lt_rng_normal(rng);
}

/* Interpolation cuts corners of edges by a part of the step; on the whole it is far better. */
START_TEST(sdf_distance)
{
    lt_rng rng = lt_rng_make(1, (uint64_t)_i);
    double worst = 0, sum = 0, p[3];
    lt_mesh_index *index;
    lt_mesh mesh;
    synth_sdf sdf;
    int n = 0;

    ck_assert_int_eq(synth_object_new(arena, grasped[_i], &mesh), LT_OK);
    ck_assert_int_eq(synth_sdf_new(arena, &mesh, &sdf), LT_OK);
    ck_assert_int_eq(lt_mesh_index_new(arena, &mesh, &index), LT_OK);
    for (int i = 0; i < 2000; i++) {
        near_surface(&mesh, &rng, p);
        const double d = lt_mesh_closest(index, p).distance, got = synth_sdf_at(&sdf, p, NULL);
        if (d > 5e-3)
            continue;
        worst = fmax(worst, fabs(fabs(got) - d));
        sum += fabs(fabs(got) - d);
        n++;
        if (d > 1.2e-3)
            ck_assert_int_eq(got < 0, lt_mesh_inside(index, p));
    }
    ck_assert_double_lt(worst, 1.2e-3);
    ck_assert_double_lt(sum / n, 1.2e-4);
}
END_TEST

START_TEST(sdf_gradient)
{
    lt_rng rng = lt_rng_make(2, 0);
    const double h = 1e-7;
    double p[3], g[3], q[3];
    lt_mesh mesh;
    synth_sdf sdf;

    ck_assert_int_eq(synth_object_new(arena, 9, &mesh), LT_OK);
    ck_assert_int_eq(synth_sdf_new(arena, &mesh, &sdf), LT_OK);
    for (int i = 0; i < 300; i++) {
        near_surface(&mesh, &rng, p);
        synth_sdf_at(&sdf, p, g);
        for (int k = 0; k < 3; k++) {
            const double at = (p[k] - sdf.origin[k]) / sdf.step;
            if (at - floor(at) < 1e-3 || at - floor(at) > 0.999)
                continue;                               /* a kink between cells */
            memcpy(q, p, sizeof(q));
            q[k] = p[k] + h;
            const double up = synth_sdf_at(&sdf, q, NULL);
            q[k] = p[k] - h;
            ck_assert_double_eq_tol((up - synth_sdf_at(&sdf, q, NULL)) / (2 * h), g[k], 1e-6);
        }
    }
}
END_TEST

START_TEST(sdf_outside)
{
    double p[3], g[3];
    lt_mesh mesh;
    synth_sdf sdf;

    ck_assert_int_eq(synth_object_new(arena, 21, &mesh), LT_OK);
    ck_assert_int_eq(synth_sdf_new(arena, &mesh, &sdf), LT_OK);
    for (int k = 0; k < 3; k++)
        p[k] = sdf.origin[k] + sdf.step * sdf.n[k] / 2;
    p[0] += 1;
    ck_assert_double_eq_tol(synth_sdf_at(&sdf, p, g), 1 - 0.0263, 3e-3);
    ck_assert_double_eq_tol(g[0], 1, 1e-12);
}
END_TEST

/* A box and another whose lower half is inside it: their union, so a point on the hidden wall is deep inside. */
static void add_box(lt_mesh *m, double x, double h)
{
    static const int quad[6][4] = { { 0, 2, 3, 1 }, { 4, 5, 7, 6 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 },
                                    { 0, 4, 6, 2 }, { 1, 3, 7, 5 } };
    const int v0 = m->n_vertices;

    for (int i = 0; i < 8; i++) {
        float *v = m->vertex[m->n_vertices++];
        v[0] = (float)(x + (i & 1 ? h : -h));
        v[1] = (float)(i & 2 ? h : -h);
        v[2] = (float)(i & 4 ? h : -h);
    }
    for (int q = 0; q < 6; q++)
        for (int t = 0; t < 2; t++) {
            int32_t *f = m->face[m->n_faces++];
            f[0] = v0 + quad[q][0];
            f[1] = v0 + quad[q][1 + t];
            f[2] = v0 + quad[q][2 + t];
        }
}

START_TEST(sdf_union)
{
    float vertex[16][3];
    int32_t face[24][3];
    lt_mesh mesh = { .vertex = vertex, .face = face };
    const double hidden[3] = { 0.01, 0, 0 }, out[3] = { -0.0225, 0, 0 }, in[3] = { 0.033, 0, 0 };
    synth_sdf sdf;

    add_box(&mesh, 0, 0.02);
    add_box(&mesh, 0.022, 0.012);                       /* its wall at 0.01 is hidden in the first */
    ck_assert_int_eq(synth_sdf_new(arena, &mesh, &sdf), LT_OK);
    ck_assert_double_le(synth_sdf_at(&sdf, hidden, NULL), -6e-3);
    ck_assert_double_eq_tol(synth_sdf_at(&sdf, out, NULL), 2.5e-3, 1e-5);
    ck_assert_double_eq_tol(synth_sdf_at(&sdf, in, NULL), -1e-3, 1e-5);
}
END_TEST

START_TEST(sdf_bad)
{
    lt_mesh mesh = { 0 };
    synth_sdf sdf;

    ck_assert_int_eq(synth_sdf_new(arena, &mesh, &sdf), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "distance field: the mesh is empty");
}
END_TEST

/* ---- grasps --------------------------------------------------------------------------------------- */

static void pose_hand(const synth_grasp *g, const double *beta, double (*p)[3], double (*joints)[3])
{
    double R[16][9];

    for (int j = 0; j < 16; j++)
        lt_rot_from_axis_angle(&g->pose[3 * j], R[j]);
    lt_hand_pose(hand, R[0], beta, g->trans, p[0], joints[0]);
}

static const double no_shape[LT_HAND_BETAS];

/* How deep one part of the hand is in another */
static double self_depth(const double (*p)[3], const double (*joints)[3])
{
    double keypoints[LT_HAND_KEYPOINTS][3];
    uint8_t part[LT_HAND_VERTICES];

    synth_hand_parts(hand, part);
    lt_hand_keypoints(p[0], joints[0], lt_hand_tips_ho3d, LT_HAND_MANO_ORDER, keypoints[0]);
    return synth_hand_self_depth(part, p, (const double (*)[3])keypoints);
}

/* thumb, index, middle, ring, little: the finger of a vertex, -1 for the palm. */
static int finger_of(int v)
{
    static const int order[5] = { 1, 2, 4, 3, 0 };
    int best = 0;

    for (int j = 1; j < LT_HAND_JOINTS; j++)
        if (hand->weights[v][j] > hand->weights[v][best])
            best = j;
    return best ? order[(best - 1) / 3] : -1;
}

static void check_grasp(const synth_grasp *g, const double *beta, const lt_mesh_index *index)
{
    double p[LT_HAND_VERTICES][3], joints[LT_HAND_JOINTS][3], near[5], deepest = 0, sum = 0;
    int fingers = 0, inside = 0;

    for (int f = 0; f < 5; f++)
        near[f] = INFINITY;
    pose_hand(g, beta, p, joints);
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        const double d = lt_mesh_closest(index, p[v]).distance;
        const int f = finger_of(v);
        if (f >= 0)
            near[f] = fmin(near[f], d);
        if (!lt_mesh_inside(index, p[v]))
            continue;
        deepest = fmax(deepest, d);
        sum += d;
        inside++;
    }
    for (int f = 0; f < 5; f++)
        fingers += near[f] < 4e-3;
    ck_assert_int_ge(fingers, 3);
    ck_assert_double_lt(near[0], 4e-3);
    ck_assert_double_lt(deepest, 3e-3);
    ck_assert_double_lt(sum / (inside + 1), 1.5e-3);
    ck_assert_double_le(g->volume, 2e-6);
    ck_assert_double_le(self_depth((const double (*)[3])p, (const double (*)[3])joints), 1e-3);
    for (int f = 0; f < 5; f++)
        ck_assert(!g->contact[f] || near[f] < 4e-3);
}

/* n grasps of seeds first, first + 1 ... */
static void draw_grasps(const synth_grasp_ctx *ctx, uint64_t first, int n, synth_grasp_stats *stats, synth_grasp *out)
{
    for (int i = 0; i < n; i++)
        check_ok(synth_grasp_sample(ctx, first + (uint64_t)i, stats, &out[i]));
}

START_TEST(grasps_hold)
{
    synth_grasp_stats stats = { 0 };
    synth_grasp_ctx *ctx;
    lt_mesh_index *index;
    synth_grasp g[8];
    lt_mesh mesh;

    ck_assert_int_eq(synth_object_new(arena, grasped[_i], &mesh), LT_OK);
    ck_assert_int_eq(lt_mesh_index_new(arena, &mesh, &index), LT_OK);
    ck_assert_int_eq(synth_grasp_ctx_new(arena, grasped[_i], &mesh, NULL, hand, NULL, &ctx), LT_OK);
    draw_grasps(ctx, 11, 8, &stats, g);
    for (int i = 0; i < 8; i++)
        check_grasp(&g[i], no_shape, index);
    ck_assert_int_eq(stats.accepted, 8);
    ck_assert_int_eq(stats.tried, stats.accepted + stats.no_contact + stats.too_deep + stats.no_balance
                                      + stats.crossed);
    ck_assert_int_lt(stats.tried, 80);
}
END_TEST

/* Every object can be grasped. */
START_TEST(every_object)
{
    synth_grasp_ctx *ctx;
    synth_grasp g[4];
    lt_mesh mesh;

    ck_assert_int_eq(synth_object_new(arena, _i, &mesh), LT_OK);
    ck_assert_int_eq(synth_grasp_ctx_new(arena, _i, &mesh, NULL, hand, NULL, &ctx), LT_OK);
    draw_grasps(ctx, 1, 4, NULL, g);
}
END_TEST

/* A hand of another shape holds things as well, and a seed gives it one grasp. */
START_TEST(another_hand)
{
    const double beta[LT_HAND_BETAS] = { 1, -0.8, 0.5 };
    synth_grasp_ctx *ctx;
    lt_mesh_index *index;
    synth_grasp g[4], again;
    lt_mesh mesh;

    ck_assert_int_eq(synth_object_new(arena, 5, &mesh), LT_OK);
    ck_assert_int_eq(lt_mesh_index_new(arena, &mesh, &index), LT_OK);
    ck_assert_int_eq(synth_grasp_ctx_new(arena, 5, &mesh, NULL, hand, beta, &ctx), LT_OK);
    draw_grasps(ctx, 1, 4, NULL, g);
    for (int i = 0; i < 4; i++)
        check_grasp(&g[i], beta, index);
    draw_grasps(ctx, 1, 1, NULL, &again);
    ck_assert_mem_eq(&again, &g[0], sizeof(again));
    ck_assert_mem_ne(g[1].pose, g[0].pose, sizeof(g[0].pose));
}
END_TEST

START_TEST(left_hand)
{
    synth_grasp_ctx *ctx;
    lt_hand_model *left = lt_arena_alloc(arena, sizeof(*left));
    lt_mesh mesh;

    synth_hand_mirror(hand, left);
    ck_assert_int_eq(synth_object_new(arena, 3, &mesh), LT_OK);
    ck_assert_int_eq(synth_grasp_ctx_new(arena, 3, &mesh, NULL, left, NULL, &ctx), LT_EINVAL);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_unchecked_fixture(t, setup_hand, teardown_hand);
    tcase_set_timeout(t, 0);
    tcase_add_loop_test(t, sdf_distance, 0, (int)LT_COUNT(grasped));
    tcase_add_test(t, sdf_gradient);
    tcase_add_test(t, sdf_outside);
    tcase_add_test(t, sdf_union);
    tcase_add_test(t, sdf_bad);
    tcase_add_loop_test(t, grasps_hold, 0, (int)LT_COUNT(grasped));
    tcase_add_loop_test(t, every_object, 1, SYNTH_OBJECTS + 1);
    tcase_add_test(t, another_hand);
    tcase_add_test(t, left_hand);
}

int main(void)
{
    setenv("CK_FORK", "no", 1);         /* OpenMP's threads do not survive a fork */
    return run_suite("grasp", add_tests);
}
