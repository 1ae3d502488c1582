/* SPDX-License-Identifier: Apache-2.0 */
/* The parts of watch that need no pictures: which frames go together, what touches, which tracks are one, what goes
 * on. */
#include "pipeline/watch/internal.h"

#include "tests/suite.h"

#include <math.h>

/* ---- pairing ---- */

static pairing two_cameras(void)
{
    return (pairing){ .n = 2, .reference = 0, .period = 1.0 / 30 };
}

START_TEST(half_a_period)
{
    const pairing p = two_cameras();

    ck_assert(pairing_fits(&p, pairing_apart(&p, 1, 1.016, 1)));
    ck_assert(!pairing_fits(&p, pairing_apart(&p, 1, 1.018, 1)));
    ck_assert(pairing_fits(&p, pairing_apart(&p, 1, 0.984, 1)));
}
END_TEST

/* A clock that is off by less than half a period is believed at first, and by and by known better. */
START_TEST(lagging_clock)
{
    pairing p = two_cameras();

    for (int i = 0; i < PAIRING_REMEMBERED; i++) {
        const double jitter = 0.004 * (i % 3 - 1);

        if (i == 3)
            ck_assert_double_eq(pairing_offset(&p, 1), 0);
        pairing_note(&p, 1, i / 30.0 + 0.012 + jitter, i / 30.0);
    }
    ck_assert_double_eq_tol(pairing_offset(&p, 1), 0.012, 1e-9);
    ck_assert_double_eq(pairing_offset(&p, 0), 0);
}
END_TEST

/* One that is seconds off is known from the first frames that came together. */
START_TEST(another_clock)
{
    pairing p = two_cameras();

    pairing_note(&p, 1, 103.5, 100);
    ck_assert_double_eq_tol(pairing_apart(&p, 1, 104.5, 101), 0, 1e-9);
}
END_TEST

/* ---- contact ---- */

enum { WIDE = 64, HIGH = 48 };

typedef struct {
    watch_options o;
    watch_world w;
    watch_set set;
    watch_sight sight[WATCH_CAMERAS][4];
    float metres[HIGH * WIDE];
} stage_set;

static stage_set *open_stage(int cameras)
{
    stage_set *s = lt_alloc(sizeof(*s));

    s->o.rig.n = cameras;
    s->o.rig.fps = 30;
    for (int c = 0; c < cameras; c++) {
        s->o.rig.camera[c] = (recording_camera){ .name = "a", .width = WIDE, .height = HIGH,
                                                 .K = { 60, 60, 31.5, 23.5 },
                                                 .depth_scale = 0.001 };
        s->w.eye[c].sight = s->sight[c];
        s->w.eye[c].fresh = true;
    }
    s->w.o = &s->o;
    s->w.dt = 1.0 / 30;
    s->w.arena = lt_arena_new();
    return s;
}

static void close_stage(stage_set *s)
{
    lt_arena_free(s->w.arena);
    lt_release(s);
}

/* A box all of whose pixels are the thing's */
static void see(stage_set *s, int camera, predict_kind kind, int64_t track, int x0, int y0, int x1, int y1)
{
    const size_t n = (size_t)(x1 - x0) * (size_t)(y1 - y0);
    watch_sight *to = &s->sight[camera][s->w.eye[camera].n++];

    *to = (watch_sight){ .seen = { .kind = kind, .cls = kind == DETECTED_HAND, .name = "x", .score = 0.9,
                                   .track = track,
                                   .box = { (float)x0, (float)y0, (float)x1, (float)y1 },
                                   .window = { x0, y0, x1, y1, lt_arena_alloc(s->w.arena, n) } } };
    memset(to->seen.window.pixel, 1, n);
}

static void pair_in_sight(stage_set *s, float hand_m, float object_m)
{
    s->w.eye[0].n = 0;
    see(s, 0, DETECTED_HAND, 1, 10, 10, 30, 30);
    see(s, 0, DETECTED_OBJECT, 2, 28, 12, 48, 32);
    s->sight[0][0].id = 1;
    s->sight[0][1].id = 2;
    s->w.n_things = 2;
    s->w.thing[0] = (watch_thing){ .id = 1, .kind = DETECTED_HAND };
    s->w.thing[1] = (watch_thing){ .id = 2, .kind = DETECTED_OBJECT };
    for (int y = 0; y < HIGH; y++)
        for (int x = 0; x < WIDE; x++)
            s->metres[y * WIDE + x] = x < 29 ? hand_m : object_m;
    s->w.eye[0].metres = s->metres;
}

static bool step_contact(stage_set *s)
{
    s->set.t += 1.0 / 30;
    check_ok(watch_contact_run(&s->w, &s->set));
    return s->w.n_contacts && s->w.contact[0].on;
}

START_TEST(contact_comes_and_goes)
{
    stage_set *s = open_stage(1);

    pair_in_sight(s, 0.5f, 0.53f);
    ck_assert(!step_contact(s));
    ck_assert(step_contact(s));
    ck_assert_double_eq_tol(s->w.contact[0].since, 2 / 30.0, 1e-9);
    pair_in_sight(s, 0.5f, 0.7f);               /* behind it now */
    for (int i = 0; i < 4; i++)
        ck_assert(step_contact(s));
    ck_assert(!step_contact(s));
    close_stage(s);
}
END_TEST

START_TEST(apart_in_depth)
{
    stage_set *s = open_stage(1);

    pair_in_sight(s, 0.5f, 0.56f);
    for (int i = 0; i < 4; i++)
        ck_assert(!step_contact(s));
    s->w.eye[0].metres = NULL;                  /* no depth: the overlap is all that there is */
    ck_assert(!step_contact(s));
    ck_assert(step_contact(s));
    close_stage(s);
}
END_TEST

/* Masks that are three pixels apart meet, boxes that do not overlap or not. */
START_TEST(near_is_touching)
{
    for (int gap = 3; gap <= 4; gap++) {
        stage_set *s = open_stage(1);

        pair_in_sight(s, 0.5f, 0.5f);
        s->w.eye[0].n = 1;
        see(s, 0, DETECTED_OBJECT, 2, 29 + gap, 12, 48, 32);
        s->sight[0][1].id = 2;
        step_contact(s);
        ck_assert_int_eq(step_contact(s), gap == 3);
        close_stage(s);
    }
}
END_TEST

/* ---- tracks of several cameras ---- */

static void place(watch_sight *s, double x, double y, double z)
{
    s->placed = true;
    s->centre[0] = x;
    s->centre[1] = y;
    s->centre[2] = z;
}

START_TEST(two_cameras_one_mug)
{
    stage_set *s = open_stage(2);

    see(s, 0, DETECTED_OBJECT, 5, 0, 0, 10, 10);
    see(s, 1, DETECTED_OBJECT, 1, 0, 0, 10, 10);
    see(s, 1, DETECTED_OBJECT, 2, 20, 0, 30, 10);
    see(s, 1, DETECTED_HAND, 1, 20, 0, 30, 10);
    place(&s->sight[0][0], 0.1, 0.2, 0.3);
    place(&s->sight[1][0], 0.4, 0.2, 0.3);
    place(&s->sight[1][1], 0.12, 0.2, 0.35);
    place(&s->sight[1][2], 0.1, 0.2, 0.3);
    check_ok(watch_together_run(&s->w, &s->set));
    ck_assert_int_eq(s->w.n_things, 3);
    ck_assert_int_eq(s->sight[0][0].id, s->sight[1][1].id);
    ck_assert_int_ne(s->sight[1][0].id, s->sight[1][1].id);
    ck_assert_int_ne(s->sight[1][2].id, s->sight[1][1].id);
    ck_assert_double_eq_tol(watch_thing_of(&s->w, s->sight[0][0].id)->centre.x[2], 0.325, 1e-6);

    s->sight[1][1].id = 0;                      /* the next set: numbers stay */
    s->set.t = 1.0 / 30;
    place(&s->sight[1][1], 0.5, 0.5, 0.5);
    check_ok(watch_together_run(&s->w, &s->set));
    ck_assert_int_eq(s->sight[1][1].id, s->sight[0][0].id);
    s->set.t = 10;                              /* nobody has seen them for long */
    s->w.eye[0].n = s->w.eye[1].n = 0;
    check_ok(watch_together_run(&s->w, &s->set));
    ck_assert_int_eq(s->w.n_things, 0);
    close_stage(s);
}
END_TEST

START_TEST(worlds_of_their_own)
{
    const recording_camera placed = { .placed = true, .R = { 0, 0, 1, -1, 0, 0, 0, -1, 0 }, .t = { 1, 2, 3 } },
        none = { .name = "none" };
    const double p[3] = { 0.1, 0.2, 2 };
    double world[3], back[3];

    watch_to_world(&placed, p, world);
    ck_assert_double_eq_tol(world[0], 3, 1e-12);
    ck_assert_double_eq_tol(world[1], 1.9, 1e-12);
    ck_assert_double_eq_tol(world[2], 2.8, 1e-12);
    watch_to_camera(&placed, world, back);
    for (int d = 0; d < 3; d++)
        ck_assert_double_eq_tol(back[d], p[d], 1e-12);
    watch_to_world(&none, p, world);
    ck_assert_mem_eq(world, p, sizeof(p));
}
END_TEST

/* ---- what goes on ---- */

static const interaction_seen nothing = {
    .action = -1, .reach = INFINITY, .object_speed = NAN, .slip = NAN, .lift = NAN, .robot = NAN, .robot_speed = NAN,
    .flexion_deg = NAN,
};

/* n sets of it, 30 a second */
static interaction_state after(interaction *s, interaction_seen *e, int n)
{
    for (int i = 0; i < n; i++) {
        e->t += 1.0 / 30;
        interaction_step(s, e);
    }
    return s->state;
}

START_TEST(picked_up_and_put_down)
{
    interaction s = { .n_past = 0 };
    interaction_seen e = nothing;

    ck_assert_int_eq(after(&s, &e, 5), INTERACTION_NONE);
    for (e.reach = 0.5; e.reach > 0.2; e.reach -= 0.01)         /* 0.3 m/s */
        after(&s, &e, 1);
    ck_assert_int_eq(s.state, INTERACTION_APPROACH);
    e.contact = true;
    e.contact_since = e.t;
    e.reach = e.object_speed = e.slip = e.lift = 0;
    ck_assert_int_eq(after(&s, &e, 2), INTERACTION_APPROACH);   /* a change needs three in a row */
    ck_assert_int_eq(after(&s, &e, 1), INTERACTION_CONTACT);
    e.object_speed = 0.05;
    e.lift = 0.01;
    ck_assert_int_eq(after(&s, &e, 12), INTERACTION_HOLD);      /* slow and low, but on its way up */
    e.object_speed = 0.2;
    e.lift = 0.1;
    ck_assert_int_eq(after(&s, &e, 6), INTERACTION_HOLD);
    e.object_speed = 0.05;
    e.lift = 0.02;
    ck_assert_int_eq(after(&s, &e, 3), INTERACTION_PLACE);
    e.contact = false;
    e.reach = 0.1;
    ck_assert_int_eq(after(&s, &e, 3), INTERACTION_NONE);
}
END_TEST

/* Who crosses his hands comes near to what lies on the table, and wants nothing of it. */
START_TEST(not_reached_for)
{
    interaction s = { .n_past = 0 };
    interaction_seen e = nothing;

    e.action = 3;
    e.p = 0.9;
    for (e.reach = 0.5; e.reach > 0.2; e.reach -= 0.01)
        ck_assert_int_eq(after(&s, &e, 1), INTERACTION_NONE);
    e.p = 0.4;
    for (; e.reach > 0.1; e.reach -= 0.01)
        after(&s, &e, 1);
    ck_assert_int_eq(s.state, INTERACTION_APPROACH);
}
END_TEST

START_TEST(given_and_taken)
{
    interaction s = { .n_past = 0 };
    interaction_seen e = nothing;

    e.contact = true;
    e.contact_since = -1;
    e.reach = e.slip = 0;
    e.object_speed = 0.3;
    e.lift = 0.2;
    e.robot = 1;
    ck_assert_int_eq(after(&s, &e, 3), INTERACTION_HOLD);
    e.robot = 0.3;
    e.robot_speed = 0.2;
    ck_assert_int_eq(after(&s, &e, 3), INTERACTION_HANDOVER);
    e.robot_speed = -0.2;                                       /* as long as it is held */
    ck_assert_int_eq(after(&s, &e, 3), INTERACTION_HANDOVER);
    e.contact = false;
    e.flexion_deg = 10;                                         /* an open hand by the robot */
    ck_assert_int_eq(after(&s, &e, 3), INTERACTION_RECEIVE);
    e.contact = true;
    e.contact_since = e.t;
    ck_assert_int_eq(after(&s, &e, 3), INTERACTION_RECEIVE);
    e.robot = 0.5;
    ck_assert_int_eq(after(&s, &e, 6), INTERACTION_HOLD);
    e.action = 8;                                               /* handing over, but nobody is sure of it */
    e.p = 0.4;
    ck_assert_int_eq(after(&s, &e, 6), INTERACTION_HOLD);
    e.p = 0.6;
    ck_assert_int_eq(after(&s, &e, 3), INTERACTION_HANDOVER);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_test(tc, half_a_period);
    tcase_add_test(tc, lagging_clock);
    tcase_add_test(tc, another_clock);
    tcase_add_test(tc, contact_comes_and_goes);
    tcase_add_test(tc, apart_in_depth);
    tcase_add_test(tc, near_is_touching);
    tcase_add_test(tc, two_cameras_one_mug);
    tcase_add_test(tc, worlds_of_their_own);
    tcase_add_test(tc, picked_up_and_put_down);
    tcase_add_test(tc, not_reached_for);
    tcase_add_test(tc, given_and_taken);
}

int main(void)
{
    return run_suite("watch_rules", add_tests);
}
