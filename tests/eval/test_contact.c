/* SPDX-License-Identifier: Apache-2.0 */
/* How a hand touches an object: cubes whose answers are known, and cubes in a hand. */
#include "eval/metrics/contact.h"

#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/surface.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <math.h>

static lt_arena *arena;
static const double one[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, origin[3] = { 0, 0, 0 };

/* ---- cubes of 40 mm, counter-clockwise from outside ---- */

typedef struct { float vertex[8][3]; int32_t face[12][3]; lt_mesh mesh; } cube;

static void make_cube(cube *c, double x, double y, double z)
{
    static const int32_t face[12][3] = {
        { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
        { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 },
    };

    for (int i = 0; i < 8; i++) {
        c->vertex[i][0] = (float)(x + (i & 1 ? 0.02 : -0.02));
        c->vertex[i][1] = (float)(y + (i & 2 ? 0.02 : -0.02));
        c->vertex[i][2] = (float)(z + (i & 4 ? 0.02 : -0.02));
    }
    memcpy(c->face, face, sizeof(face));
    c->mesh = (lt_mesh){ .n_vertices = 8, .n_faces = 12, .vertex = c->vertex, .face = c->face };
}

static eval_contact_score of_cubes(const double R[9], const double t[3], double x, double y, double z)
{
    eval_contact_object *object;
    eval_contact_score s;
    cube a, b;

    make_cube(&a, 0, 0, 0);
    make_cube(&b, x, y, z);
    for (int i = 0; i < 8; i++) {               /* the hand goes where the object goes */
        const double p[3] = { b.vertex[i][0], b.vertex[i][1], b.vertex[i][2] };
        double q[3];
        lt_rigid_apply(R, t, p, q);
        for (int k = 0; k < 3; k++)
            b.vertex[i][k] = (float)q[k];
    }
    check_ok(eval_contact_object_new(arena, &a.mesh, &object));
    check_ok(eval_contact(object, R, t, &b.mesh, &s));
    return s;
}

/* One corner is in: 5 mm deep; 2 x 7 x 7 voxels, and 10 x 35 x 35 mm exactly. However both lie in the camera's frame,
 * and in a mirror. */
START_TEST(two_cubes)
{
    const double turn[3] = { 0.3, -0.7, 1.1 }, t[3] = { 0.1, -0.2, 0.7 };
    double R[9];
    eval_contact_score s;

    lt_rot_from_axis_angle(turn, R);
    if (_i == 0)
        memcpy(R, one, sizeof(R));
    for (int i = 0; i < 9 && _i == 2; i += 3)
        R[i] = -R[i];
    s = of_cubes(R, _i ? t : origin, 0.030, 0.005, 0.005);
    ck_assert_double_eq_tol(s.penetration_mm, 5, 1e-3);
    ck_assert_double_eq_tol(s.intersection_cm3, 12.25, 1e-9);
    ck_assert(s.contact);
}
END_TEST

/* A gap of 3 mm is a touch, one of 5 is none. */
START_TEST(cubes_apart)
{
    const eval_contact_score near = of_cubes(one, origin, 0.043, 0, 0), far = of_cubes(one, origin, 0.045, 0, 0);

    ck_assert(near.contact && near.penetration_mm == 0 && near.intersection_cm3 == 0);
    ck_assert(!far.contact && far.penetration_mm == 0 && far.intersection_cm3 == 0);
}
END_TEST

START_TEST(cube_in_itself)
{
    const eval_contact_score s = of_cubes(one, origin, 0, 0, 0);

    ck_assert_double_eq_tol(s.intersection_cm3, 64, 1e-9);
    ck_assert(s.contact);
}
END_TEST

/* ---- a hand ---- */

static void pose_flat(const lt_hand_model *hand, float (*vertex)[3])
{
    double R[9 * LT_HAND_JOINTS] = { 0 }, beta[LT_HAND_BETAS] = { 0 }, v[LT_HAND_VERTICES][3];

    for (int j = 0; j < LT_HAND_JOINTS; j++)
        R[9 * j] = R[9 * j + 4] = R[9 * j + 8] = 1;
    lt_hand_pose(hand, R, beta, NULL, v[0], NULL);
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int k = 0; k < 3; k++)
            vertex[i][k] = (float)v[i][k];
}

/* Closed, a hand of either side has faces that look outwards, and two of them at every edge. */
START_TEST(hands_are_closed)
{
    static int32_t face[EVAL_CLOSED_HAND_FACES][3];
    static float vertex[LT_HAND_VERTICES][3];
    lt_hand_model *right, *left = lt_arena_alloc(arena, sizeof(*left));
    lt_mesh mesh = { .n_vertices = LT_HAND_VERTICES, .n_faces = EVAL_CLOSED_HAND_FACES, .vertex = vertex,
                     .face = face };
    lt_mesh_index *index;
    double p[3];

    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &right));
    synth_hand_mirror(right, left);
    for (int side = 0; side < 2; side++) {
        const lt_hand_model *hand = side ? left : right;
        pose_flat(hand, vertex);
        eval_close_hand(hand, face);
        check_ok(lt_mesh_index_new(arena, &mesh, &index));
        for (int k = 0; k < 3; k++)             /* in the palm, between its front and its back */
            p[k] = (vertex[95][k] + vertex[22][k]) / 2;
        ck_assert_double_eq_tol(lt_mesh_winding(index, p), 1, 0.01);
        for (int k = 0; k < 3; k++)             /* in the wrist, just before its end */
            p[k] = (vertex[92][k] + vertex[79][k]) / 2 - (k == 0) * (side ? -0.003 : 0.003);
        ck_assert_double_eq_tol(lt_mesh_winding(index, p), 1, 0.02);
        p[0] += side ? -0.02 : 0.02;
        ck_assert_double_eq_tol(lt_mesh_winding(index, p), 0, 0.02);
    }
}
END_TEST

/* All of an object that lies in the palm is shared: one voxel, and eight. */
START_TEST(small_object_in_a_hand)
{
    static int32_t face[EVAL_CLOSED_HAND_FACES][3];
    static float vertex[LT_HAND_VERTICES][3];
    static const double sizes[] = { 0.1, 0.2 };
    lt_mesh mesh = { .n_vertices = LT_HAND_VERTICES, .n_faces = EVAL_CLOSED_HAND_FACES, .vertex = vertex,
                     .face = face };
    eval_contact_object *object;
    eval_contact_score s;
    lt_hand_model *hand;
    double t[3];
    cube c;

    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
    pose_flat(hand, vertex);
    eval_close_hand(hand, face);
    for (int k = 0; k < 3; k++)
        t[k] = (vertex[95][k] + vertex[22][k]) / 2;
    for (size_t i = 0; i < LT_COUNT(sizes); i++) {
        make_cube(&c, 0, 0, 0);
        for (int v = 0; v < 24; v++)
            c.vertex[v / 3][v % 3] *= (float)sizes[i];      /* 4 and 8 mm */
        check_ok(eval_contact_object_new(arena, &c.mesh, &object));
        check_ok(eval_contact(object, one, t, &mesh, &s));
        ck_assert_double_eq_tol(s.intersection_cm3, i ? 1 : 0.125, 1e-9);
        ck_assert_double_eq(s.penetration_mm, 0);           /* no vertex of the hand is that deep in itself */
    }
}
END_TEST

START_TEST(refused)
{
    eval_contact_object *object;
    eval_contact_score s;
    cube c, hand;

    make_cube(&c, 0, 0, 0);
    make_cube(&hand, 0, 0, 0);
    check_ok(eval_contact_object_new(arena, &c.mesh, &object));
    hand.vertex[3][1] = NAN;
    check_error(eval_contact(object, one, origin, &hand.mesh, &s), LT_EINVAL,
                "vertex 3 has a coordinate that is not finite");
    c.vertex[7][0] = 3;
    check_error(eval_contact_object_new(arena, &c.mesh, &object), LT_EINVAL,
                "contact: the object is 3.02 m large, want at most 2");
    c.mesh.n_faces = 0;
    check_error(eval_contact_object_new(arena, &c.mesh, &object), LT_EINVAL, "0 faces");
}
END_TEST

static void setup(void)
{
    arena = lt_arena_new();
}

static void teardown(void)
{
    lt_arena_free(arena);
}

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_set_timeout(c, 0);
    tcase_add_loop_test(c, two_cubes, 0, 3);
    tcase_add_test(c, cubes_apart);
    tcase_add_test(c, cube_in_itself);
    tcase_add_test(c, hands_are_closed);
    tcase_add_test(c, small_object_in_a_hand);
    tcase_add_test(c, refused);
}

int main(void)
{
    return run_suite("contact", add_tests);
}
