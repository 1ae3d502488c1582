/* SPDX-License-Identifier: Apache-2.0 */
/* OBJ and .xyz: the rules of the format, round trips, and text that breaks them. */
#include "libtensor/io/mesh/obj.h"
#include "tests/io/hostile.h"

#include <unistd.h>

static lt_status read_obj(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_mesh mesh;

    put_file(in_folder("h.obj"), bytes, n);
    return lt_obj_read(arena, in_folder("h.obj"), &mesh, NULL);
}

static const char box[] =
    "# a square, its texture turned over at one corner\nmtllib box.mtl\no thing\nusemtl skin\n"
    "v 0 0 0\nv 1 0 0\nv 1 1 0\r\nv 0 1 \\\n 0\nv 9 9 9\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt .5 .5\nvn 0 0 2\n"
    "f 1/1/1 2/2/1 3/3/1 4/4/1\nf -5/5/1 -4/2/1 -2/4/-1\n";

START_TEST(obj)
{
    static const char library[] = "newmtl other\nmap_Kd no.png\nnewmtl skin\nKd 1 1 1\nmap_Kd -s 1 1 skin.png \r\n";
    lt_arena *arena = lt_arena_new();
    const char *texture;
    lt_mesh m;

    put_file(in_folder("box.obj"), box, sizeof(box) - 1);
    put_file(in_folder("box.mtl"), library, sizeof(library) - 1);
    check_ok(lt_obj_read(arena, in_folder("box.obj"), &m, &texture));
    ck_assert_str_eq(texture, in_folder("skin.png"));
    ck_assert_int_eq(m.n_vertices, 6);          /* the first corner has two texture places */
    ck_assert_int_eq(m.n_faces, 3);
    ck_assert(m.uv && m.normal && !m.color);
    ck_assert(m.face[1][0] == 0 && m.face[1][1] == 2 && m.face[1][2] == 3);
    ck_assert(m.face[2][0] == 5 && m.face[2][1] == 1 && m.face[2][2] == 3);
    ck_assert(m.vertex[5][0] == 0 && m.uv[5][0] == 0.5f && m.vertex[4][0] == 9);
    ck_assert(m.normal[0][2] == 1);
    put_file(in_folder("box.mtl"), "newmtl skin\nmap_Kd ../../etc/passwd\n", 36);
    check_ok(lt_obj_read(arena, in_folder("box.obj"), &m, &texture));
    ck_assert_ptr_null(texture);
    put_file(in_folder("box.mtl"), "newmtl skin\nmap_Kd a\0b.png\n", 27);
    check_ok(lt_obj_read(arena, in_folder("box.obj"), &m, &texture));
    ck_assert_ptr_null(texture);
    put_file(in_folder("box.mtl"), "newmtl skin\nnewmtl other\nmap_Kd other.png\n", 42);
    check_ok(lt_obj_read(arena, in_folder("box.obj"), &m, &texture));
    ck_assert_ptr_null(texture);
    unlink(in_folder("box.mtl"));
    check_ok(lt_obj_read(arena, in_folder("box.obj"), &m, &texture));
    ck_assert_ptr_null(texture);
    lt_arena_free(arena);
}
END_TEST

/* Of several libraries and materials the first ones; a library's first map where no material is used. */
START_TEST(the_first_texture)
{
    static const struct {
        const char *obj, *want;
    } cases[] = {
        { "mtllib a.mtl\nusemtl two\nmtllib b.mtl\nusemtl one\n", "2.png" }, { "mtllib a.mtl\n", "1.png" },
        { "mtllib /a.mtl\n", NULL }, { "usemtl one\n", NULL }, { "mtllib a.mtl\nusemtl none\n", NULL },
        { "mtllib a.mtl \nusemtl -three\n", "3.png" },
    };
    static const char library[] = "newmtl one\nmap_Kd 1.png\nnewmtl two\nmap_Kd 2.png\n"
                                  "newmtl -three\nmap_Kd -blendu on 3.png";
    lt_arena *arena = lt_arena_new();
    const char *texture;
    lt_mesh m;

    put_file(in_folder("a.mtl"), library, sizeof(library) - 1);
    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        put_file(in_folder("a.obj"), cases[i].obj, strlen(cases[i].obj));
        check_ok(lt_obj_read(arena, in_folder("a.obj"), &m, &texture));
        ck_assert_msg(!texture == !cases[i].want, "%s", cases[i].obj);
        if (texture)
            ck_assert_str_eq(texture, in_folder(cases[i].want));
    }
    lt_arena_free(arena);
}
END_TEST

/* Corners of one position that differ in texture or normal alone are vertices apart; no length is no direction. */
START_TEST(corners_apart)
{
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 0\nvn 0 3 4\n"
                               "f 1/1/1 2/1/1 3/1/1\nf 1/1/2 2/1/1 3/1/1\nf 1/2/2 2/1/1 3/1/1\nf 1/2/2 2/1/1 3/1/1\n";
    lt_arena *arena = lt_arena_new();
    lt_mesh m;

    put_file(in_folder("c.obj"), text, sizeof(text) - 1);
    check_ok(lt_obj_read(arena, in_folder("c.obj"), &m, NULL));
    ck_assert_int_eq(m.n_vertices, 5);
    ck_assert(m.face[0][0] == 0 && m.face[1][0] == 3 && m.face[2][0] == 4 && m.face[3][0] == 4);
    ck_assert(m.normal[0][1] == 0 && m.normal[3][1] == 0.6f && m.normal[3][2] == 0.8f && m.uv[4][0] == 1);
    lt_arena_free(arena);
}
END_TEST

/* A byte order mark, and the line ends of three systems. */
START_TEST(texts_of_all_systems)
{
    static const char *const texts[] = {
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 3\n", "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nv 1 1 1\r\nf 1 2 3",
        "v 0 0 0\rv 1 \\\r0 0\rv 0 1 0\rv 1 1 1\rf 1 2 3\r",
    };
    lt_arena *arena = lt_arena_new();
    float (*point)[3];
    lt_mesh m;
    size_t n;

    for (size_t i = 0; i < 2 * LT_COUNT(texts); i++) {
        const char *text = lt_arena_printf(arena, "%s%s", i % 2 ? "\xef\xbb\xbf" : "", texts[i / 2]);

        put_file(in_folder("s.obj"), text, strlen(text));
        check_ok(lt_obj_read(arena, in_folder("s.obj"), &m, NULL));
        ck_assert_msg(m.n_vertices == 4 && m.n_faces == 1, "%zu: %d %d", i, m.n_vertices, m.n_faces);
        ck_assert(m.vertex[1][0] == 1 && m.face[0][2] == 2);
    }
    put_file(in_folder("s.xyz"), "\xef\xbb\xbf" "1 2 3\r\r4 5 6\r", 16);
    check_ok(lt_xyz_read(arena, in_folder("s.xyz"), &point, &n));
    ck_assert(n == 2 && point[0][0] == 1 && point[1][2] == 6);
    lt_arena_free(arena);
}
END_TEST

/* As programs write them: empty places, a comment behind, a circle as one face */
START_TEST(faces_of_all_programs)
{
    static const char *const lines[] = { "f 1/ 2/ 3/", "f 1// 2// 3//", "f 1 2 3 # of one", "f 1// 2/ 3 #" };
    char text[1024];
    lt_arena *arena = lt_arena_new();
    lt_mesh m;

    for (size_t i = 0; i < LT_COUNT(lines); i++) {
        snprintf(text, sizeof(text), "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 1 0 0\n%s\n", lines[i]);
        put_file(in_folder("p.obj"), text, strlen(text));
        check_ok(lt_obj_read(arena, in_folder("p.obj"), &m, NULL));
        ck_assert_msg(m.n_faces == 1 && !m.uv && !m.normal && m.face[0][2] == 2, "%s", lines[i]);
    }
    strcpy(text, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf");
    for (int i = 0; i < 100; i++)
        sprintf(text + strlen(text), " %d", 1 + i % 3);
    put_file(in_folder("p.obj"), text, strlen(text));
    check_ok(lt_obj_read(arena, in_folder("p.obj"), &m, NULL));
    ck_assert_int_eq(m.n_faces, 98);
    ck_assert(m.face[97][0] == 0 && m.face[97][1] == 98 % 3 && m.face[97][2] == 99 % 3);
    lt_arena_free(arena);
}
END_TEST

START_TEST(bad_obj)
{
    static const struct {
        const char *text, *reason;
    } cases[] = {
        { "v 0 0\n", "h.obj:1: vertex without" }, { "v 0 0 nan\n", "finite" }, { "v 0 0 1e39\n", "finite" },
        { "v 0 0 0x\n", "finite" }, { "\n\nvt 1\n", "h.obj:3: texture" }, { "vn 1 2\n", "normal" },
        { "v 0 0 0\nf 1 1\n", "fewer than 3" }, { "v 0 0 0\nf 1 1 2\n", "index beyond" },
        { "v 0 0 0\nf 1 1 0\n", "no index" }, { "v 0 0 0\nf 1 1 -2\n", "no index" },
        { "v 0 0 0\nf 1 1 99999999999\n", "no index" }, { "v 0 0 0\nf 1/x 1 1\n", "no index" },
        { "v 0 0 0\nf 1/// 1 1\n", "no index" }, { "v 0 0 0\nf 1 1 # 1\n", "fewer than 3" },
        { "v 0 0 0\nf 1 1 1# 1\n", "no index" },
        { "v 0 0 0\nf 1/1 1/1 1/1\n", "index beyond" }, { "v 0 0 0\nf a b c\n", "no index" },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++)
        check_refused(read_obj, cases[i].text, strlen(cases[i].text), cases[i].reason);
    check_refused(read_obj, "v 0 0 0\0v 1 1 1\n", 16, "zero byte");
    check_ok(attempt(read_obj, (const uint8_t *)"", 0));
    check_flipped(read_obj, (const uint8_t *)box, sizeof(box) - 1, 2000);
    for (size_t cut = 0; cut < sizeof(box); cut++)
        attempt(read_obj, (const uint8_t *)box, cut);
}
END_TEST

START_TEST(obj_round_trip)
{
    float vertex[4][3] = { { 0.1f, 1e-7f, -3 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 / 3.0f } };
    float uv[4][2] = { { 0, 0 }, { 1, 0 }, { 0, 1 }, { 0.5f, 0.25f } };
    float normal[4][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 0, -1, 0 } };
    float color[4][3] = { { 0.5f, 0.25f, 1 } };
    int32_t face[2][3] = { { 0, 1, 2 }, { 2, 1, 3 } };
    const lt_mesh mesh = {
        .n_vertices = 4, .n_faces = 2, .vertex = vertex, .face = face, .uv = _i & 1 ? uv : NULL,
        .normal = _i & 2 ? normal : NULL, .color = _i & 4 ? color : NULL,
    };
    lt_arena *arena = lt_arena_new();
    const char *texture;
    lt_mesh back;

    check_ok(lt_obj_write(in_folder("r.obj"), &mesh, _i & 1 ? "skin.png" : NULL));
    check_ok(lt_obj_read(arena, in_folder("r.obj"), &back, &texture));
    ck_assert(back.n_vertices == 4 && back.n_faces == 2);
    ck_assert_mem_eq(back.vertex, vertex, sizeof(vertex));
    ck_assert_mem_eq(back.face, face, sizeof(face));
    ck_assert(!back.uv == !mesh.uv && !back.normal == !mesh.normal && !back.color == !mesh.color);
    if (back.uv) {
        ck_assert_mem_eq(back.uv, uv, sizeof(uv));
        ck_assert_str_eq(texture, in_folder("skin.png"));
    }
    if (back.color)
        ck_assert_mem_eq(back.color, color, sizeof(color));
    check_error(lt_obj_write(in_folder("r.obj"), &mesh, "../x.png"), LT_EINVAL, "no file name in its folder");
    check_error(lt_obj_write(in_folder("r.obj"), &mesh, "x\n.png"), LT_EINVAL, "no file name in its folder");
    lt_arena_free(arena);
}
END_TEST

/* "box.obj" -> "box.mtl", whatever else has a dot */
START_TEST(library_beside_its_mesh)
{
    static const struct {
        const char *obj, *library;
    } cases[] = { { "a.b/box", "a.b/box.mtl" }, { "a.b/.box", "a.b/.box.mtl" }, { "a.b/b.c.obj", "a.b/b.c.mtl" } };
    float vertex[1][3] = { { 0 } };
    const lt_mesh mesh = { .n_vertices = 1, .vertex = vertex };
    lt_arena *arena = lt_arena_new();
    const char *texture;
    lt_mesh back;

    ck_assert_int_eq(mkdir(in_folder("a.b"), 0700), 0);
    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        check_ok(lt_obj_write(in_folder(cases[i].obj), &mesh, "skin.png"));
        ck_assert_msg(exists(in_folder(cases[i].library)), "%s", cases[i].library);
        check_ok(lt_obj_read(arena, in_folder(cases[i].obj), &back, &texture));
        ck_assert_str_eq(texture, in_folder("a.b/skin.png"));
    }
    lt_arena_free(arena);
}
END_TEST

START_TEST(xyz)
{
    static const float points[3][3] = { { 0.1f, 2, 3 }, { -1e-20f, 5, 6 }, { 7, 8, 9 } };
    lt_arena *arena = lt_arena_new();
    float (*back)[3];
    size_t n;

    check_ok(lt_xyz_write(in_folder("p.xyz"), points, 3));
    check_ok(lt_xyz_read(arena, in_folder("p.xyz"), &back, &n));
    ck_assert_uint_eq(n, 3);
    ck_assert_mem_eq(back, points, sizeof(points));
    put_file(in_folder("q.xyz"), "# c\n\n1 2 3 255 0 0\r\n4 5", 23);
    check_error(lt_xyz_read(arena, in_folder("q.xyz"), &back, &n), LT_EFORMAT, "q.xyz:4: want three");
    put_file(in_folder("q.xyz"), "# c\n\n1 2 3 255 0 0\r\n4 5 6", 25);
    check_ok(lt_xyz_read(arena, in_folder("q.xyz"), &back, &n));
    ck_assert(n == 2 && back[1][2] == 6);
    put_file(in_folder("q.xyz"), "1 2 3\0", 6);
    check_error(lt_xyz_read(arena, in_folder("q.xyz"), &back, &n), LT_EFORMAT, "q.xyz: a zero byte: no text file");
    check_error(lt_xyz_read(arena, in_folder("none.xyz"), &back, &n), LT_EIO, "No such file");
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, obj);
    tcase_add_test(tc, the_first_texture);
    tcase_add_test(tc, corners_apart);
    tcase_add_test(tc, library_beside_its_mesh);
    tcase_add_test(tc, texts_of_all_systems);
    tcase_add_test(tc, faces_of_all_programs);
    tcase_add_test(tc, bad_obj);
    tcase_add_loop_test(tc, obj_round_trip, 0, 8);
    tcase_add_test(tc, xyz);
}

int main(void)
{
    return run_suite("mesh_io", add_tests);
}
