/* SPDX-License-Identifier: Apache-2.0 */
/* What the generator's DexYCB layout is made of: who takes what, cameras on a ring, things on a table, left hands. */
#include "data/dexycb/split.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "synth/cast.h"
#include "synth/take/rig.h"
#include "synth/take/stage.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static lt_arena *arena;

static void setup(void)
{
    arena = lt_arena_new();
}

static void teardown(void)
{
    lt_arena_free(arena);
}

/* Five trials of each object, the fifth for evaluation as s0 has it; half of the hands left; 2 to 4 things beside. */
START_TEST(takes_are_counted_as_dexycb_counts)
{
    const dexycb_split train = { .setup = 0, .part = DEXYCB_TRAIN };
    synth_cast *c = lt_arena_alloc(arena, sizeof(*c));
    int left = 0;

    check_ok(synth_cast_plan_dexycb((synth_preset)_i, 0, 7, c));
    for (int i = 0; i < c->n_takes; i++) {
        const synth_take *t = &c->take[i];
        const int per_subject = c->n_takes / c->n_subjects, sequence = i % per_subject;
        ck_assert_int_eq(t->subject, i / per_subject);
        ck_assert_int_eq(t->object, c->object[sequence / 5]);
        ck_assert_int_eq(t->evaluation, !dexycb_has_sequence(train, sequence));
        ck_assert(i == 0 || strcmp(t->base, c->take[i - 1].base) > 0);
        ck_assert(t->n_others >= 2 && t->n_others <= 4);
        for (int k = 0; k < t->n_others; k++) {
            ck_assert_int_ne(t->other[k], t->object);
            for (int l = 0; l < k; l++)
                ck_assert_int_ne(t->other[k], t->other[l]);
        }
        left += t->left;
    }
    ck_assert_int_le(abs(2 * left - c->n_takes), c->n_takes / 5);
    ck_assert_int_eq(synth_cast_plan_dexycb((synth_preset)_i, 3, 7, c), LT_EINVAL);
}
END_TEST

/* The full preset is as large as DexYCB: 10 subjects, 20 objects but the large clamp, 8 cameras. */
START_TEST(default_is_dexycb_sized)
{
    synth_cast *c = lt_arena_alloc(arena, sizeof(*c));

    check_ok(synth_cast_plan_dexycb(SYNTH_DEFAULT, 0, 1, c));
    ck_assert_int_eq(c->n_takes, 1000);
    ck_assert_int_eq(c->n_cameras, 8);
    for (int i = 0; i < c->n_takes; i++)
        ck_assert_int_ne(c->take[i].object, 19);
}
END_TEST

/* Cameras are rigid, on the ring, see the middle of the table in the middle, and keep their lenses. */
START_TEST(ring)
{
    synth_camera a[8], b[8], m[8];
    const double over[3] = { 0.03, -0.02, 0.1 }, mirrored[3] = { -0.03, -0.02, 0.1 };

    synth_rig_new(5, 0, 8, a);
    synth_rig_new(5, 1, 8, b);
    memcpy(m, a, sizeof(m));
    synth_rig_mirror(m, 8);
    for (int i = 0; i < 8; i++) {
        const lt_camera cam = { a[i].fx, a[i].fy, a[i].cx, a[i].cy }, glass = { m[i].fx, m[i].fy, m[i].cx, m[i].cy };
        double p[3], uv[2], back[9], eye[3], q[3], vw[2];
        ck_assert_double_eq_tol(lt_mat3_det(a[i].R_cam_world), 1, 1e-12);
        ck_assert_double_eq_tol(lt_mat3_det(m[i].R_cam_world), 1, 1e-12);
        lt_mat3_transpose(a[i].R_cam_world, back);
        lt_mat3_mulvec(back, a[i].t_cam_world, eye);
        ck_assert_double_eq_tol(hypot(eye[0], eye[1]), 0.8, 1e-9);
        ck_assert(-eye[2] >= 0.3 && -eye[2] <= 0.7);
        lt_rigid_apply(a[i].R_cam_world, a[i].t_cam_world, over, p);
        ck_assert(lt_camera_project(&cam, p, uv));
        ck_assert(uv[0] > 220 && uv[0] < 420 && uv[1] > 160 && uv[1] < 320);
        lt_rigid_apply(m[i].R_cam_world, m[i].t_cam_world, mirrored, q);
        lt_camera_project(&glass, q, vw);
        ck_assert_double_eq_tol(vw[0], 639 - uv[0], 1e-9);
        ck_assert_double_eq_tol(vw[1], uv[1], 1e-9);
        ck_assert_double_eq(a[i].fx, b[i].fx);
        ck_assert_double_ne(a[i].t_cam_world[0], b[i].t_cam_world[0]);
    }
}
END_TEST

/* A box stands on the table, clear of what moves and of what stands there already. */
START_TEST(things_on_the_table)
{
    synth_prop prop;
    synth_ball ball[12] = { { { 0, 0, 0.1 }, 0.12 }, { { 0.1, -0.2, 0.2 }, 0.2 } };
    lt_rng rng = lt_rng_make(1, 2);

    check_ok(synth_prop_new(arena, 9, false, &prop));
    for (int n = 2; n < 8; n++) {
        synth_settled at;
        double lowest = INFINITY;
        ck_assert(synth_settle(&prop.mesh, ball, n, &rng, &at));
        for (int i = 0; i < prop.mesh.n_vertices; i++) {
            const double x[3] = { prop.mesh.vertex[i][0], prop.mesh.vertex[i][1], prop.mesh.vertex[i][2] };
            double p[3];
            lt_rigid_apply(at.R, at.t, x, p);
            lowest = fmin(lowest, p[2]);
            for (int k = 0; k < n; k++)
                ck_assert_double_ge(hypot(p[0] - ball[k].centre[0], p[1] - ball[k].centre[1]), ball[k].radius);
        }
        ck_assert_double_eq_tol(lowest, 0, 1e-7);
        ball[n] = synth_settled_ball(&prop.mesh, &at);
    }
    ball[0].radius = 2;                                         /* no place is left */
    ck_assert(!synth_settle(&prop.mesh, ball, 1, &rng, &(synth_settled){ .t = { 0 } }));
}
END_TEST

/* A grasp of the mirrored mug by a right hand, in the mirror, is a left hand's of the mug: its tips touch the mug. */
START_TEST(left_hands_hold)
{
    synth_prop mug, mirrored;
    synth_grasp_ctx *ctx;
    synth_grasp g;
    lt_hand_model *right, *left;
    double R[16 * 9], trans[3], v[LT_HAND_VERTICES][3], j[16][3];
    int touching = 0;

    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &right));
    left = lt_arena_alloc(arena, sizeof(*left));
    synth_hand_mirror(right, left);
    check_ok(synth_prop_new(arena, 14, false, &mug));
    check_ok(synth_prop_mirror(arena, &mug, &mirrored));
    ck_assert(mirrored.mirrored && !mug.mirrored);
    ck_assert_float_eq_tol((float)mirrored.box.lo[0], -(float)mug.box.hi[0], 1e-7f);
    check_ok(synth_grasp_ctx_new(arena, 14, &mirrored.mesh, &mirrored.sdf, right, NULL, &ctx));
    synth_grasp_ctx_mirror(ctx);
    check_ok(synth_grasp_sample(ctx, 9, NULL, &g));
    for (int i = 0; i < 16; i++) {
        double aa[3] = { g.pose[3 * i], g.pose[3 * i + 1], g.pose[3 * i + 2] };
        lt_mirror_axis_angle(aa);
        lt_rot_from_axis_angle(aa, R + 9 * i);
    }
    memcpy(trans, g.trans, sizeof(trans));
    trans[0] = -trans[0];
    lt_hand_pose(left, R, (double[10]){ 0 }, trans, v[0], j[0]);
    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        const double d = lt_mesh_closest(mug.index, v[i]).distance;
        touching += d < 0.004;
    }
    ck_assert_int_gt(touching, 5);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_set_timeout(c, 0);
    tcase_add_loop_test(c, takes_are_counted_as_dexycb_counts, SYNTH_TINY, SYNTH_DEFAULT + 1);
    tcase_add_test(c, default_is_dexycb_sized);
    tcase_add_test(c, ring);
    tcase_add_test(c, things_on_the_table);
    tcase_add_test(c, left_hands_hold);
}

int main(void)
{
    return run_suite("synth_dexycb", add_tests);
}
