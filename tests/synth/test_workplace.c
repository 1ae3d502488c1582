/* SPDX-License-Identifier: Apache-2.0 */
/* Worlds: bodies that follow programs, objects in hands, clocks, and what is written of all that. */
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/text/json.h"
#include "synth/workplace/clock.h"
#include "synth/workplace/truth.h"
#include "tests/synth/cans.h"

#include <cjson/cJSON.h>
#include <math.h>

enum { FRAMES = 900, SEED = 3, SHRINK = 5 };

static lt_arena *arena;
static workplace_script script;
static workplace_means means;

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
    lt_set_threads(1);
    means = cans_new(arena);
    script = cans_script(arena, &means, SEED, FRAMES);
}

static void teardown(void)
{
    remove_scratch_folder();
    lt_arena_free(arena);
}

/* ---- bodies ---- */

START_TEST(joints_bend_within_limits)
{
    workplace_moment m;

    for (int k = 0; k < FRAMES; k += 29) {
        workplace_person_at(&script, 0, k, &m);
        for (int j = 1; j < BODY_FINGERS; j++)
            ck_assert_msg(synth_body_within(j, m.body.R[j]), "frame %d, joint %d", k, j);
    }
}
END_TEST

/* Wrists are where programs and grasps have them; soles are on the floor or over it, hands over the table. */
START_TEST(a_body_follows)
{
    const double ankle = script.person[0].body.ankle, *t = script.table;
    workplace_moment m;
    double miss = 0;
    int n = 0;

    for (int k = 70; k < FRAMES; k += 23) {
        workplace_person_at(&script, 0, k, &m);
        miss += (m.miss[0] + m.miss[1]) / 2;
        n++;
        for (int side = 0; side < 2; side++) {
            const double up = m.body.joint[BODY_ANKLE + side][2] - WORKPLACE_FLOOR - ankle;

            ck_assert_msg(up > -0.003 && up < 0.2, "frame %d: a sole is %g m over the floor", k, up);
            for (int j = 0; j < BODY_HAND_JOINTS; j++) {
                const double *x = m.body.joint[BODY_FINGERS + side * BODY_HAND_JOINTS + j];

                ck_assert(x[0] < t[0] || x[0] > t[2] || x[1] < t[1] || x[1] > t[3] || x[2] > 0.003);
            }
        }
    }
    ck_assert_double_lt(miss / n, 0.01);
}
END_TEST

/* From frame to frame nothing jumps, neither within programs nor between them. */
START_TEST(nothing_jumps)
{
    static workplace_moment m[2];

    for (int k = 0; k < FRAMES; k += k % 16 == 15 ? 49 : 1) {
        workplace_person_at(&script, 0, k, &m[k % 2]);
        for (int j = 0; k % 16 && j < BODY_JOINTS; j++)
            ck_assert_msg(lt_vec3_distance(m[0].body.joint[j], m[1].body.joint[j]) < 0.2 &&
                              lt_rot_angle(m[0].body.R[j], m[1].body.R[j]) < 0.8, "frame %d, joint %d", k, j);
    }
}
END_TEST

/* ---- objects ---- */

/* Where the object is, seen from the wrist */
static void seen_from_wrist(const workplace_hold *h, int k, synth_settled *out, int *owner)
{
    const int wrist = BODY_WRIST + script.person[0].style.arm;
    workplace_moment who[WORKPLACE_PEOPLE];
    double back[9];

    for (int i = 0; i < script.n_people; i++)
        workplace_person_at(&script, i, k, &who[i]);
    workplace_object_at(&script, who, h->object, k, out, owner);
    lt_mat3_transpose(who[0].body.world[wrist], back);
    lt_mat3_mul(back, out->R, out->R);
    lt_vec3_sub(out->t, who[0].body.joint[wrist], out->t);
    lt_mat3_mulvec(back, out->t, out->t);
}

START_TEST(an_object_moves_with_the_hand)
{
    ck_assert_int_gt(script.person[0].n_holds, 1);
    for (int i = 0; i < script.person[0].n_holds; i++) {
        const workplace_hold *h = &script.person[0].hold[i];
        synth_settled first, at;
        int owner;

        seen_from_wrist(h, h->from + 6, &first, &owner);
        ck_assert_int_eq(owner, 0);
        for (int k = h->from + 8; k < h->to - 6; k += 17) {
            seen_from_wrist(h, k, &at, &owner);
            ck_assert_int_eq(owner, 0);
            ck_assert_double_lt(lt_vec3_distance(at.t, first.t), 1e-9);
            ck_assert_double_lt(lt_rot_angle(at.R, first.R), 1e-6);
        }
        seen_from_wrist(h, h->to, &at, &owner);
        ck_assert_int_eq(owner, -1);
    }
}
END_TEST

/* At all moments an object goes on from where it was, whoever takes it over. */
START_TEST(an_object_never_jumps)
{
    synth_settled at[2];
    int owner;

    for (int i = 0; i < script.person[0].n_holds; i++)
        for (int e = 0; e < 2; e++) {
            const workplace_hold *h = &script.person[0].hold[i];
            const int at_frame = e ? h->to : h->from;

            for (int k = at_frame - 7; k < at_frame + 8; k++) {
                workplace_moment who[WORKPLACE_PEOPLE];

                for (int p = 0; p < script.n_people; p++)
                    workplace_person_at(&script, p, k, &who[p]);
                workplace_object_at(&script, who, h->object, k, &at[k & 1], &owner);
                if (k > at_frame - 7) {
                    ck_assert_msg(lt_vec3_distance(at[0].t, at[1].t) < 0.06, "hold %d, frame %d: %g m", i, k,
                                  lt_vec3_distance(at[0].t, at[1].t));
                    ck_assert_double_lt(lt_rot_angle(at[0].R, at[1].R), 0.2);
                }
            }
        }
}
END_TEST

START_TEST(held_is_touched)
{
    const workplace_hold *h = &script.person[0].hold[0];
    const int moments[3] = { h->from + 1, (h->from + h->to) / 2, h->to - 1 };
    synth_room *room;

    check_ok(workplace_room(arena, &script, &room));
    for (int i = 0; i < 3; i++) {
        workplace_scene *scene;

        check_ok(workplace_scene_at(arena, &script, room, moments[i], &scene));
        ck_assert_double_lt(truth_contact(scene, 0, script.person[0].style.arm, h->object), 0.005);
    }
}
END_TEST

/* The states of a hold come in the order of the programs' phases. */
START_TEST(states_are_phases)
{
    static const workplace_state after[] = { WORKPLACE_APPROACH, WORKPLACE_CONTACT, WORKPLACE_HOLD };
    const workplace_person *p = &script.person[0];

    for (int i = 0; i < p->n_holds; i++) {
        const workplace_hold *h = &p->hold[i];
        workplace_moment m;

        for (int e = 0; e < 3; e++) {
            workplace_person_at(&script, 0, h->from + (int[]){ -1, 1, 4 }[e], &m);
            ck_assert_int_eq(m.state, h->picked ? after[e] : WORKPLACE_RECEIVE);
            ck_assert_int_eq(m.object, h->object);
        }
        ck_assert_int_le(m.since, h->from + 4);
        workplace_person_at(&script, 0, h->to - 1, &m);
        ck_assert_int_eq(m.state, h->placed ? WORKPLACE_PLACE : WORKPLACE_HANDOVER);
        workplace_person_at(&script, 0, h->to, &m);
        ck_assert_int_eq(m.state, WORKPLACE_NONE);
    }
}
END_TEST

/* ---- clocks ---- */

START_TEST(clocks)
{
    enum { LONG = 20000 };
    workplace_clock c;
    int late = 0;

    workplace_clock_draw(7, 4, &c);
    ck_assert(c.lag[0] == 0);
    for (int i = 0; i < 4; i++) {
        double before = -1;
        int lost = 0;

        late += c.lag[i] > 0;
        for (int k = 0; k < LONG; k++) {
            double t;

            lost += !workplace_stamp(&c, i, k, &t);
            ck_assert_double_le(fabs(t - workplace_time(k) - c.lag[i]), 0.005);
            ck_assert_double_gt(t, before);
            before = t;
        }
        ck_assert(lost > 0.008 * LONG && lost < 0.022 * LONG);
    }
    ck_assert_int_eq(late, 1);
}
END_TEST

/* ---- what is written ---- */

static void film(const char *within, int frames, int cameras, int threads)
{
    const synth_options o = { .preset = SYNTH_WORLD, .out = in_folder(within), .seed = SEED, .frames = frames,
                              .cameras = cameras, .difficulty = 0.2 };
    synth_figure figures[SYNTH_FIGURES];
    int n_figures;

    lt_set_threads(threads);
    check_ok(workplace_film(&o, &means, SHRINK, figures, &n_figures));
    lt_set_threads(1);
}

static cJSON *checksums(const char *manifest)
{
    cJSON *j;

    check_ok(lt_json_read(in_folder(manifest), &j));
    return j;
}

/* The same bits on two threads, and of a frame in whichever length of the world and number of cameras it is. */
START_TEST(a_frame_is_a_function_of_its_number)
{
    cJSON *one, *two, *file;
    int shared = 0;

    film("one", 3, 2, 1);
    film("two", 5, 1, 2);
    one = checksums("one/manifest.json");
    two = checksums("two/manifest.json");
    cJSON_ArrayForEach(file, cJSON_GetObjectItem(two, "files_crc32")) {
        const cJSON *other = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItem(one, "files_crc32"), file->string);

        if (!other || !strchr(file->string, '/'))
            continue;
        ck_assert_msg(strcmp(other->valuestring, file->valuestring) == 0, "%s", file->string);
        shared++;
    }
    ck_assert_int_ge(shared, 6);
    cJSON_Delete(one);
    cJSON_Delete(two);
}
END_TEST

static void take_point(const cJSON *from, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = cJSON_GetArrayItem(from, k)->valuedouble;
}

/* Whoever projects a person's joints finds them in the box that the picture's truth has around him. */
static void check_joints(const recording_rig *rig, const cJSON *line, const cJSON *track)
{
    const int c = cJSON_GetObjectItem(track, "camera")->valueint, id = cJSON_GetObjectItem(track, "id")->valueint;
    const cJSON *person = cJSON_GetArrayItem(cJSON_GetObjectItem(line, "people"), id - 1), *joint;
    const cJSON *box = cJSON_GetObjectItem(track, "amodal");
    const recording_camera *cam = &rig->camera[c];
    double corner[4];
    int n = 0;

    for (int k = 0; k < 4; k++)
        corner[k] = cJSON_GetArrayItem(box, k)->valuedouble;
    ck_assert_int_eq(cJSON_GetObjectItem(person, "id")->valueint, id);
    cJSON_ArrayForEach(joint, cJSON_GetObjectItem(person, "joints")) {
        double x[3], back[9], p[3], u, v;

        take_point(joint, x);
        lt_vec3_sub(x, cam->t, x);
        lt_mat3_transpose(cam->R, back);
        lt_mat3_mulvec(back, x, p);
        u = cam->K.fx * p[0] / p[2] + cam->K.cx;
        v = cam->K.fy * p[1] / p[2] + cam->K.cy;
        n++;
        if (u < 2 || v < 2 || u > cam->width - 3 || v > cam->height - 3)
            continue;
        ck_assert_msg(u > corner[0] - 3 && u < corner[2] + 3 && v > corner[1] - 3 && v < corner[3] + 3,
                      "camera %d: %g %g", c, u, v);
    }
    ck_assert_int_eq(n, BODY_NODES);
}

START_TEST(truth_and_recording_agree)
{
    recording r;
    FILE *f;
    char *line = NULL;
    size_t room = 0;
    int lines = 0, persons = 0;

    film("whole", 2, 4, 1);
    check_ok(recording_open(arena, in_folder("whole"), &r));
    ck_assert(r.rig.n == 4 && r.rig.synthetic && r.rig.has_robot && r.rig.camera[0].role == RECORDING_FRONT);
    f = fopen(in_folder("whole/truth.ndjson"), "r");
    while (getline(&line, &room, f) > 0) {
        cJSON *j, *track;

        check_ok(lt_json_parse("truth", line, strlen(line), &j));
        ck_assert_int_eq(cJSON_GetObjectItem(j, "set")->valueint, lines++);
        for (int c = 0; c < 4; c++) {
            const cJSON *number = cJSON_GetArrayItem(cJSON_GetObjectItem(j, "frames"), c);

            if (cJSON_IsNull(number))
                continue;
            ck_assert_int_eq(r.frame[number->valueint].camera, c);
            ck_assert_double_eq_tol(r.frame[number->valueint].t,
                                    cJSON_GetArrayItem(cJSON_GetObjectItem(j, "t"), c)->valuedouble, 1e-5);
        }
        cJSON_ArrayForEach(track, cJSON_GetObjectItem(j, "tracks"))
            if (strcmp(cJSON_GetObjectItem(track, "class")->valuestring, "person") == 0) {
                check_joints(&r.rig, j, track);
                persons++;
            }
        cJSON_Delete(j);
    }
    ck_assert_int_eq(lines, 2);
    ck_assert_int_ge(persons, 4);
    free(line);
    fclose(f);
}
END_TEST

START_TEST(refused)
{
    const synth_options o = { .preset = SYNTH_WORLD, .out = in_folder("never"), .cameras = 5 };

    check_error(synth_generate(&o, NULL, NULL), LT_EINVAL,
                "5 cameras, 600 moments: preset world has 1 to 4 cameras and an hour at most, 108000 moments");
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 0);
    tcase_add_unchecked_fixture(t, setup, teardown);
    tcase_add_test(t, joints_bend_within_limits);
    tcase_add_test(t, a_body_follows);
    tcase_add_test(t, nothing_jumps);
    tcase_add_test(t, an_object_moves_with_the_hand);
    tcase_add_test(t, an_object_never_jumps);
    tcase_add_test(t, held_is_touched);
    tcase_add_test(t, states_are_phases);
    tcase_add_test(t, clocks);
    tcase_add_test(t, a_frame_is_a_function_of_its_number);
    tcase_add_test(t, truth_and_recording_agree);
    tcase_add_test(t, refused);
}

int main(void)
{
    return run_suite("workplace", add_tests);
}
