/* SPDX-License-Identifier: Apache-2.0 */
/* The generator's set for HOGS: light that is written down, hands that lie on objects, poses to begin from. */
#include "assets/hand/hand.h"
#include "data/ho3d/ho3d.h"
#include "data/poses/initial_poses.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mesh/surface.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/text/json.h"
#include "synth/generate.h"
#include "synth/take/light.h"
#include "tests/scratch.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SEQUENCES = 32 };

static synth_figure figure[SYNTH_FIGURES];
static int n_figures;

static synth_options options(const char *folder)
{
    return (synth_options){ .preset = SYNTH_HOGS, .out = at(folder), .seed = 3, .frames = SEQUENCES };
}

/* One dataset for all tests: a frame of each sequence. */
static void setup(void)
{
    synth_options o;

    open_scratch();
    o = options("data");
    check_ok(synth_generate(&o, figure, &n_figures));
}

static double figure_of(const char *name)
{
    for (int i = 0; i < n_figures; i++)
        if (!strcmp(figure[i].name, name))
            return figure[i].value;
    ck_abort_msg("no figure %s", name);
}

static dataset *open_split(const char *split)
{
    dataset *d;

    check_ok(ho3d_open(&(ho3d_options){ .root = at("data"), .split = split, .vertices = true }, &d));
    return d;
}

/* ---- frames ---- */

START_TEST(small_pictures_by_the_same_reader)
{
    static const struct { const char *split; int count; } cases[] = { { "train", 24 }, { "evaluation", 8 } };

    for (size_t c = 0; c < LT_COUNT(cases); c++) {
        dataset *d = open_split(cases[c].split);
        dataset_sample s;

        ck_assert_int_eq(d->count, cases[c].count);
        ck_assert_int_eq(d->n_objects, 4);
        for (int64_t i = 0; i < d->count; i++) {
            check_ok(dataset_read(d, i, SAMPLE_DEPTH | SAMPLE_SEGMENTS, arena, &s));
            ck_assert_int_eq(s.width, 320);
            ck_assert_int_eq(s.height, 240);
            ck_assert_int_eq(s.segments_width, 320);
            ck_assert(s.camera.cx > 150 && s.camera.cx < 170 && s.camera.fx > 295 && s.camera.fx < 315);
        }
        dataset_free(d);
    }
}
END_TEST

/* Every hand with every object, in training as in evaluation. */
START_TEST(every_pair)
{
    static const char *const letters[] = { "MB", "PM", "BC", "MU" };

    for (int subject = 0; subject < 2; subject++)
        for (int object = 0; object < 4; object++)
            for (int i = 0; i < 4; i++)
                ck_assert_msg(lt_is_folder(at(lt_arena_printf(arena, "data/%s/SYN%d%s%d0", i < 3 ? "train" :
                              "evaluation", subject, letters[object], i))), "%d %s %d", subject, letters[object], i);
}
END_TEST

/* Seen by the mesh itself: no vertex of a hand is in the object. */
START_TEST(hand_and_object_are_apart)
{
    ck_assert_double_eq(figure_of("frames with the hand in the object"), 0);
    ck_assert_double_eq(figure_of("frames that show hand and object"), 1);
    ck_assert_double_ge(figure_of("frames of handling with contact"), 0.7);
}
END_TEST

START_TEST(same_seed_same_bytes)
{
    synth_options o = options("again");

    lt_set_threads(3);
    check_ok(synth_generate(&o, NULL, NULL));
    lt_set_threads(0);
    same_files(at("data/manifest.json"), at("again/manifest.json"));
}
END_TEST

/* ---- light ---- */

START_TEST(light_is_written_down)
{
    char header[256];
    double v[12], norm;
    FILE *f = fopen(at("data/train/SYN0MB00/light.csv"), "r");

    ck_assert_ptr_nonnull(f);
    ck_assert_ptr_nonnull(fgets(header, sizeof(header), f));
    ck_assert_str_eq(header, "frame,exposure,warmth,tint,toward_x,toward_y,toward_z,key,highlight,"
                             "jitter_r,jitter_g,jitter_b\n");
    for (int i = 0; i < 12; i++)
        ck_assert_int_eq(fscanf(f, i ? ",%lf" : "%lf", &v[i]), 1);
    fclose(f);
    norm = sqrt(v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
    ck_assert_double_eq_tol(norm, 1, 1e-5);
    ck_assert(v[1] > 0.46 && v[1] < 2.15);
    ck_assert(v[9] == 1 && v[10] == 1 && v[11] == 1);
    ck_assert_double_eq_tol(figure_of("change of pixels by global light, share") +
                            figure_of("change of pixels by local light, share"), 1, 1e-12);
}
END_TEST

START_TEST(light_drifts_or_stands_still)
{
    synth_light_spec spec = { .varied = true, .seed = 1, .stream = 2, .frames = 80 };
    const synth_light_state *still = &synth_light_still;
    double most = 0, step = 0;

    for (int k = 0; k + 1 < spec.frames; k++) {
        const synth_light_state a = synth_light_at(&spec, k), b = synth_light_at(&spec, k + 1);
        most = fmax(most, fabs(log2(a.global.exposure)));
        step = fmax(step, fabs(log2(a.global.exposure / b.global.exposure)));
    }
    ck_assert(most > 0.1 && most <= 1.1);
    ck_assert(step > 0 && step < 0.07);
    spec.varied = false;
    for (int k = 0; k < spec.frames; k++) {
        const synth_light_state a = synth_light_at(&spec, k);
        ck_assert_mem_eq(&a, still, sizeof(a));
    }
}
END_TEST

START_TEST(jitter_is_of_each_frame)
{
    const synth_light_spec spec = { .jitter = true, .seed = 1, .stream = 2, .frames = 80 };
    double least = 2, most = 0, sum = 0;
    uint8_t rgb[2][3] = { { 100, 100, 100 }, { 255, 10, 0 } };

    for (int k = 0; k < spec.frames; k++) {
        const synth_light_state a = synth_light_at(&spec, k);
        for (int c = 0; c < 3; c++) {
            least = fmin(least, a.jitter[c]);
            most = fmax(most, a.jitter[c]);
            sum += a.jitter[c] / (3 * spec.frames);
        }
    }
    ck_assert(least >= 0.7 && least < 0.72);
    ck_assert(most < 1.3 && most > 1.28);
    ck_assert_double_eq_tol(sum, 1, 0.03);
    synth_light_jitter((const double[]){ 1.2, 0.75, 1 }, rgb, 2);
    ck_assert_mem_eq(rgb, ((const uint8_t[2][3]){ { 120, 75, 100 }, { 255, 8, 0 } }), 6);
}
END_TEST

/* ---- poses ---- */

static cJSON *poses(const char *name)
{
    cJSON *root;

    check_ok(lt_json_read(at(name), &root));
    ck_assert_str_eq(cJSON_GetObjectItem(root, "format")->valuestring, "palmar.poses/1");
    ck_assert_int_eq(cJSON_GetArraySize(cJSON_GetObjectItem(root, "frames")), SEQUENCES);
    return root;
}

static void numbers(const cJSON *of, const char *key, int n, double *out)
{
    const cJSON *a = cJSON_GetObjectItem(of, key);

    ck_assert_int_eq(cJSON_GetArraySize(a), n);
    for (int i = 0; i < n; i++)
        out[i] = cJSON_GetArrayItem(a, i)->valuedouble;
}

/* The file's hand, posed, is the annotation's; and its object. In training, where both are known. */
START_TEST(truth_is_the_annotation)
{
    cJSON *root = poses("data/poses/truth.json");
    dataset *d = open_split("train");
    lt_hand_model *hand;

    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
    for (int64_t i = 0; i < d->count; i++) {
        const cJSON *frame = cJSON_GetObjectItem(cJSON_GetObjectItem(root, "frames"), dataset_name(d, i));
        const cJSON *h = cJSON_GetObjectItem(frame, "hand"), *o = cJSON_GetObjectItem(frame, "object");
        double pose[48], beta[10], trans[3], aa[3], t[3], R[16][9], v[LT_HAND_VERTICES][3], joints[16][3];
        dataset_sample s;

        check_ok(dataset_annotation(d, i, arena, &s));
        numbers(h, "pose", 48, pose);
        numbers(h, "shape", 10, beta);
        numbers(h, "trans", 3, trans);
        numbers(o, "R", 3, aa);
        numbers(o, "t", 3, t);
        for (int j = 0; j < 16; j++)
            lt_rot_from_axis_angle(pose + 3 * j, R[j]);
        lt_hand_pose(hand, R[0], beta, trans, v[0], joints[0]);
        lt_rot_from_axis_angle(aa, R[0]);
        for (int k = 0; k < 3; k++) {
            ck_assert_double_eq_tol(joints[0][k], s.root[k], 1e-5);
            ck_assert_double_eq_tol(t[k], s.t[k], 1e-5);
        }
        for (int k = 0; k < 9; k++)
            ck_assert_double_eq_tol(R[0][k], s.R[k], 1e-5);
    }
    dataset_free(d);
    cJSON_Delete(root);
}
END_TEST

/* HOISDF's size; the hand keeps its wrist. */
START_TEST(noise_is_as_large_as_said)
{
    static const char *const file[] = { "data/poses/independent.json", "data/poses/correlated.json" };
    cJSON *truth = poses("data/poses/truth.json");

    for (int f = 0; f < 2; f++) {
        cJSON *root = poses(file[f]);
        const cJSON *a = cJSON_GetObjectItem(truth, "frames")->child, *b = cJSON_GetObjectItem(root, "frames")->child;
        double oce = 0;

        for (; a; a = a->next, b = b->next) {
            double t[3], u[3];
            ck_assert_str_eq(a->string, b->string);
            numbers(cJSON_GetObjectItem(a, "object"), "t", 3, t);
            numbers(cJSON_GetObjectItem(b, "object"), "t", 3, u);
            oce += 1000 * sqrt(pow(t[0] - u[0], 2) + pow(t[1] - u[1], 2) + pow(t[2] - u[2], 2)) / SEQUENCES;
            numbers(cJSON_GetObjectItem(a, "hand"), "trans", 3, t);
            numbers(cJSON_GetObjectItem(b, "hand"), "trans", 3, u);
            ck_assert_mem_eq(t, u, sizeof(t));
        }
        ck_assert(oce > 13 && oce < 24);            /* 18.4 on the mean of many; deviation of a mean of 32: 1.6 */
        cJSON_Delete(root);
    }
    cJSON_Delete(truth);
}
END_TEST

/* What was written is read back, for either split; in training it is what the annotation has. */
START_TEST(poses_are_read)
{
    dataset *train = open_split("train"), *evaluation = open_split("evaluation");
    initial_poses_options o = { .path = at("data/poses/truth.json"), .data = train, .other = evaluation };
    initial_poses *p, *truth;
    lt_hand_model *hand;

    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
    o.hand = hand;
    check_ok(initial_poses_read(&o, &p));
    o.path = "truth";
    check_ok(initial_poses_read(&o, &truth));
    for (int64_t i = 0; i < train->count; i++) {
        const initial_pose *a = initial_poses_at(p, i), *b = initial_poses_at(truth, i);

        ck_assert(a && b && a->has_hand && a->has_object && b->has_hand && b->has_object);
        ck_assert_int_eq(a->object, b->object);
        ck_assert_int_ge(a->object, 0);
        for (int k = 0; k < 3; k++) {
            ck_assert_double_eq_tol(a->wrist[k], b->wrist[k], 1e-5);
            ck_assert_double_eq_tol(a->t[k], b->t[k], 1e-6);
        }
        for (int k = 0; k < 9; k++)
            ck_assert_double_eq_tol(a->R[k], b->R[k], 1e-5);
    }
    ck_assert_int_eq(initial_poses_count(p).other, evaluation->count);
    ck_assert_int_eq(initial_poses_count(p).missed, 0);
    initial_poses_free(p);
    o.path = at("data");                        /* a folder stands for its annotation */
    check_ok(initial_poses_read(&o, &p));
    for (int64_t i = 0; i < train->count; i++) {
        const initial_pose *a = initial_poses_at(p, i), *b = initial_poses_at(truth, i);

        ck_assert_mem_eq(a->pose, b->pose, sizeof(a->pose));
        ck_assert_mem_eq(a->wrist, b->wrist, sizeof(a->wrist));
        ck_assert_mem_eq(a->R, b->R, sizeof(a->R));
        ck_assert_int_eq(a->object, b->object);
    }
    initial_poses_free(truth);
    initial_poses_free(p);
    o = (initial_poses_options){ .path = at("data/poses/independent.json"), .data = evaluation, .other = train,
                                 .hand = hand };
    check_ok(initial_poses_read(&o, &p));
    ck_assert_int_eq(initial_poses_count(p).matched, evaluation->count);
    initial_poses_free(p);
    dataset_free(evaluation);
    dataset_free(train);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_unchecked_fixture(c, setup, close_scratch);
    tcase_set_timeout(c, 0);
    tcase_add_test(c, small_pictures_by_the_same_reader);
    tcase_add_test(c, every_pair);
    tcase_add_test(c, hand_and_object_are_apart);
    tcase_add_test(c, same_seed_same_bytes);
    tcase_add_test(c, light_is_written_down);
    tcase_add_test(c, light_drifts_or_stands_still);
    tcase_add_test(c, jitter_is_of_each_frame);
    tcase_add_test(c, truth_is_the_annotation);
    tcase_add_test(c, noise_is_as_large_as_said);
    tcase_add_test(c, poses_are_read);
}

int main(void)
{
    setenv("CK_FORK", "no", 1);         /* the threads that parallel loops leave do not survive a fork */
    return run_suite("hogs", add_tests);
}
