/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures without boxes: what a detector sees becomes hands, each with its object, and a record of all of it. */
#include "pipeline/internal.h"
#include "pipeline/objects/objects.h"
#include "pipeline/stages/stages.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/coco_rle.h"
#include "libtensor/io/image/image.h"
#include "tests/estimate/drawn_detector.h"
#include "tests/estimate/tiny_model.h"
#include "tests/suite.h"

enum { WIDTH = 100, HEIGHT = 80 };

static tiny_model tiny;
static detector seeing;                 /* every class of four, by name below; what it finds is written here */
static lt_arena *arena;
static char *said;

static const char *const names[] = { "hand", "left_hand", "025_mug", "cup" };

static const char *in(const char *name)
{
    return lt_path_join(arena, scratch_folder, name);
}

static predict_detection seen(int cls, double score, float x0, float y0, float x1, float y1)
{
    return (predict_detection){
        .kind = cls < 2 ? DETECTED_HAND : DETECTED_OBJECT, .cls = cls, .name = names[cls], .score = score,
        .box = { x0, y0, x1, y1 }, .side = cls == 1 ? PREDICT_LEFT : PREDICT_ANY_SIDE,
    };
}

/* ---- pairs ----------------------------------------------------------------------------------------------- */

START_TEST(partners)
{
    const predict_detection hand = seen(0, 0.9, 40, 40, 60, 60);
    const predict_detection all[] = {
        seen(2, 0.9, 66, 40, 80, 60),           /* 6 px away, a quarter of the hand is 5 */
        seen(2, 0.8, 40, 64, 60, 80),           /* 4 px away */
        seen(3, 0.7, 0, 0, 100, 80),            /* all around, IoU 0.05 */
        seen(2, 0.6, 50, 50, 70, 70),           /* IoU 1/7 */
        seen(3, 0.5, 50, 50, 70, 70),           /* the same, less sure */
        seen(1, 0.9, 40, 40, 60, 60),           /* a hand */
    };

    ck_assert_ptr_null(predict_partner(&hand, all, 1));
    ck_assert_ptr_eq(predict_partner(&hand, all, 2), &all[1]);
    ck_assert_ptr_eq(predict_partner(&hand, all, 3), &all[2]);
    ck_assert_ptr_eq(predict_partner(&hand, all, 6), &all[3]);
    ck_assert_ptr_null(predict_partner(&hand, &all[5], 1));
    ck_assert_ptr_null(predict_partner(&hand, all, 0));
}
END_TEST

/* ---- a frame whose detections are known ------------------------------------------------------------------- */

/* root.a.2.c of "a.2.c"; the test fails when it is not there */
static const cJSON *get(const cJSON *root, const char *path)
{
    char *copy = strdup(path), *rest = copy;

    for (const char *key = strtok_r(rest, ".", &rest); key; key = strtok_r(rest, ".", &rest)) {
        root = cJSON_IsArray(root) ? cJSON_GetArrayItem(root, atoi(key)) : cJSON_GetObjectItemCaseSensitive(root, key);
        ck_assert_msg(root, "no %s in %s", key, path);
    }
    free(copy);
    return root;
}

static const char *text(const cJSON *root, const char *path)
{
    return get(root, path)->valuestring;
}

static bool noted(const cJSON *root, const char *code)
{
    const cJSON *note;

    cJSON_ArrayForEach(note, get(root, "notes"))
        if (strcmp(text(note, "code"), code) == 0)
            return true;
    return false;
}

/* A hand with a mug, a lone left one, one with a cup, somebody, and a mug by itself */
static void fill(predict_frame *f)
{
    static uint8_t pixels[3 * WIDTH * HEIGHT], ones[200];
    static predict_detection list[7];

    list[0] = seen(0, 0.95, 10, 10, 30, 30);
    list[1] = seen(2, 0.9, 20, 10, 40, 30);
    list[2] = seen(1, 0.8, 60, 10, 80, 30);
    list[3] = (predict_detection){ .kind = DETECTED_PERSON, .name = "person", .score = 0.7, .box = { 0, 0, 50, 80 } };
    list[4] = seen(0, 0.4, 10, 50, 30, 70);
    list[5] = seen(3, 0.35, 15, 50, 35, 70);
    list[6] = seen(2, 0.3, 80, 60, 95, 75);
    memset(ones, 1, sizeof(ones));
    list[0].window = (detection_pixels){ 10, 12, 20, 32, ones };
    f->scene = (predict_view){ .path = "p", .name = "p", .rgb = pixels, .width = WIDTH, .height = HEIGHT,
                               .orientation = 1, .camera = { 120, 120, 49.5, 39.5 } };
    f->detection = list;
    f->n_detections = 7;
    f->detected = true;
}

static cJSON *through(const predict_options *o, const char *const *row)
{
    predict_frame f = { .o = o, .arena = arena, .notes.arena = arena };
    pipeline *p;
    cJSON *root;
    char *line;
    size_t n;
    FILE *to = open_memstream(&line, &n);

    fill(&f);
    check_ok(pipeline_open(o, FRAME_SCENE | FRAME_DETECTIONS, row, &p));
    check_ok(pipeline_run(p, &f));
    check_ok(predict_print_json(&f, to));
    fclose(to);
    check_ok(lt_json_parse("line", line, n, &root));
    free(line);
    pipeline_close(p);
    return root;
}

static void check_mask(const cJSON *mask)
{
    static uint8_t pixel[WIDTH * HEIGHT];

    ck_assert_int_eq(get(mask, "size.0")->valueint, HEIGHT);
    ck_assert_int_eq(get(mask, "size.1")->valueint, WIDTH);
    check_ok(lt_rle_decode(text(mask, "counts"), HEIGHT, WIDTH, pixel));
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            ck_assert_int_eq(pixel[y * WIDTH + x], x >= 10 && x < 20 && y >= 12 && y < 32);
}

static void check_objects(const cJSON *root, bool estimated)
{
    static const struct { int hand; const char *cls, *name; } objects[] = {
        { 0, "025_mug", "025_mug" }, { 2, "cup", "unknown" }, { -1, "025_mug", NULL },
    };

    ck_assert_int_eq(cJSON_GetArraySize(get(root, "objects")), LT_COUNT(objects));
    for (size_t i = 0; i < LT_COUNT(objects); i++) {
        const cJSON *b = cJSON_GetArrayItem(get(root, "objects"), (int)i);

        ck_assert_str_eq(text(b, "class"), objects[i].cls);
        ck_assert_str_eq(text(b, "box.source"), "detected");
        ck_assert(objects[i].hand < 0 ? cJSON_IsNull(get(b, "hand")) : get(b, "hand")->valueint == objects[i].hand);
        if (objects[i].name && estimated)
            ck_assert_str_eq(text(b, "name"), objects[i].name);
    }
}

START_TEST(estimates)
{
    static const char *const row[] = { "look", "estimate", "solve", "smooth", "judge", NULL };
    const predict_options o = { .m = &tiny.m, .hand = tiny.hand, .detector = &seeing };
    cJSON *root = through(&o, row);

    ck_assert_int_eq(cJSON_GetArraySize(get(root, "hands")), 3);
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "people")), 1);
    ck_assert_double_eq(get(root, "hands.0.score")->valuedouble, 0.95);
    ck_assert(cJSON_IsNull(get(root, "hands.0.track_id")));
    ck_assert_str_eq(text(root, "hands.0.side"), "right");
    ck_assert_str_eq(text(root, "hands.1.side"), "left");
    ck_assert_str_eq(text(root, "hands.1.class"), "left_hand");
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "hands.1.joints3d_m")), 21);
    check_mask(get(root, "hands.0.mask"));
    check_objects(root, true);
    ck_assert_str_eq(text(root, "detector.variant"), "n");
    ck_assert(noted(root, "low-score") && noted(root, "side-assumed") && noted(root, "object-unknown"));
    ck_assert(!noted(root, "hand-box-assumed") && !noted(root, "object-box-assumed") && !noted(root, "no-object"));
    cJSON_Delete(root);
}
END_TEST

/* What is asked for is what is in every hand. */
START_TEST(one_object_for_all)
{
    static const char *const row[] = { "look", "estimate", "solve", NULL };
    const predict_options o = { .m = &tiny.m, .hand = tiny.hand, .detector = &seeing };
    predict_object own = { .name = NULL };
    predict_frame f = { .o = &o, .arena = arena, .notes.arena = arena, .object = &own };
    pipeline *p;
    cJSON *root;
    char *line;
    size_t n;
    FILE *to = open_memstream(&line, &n);

    check_ok(predict_load_object(arena, &o, "banana", &own));
    fill(&f);
    check_ok(pipeline_open(&o, FRAME_SCENE | FRAME_DETECTIONS, row, &p));
    check_ok(pipeline_run(p, &f));
    for (int i = 0; i < f.n; i++)
        ck_assert_ptr_eq(f.view[i].object, &own);
    check_ok(predict_print_json(&f, to));
    fclose(to);
    check_ok(lt_json_parse("line", line, n, &root));
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "objects")), 4);          /* three hands', and the mug by itself */
    ck_assert_str_eq(text(root, "objects.1.name"), "011_banana");
    ck_assert_str_eq(text(root, "objects.1.box.source"), "default");
    cJSON_Delete(root);
    free(line);
    pipeline_close(p);
}
END_TEST

START_TEST(detections_alone)
{
    static const char *const row[] = { "look", "judge", "draw", NULL };
    const predict_options o = { .detector = &seeing };
    cJSON *root = through(&o, row);

    ck_assert(cJSON_IsNull(get(root, "model")) && cJSON_IsNull(get(root, "hand")));
    ck_assert(cJSON_IsNull(get(root, "hands.0.side")));
    ck_assert_str_eq(text(root, "hands.1.side"), "left");
    ck_assert_ptr_null(cJSON_GetObjectItem(get(root, "hands.0"), "joints3d_m"));
    check_objects(root, false);
    ck_assert(!noted(root, "side-assumed") && !noted(root, "object-unknown"));
    cJSON_Delete(root);
}
END_TEST

/* ---- films ------------------------------------------------------------------------------------------------ */

enum { FRAMES = 12 };

/* A frame of a film in which one hand moves right, another one left, they pass, and a mug stands by. */
static void fill_frame(predict_frame *f, int k, const predict_followed *film)
{
    static predict_detection list[4];
    const float x = (float)(4 * k);

    fill(f);
    list[0] = seen(0, 0.9, x, 5, x + 20, 25);
    list[1] = seen(0, k == 8 ? 0.15 : 0.8, 80 - x, 40, 100 - x, 60);
    list[2] = seen(2, 0.6, 70, 60, 90, 75);
    list[3] = seen(3, 0.2, 0, 60, 10, 70);
    f->detection = list;
    f->n_detections = 4;
    f->film = (predict_followed *)film;
}

static void check_film(pipeline *p, const predict_options *o, int which)
{
    predict_followed film = { .arena = arena, .which = which, .dt = 1.0 / 30 };
    const int64_t *last = NULL;
    int64_t track[3];

    for (int k = 0; k < FRAMES; k++) {
        predict_frame f = { .o = o, .arena = arena, .notes.arena = arena };

        film.time += film.dt;
        fill_frame(&f, k, &film);
        check_ok(pipeline_run(p, &f));
        ck_assert_int_eq(f.n_detections, 3);
        ck_assert_int_eq(f.n, 2);
        if (k < 2)
            continue;
        for (int i = 0; i < 3; i++) {
            ck_assert_int_gt(f.detection[i].track, 0);
            ck_assert(!last || last[i] == f.detection[i].track);
            track[i] = f.detection[i].track;
        }
        last = track;
    }
    ck_assert_int_le(track[0] + track[1] + track[2], 6);
}

/* Each thing keeps its number from the third time on that it is seen, also where it is seen badly; what is seen badly
 * alone is not there. The next film counts anew. */
START_TEST(numbers_stay)
{
    static const char *const row[] = { "track", "look", NULL };
    const predict_options o = { .detector = &seeing, .track = TRACK_BYTE };
    pipeline *p;

    check_ok(pipeline_open(&o, FRAME_SCENE | FRAME_DETECTIONS, row, &p));
    check_film(p, &o, 1);
    check_film(p, &o, 2);
    pipeline_close(p);
}
END_TEST

/* With a network for looks DeepSORT does the same; a thing that is not sure enough is not there. */
START_TEST(numbers_by_looks)
{
    static const char *const row[] = { "track", NULL };
    predict_followed film = { .arena = arena, .which = 1, .dt = 1.0 / 30 };
    predict_options o = { .detector = &seeing, .track = TRACK_DEEPSORT };
    model m;
    lt_params *set = model_of("reid", "{}", NULL, &m);
    pipeline *p;

    m.cls->init(&m, 1);
    check_ok(embedder_new(&m, &o.embedder));
    check_ok(pipeline_open(&o, FRAME_SCENE | FRAME_DETECTIONS, row, &p));
    for (int k = 0; k < 4; k++) {
        predict_frame f = { .o = &o, .arena = arena, .notes.arena = arena };

        film.time += film.dt;
        fill_frame(&f, 0, &film);
        check_ok(pipeline_run(p, &f));
        ck_assert_int_eq(f.n_detections, 3);
        for (int i = 0; i < 3; i++)
            ck_assert_int_eq(f.detection[i].track > 0, k >= 2);
    }
    pipeline_close(p);
    embedder_free(o.embedder);
    lt_params_free(set);
}
END_TEST

static bool drawn_left_of(const lt_image *im, int x, int from_y)
{
    for (int y = from_y; y < im->height; y++)
        for (int k = 0; k < 3 * x; k++)
            if (((const uint8_t *)im->data)[3 * y * im->width + k])
                return true;
    return false;
}

/* A hand in space that does not fit what the picture shows of it is not drawn; its joints in the picture are. */
START_TEST(only_what_fits_is_drawn)
{
    enum { SIDE = 200 };
    static uint8_t rgb[3 * SIDE * SIDE];
    static int32_t face[LT_HAND_FACES][3];
    const crop_box box = { 120, 120, 180, 180 };
    const predict_options o = { .m = NULL };
    predict_view v = { .path = "a", .rgb = rgb, .width = SIDE, .height = SIDE, .camera = { 100, 100, 100, 100 },
                       .hand_box = box, .object_box = box };
    predict_result *r = lt_arena_alloc(arena, sizeof(*r));
    lt_mesh hand = { .face = face };
    predict_frame f = { .o = &o, .arena = arena, .scene = v, .view = &v, .n = 1, .result = r, .hand = &hand,
                        .has = FRAME_POSES };
    lt_image im;

    r->placed = true;
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        memcpy(r->e.joints[i], (float[]){ -0.5f, 0.5f, 1 }, sizeof(r->e.joints[i]));     /* at (50, 150) */
        r->heatmap2d[i][0] = (float)(130 + 10 * (i % 5));
        r->heatmap2d[i][1] = (float)(130 + 10 * (i / 5));
    }
    r->agreement_px = 5;
    check_ok(predict_draw_overlay(&f, &im));
    ck_assert(drawn_left_of(&im, 110, 110));
    r->agreement_px = 90;
    check_ok(predict_draw_overlay(&f, &im));
    ck_assert(!drawn_left_of(&im, 110, 110) && drawn_left_of(&im, 150, 110));
}
END_TEST

/* Filters go with the numbers: hands that pass each other keep theirs. */
START_TEST(filters_go_with_numbers)
{
    predict_followed film = { .arena = arena, .which = 1, .dt = 1.0 / 30 };
    predict_detection a = seen(0, 0.9, 0, 0, 20, 20), b = seen(0, 0.9, 10, 0, 30, 20);
    predict_view v[2] = { { .hand_seen = &a, .hand_box = a.box }, { .hand_seen = &b, .hand_box = b.box } };
    predict_result *r = lt_arena_array(arena, 2, sizeof(*r));

    a.track = 7;
    b.track = 8;
    check_ok(predict_follow(&film, arena, v, r, 2));
    ck_assert_int_eq(film.smoother[0].track, 7);
    v[0].hand_box = b.box;
    v[1].hand_box = a.box;
    check_ok(predict_follow(&film, arena, v, r, 2));
    ck_assert_uint_eq(film.n, 2);
    ck_assert_float_eq(film.smoother[0].box.x0, b.box.x0);
    a.track = 9;
    check_ok(predict_follow(&film, arena, v, r, 1));
    ck_assert_uint_eq(film.n, 3);
    ck_assert_int_eq(film.smoother[0].unseen, 1);
    ck_assert_int_eq(film.smoother[2].track, 9);
}
END_TEST

/* ---- from files to files ---------------------------------------------------------------------------------- */

static void write_picture(const char *name)
{
    lt_image img;

    check_ok(lt_image_init(arena, WIDTH, HEIGHT, 3, 8, &img));
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
        img.data[i] = (uint8_t)(i * i / 7);
    check_ok(lt_png_write(in(name), &img));
}

static void predict(predict_options o, int n, const char *const *inputs)
{
    size_t size;
    predict_summary sum;

    free(said);
    said = NULL;
    o.hand = tiny.hand;
    o.inputs = inputs;
    o.n_inputs = n;
    o.out = in("out");
    o.messages = open_memstream(&said, &size);
    check_ok(predict_images(&o, &sum));
    fclose(o.messages);
    ck_assert_int_eq(sum.written, n);
}

static cJSON *numbers(const char *name)
{
    cJSON *root;

    check_ok(lt_json_read(in(name), &root));
    return root;
}

static int count(const char *text_of, const char *words)
{
    int n = 0;

    for (; (text_of = strstr(text_of, words)) != NULL; text_of++)
        n++;
    return n;
}

/* Nothing is found: a line each, and what an earlier run left of hands goes. What is listed is there all the same. */
START_TEST(nothing_found)
{
    static const char boxes[] = "image,hand_x0,hand_y0,hand_x1,hand_y1\na.png,20,20,60,60\n";
    const char *const input[] = { in("a.png"), in("b.png") };
    predict_options o = { .m = &tiny.m };
    detector blind;
    cJSON *root;

    write_picture("a.png");
    write_picture("b.png");
    write_detector(in("none.safetensors"), 23, -1);
    check_ok(detector_open(in("none.safetensors"), &blind));
    predict(o, 2, input);
    ck_assert(exists(in("out/a.hand.obj")));
    o.detector = &blind;
    predict(o, 2, input);
    ck_assert_int_eq(count(said, "the detector found nothing"), 2);
    ck_assert(!exists(in("out/a.hand.obj")) && exists(in("out/a.overlay.png")));
    root = numbers("out/a.json");
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "hands")), 0);
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "objects")), 0);
    ck_assert(cJSON_IsNull(get(root, "hand")) && noted(root, "nothing-found"));
    cJSON_Delete(root);
    put_file(in("boxes.csv"), boxes, sizeof(boxes) - 1);
    o.boxes = in("boxes.csv");
    predict(o, 2, input);
    ck_assert_int_eq(count(said, "the detector found nothing"), 1);
    root = numbers("out/a.json");
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "hands")), 1);
    ck_assert_str_eq(text(root, "hands.0.box.source"), "listed");
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "objects")), 1);
    cJSON_Delete(root);
    detector_close(&blind);
}
END_TEST

/* A detector without a class for hands says so once; whatever it finds is told. */
START_TEST(no_class_of_hands)
{
    const char *const input[] = { in("a.png"), in("a.png") };
    detector cups;
    cJSON *root;

    write_picture("a.png");
    write_detector(in("cups.safetensors"), 2, 1);
    check_ok(detector_open(in("cups.safetensors"), &cups));
    predict((predict_options){ .detector = &cups }, 2, input);
    ck_assert_int_eq(count(said, "none of its 2 classes is called hand, left_hand or right_hand"), 1);
    root = numbers("out/a.json");
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "hands")), 0);
    ck_assert_int_gt(cJSON_GetArraySize(get(root, "objects")), 0);
    ck_assert_str_eq(text(root, "objects.0.class"), "class 1");
    cJSON_Delete(root);
    ck_assert(exists(in("out/a.overlay.png")));
    detector_close(&cups);
}
END_TEST

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
    tiny_model_init(&tiny);
    seeing = (detector){ .n = LT_COUNT(names), .name = (const char **)names };
    seeing.t.path = "d";
    seeing.t.m = (model){ .cls = tiny.m.cls, .variant = "n" };
}

static void teardown(void)
{
    tiny_model_fini(&tiny);
    lt_arena_free(arena);
    remove_scratch_folder();
    free(said);
    said = NULL;
}

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 60);
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_add_test(t, partners);
    tcase_add_test(t, estimates);
    tcase_add_test(t, one_object_for_all);
    tcase_add_test(t, detections_alone);
    tcase_add_test(t, numbers_stay);
    tcase_add_test(t, numbers_by_looks);
    tcase_add_test(t, filters_go_with_numbers);
    tcase_add_test(t, only_what_fits_is_drawn);
    tcase_add_test(t, nothing_found);
    tcase_add_test(t, no_class_of_hands);
}

int main(void)
{
    return run_suite("detected", add_tests);
}
