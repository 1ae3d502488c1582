/* SPDX-License-Identifier: Apache-2.0 */
/* Motions keep their limits, views see what they should, rooms are cleared, casts are as promised. */
#include "assets/ycb/objects.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/rotation.h"
#include "synth/cast.h"
#include "synth/take/clearing.h"
#include "synth/take/sequence.h"
#include "synth/take/subject.h"
#include "synth/take/view.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

static lt_arena *arena;
static lt_hand_model *hand;
static synth_subject subject;
static lt_mesh object;
static synth_grasp grasp;

/* A hand beside a mustard bottle, bent as if it held it: contact is not what is tested here. */
static void setup(void)
{
    const double sideways[3] = { 0, 0, M_PI / 2 };
    double R[9], at[3] = { 0.0, 0.14, 0.0 }, J0[3];

    arena = lt_arena_new();
    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
    check_ok(synth_object_new(arena, 5, &object));
    synth_subject_draw(hand, 1, 0, &subject);
    memcpy(J0, subject.rest_wrist, sizeof(J0));
    memset(&grasp, 0, sizeof(grasp));
    lt_rot_from_axis_angle(sideways, R);
    lt_rot_to_axis_angle(R, grasp.pose);
    for (int j = 1; j < 13; j++)
        grasp.pose[3 * j + 2] = 0.7;
    for (int k = 0; k < 3; k++)
        grasp.trans[k] = at[k] - J0[k];
    grasp.lowest = 0.03;
}

static void teardown(void)
{
    lt_arena_free(arena);
}

static synth_sequence make(uint64_t stream, int min_moments)
{
    synth_sequence_spec spec = { .grasp = &grasp, .object = &object, .min_moments = min_moments, .seed = 4,
                                 .stream = stream };
    synth_sequence s;

    memcpy(spec.rest_wrist, subject.rest_wrist, sizeof(spec.rest_wrist));
    check_ok(synth_sequence_new(arena, &spec, &s));
    return s;
}

static void limits(const synth_sequence *s)
{
    synth_posed_hand now, before;

    for (int t = 0; t < s->n; t++) {
        const synth_moment *m = &s->moment[t];
        synth_subject_pose(&subject, hand, m->R_hand, m->wrist, m->fingers, &now);
        for (int i = 0; t > 0 && i < LT_HAND_KEYPOINTS; i++)
            ck_assert_double_le(lt_vec3_distance(now.keypoints[i], before.keypoints[i]), SYNTH_MAX_STEP);
        if (t > 0) {
            ck_assert_double_le(lt_rot_angle(m->R_hand, m[-1].R_hand), SYNTH_MAX_TURN);
            ck_assert_double_le(lt_rot_angle(m->R_obj, m[-1].R_obj), SYNTH_MAX_TURN);
            ck_assert_int_ge(m->phase, m[-1].phase);
        }
        before = now;
    }
}

START_TEST(motion_keeps_its_limits)
{
    grasp.lowest = _i % 2 ? 0.03 : -0.01;
    for (uint64_t k = 0; k < 20; k++) {
        const synth_sequence s = make(k, 16);
        ck_assert_int_ge(s.n, 48);
        ck_assert_int_eq(s.held, _i % 2 == 0);
        limits(&s);
    }
}
END_TEST

START_TEST(motion_is_as_long_as_asked)
{
    const synth_sequence s = make(1, 190);

    ck_assert_int_ge(s.n, 190);
    limits(&s);
}
END_TEST

START_TEST(rounds_follow_each_other)
{
    const synth_sequence part[2] = { make(3, 48), make(4, 60) };
    synth_sequence all;

    check_ok(synth_sequence_join(arena, part, 2, &all));
    ck_assert_int_eq(all.n, part[0].n + part[1].n);
    ck_assert_int_eq(all.held, part[0].held);
    for (int t = 0; t < all.n; t++) {
        const int round = t >= part[0].n;
        synth_moment want = part[round].moment[t - round * part[0].n];

        want.round = round;
        ck_assert_mem_eq(&all.moment[t], &want, sizeof(want));
    }
}
END_TEST

/* The wrist stays where the grasp has it, but for the slip, as long as the object is handled. */
START_TEST(held_things_move_with_the_hand)
{
    const synth_sequence s = make(2, 48);
    double grip[3], R[9], want[9];
    int handled = 0;

    for (int k = 0; k < 3; k++)
        grip[k] = subject.rest_wrist[k] + grasp.trans[k];
    lt_rot_from_axis_angle(grasp.pose, want);
    for (int t = 0; t < s.n; t++) {
        const synth_moment *m = &s.moment[t];
        double at[3], back[9];
        if (m->phase != SYNTH_MANIPULATE)
            continue;
        lt_rigid_apply(m->R_obj, m->t_obj, grip, at);
        ck_assert_double_le(lt_vec3_distance(at, m->wrist), 0.0015);
        lt_mat3_transpose(m->R_obj, back);
        lt_mat3_mul(back, m->R_hand, R);
        ck_assert_double_le(lt_rot_angle(R, want), 1e-6);
        ck_assert_double_gt(m->t_obj[2], 0.02);
        handled++;
    }
    ck_assert_int_gt(handled, 10);
}
END_TEST

/* Before it is lifted and after it is put back the object stands on the table. */
START_TEST(objects_stand)
{
    const synth_sequence s = make(3, 48);
    const int at[2] = { 0, s.n - 1 };

    for (int i = 0; i < 2; i++) {
        const synth_moment *m = &s.moment[at[i]];
        double lowest = INFINITY;
        for (int v = 0; v < object.n_vertices; v++) {
            const double x[3] = { object.vertex[v][0], object.vertex[v][1], object.vertex[v][2] };
            double p[3];
            lt_rigid_apply(m->R_obj, m->t_obj, x, p);
            lowest = fmin(lowest, p[2]);
        }
        ck_assert_double_eq_tol(lowest, 0, 1e-6);
    }
}
END_TEST

START_TEST(views_see_the_hand)
{
    const synth_sequence s = make(5, 48);
    synth_sight sight[12];
    synth_camera camera[3];

    for (int i = 0; i < 12; i++) {
        const synth_moment *m = &s.moment[i * (s.n - 1) / 11];
        synth_posed_hand posed;
        synth_subject_pose(&subject, hand, m->R_hand, m->wrist, m->fingers, &posed);
        memcpy(sight[i].keypoints, posed.keypoints, sizeof(posed.keypoints));
        memcpy(sight[i].object, m->t_obj, sizeof(m->t_obj));
        for (int k = 0; k < 3; k++)
            sight[i].elbow[k] = m->R_hand[3 * k];
    }
    synth_view_choose(sight, 12, 7, 1, 0, 3, camera);
    for (int c = 0; c < 3; c++) {
        const lt_camera cam = { camera[c].fx, camera[c].fy, camera[c].cx, camera[c].cy };
        int inside = 0;
        ck_assert_double_eq_tol(lt_mat3_det(camera[c].R_cam_world), 1, 1e-9);
        ck_assert(camera[c].fx >= 600 && camera[c].fx <= 620);
        for (int i = 0; i < 12 * LT_HAND_KEYPOINTS; i++) {
            double p[3], uv[2];
            lt_rigid_apply(camera[c].R_cam_world, camera[c].t_cam_world, sight[i / 21].keypoints[i % 21], p);
            ck_assert(lt_camera_project(&cam, p, uv));
            inside += uv[0] >= 0 && uv[0] < 640 && uv[1] >= 0 && uv[1] < 480;
        }
        ck_assert_int_ge(inside, 12 * LT_HAND_KEYPOINTS * 9 / 10);
    }
}
END_TEST

/* A unit square: a thing of it stands where it is put. */
static synth_instance thing(const lt_mesh *square, double x, double y, double z, bool no_shadow)
{
    return (synth_instance){ .mesh = square, .R_world_obj = { .1, 0, 0, 0, .1, 0, 0, 0, .1 },
                             .t_world_obj = { x, y, z }, .no_shadow = no_shadow };
}

START_TEST(way_is_cleared)
{
    float vertex[4][3] = { { -.5f, -.5f, 0 }, { .5f, -.5f, 0 }, { .5f, .5f, 1 }, { -.5f, .5f, 1 } };
    const lt_mesh square = { .n_vertices = 4, .vertex = vertex };
    static synth_room room;
    const synth_ball ball = { { 0.02, 0, 0.12 }, 0.03 };

    room.n_instances = 0;
    room.instance[room.n_instances++] = thing(&square, 0, 0, 0, true);          /* a table */
    room.instance[room.n_instances++] = thing(&square, 0, 0, 0, false);         /* in the way */
    room.instance[room.n_instances++] = thing(&square, 0.01, 0, -0.05, false);  /* lower, part of it */
    room.instance[room.n_instances++] = thing(&square, 0.3, 0, 0, false);       /* elsewhere */
    synth_clear_way(&room, &ball, 1);
    ck_assert_int_eq(room.n_instances, 2);
    ck_assert(room.instance[0].no_shadow);
    ck_assert_double_eq(room.instance[1].t_world_obj[0], 0.3);
}
END_TEST

START_TEST(casts)
{
    static const int sequences[] = { 6, 48, 151, 246, 200 }, frames[] = { 96, 2304, 2416, 11808, 14000 };
    static const int rounds[] = { 1, 24, 8, 48, 1 };
    int jugs = 0;
    synth_cast c;

    for (int p = 0; p < (int)LT_COUNT(frames); p++) {
        int all = 0;
        check_ok(synth_cast_plan((synth_preset)p, 0, &c));
        ck_assert_int_eq(c.n_takes * c.n_cameras, sequences[p]);
        for (int i = 0; i < c.n_takes; i++) {
            ck_assert_int_eq(c.take[i].rounds, rounds[p]);
            all += c.take[i].frames * c.n_cameras;
            ck_assert(c.take[i].subject < c.n_subjects);
            ck_assert(c.take[i].evaluation || c.take[i].object != 11);  /* the pitcher is never trained on */
            for (int k = 0; k < i; k++)
                ck_assert_str_ne(c.take[i].base, c.take[k].base);
        }
        ck_assert_int_eq(all, frames[p]);
    }
    ck_assert_int_eq(c.n_subjects, 10);
    ck_assert_int_eq(c.n_objects, 10);
    check_ok(synth_cast_plan(SYNTH_PRETRAIN, 0, &c));
    for (int i = 0; i < 240; i++) {
        ck_assert_int_eq(c.take[i].subject, i);             /* a hand of its own to each sequence */
        jugs += c.take[i].object == SYNTH_JUG;
    }
    ck_assert_int_eq(jugs, 53);
    check_ok(synth_cast_plan(SYNTH_TINY, 14, &c));
    ck_assert_int_eq(c.take[0].frames, 3);
    ck_assert_int_eq(c.take[5].frames, 2);
    check_ok(synth_cast_plan(SYNTH_SMALL, 96, &c));
    ck_assert_int_eq(c.take[0].rounds, 2);                  /* no more than frames */
    ck_assert_int_eq(synth_cast_plan(SYNTH_TINY, 5, &c), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "5 frames: preset tiny has 6 sequences, and each needs 1 to 199 frames");
}
END_TEST

START_TEST(presets)
{
    synth_preset p;

    check_ok(synth_parse_preset("small", &p));
    ck_assert_int_eq(p, SYNTH_SMALL);
    ck_assert_int_eq(synth_parse_preset("huge", &p), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "no preset \"huge\": tiny, small, demo, pretrain, default, hogs, "
                     "detect, track, actions, body, turntable or world");
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_unchecked_fixture(c, setup, teardown);
    tcase_set_timeout(c, 120);
    tcase_add_loop_test(c, motion_keeps_its_limits, 0, 2);
    tcase_add_test(c, motion_is_as_long_as_asked);
    tcase_add_test(c, rounds_follow_each_other);
    tcase_add_test(c, held_things_move_with_the_hand);
    tcase_add_test(c, objects_stand);
    tcase_add_test(c, views_see_the_hand);
    tcase_add_test(c, way_is_cleared);
    tcase_add_test(c, casts);
    tcase_add_test(c, presets);
}

int main(void)
{
    return run_suite("sequence", add_tests);
}
