/* SPDX-License-Identifier: Apache-2.0 */
/* `palmar info --data` on a dataset whose labels, intrinsics, models or masks have a slip that people make: the last
 * line names it, and so do the notes. The dataset is the generator's, its files written anew with the slip. */
#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/array/array.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/pickle/pickle.h"
#include "libtensor/io/text/json.h"
#include "tests/suite.h"

#include <cjson/cJSON.h>
#include <glob.h>
#include <stdarg.h>
#include <stdio.h>
#include <unistd.h>

enum { J = LT_HAND_KEYPOINTS };

static lt_arena *arena;
static const char *data;            /* the sound dataset; each case changes a copy of it */

/* Runs a command; its output, at most a screen of it. */
static int run(char *out, size_t n, const char *fmt, ...)
{
    char *command;
    va_list ap;
    FILE *p;
    size_t got;

    va_start(ap, fmt);
    command = lt_arena_vprintf(arena, fmt, ap);
    va_end(ap);
    p = popen(command, "r");
    ck_assert_ptr_nonnull(p);
    got = fread(out, 1, n - 1, p);
    out[got] = '\0';
    return WEXITSTATUS(pclose(p));
}

/* ---- labels written anew ---- */

typedef struct {
    float K[9], rot[3], trans[3], pose[48], hand_trans[3], beta[10], joints[J][3];
    const char *object;
} label;

static const struct { const char *key; size_t at, n; } fields[] = {
    { "camMat", offsetof(label, K), 9 },
    { "objRot", offsetof(label, rot), 3 }, { "objTrans", offsetof(label, trans), 3 },
    { "handPose", offsetof(label, pose), 48 }, { "handTrans", offsetof(label, hand_trans), 3 },
    { "handBeta", offsetof(label, beta), 10 }, { "handJoints3D", offsetof(label, joints), 3 * J },
};

static float *place_of(label *l, size_t field)
{
    return (float *)(void *)((char *)l + fields[field].at);
}

typedef void changer(label *l);

static void rewrite(const char *path, changer *change)
{
    lt_pwrite item[LT_COUNT(fields) + 1];
    const lt_pvalue *v;
    label l;

    check_ok(lt_pickle_read(arena, path, &v));
    for (size_t i = 0; i < LT_COUNT(fields); i++)
        check_ok(lt_pfloats(lt_pdict_get(v, fields[i].key), "x", place_of(&l, i), fields[i].n));
    l.object = lt_pstr(lt_pdict_get(v, "objName"));
    change(&l);
    for (size_t i = 0; i < LT_COUNT(fields); i++) {
        const int64_t shape[2] = { (int64_t)fields[i].n / 3, 3 }, flat[1] = { (int64_t)fields[i].n };
        const bool table = fields[i].n == 9 || fields[i].n == 3 * J;
        item[i] = (lt_pwrite){ .key = fields[i].key, .kind = LT_PW_ARRAY };
        item[i].array = lt_array_make(LT_ELEM_F4, table ? 2 : 1, table ? shape : flat, place_of(&l, i));
    }
    item[LT_COUNT(fields)] = (lt_pwrite){ .key = "objName", .kind = LT_PW_STR, .text = l.object };
    check_ok(lt_pickle_write_dict(path, item, LT_COUNT(item)));
}

/* Calls act with each file that matches. */
static void for_each(const char *pattern, void (*act)(const char *path, changer *change), changer *change)
{
    glob_t g;

    ck_assert_int_eq(glob(lt_arena_printf(arena, "%s/%s", data, pattern), 0, NULL, &g), 0);
    for (size_t i = 0; i < g.gl_pathc; i++)
        act(g.gl_pathv[i], change);
    globfree(&g);
}

static void scale(float *x, int n, float by)
{
    for (int i = 0; i < n; i++)
        x[i] *= by;
}

static void flip(float *x, int points)
{
    for (int i = 0; i < points; i++)
        scale(x + 3 * i + 1, 2, -1);
}

static void flip_rotation(float *aa)
{
    double v[3] = { aa[0], aa[1], aa[2] }, R[9];

    lt_rot_from_axis_angle(v, R);
    for (int i = 3; i < 9; i++)
        R[i] = -R[i];
    lt_rot_to_axis_angle(R, v);
    for (int i = 0; i < 3; i++)
        aa[i] = (float)v[i];
}

static void reorder(label *l, const int *from)
{
    float old[J][3];

    memcpy(old, l->joints, sizeof(old));
    for (int i = 0; i < J; i++)
        memcpy(l->joints[i], old[from[i]], sizeof(old[0]));
}

static const float wide[9] = { 1840, 0, 960, 0, 1838, 720, 0, 0, 1 };

static void joints_mm(label *l) { scale(l->joints[0], 3 * J, 1000); }
static void joints_cm(label *l) { scale(l->joints[0], 3 * J, 100); }
static void joints_opencv(label *l) { flip(l->joints[0], J); }
static void joints_simple(label *l) { reorder(l, lt_mano_to_simple); }
static void joints_mm_simple(label *l) { joints_mm(l), joints_simple(l); }
static void objects_mm(label *l) { scale(l->trans, 3, 1000); }
static void objects_opencv(label *l) { flip(l->trans, 1); }
static void wide_camera(label *l) { memcpy(l->K, wide, sizeof(wide)); }
static void half_camera(label *l) { scale(l->K, 6, 0.5f); }
static void exchanged_camera(label *l) { const float cx = l->K[2]; l->K[2] = l->K[5]; l->K[5] = cx; }

static void all_opencv(label *l)
{
    flip(l->joints[0], J);
    flip(l->trans, 1);
    flip_rotation(l->pose);
    flip_rotation(l->rot);
}

/* ---- other files written anew ---- */

static void model_mm(const char *obj, changer *change)
{
    const char *xyz = lt_arena_printf(arena, "%.*s/points.xyz", (int)(strrchr(obj, '/') - obj), obj);
    lt_mesh m;
    float (*p)[3];
    size_t n;

    (void)change;
    check_ok(lt_obj_read(arena, obj, &m, NULL));
    check_ok(lt_xyz_read(arena, xyz, &p, &n));
    scale(m.vertex[0], 3 * m.n_vertices, 1000);
    scale(p[0], 3 * (int)n, 1000);
    check_ok(lt_obj_write(obj, &m, NULL));
    check_ok(lt_xyz_write(xyz, (const float (*)[3])p, n));
}

static void models_mm(void)
{
    for_each("models/*/textured_simple.obj", model_mm, NULL);
}

/* Grey where somebody is: no colour of either version. */
static void grey_mask(const char *path, changer *change)
{
    lt_image img;

    (void)change;
    check_ok(lt_image_read(arena, path, &img));
    for (size_t k = 0; k < lt_image_bytes(&img); k++)
        img.data[k] = img.data[k] ? 120 : 0;
    check_ok(lt_png_write(path, &img));
}

static void grey_masks(void)
{
    for_each("train/*/seg/*.png", grey_mask, NULL);
}

/* ---- cases ---- */

static const struct {
    changer *label;
    void (*file)(void);
    const char *code, *line;        /* of the notes; what the last line has */
} cases[] = {
    { joints_mm, NULL, "unit", "it looks as if the joints are in millimetres, not metres" },
    { joints_cm, NULL, "unit", "it looks as if the joints are in centimetres, not metres" },
    { joints_opencv, NULL, "axes", "it looks as if the joints have OpenCV's axes (y down, z forward), not OpenGL's" },
    { all_opencv, NULL, "axes",
      "it looks as if the hands are not where the camera looks: poses and joints have OpenCV's axes" },
    { joints_simple, NULL, "order", "it looks as if the joints are ordered from thumb to little finger, not as MANO" },
    { joints_mm_simple, NULL, "unit",
      "the joints are in millimetres, not metres, and are ordered from thumb to little finger" },
    { objects_mm, NULL, "unit", "it looks as if the objects' translations are in millimetres, not metres" },
    { objects_opencv, NULL, "axes", "it looks as if the objects' translations have OpenCV's axes, not OpenGL's" },
    { wide_camera, NULL, "camera", "the intrinsics are those of an image of 1920 x 1440, not of 640 x 480" },
    { half_camera, NULL, "camera", "the intrinsics are those of an image of 3" },
    { exchanged_camera, NULL, "camera", "it looks as if cx and cy are exchanged" },
    { NULL, models_mm, NULL, "m across, expected a thing that a hand can hold, in metres; it looks as if the model is "
      "in millimetres, not metres" },
    { NULL, grey_masks, "masks", "masks have 0 % of the joints: their colours are not those of hand and object" },
};

static char text[1 << 16];

static bool has_code(const char *json, const char *code)
{
    cJSON *root;
    const cJSON *note;
    bool found = false;

    check_ok(lt_json_parse("info", json, strlen(json), &root));
    cJSON_ArrayForEach(note, cJSON_GetObjectItem(root, "notes")) {
        ck_assert(cJSON_IsString(cJSON_GetObjectItem(note, "text")));
        found = found || !strcmp(cJSON_GetObjectItem(note, "code")->valuestring, code);
    }
    cJSON_Delete(root);
    return found;
}

START_TEST(slip_is_named)
{
    const char *line;

    if (cases[_i].label)
        for_each("train/*/meta/*.pkl", rewrite, cases[_i].label);
    else
        cases[_i].file();
    ck_assert_int_eq(run(text, sizeof(text), "./palmar info --data %s --json 2>%s/line", data, scratch_folder),
                     1);
    if (cases[_i].code)
        ck_assert_msg(has_code(text, cases[_i].code), "no note \"%s\" in %s", cases[_i].code, text);
    run(text, sizeof(text), "cat %s/line", scratch_folder);
    line = text;
    ck_assert_msg(strstr(line, cases[_i].line) != NULL, "\"%s\" lacks \"%s\"", line, cases[_i].line);
    ck_assert_ptr_eq(strchr(line, '\n'), line + strlen(line) - 1);
}
END_TEST

START_TEST(sound_has_no_notes)
{
    cJSON *root;

    ck_assert_int_eq(run(text, sizeof(text), "./palmar info --data %s --json", data), 0);
    check_ok(lt_json_parse("info", text, strlen(text), &root));
    ck_assert(cJSON_IsArray(cJSON_GetObjectItem(root, "notes")));
    ck_assert_int_eq(cJSON_GetArraySize(cJSON_GetObjectItem(root, "notes")), 0);
    cJSON_Delete(root);
    ck_assert_int_eq(run(text, sizeof(text), "./palmar info --data %s", data), 0);
    ck_assert_ptr_null(strstr(text, "notes"));
}
END_TEST

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
    data = lt_arena_printf(arena, "%s/data", scratch_folder);
    ck_assert_int_eq(run(text, sizeof(text), "cp -r field-labels %s", data), 0);
}

static void teardown(void)
{
    remove_scratch_folder();
    lt_arena_free(arena);
}

static void make_data(void)
{
    ck_assert_int_eq(system("rm -rf field-labels && ./palmar synth --preset tiny --frames 12 --out field-labels "
                            ">/dev/null 2>&1"),
                     0);
}

static void remove_data(void)
{
    ck_assert_int_eq(system("rm -r field-labels"), 0);
}

static void add_tests(TCase *c)
{
    tcase_set_timeout(c, 0);
    tcase_add_unchecked_fixture(c, make_data, remove_data);
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_add_loop_test(c, slip_is_named, 0, LT_COUNT(cases));
    tcase_add_test(c, sound_has_no_notes);
}

int main(void)
{
    return run_suite("labels", add_tests);
}
