/* SPDX-License-Identifier: Apache-2.0 */
/* Bodies of several persons in watch: whose turn it is, and what becomes of the others meanwhile. */
#include "pipeline/watch/internal.h"

#include "libtensor/base/parallel.h"
#include "tests/estimate/body_run.h"
#include "tests/suite.h"

enum { WIDTH = 128, HEIGHT = 80, PERSON_WIDTH = 24, SEEN = 4 };

static const double PERIOD = 1.0 / 30;

static lt_arena *arena;
static body_estimator bodies;
static uint8_t picture[3 * WIDTH * HEIGHT];

/* One network for all tests */
static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
    lt_set_threads(1);
    write_body_run(in_folder("osx.safetensors"), "embedded", 0);
    check_ok(body_estimator_open(in_folder("osx.safetensors"), &bodies));
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
        picture[i] = (uint8_t)(i * 7 % 251);
}

static void teardown(void)
{
    body_estimator_close(&bodies);
    lt_arena_free(arena);
    remove_scratch_folder();
}

typedef struct {
    watch_options o;
    watch_world w;
    watch_set set;
    watch_sight sight[SEEN];
} stage_set;

/* The persons of the first n numbers, side by side in front of one camera */
static void show(stage_set *s, int n)
{
    s->w.eye[0].n = n;
    for (int i = 0; i < n; i++) {
        const float left = (float)((PERSON_WIDTH + 4) * i);

        s->sight[i] = (watch_sight){ .id = 1 + i, .seen = { .kind = DETECTED_PERSON, .name = "person",
                                     .box = { left, 4, left + PERSON_WIDTH, HEIGHT - 4 } } };
    }
}

static stage_set *open_stage(watch_profile profile, int n)
{
    stage_set *s = lt_arena_alloc(arena, sizeof(*s));

    s->o = (watch_options){ .profile = profile, .models.body = &bodies, .rig = { .n = 1, .fps = 30 } };
    s->o.rig.camera[0] = (recording_camera){ .name = "front", .width = WIDTH, .height = HEIGHT,
                                             .role = RECORDING_FRONT, .K = { 60, 60, 63.5, 39.5 } };
    s->w = (watch_world){ .o = &s->o, .arena = arena, .dt = PERIOD, .eye[0].sight = s->sight };
    s->set = (watch_set){ .there[0] = true, .picture[0].rgb = { WIDTH, HEIGHT, 3, 8, picture } };
    show(s, n);
    return s;
}

/* The next set; the number of the one whose body was estimated, 0 where it was nobody's or of several */
static int64_t step(stage_set *s)
{
    int64_t who = 0;
    int n = 0;

    check_ok(watch_people_run(&s->w, &s->set));
    s->set.t += PERIOD;
    for (int i = 0; i < s->w.n_people; i++)
        if (s->w.person[i].state == LT_FILTER_ON) {
            who = s->w.person[i].id;
            n++;
        }
    return n == 1 ? who : 0;
}

START_TEST(one_is_looked_at_always)
{
    stage_set *s = open_stage(WATCH_CPU, 1);

    for (int k = 0; k < 4; k++)
        ck_assert_int_eq(step(s), 1);
    watch_actions_close(&s->w);
}
END_TEST

/* Each comes up after all others, and who was not looked at yet is not there yet. */
START_TEST(three_in_turn)
{
    static const int64_t want[] = { 1, 2, 3, 1, 2, 3, 1 };
    stage_set *s = open_stage(WATCH_CPU, 3);

    for (int k = 0; k < (int)LT_COUNT(want); k++) {
        ck_assert_int_eq(step(s), want[k]);
        ck_assert_int_eq(s->w.n_people, k < 2 ? k + 1 : 3);
        for (int i = 0; i < s->w.n_people; i++)
            ck_assert_int_ne(s->w.person[i].state, LT_FILTER_OFF);
    }
    watch_actions_close(&s->w);
}
END_TEST

START_TEST(who_is_new_goes_first)
{
    stage_set *s = open_stage(WATCH_CPU, 2);

    for (int k = 0; k < 3; k++)
        ck_assert_int_eq(step(s), 1 + k % 2);
    show(s, 3);
    ck_assert_int_eq(step(s), 3);
    ck_assert_int_eq(step(s), 2);
    watch_actions_close(&s->w);
}
END_TEST

/* There is room for three, and a fourth does not take their turns. */
START_TEST(one_too_many)
{
    stage_set *s = open_stage(WATCH_CPU, 4);

    for (int k = 0; k < 6; k++)
        ck_assert_int_eq(step(s), 1 + k % 3);
    ck_assert_int_eq(s->w.n_people, WATCH_PEOPLE);
    watch_actions_close(&s->w);
}
END_TEST

/* With room for it everybody is looked at in each set, to the bodies that turns come to. */
START_TEST(all_at_once)
{
    stage_set *all = open_stage(WATCH_FULL, 3), *turns = open_stage(WATCH_CPU, 3);

    for (int64_t id = 1; id <= 3; id++) {
        step(all);
        ck_assert_int_eq(step(turns), id);
        for (int i = 0; i < 3; i++)
            ck_assert_int_eq(all->w.person[i].state, LT_FILTER_ON);
        ck_assert_mem_eq(all->w.person[id - 1].joint, turns->w.person[id - 1].joint, sizeof(turns->w.person->joint));
    }
    watch_actions_close(&all->w);
    watch_actions_close(&turns->w);
}
END_TEST

/* Whose turn it is not keeps his joints, in the box where he is now, and is off once nobody sees him. */
START_TEST(waits_for_his_turn)
{
    stage_set *s = open_stage(WATCH_CPU, 2);
    watch_person *p = s->w.person;
    double joint[ACTION_BODY][3];

    ck_assert_int_eq(step(s), 1);
    memcpy(joint, p->joint, sizeof(joint));
    s->sight[0].seen.box.x0 = 3;
    ck_assert_int_eq(step(s), 2);
    ck_assert_int_eq(p->state, LT_FILTER_COAST);
    ck_assert_mem_eq(p->joint, joint, sizeof(joint));
    ck_assert_float_eq(p->box[0], 3);
    s->w.eye[0].sight = &s->sight[1];
    s->w.eye[0].n = 1;
    ck_assert_int_eq(step(s), 2);
    ck_assert_int_eq(p->state, LT_FILTER_OFF);
    watch_actions_close(&s->w);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_unchecked_fixture(tc, setup, teardown);
    tcase_add_test(tc, one_is_looked_at_always);
    tcase_add_test(tc, three_in_turn);
    tcase_add_test(tc, who_is_new_goes_first);
    tcase_add_test(tc, one_too_many);
    tcase_add_test(tc, all_at_once);
    tcase_add_test(tc, waits_for_his_turn);
}

int main(void)
{
    setenv("CK_FORK", "no", 1);         /* the threads that parallel loops leave do not survive a fork */
    return run_suite("watch_people", add_tests);
}
