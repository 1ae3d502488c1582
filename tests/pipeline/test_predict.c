/* SPDX-License-Identifier: Apache-2.0 */
/* From photographs to files: names, defaults, JSON, meshes, mirrored hands, and inputs that are none. */
#include <config.h>
#include "pipeline/internal.h"

#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/mesh/ply.h"
#include "tasks/hand_object/sheet.h"
#include "tests/estimate/tiny_model.h"
#include "tests/io/avi.h"
#include "tests/suite.h"
#include "vision/drawing/draw.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

enum { WIDTH = 100, HEIGHT = 80 };

static tiny_model tiny;
static lt_arena *arena;
static char *said;                      /* messages of the last run */

static const char *in(const char *name)
{
    return lt_path_join(arena, scratch_folder, name);
}

/* A picture without symmetry. */
static lt_image picture(bool mirrored)
{
    lt_image img;

    ck_assert_int_eq(lt_image_init(arena, WIDTH, HEIGHT, 3, 8, &img), LT_OK);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            uint8_t *p = img.data + 3 * (y * WIDTH + (mirrored ? WIDTH - 1 - x : x));

            p[0] = (uint8_t)(2 * x);
            p[1] = (uint8_t)(3 * y);
            p[2] = (uint8_t)((x - 30) * (x - 30) + (y - 50) * (y - 50) < 400 ? 250 : 20);
        }
    return img;
}

static void write_png(const char *name, bool mirrored)
{
    const lt_image img = picture(mirrored);

    ck_assert_int_eq(lt_png_write(in(name), &img), LT_OK);
}

static void write_bytes(const char *name, const void *bytes, size_t n)
{
    ck_assert_int_eq(lt_write_file(in(name), bytes, n), LT_OK);
}

static lt_status predict(predict_options o, int n, const char *const *inputs, predict_summary *sum)
{
    size_t size;
    lt_status st;

    free(said);
    said = NULL;
    o.m = o.m ? o.m : &tiny.m;
    o.hand = tiny.hand;
    o.inputs = inputs;
    o.n_inputs = n;
    o.out = in("out");
    o.messages = open_memstream(&said, &size);
    st = predict_images(&o, sum);
    fclose(o.messages);
    return st;
}

static cJSON *numbers(const char *name)
{
    cJSON *root;

    check_ok(lt_json_read(in(name), &root));
    return root;
}

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

static double item(const cJSON *root, const char *path, int i)
{
    return cJSON_GetArrayItem(get(root, path), i)->valuedouble;
}

static const char *text(const cJSON *root, const char *path)
{
    return get(root, path)->valuestring;
}

static void check_files(const char *name, const cJSON *root)
{
    lt_image img;
    lt_mesh mesh;

    ck_assert_int_eq(lt_image_read(arena, in(lt_arena_printf(arena, "out/%s.overlay.png", name)), &img), LT_OK);
    ck_assert_int_eq(img.width, (int)get(root, "width_px")->valuedouble);
    ck_assert_int_eq(img.height, (int)get(root, "height_px")->valuedouble);
    ck_assert_int_eq(lt_obj_read(arena, in(lt_arena_printf(arena, "out/%s", text(root, "hand.vertices_file"))),
                                 &mesh, NULL), LT_OK);
    ck_assert_int_eq(mesh.n_vertices, LT_HAND_VERTICES);
    ck_assert_int_eq(mesh.n_faces, LT_HAND_FACES);
    ck_assert_int_eq(exists(in(lt_arena_printf(arena, "out/%s.object.obj", name))),
                     cJSON_IsTrue(get(root, "object.found")));
}

START_TEST(one_image)
{
    static const struct { const char *key; int n; } lists[] = {
        { "hand.joints3d_m", 21 }, { "hand.joints2d_px", 21 }, { "hand.heatmap2d_px", 21 },
        { "hand.theta_rad", 48 }, { "hand.beta", 10 }, { "camera.K_px", 4 },
        { "boxes.hand.x0y0x1y1_px", 4 }, { "boxes.object.x0y0x1y1_px", 4 },
    };
    static const char *const present[] = {
        "object.confidence", "object.inliers", "object.trusted", "object.R", "object.t_m", "hand.agreement_px",
        "hand.trusted",
        "conventions.axes", "conventions.joints", "conventions.theta", "model.checkpoint",
    };
    const crop_box hand = { 20, 20, 70, 70 };
    const lt_camera camera = { 120, 121, 50, 40 };
    const char *const input[] = { in("one.png") };
    predict_summary sum;
    cJSON *root;

    write_png("one.png", false);
    ck_assert_int_eq(predict((predict_options){ .checkpoint = "run/best", .trained_on = "synthetic",
                     .hand_box = &hand, .camera = &camera, .object = "cracker_box" }, 1, input, &sum), LT_OK);
    ck_assert_int_eq(sum.written, 1);
    ck_assert_int_eq(sum.skipped, 0);
    root = numbers("out/one.json");
    for (size_t i = 0; i < LT_COUNT(lists); i++)
        ck_assert_int_eq(cJSON_GetArraySize(get(root, lists[i].key)), lists[i].n);
    for (size_t i = 0; i < LT_COUNT(present); i++)
        get(root, present[i]);
    ck_assert_str_eq(text(root, "image"), input[0]);
    ck_assert_str_eq(text(root, "object.name"), "003_cracker_box");
    ck_assert_str_eq(text(root, "model.trained_on"), "synthetic");
    ck_assert_str_eq(text(root, "boxes.hand.source"), "given");
    ck_assert_str_eq(text(root, "boxes.object.source"), "default");
    ck_assert_str_eq(text(root, "camera.source"), "given");
    ck_assert_double_eq(item(root, "camera.K_px", 1), 121);
    check_files("one", root);
    cJSON_Delete(root);
    ck_assert(!strstr(said, "--hand-box"));
    ck_assert(strstr(said, "--object-box"));
}
END_TEST

/* Whether there is a note with this code and these words. */
static bool noted(const cJSON *root, const char *code, const char *words)
{
    const cJSON *note;

    cJSON_ArrayForEach(note, get(root, "notes"))
        if (strcmp(text(note, "code"), code) == 0 && strstr(text(note, "text"), words))
            return true;
    return false;
}

static void check_same(const cJSON *root, const char *a, const char *b)
{
    ck_assert_msg(cJSON_Compare(get(root, a), get(root, b), true), "%s and %s differ", a, b);
}

/* What programs read: lists of hands and objects, notes with codes; and beside them the keys of before. */
START_TEST(schema)
{
    static const char *const hand[] = { "side", "position", "trusted", "joints3d_m", "theta_rad", "vertices_file" };
    static const char *const object[] = { "name", "found", "R", "t_m", "confidence", "vertices_file" };
    const char *const input[] = { in("one.png") };
    cJSON *root;

    write_png("one.png", false);
    check_ok(predict((predict_options){ .object = "mug" }, 1, input, NULL));
    root = numbers("out/one.json");
    ck_assert_str_eq(text(root, "schema"), "palmar.frame/1");
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "hands")), 1);
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "objects")), 1);
    ck_assert_int_eq(get(root, "objects.0.hand")->valueint, 0);
    for (size_t i = 0; i < LT_COUNT(hand); i++)
        check_same(root, lt_arena_printf(arena, "hands.0.%s", hand[i]), lt_arena_printf(arena, "hand.%s", hand[i]));
    for (size_t i = 0; i < LT_COUNT(object); i++)
        check_same(root, lt_arena_printf(arena, "objects.0.%s", object[i]),
                   lt_arena_printf(arena, "object.%s", object[i]));
    check_same(root, "hands.0.box", "boxes.hand");
    check_same(root, "objects.0.box", "boxes.object");
    check_same(root, "objects.0.box2d_px", "object_box2d_px");
    ck_assert(noted(root, "hand-box-assumed", "no --hand-box: took the middle of the image, 26,16,74,64"));
    ck_assert(noted(root, "object-box-assumed", "took the hand's box grown"));
    ck_assert(noted(root, "camera-assumed", "120 px"));
    ck_assert(!noted(root, "no-object", ""));
    cJSON_Delete(root);
    check_ok(predict((predict_options){ 0 }, 1, input, NULL));
    root = numbers("out/one.json");
    ck_assert(cJSON_IsNull(get(root, "objects.0.name")) && cJSON_IsFalse(get(root, "objects.0.found")));
    ck_assert(noted(root, "no-object", "no --object"));
    cJSON_Delete(root);
}
END_TEST

START_TEST(no_old_object_stays)       /* beside a prediction that knows of none */
{
    const char *const input[] = { in("a.png") };

    write_png("a.png", false);
    ck_assert_int_eq(predict((predict_options){ .object = "mug" }, 1, input, NULL), LT_OK);
    ck_assert_int_eq(lt_write_file(in("out/a.object.obj"), "", 0), LT_OK);
    ck_assert_int_eq(predict((predict_options){ 0 }, 1, input, NULL), LT_OK);
    ck_assert(!exists(in("out/a.object.obj")));
}
END_TEST

/* The same hand in each format: the object of an untrained model may or may not be found. */
START_TEST(formats)
{
    const char *const input[] = { in("a.png") };
    predict_options o = { .object = "mug" };
    lt_mesh obj, ply;
    uint8_t *bytes;
    lt_ply file;
    size_t n;
    cJSON *root;

    write_png("a.png", false);
    ck_assert_int_eq(predict(o, 1, input, NULL), LT_OK);
    o.format = PREDICT_PLY;
    ck_assert_int_eq(predict(o, 1, input, NULL), LT_OK);
    ck_assert_int_eq(lt_obj_read(arena, in("out/a.hand.obj"), &obj, NULL), LT_OK);
    ck_assert_int_eq(lt_ply_read(arena, in("out/a.hand.ply"), &file), LT_OK);
    ck_assert_int_eq(lt_ply_mesh(arena, &file, &ply), LT_OK);
    ck_assert_mem_eq(obj.vertex, ply.vertex, (size_t)LT_HAND_VERTICES * sizeof(*obj.vertex));
    ck_assert_mem_eq(obj.face, ply.face, (size_t)LT_HAND_FACES * sizeof(*obj.face));
    o.format = PREDICT_GLB;
    ck_assert_int_eq(predict(o, 1, input, NULL), LT_OK);
    ck_assert_int_eq(lt_read_file(arena, in("out/a.glb"), LT_FILE_MAX, &bytes, &n), LT_OK);
    ck_assert_mem_eq(bytes, "glTF", 4);
    root = numbers("out/a.json");
    ck_assert_str_eq(text(root, "hand.vertices_file"), "a.glb");
    ck_assert_int_eq(exists(in("out/a.object.obj")), cJSON_IsTrue(get(root, "object.found")));
    ck_assert_int_eq(exists(in("out/a.object.ply")), cJSON_IsTrue(get(root, "object.found")));
    cJSON_Delete(root);
}
END_TEST

START_TEST(defaults)
{
    static const double hand[4] = { 25.5, 15.5, 73.5, 63.5 }, object[4] = { 18.3, 8.3, 80.7, 70.7 };
    const char *const input[] = { in("one.png") };
    cJSON *root;

    write_png("one.png", false);
    ck_assert_int_eq(predict((predict_options){ .left = false }, 1, input, NULL), LT_OK);
    root = numbers("out/one.json");
    for (int i = 0; i < 4; i++) {
        ck_assert_double_eq_tol(item(root, "boxes.hand.x0y0x1y1_px", i), hand[i], 1e-4);
        ck_assert_double_eq_tol(item(root, "boxes.object.x0y0x1y1_px", i), object[i], 1e-4);
    }
    ck_assert_double_eq(item(root, "camera.K_px", 0), 120);
    ck_assert_double_eq(item(root, "camera.K_px", 2), 49.5);
    ck_assert_str_eq(text(root, "camera.source"), "default");
    ck_assert(cJSON_IsNull(get(root, "object")));
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "object_box2d_px")), 21);
    ck_assert(cJSON_IsNull(get(root, "model.trained_on")));
    cJSON_Delete(root);
    ck_assert(strstr(said, "--hand-box") && strstr(said, "--object-box") && strstr(said, "--K"));
    ck_assert(strstr(said, "--object:"));
}
END_TEST

/* Two folders with the same names, and things in them that are no images. */
START_TEST(folders)
{
    const char *const inputs[] = { in("first"), in("second"), in("missing.png"), in("empty") };
    predict_summary sum;

    ck_assert(!lt_make_dirs(in("first/deeper")) && !lt_make_dirs(in("second")) && !lt_make_dirs(in("empty")));
    write_png("first/b.png", false);
    write_png("first/a b \xc3\xbc.PNG", false);
    write_png("first/.hidden.png", false);
    write_png("first/b.overlay.png", false);
    write_bytes("first/notes.txt", "no image", 8);
    write_bytes("first/bad.jpg", "\xff\xd8\xff\xe1 no image either", 20);
    write_bytes("first/c.png", "", 0);
    write_png("second/b.png", false);
    write_png("second/b-2.png", false);
    ck_assert_int_eq(predict((predict_options){ .left = true }, 4, inputs, &sum), LT_EFORMAT);
    ck_assert(strstr(lt_last_error(), "4 of 8"));
    ck_assert_int_eq(sum.written, 4);
    ck_assert_int_eq(sum.skipped, 4);
    ck_assert(exists(in("out/a b \xc3\xbc.json")) && exists(in("out/b.json")));
    ck_assert(exists(in("out/b-2.json")) && exists(in("out/b-3.json")));
    ck_assert(!exists(in("out/bad.json")) && !exists(in("out/bad.hand.obj")) && !exists(in("out/.hidden.json")));
    ck_assert(!exists(in("out/b.overlay.json")));
    ck_assert(strstr(said, "bad.jpg") && strstr(said, "c.png") && strstr(said, "missing.png"));
    ck_assert(strstr(said, "empty: no images"));
}
END_TEST

/* The names of the results of these inputs, in order. */
static void check_listed(double fps, const char *const *inputs, int n, const char *names)
{
    const predict_options o = { .m = &tiny.m, .inputs = inputs, .n_inputs = n, .fps = fps };
    const char *found = "";
    predict_list list;

    check_ok(predict_list_inputs(arena, &o, &list));
    for (int i = 0; i < list.n; i++)
        found = lt_arena_printf(arena, "%s%s ", found, list.input[i].name);
    ck_assert_str_eq(found, names);
}

/* Frames come as they are numbered: from a folder, and from the shell, which goes by letters. */
START_TEST(frames_in_order)
{
    static const char *const names[] = { "film/f1.png", "film/f10.png", "film/f2.JPEG", "film/f9999.jpg",
                                         "film/f10000.jpg", "film/f007.Png" };
    const char *const folder[] = { in("film") }, *const shell[] = { in("f1.png"), in("f10.png"), in("f2.png") };
    const char *const by_hand[] = { shell[2], shell[1], shell[0] };

    ck_assert_int_eq(lt_make_dirs(in("film")), LT_OK);
    for (size_t i = 0; i < LT_COUNT(names); i++)
        put_file(in(names[i]), "", 0);
    for (int i = 0; i < 3; i++)
        put_file(shell[i], "", 0);
    check_listed(30, folder, 1, "f1 f2 f007 f10 f9999 f10000 ");
    check_listed(0, folder, 1, "f1 f2 f007 f10 f9999 f10000 ");
    check_listed(30, shell, 3, "f1 f2 f10 ");
    check_listed(0, shell, 3, "f1 f10 f2 ");
    check_listed(30, by_hand, 3, "f2 f10 f1 ");
}
END_TEST

static bool at_once(void)
{
    return true;
}

/* Stopped, it leaves whole what it has written, and says so. */
START_TEST(stopped)
{
    const char *const inputs[] = { in("a.png"), in("b.png") };
    predict_summary sum;

    write_png("a.png", false);
    write_png("b.png", false);
    ck_assert_int_eq(predict((predict_options){ .stop = at_once }, 2, inputs, &sum), LT_ESTOPPED);
    ck_assert_int_eq(sum.written, 1);
    ck_assert(exists(in("out/a.json")) && exists(in("out/a.overlay.png")) && !exists(in("out/b.json")));
}
END_TEST

START_TEST(wrong)
{
    const crop_box outside = { 500, 500, 600, 600 };
    const char *const input[] = { in("one.png") };
    predict_summary sum;

    write_png("one.png", false);
    ck_assert_int_eq(predict((predict_options){ .hand_box = &outside }, 1, input, &sum), LT_EFORMAT);
    ck_assert(strstr(said, "outside the image of 100 x 80"));
    ck_assert_int_eq(sum.skipped, 1);
    ck_assert_int_eq(predict((predict_options){ .object = "cracker_bix" }, 1, input, NULL), LT_EUSAGE);
    ck_assert(strstr(lt_last_error(), "cracker_box"));
    ck_assert_int_eq(predict((predict_options){ .object = "cracker_box", .models = in("nowhere") }, 1, input,
                     NULL), LT_EIO);
    ck_assert_int_eq(predict((predict_options){ .left = false }, 0, input, NULL), LT_EINVAL);
    ck_assert(!exists(in("out/one.json")));
}
END_TEST

/* A model that has gone bad stops the run before anything is written. */
START_TEST(not_finite)
{
    const char *const input[] = { in("one.png") };

    write_png("one.png", false);
    lt_params_first(tiny.params)->data[0] = NAN;
    ck_assert_int_eq(predict((predict_options){ .left = false }, 1, input, NULL), LT_ENUMERIC);
    ck_assert(!exists(in("out/one.json")));
}
END_TEST

/* The left hand in a mirrored image is the mirrored right hand. Boxes are their own mirror images. */
START_TEST(mirror)
{
    const crop_box hand = { 20, 20, 79, 70 }, object = { 10, 10, 89, 75 };
    predict_options o = { .object = "mug", .hand_box = &hand, .object_box = &object };
    const char *const right[] = { in("right.png") }, *const left[] = { in("left.png") };
    cJSON *r, *l;

    write_png("right.png", false);
    write_png("left.png", true);
    ck_assert_int_eq(predict(o, 1, right, NULL), LT_OK);
    o.left = true;
    ck_assert_int_eq(predict(o, 1, left, NULL), LT_OK);
    r = numbers("out/right.json");
    l = numbers("out/left.json");
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const cJSON *a = cJSON_GetArrayItem(get(r, "hand.joints3d_m"), i);
        const cJSON *b = cJSON_GetArrayItem(get(l, "hand.joints3d_m"), i);

        for (int d = 0; d < 3; d++)
            ck_assert_double_eq_tol(cJSON_GetArrayItem(b, d)->valuedouble,
                                    (d ? 1 : -1) * cJSON_GetArrayItem(a, d)->valuedouble, 1e-5);
    }
    for (int k = 0; k < 48; k++)
        ck_assert_double_eq_tol(item(l, "hand.theta_rad", k), (k % 3 ? -1 : 1) * item(r, "hand.theta_rad", k),
                                1e-5);
    ck_assert_int_eq(cJSON_IsTrue(get(l, "object.found")), cJSON_IsTrue(get(r, "object.found")));
    ck_assert_str_eq(text(l, "hand.side"), "left");
    cJSON_Delete(r);
    cJSON_Delete(l);
}
END_TEST

/* A JPEG of ours with an APP1 behind its first two bytes: turned by 90 degrees, 28 mm. */
static void write_exif_jpeg(const char *name)
{
    static const uint8_t app1[] = {
        0xff, 0xe1, 0, 64, 'E', 'x', 'i', 'f', 0, 0, 'I', 'I', 42, 0, 8, 0, 0, 0, 2, 0,
        0x12, 0x01, 3, 0, 1, 0, 0, 0, 6, 0, 0, 0, 0x69, 0x87, 4, 0, 1, 0, 0, 0, 38, 0, 0, 0, 0, 0, 0, 0,
        1, 0, 0x05, 0xa4, 3, 0, 1, 0, 0, 0, 28, 0, 0, 0, 0, 0, 0, 0,
    };
    const lt_image img = picture(false);
    uint8_t *jpeg, *all;
    size_t n;

    ck_assert_int_eq(lt_jpeg_encode(arena, &img, 90, &jpeg, &n), LT_OK);
    all = lt_arena_alloc(arena, n + sizeof(app1));
    memcpy(all, jpeg, 2);
    memcpy(all + 2, app1, sizeof(app1));
    memcpy(all + 2 + sizeof(app1), jpeg + 2, n - 2);
    write_bytes(name, all, n + sizeof(app1));
}

START_TEST(exif)
{
    const char *const input[] = { in("turned.jpg") };
    cJSON *root;

    write_exif_jpeg("turned.jpg");
    ck_assert_int_eq(predict((predict_options){ .object = "mug" }, 1, input, NULL), LT_OK);
    root = numbers("out/turned.json");
    ck_assert_double_eq(get(root, "width_px")->valuedouble, HEIGHT);
    ck_assert_double_eq(get(root, "height_px")->valuedouble, WIDTH);
    ck_assert_str_eq(text(root, "camera.source"), "exif");
    ck_assert_double_eq_tol(item(root, "camera.K_px", 0), 28 * hypot(WIDTH, HEIGHT) / hypot(36, 24), 1e-9);
    check_files("turned", root);
    cJSON_Delete(root);
    ck_assert(strstr(said, "turned upright") && strstr(said, "from EXIF"));
}
END_TEST

/* The note on this camera of a.png, which is 100 x 80; NULL: none */
static const char *doubt(predict_options o, const char *code)
{
    const char *const input[] = { in("a.png") };
    const cJSON *note;
    const char *found = NULL;
    cJSON *root;

    check_ok(predict(o, 1, input, NULL));
    root = numbers("out/a.json");
    cJSON_ArrayForEach(note, get(root, "notes"))
        if (strcmp(text(note, "code"), code) == 0)
            found = lt_arena_strdup(arena, text(note, "text"));
    cJSON_Delete(root);
    return found;
}

/* K that is not this picture's is doubted, and what would make it fit is named. */
START_TEST(camera_doubtful)
{
    static const struct { lt_camera K; const char *words; } cases[] = {
        { { 120, 120, 50, 40 }, NULL }, { { 120, 121, 46, 43 }, NULL },
        { { 360, 360, 150, 120 }, "K of pictures of about 300 x 240? For this size it would be 120,120," },
        { { 60, 60, 24, 19 }, "K of pictures of about 48 x 38?" },
        { { 120, 50, 120, 40 }, "the order is fx,fy,cx,cy; was 120,120,50,40 meant?" },
        { { 120, 120, 40, 50 }, "K of the picture before it was turned?" },
        { { 120, 120, 50, 5000 }, "K of another camera or size" },
        { { 4, 4, 50, 40 }, "focal lengths of 4 and 4 px for a picture of 100 x 80" },
        { { 120, 200, 50, 40 }, "focal lengths of 120 and 200 px: most cameras have one" },
    };

    write_png("a.png", false);
    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        const char *found = doubt((predict_options){ .camera = &cases[i].K }, "camera-doubtful");

        ck_assert_msg(cases[i].words ? found && strstr(found, cases[i].words) : !found, "%zu: %s", i, found);
    }
    ck_assert(strstr(doubt((predict_options){ .camera = &cases[0].K, .camera_skew = 2 }, "camera-doubtful"),
                     "skew of 2"));
}
END_TEST

/* K of a file that says for which size it is */
START_TEST(camera_scaled)
{
    const lt_camera K = { 240, 240, 99.5, 79.5 };
    predict_options o = { .camera = &K, .camera_width = 200, .camera_height = 160 };
    cJSON *root;

    write_png("a.png", false);
    ck_assert_str_eq(doubt(o, "camera-scaled"), "K is of pictures of 200 x 160: scaled to 100 x 80");
    root = numbers("out/a.json");
    ck_assert_double_eq(item(root, "camera.K_px", 1), 120);
    ck_assert_double_eq(item(root, "camera.K_px", 2), 49.5);
    cJSON_Delete(root);
    o.camera_width = 300;
    ck_assert(strstr(doubt(o, "camera-doubtful"), "of 300 x 160, and this one, of 100 x 80, has another shape"));
}
END_TEST

/* A picture that a lens bent gives what the straight one does, boxes in its own pixels. */
START_TEST(lens)
{
    const lt_camera K = { 100, 100, 49.5, 39.5 };
    const lt_lens bent = { .k = { -0.3, 0.05 } }, none = { .k = { 0 } }, folded = { .k = { -4 } };
    const char *const input[] = { in("a.png") };
    predict_options o = { .camera = &K, .lens = &none, .hand_box = &(crop_box){ 20, 20, 70, 70 } };
    lt_image img;
    cJSON *root;

    write_png("a.png", false);
    ck_assert_ptr_null(doubt(o, "undistorted"));
    o.lens = &bent;
    ck_assert_ptr_nonnull(doubt(o, "undistorted"));
    root = numbers("out/a.json");
    ck_assert_double_eq(item(root, "camera.distortion", 0), -0.3);
    ck_assert_double_lt(item(root, "hands.0.box.x0y0x1y1_px", 0), 19);
    ck_assert_double_lt(item(root, "objects.0.box.x0y0x1y1_px", 1), 20);
    cJSON_Delete(root);
    check_ok(lt_image_read(arena, in("out/a.overlay.png"), &img));
    ck_assert_int_eq(img.width, WIDTH);
    o.lens = &folded;
    ck_assert_int_eq(predict(o, 1, input, NULL), LT_EFORMAT);
    ck_assert_msg(strstr(said, "a.png: no lens does this"), "%s", said);
}
END_TEST

static bool differ(const lt_image *sheet, int x0, int x1)
{
    for (int y = 0; y < sheet->height; y++)
        for (int x = 0; x < x1 - x0; x++)
            if (memcmp(sheet->data + 3 * (y * sheet->width + x0 + x),
                       sheet->data + 3 * (y * sheet->width + x1 + x), 3))
                return true;
    return false;
}

START_TEST(sheet)
{
    dataset_sample s = { .name = "SEQ/0001", .flags = SAMPLE_JOINTS, .width = WIDTH, .height = HEIGHT,
                         .camera = { 120, 120, 49.5, 39.5 }, .object = -1 };
    estimate *e = lt_arena_alloc(arena, sizeof(*e));
    const sheet_item items[3] = { { .sample = &s, .estimate = e }, { .sample = &s, .estimate = e },
                                  { .sample = &s, .estimate = e, .title = "third" } };
    lt_image img = picture(false);

    s.rgb = img.data;
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const float p[3] = { .005f * (float)i - .05f, .04f * sinf((float)i), .5f };

        memcpy(s.joints[i], p, sizeof(p));
        memcpy(e->joints[i], p, sizeof(p));
        e->joints[i][1] += .02f;
        s.joints2d[i][0] = 49.5f + 120 * p[0] / p[2];
        s.joints2d[i][1] = 39.5f + 120 * p[1] / p[2];
    }
    ck_assert_int_eq(predict_sheet(in("sheet.png"), items, 3, NULL), LT_OK);
    ck_assert_int_eq(lt_image_read(arena, in("sheet.png"), &img), LT_OK);
    ck_assert_int_gt(img.width, 4 * 200);
    ck_assert_int_gt(img.height, 2 * 200);
    ck_assert(differ(&img, 0, img.width / 4));          /* the truth is not the prediction */
    ck_assert_int_eq(predict_sheet(in("sheet.png"), items, 3, tiny.hand->faces), LT_OK);
    ck_assert_int_eq(predict_sheet(in("sheet.png"), items, 0, NULL), LT_EINVAL);
}
END_TEST

START_TEST(numbers_alone)
{
    const char *const input[] = { in("a.png") };
    cJSON *root;

    write_png("a.png", false);
    ck_assert_int_eq(predict((predict_options){ .numbers = true, .quiet = true }, 1, input, NULL), LT_OK);
    ck_assert_str_eq(said, "");
    root = numbers("out/a.json");
    ck_assert_int_gt(cJSON_GetArraySize(get(root, "notes")), 0);
    ck_assert(cJSON_IsNull(get(root, "hand.vertices_file")));
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "hand.joints3d_m")), LT_HAND_KEYPOINTS);
    cJSON_Delete(root);
    ck_assert(!exists(in("out/a.overlay.png")) && !exists(in("out/a.hand.obj")));
}
END_TEST

/* Depth of `from` millimetres and a slope, in millimetres or as HO3D packs it. */
static void write_depth(const char *name, int from, int slope, bool packed)
{
    lt_image img;

    ck_assert_int_eq(lt_image_init(arena, WIDTH, HEIGHT, packed ? 3 : 1, packed ? 8 : 16, &img), LT_OK);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int mm = from + slope * (i % WIDTH), raw = 8 * mm;        /* HO3D's step is an eighth of one, nearly */

        if (packed)
            img.data[3 * i] = (uint8_t)raw, img.data[3 * i + 1] = (uint8_t)(raw >> 8);
        else
            ((uint16_t *)(void *)img.data)[i] = (uint16_t)mm;
    }
    ck_assert_int_eq(lt_png_write(in(name), &img), LT_OK);
}

/* The first finger's place with this depth. */
static double place_with(const model *m, const char *image, const char *depth, bool left)
{
    const char *const input[] = { in(image) };
    cJSON *root;
    double x;

    ck_assert_msg(!predict((predict_options){ .m = m, .depth = depth, .left = left }, 1, input, NULL), "%s",
                  lt_last_error());
    root = numbers("out/a.json");
    if (depth)
        ck_assert_str_eq(text(root, "depth"), depth);
    else
        ck_assert(cJSON_IsNull(get(root, "depth")));
    x = cJSON_GetArrayItem(cJSON_GetArrayItem(get(root, "hand.joints3d_m"), 5), 0)->valuedouble;
    cJSON_Delete(root);
    return x;
}

START_TEST(depth)
{
    tiny_model unified;
    double none, flat, sloped;

    tiny_model_of(&unified, "unified", tiny_unified);
    ck_assert_int_eq(lt_make_dirs(in("depth")), LT_OK);
    ck_assert_int_eq(lt_make_dirs(in("mirror")), LT_OK);
    write_png("a.png", false);
    write_png("mirror/a.png", true);
    write_depth("flat.png", 500, 0, false);
    write_depth("sloped.png", 500, 2, false);
    write_depth("packed.png", 500, 2, true);
    none = place_with(&unified.m, "a.png", NULL, false);
    ck_assert_msg(strstr(said, "no --depth"), "%s", said);
    flat = place_with(&unified.m, "a.png", in("flat.png"), false);
    sloped = place_with(&unified.m, "a.png", in("sloped.png"), false);
    ck_assert(none != flat && flat != sloped);
    ck_assert_double_eq_tol(place_with(&unified.m, "a.png", in("packed.png"), false), sloped, 1e-6);
    write_depth("sloped.png", 500 + 2 * (WIDTH - 1), -2, false);                     /* in the mirror */
    ck_assert_double_eq_tol(place_with(&unified.m, "mirror/a.png", in("sloped.png"), true), -sloped, 1e-5);
    tiny_model_fini(&unified);
}
END_TEST

START_TEST(depth_is_wrong)
{
    const char *const input[] = { in("a.png"), in("b.png") };
    tiny_model unified;
    predict_summary sum;
    predict_options o = { .m = &unified.m, .depth = in("depth.png") };

    tiny_model_of(&unified, "unified", tiny_unified);
    write_png("a.png", false);
    write_png("b.png", false);
    ck_assert_int_eq(predict(o, 1, input, NULL), LT_EIO);
    write_depth("depth.png", 500, 0, false);
    ck_assert_int_eq(predict(o, 2, input, NULL), LT_EUSAGE);
    ck_assert_msg(strstr(lt_last_error(), "one depth image for 2 images"), "%s", lt_last_error());
    ck_assert_int_eq(predict((predict_options){ .depth = in("depth.png") }, 1, input, NULL), LT_EUSAGE);
    ck_assert_msg(strstr(lt_last_error(), "trained without depth"), "%s", lt_last_error());
    o.depth = in("depths");
    ck_assert_int_eq(lt_make_dirs(o.depth), LT_OK);
    write_depth("depths/a.png", 500, 0, false);         /* b has none: it is skipped */
    ck_assert_int_eq(predict(o, 2, input, &sum), LT_EFORMAT);
    ck_assert(sum.written == 1 && sum.skipped == 1);
    ck_assert_msg(strstr(said, "depths/b.png"), "%s", said);
    write_png("depths/a.png", false);                   /* the picture itself */
    ck_assert_int_eq(predict(o, 1, input, NULL), LT_EFORMAT);
    ck_assert_msg(strstr(said, "a picture, expected"), "%s", said);
    write_depth("depths/a.png", 500, 0, false);
    ck_assert_int_eq(predict(o, 1, input, NULL), LT_OK);
    ck_assert_int_eq(predict(o, 2, (const char *[]){ in("a.png"), in("a.png") }, NULL), LT_EINVAL);
    ck_assert_msg(strstr(lt_last_error(), "a second image of this name"), "%s", lt_last_error());
    tiny_model_fini(&unified);
}
END_TEST

/* What is said of a picture with the hand's box and depth of so many steps */
static const char *said_of_depth(const model *m, const char *image, int steps, double scale)
{
    const crop_box box = { 30, 20, 70, 60 };            /* of 100 x 80 pixels, with a focal length of 120: 0.45 m */
    const char *const input[] = { in(image) };

    write_depth("depth.png", steps, 0, false);
    ck_assert_msg(!predict((predict_options){ .m = m, .depth = in("depth.png"), .depth_scale = scale,
                                              .hand_box = &box }, 1, input, NULL), "%s", lt_last_error());
    return said;
}

START_TEST(depth_of_another_unit)
{
    tiny_model unified;

    tiny_model_of(&unified, "unified", tiny_unified);
    write_png("a.png", false);
    ck_assert(!strstr(said_of_depth(&unified.m, "a.png", 450, 0), "its depth says"));
    ck_assert_ptr_nonnull(strstr(said_of_depth(&unified.m, "a.png", 1800, 0), "--depth-scale 0.00025 would"));
    ck_assert_ptr_nonnull(strstr(said_of_depth(&unified.m, "a.png", 4500, 0), "--depth-scale 0.0001 would"));
    ck_assert_ptr_nonnull(strstr(said_of_depth(&unified.m, "a.png", 45, 0), "--depth-scale 0.01 would"));
    ck_assert(!strstr(said_of_depth(&unified.m, "a.png", 1800, 0.00025), "its depth says"));
    ck_assert(!strstr(said_of_depth(&unified.m, "a.png", 45, 0.01), "its depth says"));
    tiny_model_fini(&unified);
}
END_TEST

/* A depth image as large as the one that is upright lies as that does, one as large as the stored picture as that. */
START_TEST(depth_beside_a_turned_picture)
{
    const char *const input[] = { in("turned.jpg") };
    tiny_model unified;
    predict_options o = { .m = &unified.m, .depth = in("depth.png") };
    lt_image upright;

    tiny_model_of(&unified, "unified", tiny_unified);
    write_exif_jpeg("turned.jpg");
    write_depth("depth.png", 500, 0, false);
    ck_assert_int_eq(predict(o, 1, input, NULL), LT_OK);
    ck_assert_msg(strstr(said, "its depth is turned with it"), "%s", said);
    ck_assert_int_eq(lt_image_init(arena, HEIGHT, WIDTH, 1, 16, &upright), LT_OK);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        ((uint16_t *)(void *)upright.data)[i] = 500;
    ck_assert_int_eq(lt_png_write(in("depth.png"), &upright), LT_OK);
    ck_assert_int_eq(predict(o, 1, input, NULL), LT_OK);
    ck_assert_msg(!strstr(said, "its depth is turned with it"), "%s", said);
    ck_assert_int_eq(lt_image_init(arena, HEIGHT, HEIGHT, 1, 16, &upright), LT_OK);
    ck_assert_int_eq(lt_png_write(in("depth.png"), &upright), LT_OK);
    ck_assert_int_eq(predict(o, 1, input, NULL), LT_EFORMAT);
    ck_assert_msg(strstr(said, "as the picture is stored, or"), "%s", said);
    tiny_model_fini(&unified);
}
END_TEST

/* ---- boxes from a file ---------------------------------------------------------------------------------- */

#define NAMED "image,hand_x0,hand_y0,hand_x1,hand_y1,object_x0,object_y0,object_x1,object_y1,side,object_name\n"
#define COLUMNS "image,hand_x0,hand_y0,hand_x1,hand_y1,object_x0,object_y0,object_x1,object_y1,side\n"

static void write_text(const char *name, const char *words)
{
    write_bytes(name, words, strlen(words));
}

/* boxes.hand.source, boxes.object.source and hand.side of a result, and where the hand's box begins */
static void check_sources(const char *result, const char *hand, const char *object, const char *side, double x0)
{
    cJSON *root = numbers(lt_arena_printf(arena, "out/%s.json", result));

    ck_assert_str_eq(text(root, "boxes.hand.source"), hand);
    ck_assert_str_eq(text(root, "boxes.object.source"), object);
    ck_assert_str_eq(text(root, "hand.side"), side);
    ck_assert_double_eq(item(root, "boxes.hand.x0y0x1y1_px", 0), x0);
    cJSON_Delete(root);
}

/* Each image its own; what the file does not know is given, or assumed and said. */
START_TEST(boxes)
{
    const char *const inputs[] = { in("frames"), in("c.png") };
    const crop_box hand = { 20, 20, 70, 70 };
    predict_options o = { .boxes = in("boxes.csv"), .hand_box = &hand };

    ck_assert_int_eq(lt_make_dirs(in("frames")), LT_OK);
    write_png("frames/a.png", false);
    write_png("frames/b.png", false);
    write_png("c.png", false);
    write_text("boxes.csv", COLUMNS "a,10,11,60,61,30,30,90,79,left\nelsewhere.png,1,2,3,4,,,,,\n"
               "c.png,12,12,62,62,,,,,\n");
    check_ok(predict(o, 2, inputs, NULL));
    check_sources("a", "listed", "listed", "left", 10);
    check_sources("b", "given", "default", "right", 20);
    check_sources("c", "listed", "default", "right", 12);
    ck_assert_msg(strstr(said, "boxes.csv: 1 of 3 lines are for none of the images, the first of them line 3 for "
                         "elsewhere.png"), "%s", said);
    ck_assert(strstr(said, "b.png: no hand box in") && strstr(said, "boxes.csv: took --hand-box\n"));
    ck_assert(strstr(said, "b.png: no object box in") && strstr(said, "took the hand's box grown"));
    ck_assert(!strstr(said, "a.png: no hand") && !strstr(said, "a.png: no object"));
    ck_assert(strstr(said, "c.png: its hand box is known") && !strstr(said, "c.png: no object"));
}
END_TEST

/* The hand of a result, alone or one of several */
static double first_joint(const char *result, const char *hand)
{
    cJSON *root = numbers(result);
    const double x = item(root, lt_arena_printf(arena, "%s.joints3d_m.5", hand), 0);

    cJSON_Delete(root);
    return x;
}

/* Two lines for an image are two hands, each with its side and its object, as if it were alone; what an earlier run
 * left of a second hand goes. */
START_TEST(several_hands)
{
    const char *const input[] = { in("a.png") };
    predict_options o = { .boxes = in("boxes.csv"), .object = "mug" };
    double alone[2];
    cJSON *root;

    write_png("a.png", false);
    write_text("boxes.csv", NAMED "a,10,11,60,61,,,,,left,\n");
    check_ok(predict(o, 1, input, NULL));
    alone[0] = first_joint("out/a.json", "hand");
    write_text("boxes.csv", NAMED "a.PNG,40,20,90,70,30,10,95,75,right,banana\n");
    check_ok(predict(o, 1, input, NULL));
    alone[1] = first_joint("out/a.json", "hand");
    write_text("boxes.csv", NAMED "a,10,11,60,61,,,,,left,\na.png,40,20,90,70,30,10,95,75,right,banana\n");
    check_ok(predict(o, 1, input, NULL));
    root = numbers("out/a.json");
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "hands")), 2);
    for (int i = 0; i < 2; i++)
        ck_assert_double_eq_tol(first_joint("out/a.json", i ? "hands.1" : "hands.0"), alone[i], 1e-6);
    ck_assert_str_eq(text(root, "hands.0.side"), "left");
    ck_assert_str_eq(text(root, "hands.1.side"), "right");
    ck_assert_str_eq(text(root, "objects.0.name"), "025_mug");
    ck_assert_str_eq(text(root, "objects.1.name"), "011_banana");
    ck_assert_int_eq(get(root, "objects.1.hand")->valueint, 1);
    ck_assert_str_eq(text(root, "objects.1.box.source"), "listed");
    ck_assert_str_eq(text(root, "hands.1.vertices_file"), "a.hand-2.obj");
    ck_assert(noted(root, "object-box-assumed", "hand 1: no object box in "));
    ck_assert(!noted(root, "object-box-assumed", "hand 2"));
    ck_assert(exists(in("out/a.hand-2.obj")));
    cJSON_Delete(root);
    put_file(in("out/a.object-2.obj"), "", 0);
    o.format = PREDICT_GLB;
    check_ok(predict(o, 1, input, NULL));
    write_text("boxes.csv", NAMED "a,10,11,60,61,,,,,left,\n");
    o.format = PREDICT_OBJ;
    check_ok(predict(o, 1, input, NULL));
    ck_assert(exists(in("out/a.hand.obj")) && !exists(in("out/a.hand-2.obj")) && !exists(in("out/a.object-2.obj")));
}
END_TEST

START_TEST(boxes_are_wrong)
{
    static const struct { const char *lines, *reason; } cases[] = {
        { "x.png,1,2,3,4,,,,,\ny,1,2,3,4,,,,,\n", "boxes.csv:2: there is no image x.png, and none of any other line" },
        { "a,1,2,3,4,,,,,\n", "boxes.csv:2: a may be " },
        { "a.png,1,2,3,4,,,,,\nb.png,1,2,3,4,,,,,\nb,1,2,3,4,,,,,\n", "boxes.csv:4: b and b.png in line 3 are the" },
        { "a.png,1,2,3,4,,,,,\nclip.avi#0,1,2,3,4,,,,,\n", "boxes.csv:3: clip.avi#0: a film's frames are counted" },
        { "clip#7,1,2,3,4,,,,,\nclip-000007,1,2,3,4,,,,,\n", "boxes.csv:3: clip-000007 and clip#7 in line 2 are the" },
        { "a.png,1,x,3,4,,,,,\n", "boxes.csv:2: hand_y0 is \"x\"" },
        { "b,1,2,3,4,,,,,\nb,,,,,5,6,7,8,\n", "boxes.csv:3: b and b in line 2 are the same image; several hands want" },
    };
    const char *const inputs[] = { in("a.png"), in("a.jpg"), in("b.png"), in("clip.avi") };

    for (size_t i = 0; i < LT_COUNT(inputs); i++)
        put_file(inputs[i], "", 0);
    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        write_text("boxes.csv", lt_arena_printf(arena, COLUMNS "%s", cases[i].lines));
        ck_assert_int_ne(predict((predict_options){ .boxes = in("boxes.csv") }, 4, inputs, NULL), LT_OK);
        ck_assert_msg(strstr(lt_last_error(), cases[i].reason), "\"%s\" lacks \"%s\"", lt_last_error(),
                      cases[i].reason);
    }
    ck_assert_int_eq(predict((predict_options){ .boxes = in("no.csv") }, 4, inputs, NULL), LT_EIO);
    write_png("b.png", false);                  /* outside the image: that image is skipped, and the line named */
    write_text("boxes.csv", COLUMNS "b,500,2,600,4,,,,,\n");
    ck_assert_int_eq(predict((predict_options){ .boxes = in("boxes.csv") }, 1, inputs + 2, NULL), LT_EFORMAT);
    ck_assert_msg(strstr(said, "boxes.csv:2: ") && strstr(said, "lies outside the image"), "%s", said);
}
END_TEST

/* Of many images the same is said once, and again where it changes. */
START_TEST(assumed_once)
{
    const char *const inputs[] = { in("a.png"), in("b.png"), in("turned.jpg"), in("turned.jpg"), in("c.png") };
    int lines = 0;

    write_png("a.png", false);
    write_png("b.png", false);
    write_png("c.png", false);
    write_exif_jpeg("turned.jpg");
    check_ok(predict((predict_options){ .camera = &(lt_camera){ 120, 120, 50, 40 } }, 5, inputs, NULL));
    ck_assert(strstr(said, "a.png: no --hand-box") && strstr(said, "a.png: no --object-box"));
    ck_assert(strstr(said, "said again where it changes"));
    ck_assert(!strstr(said, "b.png: no --"));
    ck_assert(strstr(said, "turned.jpg: turned upright") && strstr(said, "turned.jpg: no --hand-box"));
    ck_assert(strstr(said, "c.png: upright as it is stored") && strstr(said, "c.png: no --hand-box"));
    for (const char *p = said; (p = strstr(p, "turned.jpg: turned")) != NULL; p++)
        lines++;
    ck_assert_int_eq(lines, 1);
}
END_TEST

static void start(void)
{
    setenv("PALMAR_MODULES", MODULES, 1);
    arena = lt_arena_new();
    make_scratch_folder();
    tiny_model_init(&tiny);
}

static void stop(void)
{
    tiny_model_fini(&tiny);
    free(said);
    lt_arena_free(arena);
    remove_scratch_folder();
}

/* ---- where the hand is --------------------------------------------------------------------------------- */

enum { PLACE_W = 640, PLACE_H = 480 };

/* A hand of which the model says that it is a tenth larger than it is, as it was seen at `at`. */
static void wide_hand(const predict_view *v, const double at[3], predict_result *r)
{
    memset(r, 0, sizeof(*r));
    for (int j = 0; j < LT_HAND_KEYPOINTS; j++) {
        const double p[3] = { at[0] + 0.01 * (j % 5), at[1] + 0.02 * (j / 5), at[2] + 0.004 * (j % 3) };
        double uv[2];

        lt_camera_project(&v->camera, p, uv);
        for (int d = 0; d < 3; d++)
            r->e.joints[j][d] = (float)(1.1 * (p[d] - at[d]));
        r->heatmap2d[j][0] = (float)uv[0], r->heatmap2d[j][1] = (float)uv[1];
        r->e.peak[j] = 0.5f;
    }
}

static void same_everywhere(float *map, float metres)
{
    for (int i = 0; i < PLACE_W * PLACE_H; i++)
        map[i] = i % 3 ? metres : 0;          /* a sensor does not see everything */
}

/* Its size puts it a tenth too far away; a sensor knows better, unless what it sees is something else. */
START_TEST(place)
{
    const double at[3] = { -0.05, -0.04, 0.6 };
    float *map = lt_arena_array(arena, (size_t)PLACE_W * PLACE_H, sizeof(*map));
    predict_view v = { .camera = { 600, 600, 320, 240 }, .width = PLACE_W, .height = PLACE_H };
    predict_result *r = lt_arena_alloc(arena, sizeof(*r));

    wide_hand(&v, at, r);
    predict_place_hand(&v, r);
    ck_assert(r->placed);
    ck_assert_double_eq_tol((double)r->e.joints[0][2], 1.1 * at[2], 1e-3);
    v.depth = map;
    same_everywhere(map, 0.595f);
    wide_hand(&v, at, r);
    predict_place_hand(&v, r);
    ck_assert_double_eq_tol((double)r->e.joints[0][2], at[2], 2e-3);
    ck_assert_double_eq_tol((double)r->e.joints[0][0], at[0], 5e-3);
    same_everywhere(map, 0.3f);
    wide_hand(&v, at, r);
    predict_place_hand(&v, r);
    ck_assert_double_eq_tol((double)r->e.joints[0][2], 1.1 * at[2], 1e-3);
    r->heatmap2d[3][0] = NAN;                   /* no place, and no crash */
    r->heatmap2d[4][1] = 1e30f;
    predict_place_hand(&v, r);
    ck_assert(!r->placed);
}
END_TEST

/* A box of 6 by 10 by 14 cm that the hand reaches into, turned a quarter about the optical axis; then moved away. */
START_TEST(object_in_reach)
{
    predict_object box = { .name = "box" };
    predict_view v = { .hand_box = { 0, 0, 100, 100 }, .object = &box };
    predict_result *r = lt_arena_alloc(arena, sizeof(*r));

    for (int i = 0; i < LT_BOX_POINTS; i++)
        for (int d = 0; d < 3; d++)
            box.control[i][d] = (i >> d & 1 ? 0.5f : -0.5f) * (0.06f + 0.04f * (float)d);
    for (int j = 0; j < LT_HAND_KEYPOINTS; j++)
        r->e.joints[j][2] = 0.5f;
    r->placed = r->object_found = true;
    r->e.object = (lt_pose){ .R = { 0, -1, 0, 1, 0, 0, 0, 0, 1 }, .t = { 0.12, 0.04, 0.5 } };
    ck_assert_double_eq_tol(predict_object_apart(&v, r), hypot(0.12 - 0.05, 0.04 - 0.03), 1e-7);
    ck_assert(predict_object_trusted(&v, r));
    r->e.object.t[0] = 0.04;
    r->e.object.t[1] = 0.02;
    ck_assert_double_eq(predict_object_apart(&v, r), 0);
    r->agreement_px = 11;                       /* the hand itself is not to be trusted */
    ck_assert(!predict_object_trusted(&v, r));
    r->agreement_px = 0;
    r->e.object.t[2] = 0.5 - 0.58;
    ck_assert_double_eq_tol(predict_object_apart(&v, r), 0.58 - 0.07, 1e-7);
    ck_assert(!predict_object_trusted(&v, r));
    r->object_found = false;
    ck_assert(isinf(predict_object_apart(&v, r)) && !predict_object_trusted(&v, r));
}
END_TEST

/* ---- a film ------------------------------------------------------------------------------------------- */

enum { LOST = 40, FOUND = 50, FILM = 60 };

/* A hand and an object that move to the right by 9 mm a frame; between LOST and FOUND neither is seen well. */
static void frame_of(int k, const predict_view *v, predict_result *r)
{
    memset(r, 0, sizeof(*r));
    for (int j = 0; j < LT_HAND_KEYPOINTS; j++) {
        r->e.joints[j][0] = 0.009f * (float)k + 0.001f * (float)j;
        r->e.joints[j][2] = 0.6f;
    }
    memcpy(r->e.vertices[7], r->e.joints[3], sizeof(r->e.vertices[7]));
    r->placed = r->object_found = k < LOST || k >= FOUND;
    r->e.object.R[0] = r->e.object.R[4] = r->e.object.R[8] = 1;
    r->e.object.t[0] = 0.009 * k;
    r->e.object.t[2] = 0.7;
    for (int pass = 0; pass < 2; pass++) {              /* heat maps that agree with the joints */
        predict_reproject(v, r);
        memcpy(r->heatmap2d, r->joints2d, sizeof(r->heatmap2d));
    }
    if (!r->placed)
        r->e.joints[0][1] = 1, r->e.object.t[1] = 1;    /* what is not believed must not matter */
}

static const predict_object thing;      /* that looks like itself alone, its origin in its middle */

START_TEST(film)
{
    const predict_view v = { .camera = { 600, 600, 320, 240 }, .hand_box = { 0, 0, 300, 300 } };
    predict_smoother s = { .dt = 1.0 / 30 };
    predict_result *r = lt_arena_alloc(arena, sizeof(*r));

    for (int k = 0; k < FILM; k++) {
        frame_of(k, &v, r);
        predict_smooth(&s, &v, &thing, r);
        ck_assert(r->placed && r->object_found);
        if (k < 20)
            continue;
        ck_assert_double_eq_tol(r->e.joints[3][0], 0.009 * k + 0.003, 2e-3);
        ck_assert_double_eq_tol(r->e.object.t[0], 0.009 * k, 2e-3);
        ck_assert_double_eq_tol(r->e.joints[0][1], 0, 1e-6);
        if (k < LOST || k >= FOUND)
            ck_assert_double_eq_tol(r->e.vertices[7][0], r->e.joints[3][0], 1e-4);
    }
    for (int k = 0; k < 15; k++) {
        frame_of(LOST, &v, r);
        predict_smooth(&s, &v, &thing, r);
        ck_assert(r->placed && r->object_found);
    }
    frame_of(LOST, &v, r);
    predict_smooth(&s, &v, &thing, r);
    ck_assert(!r->placed && !r->object_found);
}
END_TEST

/* Frames that cannot be read take their time like any others, and count among the 15. */
START_TEST(film_with_unreadable_frames)
{
    const predict_view v = { .camera = { 600, 600, 320, 240 }, .hand_box = { 0, 0, 300, 300 } };
    predict_smoother s = { .dt = 1.0 / 30 };
    predict_result *r = lt_arena_alloc(arena, sizeof(*r));

    for (int k = 0; k < LOST; k++) {
        frame_of(k, &v, r);
        predict_smooth(&s, &v, &thing, r);
    }
    for (int k = LOST; k < FOUND - 1; k++)
        predict_smooth_missed(&s);
    frame_of(FOUND - 1, &v, r);
    predict_smooth(&s, &v, &thing, r);
    ck_assert(r->placed && r->object_found);
    ck_assert_double_eq_tol(r->e.joints[3][0], 0.009 * (FOUND - 1) + 0.003, 2e-3);
    ck_assert_double_eq_tol(r->e.object.t[0], 0.009 * (FOUND - 1), 2e-3);
    for (int k = 0; k < 5; k++)
        predict_smooth_missed(&s);
    frame_of(LOST, &v, r);
    predict_smooth(&s, &v, &thing, r);
    ck_assert(!r->placed && !r->object_found);
}
END_TEST

/* A box that looks the same turned half about z through its middle, seen so in every other frame: it is not lost, does
 * not turn, and stays where it is. */
START_TEST(film_of_a_symmetric_thing)
{
    const predict_view v = { .camera = { 600, 600, 320, 240 }, .hand_box = { 0, 0, 300, 300 } };
    predict_object box = { .n_symmetries = 1, .symmetry = { { 0, 0, 0, 1 } } };
    predict_smoother s = { .dt = 1.0 / 30 };
    predict_result *r = lt_arena_alloc(arena, sizeof(*r));

    box.control[LT_BOX_POINTS - 1][0] = 0.05f;
    for (int k = 0; k < LOST; k++) {
        frame_of(k, &v, r);
        if (k % 2) {
            r->e.object.R[0] = r->e.object.R[4] = -1;
            r->e.object.t[0] += 2 * 0.05;
        }
        predict_smooth(&s, &v, &box, r);
        ck_assert(r->object_found);
        ck_assert_double_eq_tol(r->e.object.R[0], 1, 1e-6);
        if (k >= 20)
            ck_assert_double_eq_tol(r->e.object.t[0], 0.009 * k, 2e-3);
    }
}
END_TEST

/* What fits its points badly moves the pose less. */
START_TEST(film_with_bad_fits)
{
    const predict_view v = { .camera = { 600, 600, 320, 240 }, .hand_box = { 0, 0, 300, 300 } };
    predict_result *r = lt_arena_alloc(arena, sizeof(*r));
    double seen[2];

    for (int bad = 0; bad < 2; bad++) {
        predict_smoother s = { .dt = 1.0 / 30 };

        for (int k = 0; k < 21; k++) {
            frame_of(0, &v, r);
            r->e.object.t[0] = k == 20 ? 0.01 : 0;
            r->e.object_error_px = k == 20 && bad ? 40 : 1;
            predict_smooth(&s, &v, &thing, r);
        }
        seen[bad] = r->e.object.t[0];
    }
    ck_assert_double_gt(seen[1], 0);
    ck_assert_double_lt(seen[1], 0.5 * seen[0]);
}
END_TEST

/* Another hand is not where the last one was. */
START_TEST(film_with_both_hands)
{
    predict_view v = { .camera = { 600, 600, 320, 240 }, .hand_box = { 0, 0, 300, 300 } };
    predict_smoother s = { .dt = 1.0 / 30 };
    predict_result *r = lt_arena_alloc(arena, sizeof(*r));

    for (int k = 0; k < FOUND; k++) {
        v.left = k >= LOST;
        frame_of(v.left ? 0 : LOST - 1, &v, r);
        predict_smooth(&s, &v, &thing, r);
    }
    ck_assert_double_eq_tol(r->e.joints[3][0], 0.003, 1e-4);
}
END_TEST

/* Two hands of one side that pass each other, listed now in this order and now in that, and a hand that goes away for
 * some frames: each stays who it is. */
START_TEST(film_of_several_hands)
{
    predict_followed f = { .arena = arena, .dt = 1.0 / 30 };
    predict_result *r = lt_arena_array(arena, 3, sizeof(*r));

    for (int k = 0; k < FILM; k++) {
        const bool gone = k >= LOST && k < FOUND;
        const float x = 4 * (float)k;
        predict_view v[3] = {
            { .camera = { 600, 600, 320, 240 }, .hand_box = { x, 0, x + 100, 100 } },
            { .camera = { 600, 600, 320, 240 }, .hand_box = { 240 - x, 150, 340 - x, 250 } },
            { .camera = { 600, 600, 320, 240 }, .hand_box = { 0, 0, 100, 100 }, .left = true },
        };
        const int at[3] = { k % 2, 1 - k % 2, 2 };   /* of each in the list */
        predict_view listed[3];

        for (int i = 0; i < 3; i++) {
            listed[at[i]] = v[i];
            frame_of(i == 1 ? -k : i * k, &v[i], &r[at[i]]);
            r[at[i]].placed = true;
        }
        check_ok(predict_follow(&f, arena, listed, r, gone ? 2 : 3));
        ck_assert_uint_eq(f.n, 3);
        if (k < 20)
            continue;
        ck_assert_double_eq_tol(r[at[0]].e.joints[3][0], 0.003, 2e-3);
        ck_assert_double_eq_tol(r[at[1]].e.joints[3][0], -0.009 * k + 0.003, 2e-3);
        if (!gone)
            ck_assert_double_eq_tol(r[2].e.joints[3][0], 0.018 * k + 0.003, 4e-3);
    }
    for (int k = 0; k <= PREDICT_COAST; k++)
        predict_follow_missed(&f);
    ck_assert_uint_eq(f.n, 0);
}
END_TEST

/* A picture whose results a film's frames would have. */
START_TEST(film_beside_its_frame)
{
    const char *const names[] = { "clip-000001.png", "clip-0000012.png", "clip-1.png", "clip-000001x.png" };

    fclose(fopen(in("clip.avi"), "w"));
    for (size_t i = 0; i < LT_COUNT(names); i++) {
        const char *const input[] = { in(names[i]), in("clip.avi") };

        write_png(names[i], false);
        ck_assert_int_ne(predict((predict_options){ 0 }, 2, input, NULL), LT_OK);
        ck_assert_int_eq(i < 2, strstr(lt_last_error(), "would have the same results") != NULL);
    }
}
END_TEST

static double joint_of(const cJSON *root, int joint, int d)
{
    return cJSON_GetArrayItem(cJSON_GetArrayItem(get(root, "hand.joints3d_m"), joint), d)->valuedouble;
}

/* The same picture again and again: nothing that is filtered moves. */
START_TEST(film_of_stills)
{
    const char *inputs[] = { in("frames") };
    cJSON *plain, *smooth;

    ck_assert_int_eq(lt_make_dirs(in("frames")), LT_OK);
    write_png("frames/a.png", false);
    write_png("frames/b.png", false);
    write_png("frames/c.png", false);
    ck_assert_int_eq(predict((predict_options){ 0 }, 1, inputs, NULL), LT_OK);
    plain = numbers("out/c.json");
    ck_assert_int_eq(predict((predict_options){ .fps = 30 }, 1, inputs, NULL), LT_OK);
    smooth = numbers("out/c.json");
    for (int d = 0; d < 3; d++)
        ck_assert_double_eq_tol(joint_of(smooth, 5, d), joint_of(plain, 5, d), 1e-6);
    cJSON_Delete(plain);
    cJSON_Delete(smooth);
}
END_TEST

#ifdef HAVE_OPENCV

/* Each frame has results of its own; what is assumed is said once. */
START_TEST(film_file)
{
    const char *const input[] = { in("clip.avi") };
    const lt_image img = picture(false);
    predict_summary sum;
    cJSON *root;

    avi_write(arena, input[0], &img, 25, 3);
    ck_assert_int_eq(predict((predict_options){ .object = "mug" }, 1, input, &sum), LT_OK);
    ck_assert_msg(sum.written == 3 && sum.skipped == 0, "%d written, %d skipped: %s", sum.written, sum.skipped, said);
    ck_assert(strstr(said, "clip.avi#1: no --hand-box") && !strstr(said, "clip.avi#2: no --hand-box"));
    root = numbers("out/clip-000003.json");
    ck_assert_str_eq(text(root, "image") + strlen(input[0]), "#3");
    check_files("clip-000003", root);
    cJSON_Delete(root);
    ck_assert(!exists(in("out/clip-000004.json")));
    ck_assert(!strstr(said, "cut off"));
}
END_TEST

/* A hand that moves, and a frame of which the file knows nothing. */
START_TEST(film_with_boxes)
{
    const char *const input[] = { in("clip.avi") };
    const lt_image img = picture(false);

    avi_write(arena, input[0], &img, 25, 4);
    write_text("boxes.csv", COLUMNS "clip-000004,14,11,64,61,,,,,\nclip.avi#1,10,11,60,61,,,,,\n"
               "clip#2,12,11,62,61,,,,,left\n");
    check_ok(predict((predict_options){ .boxes = in("boxes.csv") }, 1, input, NULL));
    check_sources("clip-000001", "listed", "default", "right", 10);
    check_sources("clip-000002", "listed", "default", "left", 12);
    check_sources("clip-000003", "default", "default", "right", 25.5);
    check_sources("clip-000004", "listed", "default", "right", 14);
    ck_assert_msg(strstr(said, "clip.avi#3: no hand box in ") && strstr(said, "clip.avi#4: its hand box is known"),
                  "%s", said);
    ck_assert(!strstr(said, "#1: no hand") && !strstr(said, "#4: no"));
}
END_TEST

/* Half a film is read as far as it goes, and what is missing is said. */
START_TEST(film_cut_off)
{
    const char *const input[] = { in("clip.avi") };
    const lt_image img = picture(false);
    predict_summary sum;
    struct stat all;

    avi_write(arena, input[0], &img, 25, 8);
    ck_assert_int_eq(stat(input[0], &all), 0);
    ck_assert_int_eq(truncate(input[0], all.st_size / 2), 0);
    ck_assert_int_eq(predict((predict_options){ 0 }, 1, input, &sum), LT_OK);
    ck_assert_int_ge(sum.written, 3);
    ck_assert_int_lt(sum.written, 5);
    ck_assert_msg(strstr(said, "clip.avi: says that it has 8 frames, but only"), "%s", said);
}
END_TEST

#endif

START_TEST(film_that_is_none)
{
    const char *const input[] = { in("clip.mp4"), in("none.mp4") };
    predict_summary sum;

    write_bytes("clip.mp4", "this is no film", 15);
    ck_assert_int_eq(predict((predict_options){ 0 }, 2, input, &sum), LT_EFORMAT);
    ck_assert(sum.written == 0 && sum.skipped == 2);
    ck_assert_msg(strstr(said, "clip.mp4: ") && strstr(said, "none.mp4: "), "%s", said);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, start, stop);
    tcase_set_timeout(t, 120);
    tcase_add_test(t, one_image);
    tcase_add_test(t, schema);
    tcase_add_test(t, no_old_object_stays);
    tcase_add_test(t, formats);
    tcase_add_test(t, defaults);
    tcase_add_test(t, folders);
    tcase_add_test(t, frames_in_order);
    tcase_add_test(t, stopped);
    tcase_add_test(t, wrong);
    tcase_add_test(t, not_finite);
    tcase_add_test(t, mirror);
    tcase_add_test(t, exif);
    tcase_add_test(t, camera_doubtful);
    tcase_add_test(t, camera_scaled);
    tcase_add_test(t, lens);
    tcase_add_test(t, sheet);
    tcase_add_test(t, depth);
    tcase_add_test(t, numbers_alone);
    tcase_add_test(t, depth_is_wrong);
    tcase_add_test(t, depth_of_another_unit);
    tcase_add_test(t, depth_beside_a_turned_picture);
    tcase_add_test(t, boxes);
    tcase_add_test(t, several_hands);
    tcase_add_test(t, boxes_are_wrong);
    tcase_add_test(t, assumed_once);
    tcase_add_test(t, place);
    tcase_add_test(t, object_in_reach);
    tcase_add_test(t, film);
    tcase_add_test(t, film_with_unreadable_frames);
    tcase_add_test(t, film_of_a_symmetric_thing);
    tcase_add_test(t, film_with_bad_fits);
    tcase_add_test(t, film_with_both_hands);
    tcase_add_test(t, film_of_several_hands);
    tcase_add_test(t, film_beside_its_frame);
    tcase_add_test(t, film_of_stills);
#ifdef HAVE_OPENCV
    tcase_add_test(t, film_file);
    tcase_add_test(t, film_cut_off);
    tcase_add_test(t, film_with_boxes);
#endif
    tcase_add_test(t, film_that_is_none);
}

int main(void)
{
    return run_suite("predict", add_tests);
}
