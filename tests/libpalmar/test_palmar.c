/* SPDX-License-Identifier: Apache-2.0 */
/* The library for other programs: the numbers of palmar predict, no allocation, and whatever callers may get wrong. */
#include "libpalmar/palmar.h"

#include "estimate/checkpoint/checkpoint.h"
#include "libtensor/io/atomic_file.h"
#include "pipeline/internal.h"
#include "pipeline/objects/objects.h"
#include "pipeline/stage.h"
#include "tests/estimate/tiny_model.h"
#include "tests/suite.h"

#include <math.h>
#include <pthread.h>

enum { WIDTH = 100, HEIGHT = 80, GAP = 7 };

static lt_arena *arena;
static uint8_t rgb[HEIGHT][3 * WIDTH];
static float depth[HEIGHT][WIDTH];

#define DATA ", \"data\": {\"hand\": \"embedded\", \"bilinear\": true}}"

/* A checkpoint of a small model, hocat.safetensors or unified.safetensors. */
static const char *write_checkpoint(const char *name, const char *keys)
{
    const checkpoint_state state = { .step = 1, .best = INFINITY };
    const char *config = lt_arena_printf(arena, "{\"model\": {\"name\": \"%s\", %s" DATA, name, keys + 1);
    const char *path = in_folder(lt_arena_printf(arena, "%s.safetensors", name));
    tiny_model t;

    tiny_model_of(&t, name, keys);
    check_ok(checkpoint_save(path, &t.m, NULL, config, &state, NULL));
    tiny_model_fini(&t);
    return path;
}

static palmar *open_model(bool unified)
{
    const char *path = write_checkpoint(unified ? "unified" : "hocat", unified ? tiny_unified : tiny_hocat);
    palmar *p;

    ck_assert_msg(palmar_open(path, NULL, &p) == PALMAR_OK, "%s", palmar_last_error());
    return p;
}

static palmar_image picture(void)
{
    return (palmar_image){ .rgb = rgb[0], .width = WIDTH, .height = HEIGHT, .fx = 120, .fy = 121, .cx = 50, .cy = 40 };
}

static const palmar_query two[2] = {
    { .hand_box = { 20, 20, 70, 70 } }, { .hand_box = { 40, 10, 90, 60 }, .left = 1 },
};

static void estimate_two(palmar *p, palmar_image m, int object, palmar_hand out[2])
{
    palmar_query q[2] = { two[0], two[1] };

    q[0].object = q[1].object = object;
    ck_assert_msg(palmar_estimate(p, &m, 2, q, out) == PALMAR_OK, "%s", palmar_last_error());
}

/* ---- the numbers ----------------------------------------------------------------------------------------- */

/* Hand i as the stages of palmar predict have it */
static void expect_hand(const predict_frame *f, int i, const palmar_hand *h)
{
    const predict_result *r = &f->result[i];

    ck_assert_mem_eq(h->joints, r->e.joints, sizeof(h->joints));
    ck_assert_mem_eq(h->vertices, r->e.vertices, sizeof(h->vertices));
    ck_assert_mem_eq(h->joints2d, r->joints2d, sizeof(h->joints2d));
    ck_assert_mem_eq(h->rotations, r->theta, sizeof(h->rotations));
    ck_assert_mem_eq(h->shape, r->e.beta, sizeof(h->shape));
    ck_assert_mem_eq(h->translation, h->joints[0], sizeof(h->translation));
    ck_assert_mem_eq(h->object_rotation, r->e.object.R, sizeof(h->object_rotation));
    ck_assert_mem_eq(h->object_translation, r->e.object.t, sizeof(h->object_translation));
    ck_assert_int_eq(h->object_found, r->object_found);
    ck_assert_int_eq(h->object_trusted, predict_object_trusted(&f->view[i], r));
    ck_assert_int_eq(h->trusted, predict_trusted(&f->view[i], r));
    ck_assert_double_eq(h->agreement_px, r->agreement_px);
}

START_TEST(as_predict)
{
    static const char *const names[] = { "read", "look", "estimate", "solve", NULL };
    const predict_boxes_row rows[2] = {
        { .hand = { 20, 20, 70, 70 }, .has_hand = true },
        { .hand = { 40, 10, 90, 60 }, .has_hand = true, .side = PREDICT_LEFT },
    };
    const lt_camera camera = { 120, 121, 50, 40 };
    const lt_image img = { WIDTH, HEIGHT, 3, 8, rgb[0] };
    const char *path = write_checkpoint("hocat", tiny_hocat);
    predict_object *object = lt_arena_alloc(arena, sizeof(*object));
    predict_options o = { .camera = &camera, .bilinear = true, .any_way_up = true };
    predict_frame f = { .o = &o, .arena = arena, .notes.arena = arena, .object = object, .picture = &img,
                        .input = { .path = "a frame", .boxes = rows, .n_boxes = 2 } };
    palmar_hand hand[2];
    pipeline *stages;
    tiny_model t;
    palmar *p;
    int id;

    tiny_model_init(&t);
    o.m = &t.m;
    check_ok(predict_load_object(arena, &o, "cracker_box", object));
    check_ok(pipeline_open(&o, 0, names, &stages));
    check_ok(pipeline_run(stages, &f));
    ck_assert_int_eq(palmar_open(path, "embedded", &p), PALMAR_OK);
    ck_assert_int_eq(palmar_load_object(p, "cracker_box", NULL, &id), PALMAR_OK);
    ck_assert_int_eq(id, 1);
    estimate_two(p, picture(), id, hand);
    for (int i = 0; i < 2; i++)
        expect_hand(&f, i, &hand[i]);
    ck_assert_mem_eq(palmar_faces(p), t.hand->faces, sizeof(t.hand->faces));
    palmar_close(p);
    pipeline_close(stages);
    tiny_model_fini(&t);
}
END_TEST

/* Rows with something between them; depth that is not a number is not known. */
START_TEST(strides)
{
    static uint8_t wide[HEIGHT][3 * WIDTH + GAP];
    static float deep[HEIGHT][WIDTH + GAP];
    palmar *p = open_model(true);
    palmar_image m = picture();
    palmar_hand packed[2], apart[2];

    memset(wide, 99, sizeof(wide));
    for (int y = 0; y < HEIGHT; y++) {
        memcpy(wide[y], rgb[y], sizeof(rgb[y]));
        memcpy(deep[y], depth[y], sizeof(depth[y]));
    }
    m.depth = depth[0];
    estimate_two(p, m, 0, packed);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            deep[y][x] = depth[y][x] > 0 ? depth[y][x] : NAN;
    m.rgb = wide[0], m.depth = deep[0], m.stride = sizeof(wide[0]), m.depth_stride = sizeof(deep[0]);
    estimate_two(p, m, 0, apart);
    ck_assert_mem_eq(packed[0].joints, apart[0].joints, sizeof(apart->joints));
    ck_assert_mem_eq(packed[1].vertices, apart[1].vertices, sizeof(apart->vertices));
    palmar_close(p);
}
END_TEST

/* What is zero is assumed as palmar predict assumes it. */
START_TEST(defaults)
{
    const palmar_image bare = { .rgb = rgb[0], .width = WIDTH, .height = HEIGHT };
    const palmar_image same = { .rgb = rgb[0], .width = WIDTH, .height = HEIGHT, .fx = 120, .fy = 120, .cx = 49.5,
                                .cy = 39.5 };
    const palmar_query given = { .hand_box = { 25.5, 15.5, 73.5, 63.5 } };
    palmar *p = open_model(false);
    palmar_hand a, b;

    ck_assert_int_eq(palmar_estimate(p, &bare, 1, &(palmar_query){ 0 }, &a), PALMAR_OK);
    ck_assert_int_eq(palmar_estimate(p, &same, 1, &given, &b), PALMAR_OK);
    ck_assert_mem_eq(a.joints, b.joints, sizeof(a.joints));
    palmar_close(p);
}
END_TEST

/* A film of one picture stands still, and another begins anew. */
START_TEST(film)
{
    palmar *p = open_model(false);
    palmar_image m = picture();
    palmar_hand alone, first, later;

    ck_assert_int_eq(palmar_estimate(p, &m, 1, two, &alone), PALMAR_OK);
    for (int k = 0; k < 2; k++) {
        ck_assert_int_eq(palmar_film(p, 30), PALMAR_OK);
        ck_assert_int_eq(palmar_estimate(p, &m, 1, two, &first), PALMAR_OK);
        m.fx += 20;
        ck_assert_int_eq(palmar_estimate(p, &m, 1, two, &later), PALMAR_OK);
        m.fx -= 20;
        if (alone.trusted)
            ck_assert_mem_eq(first.joints, alone.joints, sizeof(alone.joints));
    }
    ck_assert_int_eq(palmar_film(p, 0), PALMAR_OK);
    ck_assert_int_eq(palmar_estimate(p, &m, 1, two, &later), PALMAR_OK);
    ck_assert_mem_eq(later.vertices, alone.vertices, sizeof(alone.vertices));
    palmar_close(p);
}
END_TEST

/* ---- memory and threads ---------------------------------------------------------------------------------- */

START_TEST(allocates_nothing)
{
    palmar *p = open_model(false);
    palmar_hand hand[2];
    int id;

    ck_assert_int_eq(palmar_load_object(p, "mug", NULL, &id), PALMAR_OK);
    ck_assert_int_eq(palmar_film(p, 30), PALMAR_OK);
    for (int k = 0; k < 3; k++)
        estimate_two(p, picture(), id, hand);
    for (int k = 0; k < 3; k++) {
        lt_alloc_fail_at(1);
        estimate_two(p, picture(), id, hand);
        lt_alloc_fail_at(0);
    }
    palmar_close(p);
}
END_TEST

/* Allocations fail, of the later ones some: a status each time, and the next call does it. */
START_TEST(without_memory)
{
    const char *path = write_checkpoint("hocat", tiny_hocat);
    palmar_hand hand[2];
    palmar *p = NULL;
    int id;

    for (long n = 1; !p; n += 1 + n / 8) {
        lt_alloc_fail_at(n);
        if (palmar_open(path, NULL, &p))
            ck_assert_str_ne(palmar_last_error(), "");
        lt_alloc_fail_at(0);
    }
    for (long n = 1; ; n += 1 + n / 8) {
        palmar_status st;

        lt_alloc_fail_at(n);
        st = palmar_load_object(p, "mug", NULL, &id);
        if (!st)
            st = palmar_estimate(p, &(palmar_image){ .rgb = rgb[0], .width = WIDTH, .height = HEIGHT }, 2, two, hand);
        lt_alloc_fail_at(0);
        if (!st)
            break;
        ck_assert_int_eq(st, PALMAR_ENOMEM);
    }
    palmar_close(p);
}
END_TEST

typedef struct { const char *path; palmar_hand hand[2]; } worker;

static void *work(void *ctx)
{
    const palmar_image m = picture();
    worker *w = ctx;
    palmar *p;

    if (palmar_open(w->path, NULL, &p))
        return NULL;
    for (int k = 0; k < 5; k++)
        palmar_estimate(p, &m, 2, two, w->hand);
    palmar_close(p);
    return w;
}

START_TEST(threads)
{
    worker w[3] = { { 0 } };
    pthread_t thread[3];
    void *done;

    w[0].path = w[1].path = w[2].path = write_checkpoint("hocat", tiny_hocat);
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(pthread_create(&thread[i], NULL, work, &w[i]), 0);
    for (int i = 0; i < 3; i++) {
        ck_assert_int_eq(pthread_join(thread[i], &done), 0);
        ck_assert_ptr_nonnull(done);
        ck_assert_mem_eq(w[i].hand[1].vertices, w[0].hand[1].vertices, sizeof(w->hand[1].vertices));
    }
}
END_TEST

/* ---- what callers get wrong ------------------------------------------------------------------------------ */

static void expect_status(palmar_status st, palmar_status want, const char *reason)
{
    ck_assert_int_eq(st, want);
    ck_assert_msg(strstr(palmar_last_error(), reason), "\"%s\" lacks \"%s\"", palmar_last_error(), reason);
}

static void refuse(palmar *p, palmar_image m, palmar_query q, const char *reason)
{
    palmar_hand hand;

    memset(&hand, 7, sizeof(hand));
    expect_status(palmar_estimate(p, &m, 1, &q, &hand), PALMAR_EINVAL, reason);
    for (size_t i = 0; i < sizeof(hand); i++)
        ck_assert_int_eq(((uint8_t *)&hand)[i], 7);
}

START_TEST(wrong_images)
{
    palmar *p = open_model(false);
    palmar_image m[10];

    for (int i = 0; i < 10; i++)
        m[i] = picture();
    m[0].rgb = NULL, m[1].width = 0, m[2].height = -1, m[3].width = 20000, m[4].stride = 5, m[5].depth = depth[0];
    m[6].fx = NAN, m[7].cy = INFINITY, m[8].fx = 0, m[9].fy = -120;
    for (int i = 0; i < 10; i++)
        refuse(p, m[i], two[0], (const char *[]){ "image->rgb is NULL", "an image of 0 x 80", "100 x -1", "20000 x 80",
               "rows are 5 bytes apart, want 3 * 100", "hocat full was trained without depth", "the camera is nan",
               "the camera is 120, 121, 50, inf", "the camera is 0, 121", "-120" }[i]);
    palmar_close(p);
}
END_TEST

START_TEST(wrong_queries)
{
    palmar *p = open_model(false);
    palmar_query q[5] = { two[0], two[0], two[0], two[0], two[0] };

    q[0].hand_box[2] = NAN, q[1].object_box[1] = -INFINITY, q[2].hand_box[2] = 10, q[3].object = 1, q[4].object = -1;
    for (int i = 0; i < 5; i++)
        refuse(p, picture(), q[i], (const char *[]){ "query[0]: a box has the number nan", "the number -inf",
               "the hand box is empty", "object 1, and 0 were loaded", "object -1" }[i]);
    refuse(p, picture(), (palmar_query){ .hand_box = { 200, 10, 300, 60 } }, "lies outside the image of 100 x 80");
    palmar_close(p);
}
END_TEST

START_TEST(wrong_arguments)
{
    const palmar_image m = picture();
    palmar *p = open_model(false), *other = NULL;
    palmar_hand hand[2];
    int id = 5;

    expect_status(palmar_estimate(NULL, &m, 1, two, hand), PALMAR_EINVAL, "p is NULL");
    expect_status(palmar_estimate(p, NULL, 1, two, hand), PALMAR_EINVAL, "image is NULL");
    expect_status(palmar_estimate(p, &m, 1, NULL, hand), PALMAR_EINVAL, "query is NULL");
    expect_status(palmar_estimate(p, &m, 1, two, NULL), PALMAR_EINVAL, "out is NULL");
    expect_status(palmar_estimate(p, &m, 0, two, hand), PALMAR_EINVAL, "0 hands, want 1 to 64");
    expect_status(palmar_film(p, NAN), PALMAR_EINVAL, "fps is nan");
    expect_status(palmar_film(NULL, 30), PALMAR_EINVAL, "p is NULL");
    expect_status(palmar_load_object(p, "spaceship", NULL, &id), PALMAR_EINVAL, "no such object");
    expect_status(palmar_load_object(p, "mug", in_folder("none"), &id), PALMAR_EIO, "none");
    expect_status(palmar_load_object(p, NULL, NULL, &id), PALMAR_EINVAL, "name is NULL");
    ck_assert_int_eq(id, 5);
    expect_status(palmar_open(NULL, NULL, &other), PALMAR_EINVAL, "path is NULL");
    expect_status(palmar_open("x", NULL, NULL), PALMAR_EINVAL, "out is NULL");
    expect_status(palmar_open(in_folder("none"), NULL, &other), PALMAR_EIO, "none");
    ck_assert_ptr_null(other);
    palmar_close(NULL);
    palmar_close(p);
}
END_TEST

/* Checkpoints of what is not posed here */
START_TEST(wrong_models)
{
    static const struct { const char *config, *reason; palmar_status st; } bad[] = {
        { "{\"model\": {\"name\": \"resnet50\"}}", "resnet50 is trained for nothing here, want a model for hand-object",
          PALMAR_EINVAL },
        { "{\"model\": {\"name\": \"hocet\"}}", "did you mean \"hocat\"?", PALMAR_EINVAL },
        { "{\"model\": 3}", "names no model", PALMAR_EFORMAT }, { "[]", "names no model", PALMAR_EFORMAT },
        { "{\"model\": {\"name\": \"hocat\", \"widht\": 8}}", "did you mean \"width\"?", PALMAR_EINVAL },
        { "{\"model\": {\"name\": \"hocat\"}}", "\"trunk.conv1.weight\" is (8, 3, 7, 7)", PALMAR_EINVAL },
        { "{\"model\": {\"name\": \"hocat\"}, \"data\": {\"hand\": \"/none.pkl\"}}", "/none.pkl", PALMAR_EIO },
    };
    const checkpoint_state state = { .step = 1, .best = INFINITY };
    const char *path = in_folder("bad.safetensors");
    tiny_model t;
    palmar *p;

    tiny_model_init(&t);
    check_ok(checkpoint_save(path, &t.m, NULL, bad[_i].config, &state, NULL));
    tiny_model_fini(&t);
    expect_status(palmar_open(path, NULL, &p), bad[_i].st, bad[_i].reason);
    check_ok(lt_write_file(path, "none", 4));
    expect_status(palmar_open(path, NULL, &p), PALMAR_EFORMAT, path);
}
END_TEST

static void setup(void)
{
    arena = lt_arena_new();
    make_scratch_folder();
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            rgb[y][3 * x] = (uint8_t)(2 * x);
            rgb[y][3 * x + 1] = (uint8_t)(3 * y);
            rgb[y][3 * x + 2] = (uint8_t)((x - 30) * (x - 30) + (y - 50) * (y - 50) < 400 ? 250 : 20);
            depth[y][x] = (x + y) % 5 ? 0.5f + 0.001f * (float)x : 0;
        }
}

static void teardown(void)
{
    remove_scratch_folder();
    lt_arena_free(arena);
}

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 120);
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_add_test(t, as_predict);
    tcase_add_test(t, strides);
    tcase_add_test(t, defaults);
    tcase_add_test(t, film);
    tcase_add_test(t, allocates_nothing);
    tcase_add_test(t, without_memory);
    tcase_add_test(t, threads);
    tcase_add_test(t, wrong_images);
    tcase_add_test(t, wrong_queries);
    tcase_add_test(t, wrong_arguments);
    tcase_add_loop_test(t, wrong_models, 0, 7);
}

int main(void)
{
    return run_suite("palmar", add_tests);
}
