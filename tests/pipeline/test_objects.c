/* SPDX-License-Identifier: Apache-2.0 */
/* Models of a user's own: which file is read, what its numbers and axes are, what it is called. */
#include "pipeline/internal.h"
#include "pipeline/objects/mesh.h"
#include "pipeline/objects/objects.h"

#include "libtensor/io/file.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/mesh/ply.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

static lt_arena *arena;

static const char *in(const char *name)
{
    return lt_path_join(arena, scratch_folder, name);
}

/* A box of this size about this centre, of 12 triangles. */
static lt_mesh box_mesh(const double size[3], const double centre[3])
{
    static const int32_t faces[12][3] = {
        { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
        { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 },
    };
    lt_mesh m = { .n_vertices = 8, .n_faces = 12, .vertex = lt_arena_array(arena, 8, sizeof(*m.vertex)),
                  .face = lt_arena_array(arena, 12, sizeof(*m.face)) };

    memcpy(m.face, faces, sizeof(faces));
    for (int i = 0; i < 8; i++)
        for (int d = 0; d < 3; d++)
            m.vertex[i][d] = (float)(centre[d] + (i >> d & 1 ? 0.5 : -0.5) * size[d]);
    return m;
}

/* The same scaled, in models/NAME, as OBJ or PLY; points: with points.xyz */
static void put_model(const char *name, const char *file, double x, double y, double z, double scale, bool points)
{
    const double size[3] = { x * scale, y * scale, z * scale }, centre[3] = { 0 };
    const lt_mesh m = box_mesh(size, centre);
    const char *folder = in(lt_arena_printf(arena, "models/%s", name)), *path = lt_path_join(arena, folder, file);

    check_ok(lt_make_dirs(folder));
    check_ok(lt_ends_with(file, "ply") ? lt_ply_write_mesh(path, &m) : lt_obj_write(path, &m, NULL));
    if (points)
        check_ok(lt_xyz_write(lt_path_join(arena, folder, "points.xyz"), (const float (*)[3])m.vertex, 8));
}

static lt_status load(const char *asked, const predict_object **out)
{
    const predict_options o = { .models = in("models"), .object = asked };

    return predict_load_objects(arena, &o, &(predict_boxes){ .n = 0 }, out);
}

static double longest_side(const predict_object *o)
{
    double longest = 0;

    for (int d = 0; d < 3; d++)
        longest = fmax(longest, (double)o->control[7][d] - (double)o->control[0][d]);
    return longest;
}

/* Any folder, with a mesh of any name, and without points. */
START_TEST(own)
{
    static const struct { const char *name, *file; bool points; } models[] = {
        { "my_mouse", "textured_simple.obj", true }, { "my cup", "Cup.PLY", false }, { "kit-7", "scan.obj", false },
    };
    const predict_object *o;

    for (size_t i = 0; i < LT_COUNT(models); i++) {
        put_model(models[i].name, models[i].file, 0.06, 0.11, 0.04, 1, models[i].points);
        check_ok(load(models[i].name, &o));
        ck_assert_str_eq(o->name, models[i].name);
        ck_assert_int_eq(o->mesh.n_faces, 12);
        ck_assert_int_eq(o->n_symmetries, 0);
        ck_assert_double_eq_tol(longest_side(o), 0.11, 0.003);      /* drawn points leave corners out */
        ck_assert(!o->unit_note && !o->axes_note);
        ck_assert_float_eq(o->mirrored[3][0], -o->control[3][0]);
    }
    put_model("kit-7", "other.ply", 0.06, 0.11, 0.04, 1, false);
    check_error(load("kit-7", &o), LT_EFORMAT, "kit-7: 2 meshes, as other.ply and scan.obj; call the one");
    put_model("kit-7", "textured_simple.obj", 0.06, 0.11, 0.04, 1, false);
    check_ok(load("kit-7", &o));
    check_ok(lt_make_dirs(in("models/empty")));
    check_error(load("empty", &o), LT_EFORMAT, "models/empty: no mesh; want textured_simple.obj");
    put_file(in("models/empty/a.obj"), "version https://git-lfs.github.com/spec/v1\n", 43);
    check_error(load("empty", &o), LT_EFORMAT, "a git-lfs pointer in the place of a file, want a mesh");
    put_file(in("models/empty/a.obj"), "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", 32);
    check_error(load("empty", &o), LT_EFORMAT, "models/empty/a.obj: ");
}
END_TEST

/* YCB's by the name without the number, with or without the mark of stand-ins; and what is not there. */
START_TEST(names)
{
    const predict_object *o;

    put_model("syn_006_mustard_bottle", "textured_simple.obj", 0.0972, 0.0666, 0.1914, 1, true);
    put_model("025_mug", "textured_simple.obj", 0.117, 0.0931, 0.0814, 1, true);
    put_model("026_mug", "textured_simple.obj", 0.1, 0.09, 0.08, 1, true);
    put_model("jug", "textured_simple.obj", 0.1, 0.09, 0.08, 1, true);
    check_ok(load("mustard_bottle", &o));
    ck_assert_str_eq(o->name, "syn_006_mustard_bottle");
    ck_assert_int_gt(o->n_symmetries, -1);
    check_ok(load("006_mustard_bottle", &o));
    check_ok(load("025_mug", &o));
    check_ok(load("022_jug", &o));
    ck_assert_str_eq(o->name, "jug");
    check_error(load("mug", &o), LT_EUSAGE, "--object mug: several objects in ");
    check_error(load("mustrad_bottle", &o), LT_EUSAGE, "did you mean \"mustard_bottle\"?");
    check_error(load("../models/jug", &o), LT_EUSAGE, "no such object in ");
    check_error(load("zebra", &o), LT_EUSAGE, "there are: 025_mug, 026_mug, jug, syn_006_mustard_bottle");
    check_ok(lt_make_dirs(in("none")));
    check_error(predict_load_objects(arena, &(predict_options){ .models = in("none"), .object = "jug" },
                                     &(predict_boxes){ .n = 0 }, &o), LT_EFORMAT, "none: no folders of models in it");
}
END_TEST

/* What a model's numbers are is found by its size, and said. */
START_TEST(units)
{
    static const struct { const char *name; double scale; const char *note; } cases[] = {
        { "006_mustard_bottle", 1000, "spans 191 m: taken for millimetres, it spans 0.191 m" },
        { "006_mustard_bottle", 100, "spans 19.1 m: taken for centimetres" },
        { "006_mustard_bottle", 39.37, "taken for inches" }, { "006_mustard_bottle", 0.001, "taken for kilometres" },
        { "my_bottle", 1000, "the model of my_bottle spans 191 m: taken for millimetres" }, { "my_bottle", 1, NULL },
    };
    const predict_object *o;

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        put_model(cases[i].name, "textured_simple.obj", 0.0972, 0.0666, 0.1914, cases[i].scale, i % 2);
        unlink(in(lt_arena_printf(arena, "models/%s/points.xyz", i % 2 ? "" : cases[i].name)));
        check_ok(load(cases[i].name, &o));
        ck_assert_double_eq_tol(longest_side(o), 0.1914, 0.005);
        if (cases[i].note)
            ck_assert_msg(strstr(o->unit_note, cases[i].note), "%s", o->unit_note);
        else
            ck_assert_ptr_null(o->unit_note);
    }
    put_model("my_bottle", "textured_simple.obj", 1, 2, 5, 1, true);
    check_error(load("my_bottle", &o), LT_EFORMAT, "my_bottle: the model spans 5 m, want metres");
    put_model("006_mustard_bottle", "textured_simple.obj", 1, 2, 5, 1, true);
    check_error(load("mustard_bottle", &o), LT_EFORMAT, "this one as much as YCB's 006_mustard_bottle");
    put_model("my_bottle", "textured_simple.obj", 0.1, 0.1, 0.2, 1000, true);
    put_model("my_bottle", "textured_simple.obj", 0.1, 0.1, 0.2, 1, false);
    check_error(load("my_bottle", &o), LT_EFORMAT, "the mesh spans 0.2, points.xyz 200; want both in metres");
}
END_TEST

/* Axes that were swapped or turned, about a centre as YCB's, at the origin as BOP's, or anywhere. */
START_TEST(axes)
{
    static const double size[3] = { 0.0972, 0.0666, 0.1914 }, centre[3] = { -0.0013, -0.0025, 0.0118 };
    static const struct { double size[3], centre[3]; int turn[3]; } cases[] = {
        { { 0.0972, 0.0666, 0.1914 }, { -0.0013, -0.0025, 0.0118 }, { 1, 2, 3 } },
        { { 0.0972, 0.0666, 0.1914 }, { 0, 0, 0 }, { 1, 2, 3 } },
        { { 0.0972, 0.0666, 0.1914 }, { 0, 0, 0.0957 }, { 1, 2, 3 } },
        { { 0.0972, 0.1914, 0.0666 }, { -0.0013, 0.0118, 0.0025 }, { 1, 3, -2 } },     /* y up, as Blender writes it */
        { { 0.0972, 0.0666, 0.1914 }, { -0.0013, 0.0025, -0.0118 }, { 1, -2, -3 } },
        { { 0.1914, 0.0972, 0.0666 }, { 1, 1, 1 }, { 3, 1, 2 } },
    };
    int turn[3];

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        ck_assert(object_turn_of(cases[i].size, cases[i].centre, size, centre, turn));
        ck_assert_msg(memcmp(turn, cases[i].turn, sizeof(turn)) == 0, "case %zu: %d %d %d", i, turn[0], turn[1],
                      turn[2]);
    }
    ck_assert(!object_turn_of((const double[3]){ 0.1, 0.1, 0.1 }, centre, size, centre, turn));
}
END_TEST

START_TEST(axes_are_said)
{
    const predict_object *o;

    put_model("006_mustard_bottle", "textured_simple.obj", 0.0972, 0.1914, 0.0666, 1, false);
    check_ok(load("mustard_bottle", &o));
    ck_assert_msg(strstr(o->axes_note, "has YCB's axes x, z and -y as its x, y and z") ||
                  strstr(o->axes_note, "has YCB's axes x, -z and y as its x, y and z") ||
                  strstr(o->axes_note, "has YCB's axes -x, z and y as its x, y and z"), "%s", o->axes_note);
    put_model("006_mustard_bottle", "textured_simple.obj", 0.15, 0.15, 0.15, 1, false);
    check_ok(load("mustard_bottle", &o));
    ck_assert_msg(strstr(o->axes_note, "is 0.15 x 0.15 x 0.15 m, YCB's 0.0972 x 0.0666 x 0.191: another object?"), "%s",
                  o->axes_note);
}
END_TEST

static void start(void)
{
    arena = lt_arena_new();
    make_scratch_folder();
}

static void stop(void)
{
    lt_arena_free(arena);
    remove_scratch_folder();
}

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, start, stop);
    tcase_add_test(t, own);
    tcase_add_test(t, names);
    tcase_add_test(t, units);
    tcase_add_test(t, axes);
    tcase_add_test(t, axes_are_said);
}

int main(void)
{
    return run_suite("predict_objects", add_tests);
}
