/* SPDX-License-Identifier: Apache-2.0 */
/* PLY, binary glTF, COCO's masks: what was packed elsewhere, round trips to the bit, and damage. */
#include "libtensor/io/file.h"
#include "libtensor/io/image/coco_rle.h"
#include "libtensor/io/mesh/glb.h"
#include "libtensor/io/mesh/ply.h"
#include "libtensor/io/mesh/splat.h"
#include "tests/io/hostile.h"
#include "tests/io/ply_vectors.h"

#include <cjson/cJSON.h>
#include <math.h>

static lt_status read_mesh(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_ply p;
    lt_mesh m;
    lt_status st = lt_ply_parse(arena, "x.ply", bytes, n, &p);

    return st ? st : lt_ply_mesh(arena, &p, &m);
}

static lt_status read_splats(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_ply p;
    lt_splat *splat;
    size_t count;
    lt_status st = lt_ply_parse(arena, "x.ply", bytes, n, &p);

    return st ? st : lt_ply_splats(arena, &p, &splat, &count);
}

/* ---- PLY that others packed ------------------------------------------------------------------------ */

static const struct {
    const uint8_t *bytes;
    size_t n;
    const char *format;
} files[] = {
    { ply_ascii, sizeof(ply_ascii), "ascii" }, { ply_little, sizeof(ply_little), "binary_little_endian" },
    { ply_big, sizeof(ply_big), "binary_big_endian" },
};

START_TEST(every_format)
{
    static const int32_t faces[3][3] = { { 0, 1, 2 }, { 0, 2, 3 }, { 0, 2, 3 } };
    lt_arena *arena = lt_arena_new();
    const lt_ply_property *pair;
    size_t count;
    lt_mesh m;
    lt_ply p;

    check_ok(lt_ply_parse(arena, "x.ply", files[_i].bytes, files[_i].n, &p));
    ck_assert_str_eq(p.format, files[_i].format);
    ck_assert_int_eq(p.n, 4);
    ck_assert(lt_array_get(&lt_ply_find(&p, "vertex", "extra", NULL)->values, 0) == -300);
    ck_assert(lt_array_get(&lt_ply_find(&p, "edge", "sign", NULL)->values, 0) == -128);
    pair = lt_ply_find(&p, "edge", "pair", &count);
    ck_assert(count == 1 && pair->begin[1] == 2 && lt_array_get(&pair->values, 0) == 65535);
    ck_assert(!lt_ply_find(&p, "edge", "none", NULL) && !lt_ply_find(&p, "none", "x", NULL));
    check_ok(lt_ply_mesh(arena, &p, &m));
    ck_assert_int_eq(m.n_vertices, 4);
    ck_assert_int_eq(m.n_faces, 3);
    ck_assert(memcmp(m.face, faces, sizeof(faces)) == 0);
    ck_assert(m.vertex[3][1] == 1 && m.vertex[3][2] == -1 && m.vertex[0][2] == 0.5f);
    ck_assert(m.color[0][0] == 1 && m.color[0][2] == (float)(51.0 / 255) && !m.normal && !m.uv);
    lt_arena_free(arena);
    check_truncated(read_mesh, files[_i].bytes, files[_i].n, _i == 0 ? 3 : 0);    /* "-1" is a number too */
    check_flipped(read_mesh, files[_i].bytes, files[_i].n, 10000);
}
END_TEST

#define PLY(rest) "ply\nformat ascii 1.0\n" rest
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define RAW(text, reason) { text, sizeof(text) - 1, reason }

START_TEST(refused)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *reason;
    } cases[] = {
        RAW("", "an empty file, want a PLY file"), RAW("\x89PNG\r\n\x1a\n", "a PNG image, want a PLY file"),
        RAW("plx\n", "not a PLY file"), RAW("ply\n", "does not end"),
        RAW("ply\nend_header\n", "without format"), RAW("ply\nformat ascii 2.0\n", "a format other than"),
        RAW("ply\nfoo\n", "neither format, element"), RAW("ply\nelement v\n", "want \"element NAME COUNT\""),
        RAW(PLY("element v -1\n"), "want \"element NAME COUNT\""), RAW(PLY("element v 1x\n"), "more rows"),
        RAW(PLY("element v 99999\nend_header\n"), "more rows than the file can hold"),
        RAW(PLY("element v 1\nelement v 1\n"), "the second element"), RAW(PLY("property int x\n"), "of an element"),
        RAW(PLY("element v 1\nproperty long x\n"), "a type that PLY does not have"),
        RAW(PLY("element v 1\nproperty list float int x\n"), "whose length is no integer"),
        RAW(PLY("element v 1\nproperty int x\nproperty int x\n"), "the second property"),
        RAW(PLY("element vertex 1\nend_header\n"), "no vertices with x"),
        RAW(PLY("element vertex 1\n" XYZ "end_header\n1 2"), "ends early"),
        RAW(PLY("element vertex 1\n" XYZ "end_header\n1 2 x"), "not a number of its type"),
        RAW(PLY("element vertex 1\n" XYZ "end_header\n1 2 nan"), "not finite"),
        RAW(PLY("element vertex 1\n" XYZ "end_header\n1 2 1e39"), "not finite"),
        RAW(PLY("element vertex 1\nproperty uchar x\nend_header\n256"), "not a number of its type"),
        RAW(PLY("element vertex 1\nproperty int x\nend_header\n1.5"), "not a number of its type"),
        RAW(PLY("element v 1\nproperty list int int x\nend_header\n256 1"), "more than 255"),
        RAW(PLY("element v 1\nproperty list int int x\nend_header\n-1"), "more than 255"),
        RAW(PLY("element vertex 1\n" XYZ "element face 1\nproperty list int int vertex_index\nend_header\n1 2 3 3 0 0 "
                "1"),
            "vertex 1, want 3 corners or more of 0 to 0"),
        RAW(PLY("element vertex 1\n" XYZ "element face 1\nproperty list int int vertex_index\nend_header\n1 2 3 2 0 0"),
            "want 3 corners or more"),
        RAW(PLY("element vertex 1\n" XYZ "element face 1\nproperty int vertex_index\nend_header\n1 2 3 0"), "no list"),
        RAW("ply\ncomment \0\n", "no text"),
    };

    static const char no_x[] = PLY("element v 0\nend_header\n");

    for (size_t i = 0; i < LT_COUNT(cases); i++)
        check_refused(read_mesh, cases[i].bytes, cases[i].n, cases[i].reason);
    check_refused(read_splats, ply_little, sizeof(ply_little), "Gaussians without a number \"f_dc_0\"");
    check_refused(read_splats, no_x, sizeof(no_x) - 1, "without a number \"x\"");
}
END_TEST

/* ---- round trips ----------------------------------------------------------------------------------- */

/* A tetrahedron with numbers that no text would hold by chance. */
static lt_mesh sample(bool bytes)
{
    static float vertex[4][3], normal[4][3], uv[4][2], color[4][3];
    static int32_t face[4][3] = { { 0, 1, 2 }, { 0, 3, 1 }, { 1, 3, 2 }, { 2, 3, 0 } };

    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++) {
            vertex[i][k] = sinf((float)(3 * i + k)) * 0.1f;
            normal[i][k] = cosf((float)(5 * i + k));
            color[i][k] = bytes ? (float)((17 * i + 90 * k) / 255.0) : 0.1f * (float)(i + k);
        }
        uv[i][0] = 0.125f * (float)i;
        uv[i][1] = 0.3f * (float)i;
    }
    return (lt_mesh){ .n_vertices = 4, .n_faces = 4, .vertex = vertex, .face = face, .normal = normal, .uv = uv,
                      .color = color };
}

START_TEST(mesh_round_trip)
{
    lt_mesh m = sample(_i & 1), back;
    lt_arena *arena = lt_arena_new();
    lt_ply p;

    if (_i & 2)
        m.normal = NULL, m.uv = NULL, m.color = NULL;
    check_ok(lt_ply_write_mesh(in_folder("m.ply"), &m));
    check_ok(lt_ply_read(arena, in_folder("m.ply"), &p));
    if (m.color)
        ck_assert_int_eq(lt_ply_find(&p, "vertex", "red", NULL)->values.type, _i & 1 ? LT_ELEM_U1 : LT_ELEM_F4);
    check_ok(lt_ply_mesh(arena, &p, &back));
    ck_assert(back.n_vertices == 4 && back.n_faces == 4);
    ck_assert(memcmp(back.vertex, m.vertex, 48) == 0 && memcmp(back.face, m.face, 48) == 0);
    ck_assert(!m.normal == !back.normal && !m.uv == !back.uv && !m.color == !back.color);
    if (m.normal)
        ck_assert(memcmp(back.normal, m.normal, 48) == 0 && memcmp(back.uv, m.uv, 32) == 0 &&
                  memcmp(back.color, m.color, 48) == 0);
    lt_arena_free(arena);
}
END_TEST

START_TEST(splats_of_degree_1)
{
    lt_arena *arena = lt_arena_new();
    lt_splat *s;
    size_t n;
    lt_ply p;

    check_ok(lt_ply_parse(arena, "s.ply", ply_splats, sizeof(ply_splats), &p));
    check_ok(lt_ply_splats(arena, &p, &s, &n));
    ck_assert_uint_eq(n, 2);
    ck_assert(s[0].x[2] == 2 && s[0].dc[0] == 3 && s[0].normal[0] == 0);
    ck_assert(s[1].rest[0][0] == 106 && s[1].rest[0][2] == 108 && s[1].rest[0][3] == 0);
    ck_assert(s[1].rest[1][0] == 109 && s[1].rest[2][2] == 114);
    ck_assert(s[1].opacity == 115 && s[1].scale[0] == 116 && s[1].rotation[3] == 122);
    lt_arena_free(arena);
    check_truncated(read_splats, ply_splats, sizeof(ply_splats), 0);
    check_flipped(read_splats, ply_splats, sizeof(ply_splats), 10000);
}
END_TEST

START_TEST(splat_round_trip)
{
    lt_arena *arena = lt_arena_new();
    lt_splat splat[3], *back;
    uint8_t *bytes;
    size_t n;
    lt_ply p;

    ck_assert_uint_eq(sizeof(lt_splat), 248);
    for (size_t i = 0; i < 3 * 62; i++)
        ((float *)splat)[i] = sinf((float)i);
    check_ok(lt_ply_write_splats(in_folder("s.ply"), "opencv camera, metres", splat, 3));
    check_ok(lt_ply_read(arena, in_folder("s.ply"), &p));
    ck_assert_int_eq(p.element[0].n, 62);
    ck_assert_str_eq(p.element[0].property[3].name, "nx");
    ck_assert_str_eq(p.element[0].property[9].name, "f_rest_0");
    ck_assert_str_eq(p.element[0].property[54].name, "opacity");
    ck_assert_str_eq(p.element[0].property[61].name, "rot_3");
    check_ok(lt_ply_splats(arena, &p, &back, &n));
    ck_assert(n == 3 && memcmp(back, splat, sizeof(splat)) == 0);
    check_ok(lt_read_file(arena, in_folder("s.ply"), 1 << 20, &bytes, &n));
    ck_assert(memcmp(bytes + n - sizeof(splat), splat, sizeof(splat)) == 0);
    lt_arena_free(arena);
}
END_TEST

/* ---- binary glTF ------------------------------------------------------------------------------------- */

static uint32_t u32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static const cJSON *item(const cJSON *root, const char *list, int i)
{
    return cJSON_GetArrayItem(cJSON_GetObjectItem(root, list), i);
}

static int number(const cJSON *o, const char *key)
{
    ck_assert_msg(cJSON_IsNumber(cJSON_GetObjectItem(o, key)), "%s", key);
    return (int)cJSON_GetObjectItem(o, key)->valuedouble;
}

/* The words of an accessor, in a file read back. */
static const uint8_t *accessor(const cJSON *root, const uint8_t *bin, int i, int *count)
{
    const cJSON *a = item(root, "accessors", i), *view = item(root, "bufferViews", number(a, "bufferView"));

    *count = number(a, "count");
    ck_assert_int_eq(number(view, "byteOffset") % 4, 0);
    return bin + number(view, "byteOffset");
}

static void check_floats(const uint8_t *at, const float *want, int n, const float *sign, int period)
{
    for (int i = 0; i < n; i++) {
        const uint32_t bits = u32(at + 4 * i);
        const float w = want[i] * sign[i % period];

        ck_assert(memcmp(&bits, &w, 4) == 0);
    }
}

START_TEST(glb)
{
    static const float turned[3] = { 1, -1, -1 }, same[1] = { 1 };
    lt_mesh m = sample(false), bare = m;
    const lt_glb_part parts[] = { { .name = "hand", .mesh = &m, .color = { 1, 0.8f, 0.7f, 1 } },
                                  { .name = "\"object\"", .mesh = &bare, .color = { 1, 1, 1, 0.5f } } };
    lt_arena *arena = lt_arena_new();
    const cJSON *attributes;
    const uint8_t *bin;
    uint8_t *bytes;
    size_t n;
    cJSON *root;
    int count;

    bare.normal = NULL, bare.uv = NULL, bare.color = NULL;
    check_ok(lt_glb_write(in_folder("m.glb"), parts, 2));
    check_ok(lt_read_file(arena, in_folder("m.glb"), 1 << 20, &bytes, &n));
    ck_assert(memcmp(bytes, "glTF\2\0\0\0", 8) == 0 && u32(bytes + 8) == n && memcmp(bytes + 16, "JSON", 4) == 0);
    ck_assert_uint_eq(u32(bytes + 12) % 4, 0);
    root = cJSON_ParseWithLength((char *)bytes + 20, u32(bytes + 12));
    ck_assert_ptr_nonnull(root);
    bin = bytes + 20 + u32(bytes + 12);
    ck_assert(memcmp(bin + 4, "BIN\0", 4) == 0 && bin + 8 + u32(bin) == bytes + n);
    ck_assert_int_eq(number(item(root, "buffers", 0), "byteLength"), (int)u32(bin));
    bin += 8;
    ck_assert_str_eq(cJSON_GetObjectItem(item(root, "nodes", 1), "name")->valuestring, "\"object\"");
    attributes = cJSON_GetObjectItem(item(item(root, "meshes", 0), "primitives", 0), "attributes");
    check_floats(accessor(root, bin, number(attributes, "POSITION"), &count), m.vertex[0], 12, turned, 3);
    ck_assert_int_eq(count, 4);
    check_floats(accessor(root, bin, number(attributes, "NORMAL"), &count), m.normal[0], 12, turned, 3);
    check_floats(accessor(root, bin, number(attributes, "COLOR_0"), &count), m.color[0], 12, same, 1);
    for (int i = 0; i < 4; i++) {
        const float uv[2] = { m.uv[i][0], 1 - m.uv[i][1] };

        check_floats(accessor(root, bin, number(attributes, "TEXCOORD_0"), &count) + 8 * i, uv, 2, same, 1);
    }
    attributes = item(item(root, "meshes", 1), "primitives", 0);
    ck_assert(memcmp(accessor(root, bin, number(attributes, "indices"), &count), m.face, 48) == 0 && count == 12);
    cJSON_Delete(root);
    lt_arena_free(arena);
}
END_TEST

/* A quarter turn about x, which is the same in glTF's axes, then gone: one animation of three channels, in steps, whose
 * arrays are no vertices. */
START_TEST(glb_moves)
{
    static const float half = 0.70710678f;
    static const lt_glb_key key[] = {
        { .seconds = 0, .rotation = { 1 }, .translation = { 1, 2, 3 }, .shown = true },
        { .seconds = 0.5f, .rotation = { half, half }, .shown = false },
    };
    static const float seconds[] = { 0, 0.5f }, translation[] = { 1, -2, -3, 0, 0, 0 }, plus[] = { 1 };
    static const float rotation[] = { 0, 0, 0, 1, half, 0, 0, half }, scale[] = { 1, 1, 1, 0, 0, 0 };
    static const float *const want[] = { translation, rotation, scale };
    static const char *const path[] = { "translation", "rotation", "scale" };
    static const int words[] = { 6, 8, 6 };
    lt_mesh m = sample(false);
    const lt_glb_part part = { .name = "hand", .mesh = &m, .color = { 1, 1, 1, 1 }, .key = key, .n_keys = 2 };
    lt_arena *arena = lt_arena_new();
    const uint8_t *bin;
    const cJSON *animation;
    uint8_t *bytes;
    size_t n;
    cJSON *root;
    int count;

    check_ok(lt_glb_write(in_folder("moves.glb"), &part, 1));
    check_ok(lt_read_file(arena, in_folder("moves.glb"), 1 << 20, &bytes, &n));
    root = cJSON_ParseWithLength((char *)bytes + 20, u32(bytes + 12));
    ck_assert_ptr_nonnull(root);
    bin = bytes + 28 + u32(bytes + 12);
    ck_assert_int_eq(number(item(root, "buffers", 0), "byteLength"), (int)(bytes + n - bin));
    ck_assert_int_eq(cJSON_GetArraySize(cJSON_GetObjectItem(root, "animations")), 1);
    animation = item(root, "animations", 0);
    for (int i = 0; i < 3; i++) {
        const cJSON *sampler = item(animation, "samplers", i), *channel = item(animation, "channels", i);
        const cJSON *target = cJSON_GetObjectItem(channel, "target");
        const cJSON *times = item(root, "accessors", number(sampler, "input"));

        ck_assert_int_eq(number(channel, "sampler"), i);
        ck_assert_int_eq(number(target, "node"), 0);
        ck_assert_str_eq(cJSON_GetObjectItem(target, "path")->valuestring, path[i]);
        ck_assert_str_eq(cJSON_GetObjectItem(sampler, "interpolation")->valuestring, "STEP");
        ck_assert_double_eq(cJSON_GetArrayItem(cJSON_GetObjectItem(times, "max"), 0)->valuedouble, 0.5);
        ck_assert_ptr_null(cJSON_GetObjectItem(item(root, "bufferViews", number(times, "bufferView")), "target"));
        check_floats(accessor(root, bin, number(sampler, "input"), &count), seconds, 2, plus, 1);
        ck_assert_int_eq(count, 2);
        for (int k = 0; k < words[i]; k++) {
            const uint32_t bits = u32(accessor(root, bin, number(sampler, "output"), &count) + 4 * k);
            float x;

            memcpy(&x, &bits, 4);
            ck_assert_float_eq(x, want[i][k]);          /* -0 is 0 here */
        }
        ck_assert_int_eq(count, 2);
    }
    cJSON_Delete(root);
    lt_arena_free(arena);
}
END_TEST

START_TEST(glb_refuses)
{
    const lt_glb_key back[] = { { .seconds = 1, .rotation = { 1 } }, { .seconds = 1, .rotation = { 1 } } };
    lt_mesh m = sample(false), none = m;
    lt_glb_part part = { .name = "hand", .mesh = &m };

    check_error(lt_glb_write(in_folder("n.glb"), &part, 0), LT_EINVAL, "no meshes");
    none.n_faces = 0;
    part.mesh = &none;
    check_error(lt_glb_write(in_folder("n.glb"), &part, 1), LT_EINVAL, "4 vertices and 0 triangles");
    part.mesh = &m;
    part.key = back, part.n_keys = 2;
    check_error(lt_glb_write(in_folder("n.glb"), &part, 1), LT_EINVAL,
                "key 1 of \"hand\" is at 1 s, the one before at 1 s");
    part.key = NULL, part.n_keys = 0;
    m.n_vertices = 3;
    check_error(lt_glb_write(in_folder("n.glb"), &part, 1), LT_EINVAL, "has vertex 3 of 3");
    m.vertex[2][1] = NAN;
    check_error(lt_glb_write(in_folder("n.glb"), &part, 1), LT_EINVAL, "vertex 2 of \"hand\" is not finite");
    ck_assert(!exists(in_folder("n.glb")));
}
END_TEST

/* ---- Gaussians for viewers on the web ------------------------------------------------------------------- */

/* Half a turn about z, opacity 1/2, white and black; the second one larger */
static void two_splats(lt_splat out[2])
{
    for (int i = 0; i < 2; i++) {
        out[i] = (lt_splat){ .x = { 1, 2, 3 }, .dc = { 2, -2, 0 }, .scale = { 0, 0, (float)i },
                             .rotation = { 0, 0, 0, 3 } };
        for (int k = 0; k < 45; k++)
            out[i].rest[k / 15][k % 15] = (float)(k + 1);
    }
}

START_TEST(splat_file)
{
    lt_arena *arena = lt_arena_new();
    lt_splat splat[2];
    uint8_t *bytes;
    float x[6];
    size_t n;

    two_splats(splat);
    check_ok(lt_splat_write(in_folder("s.splat"), splat, 2));
    check_ok(lt_read_file(arena, in_folder("s.splat"), 1 << 20, &bytes, &n));
    ck_assert_uint_eq(n, 64);
    memcpy(x, bytes, sizeof(x));
    ck_assert(x[0] == 1 && x[2] == 3 && x[3] == 1);
    ck_assert_float_eq(x[5], expf(1));                  /* the larger one comes first */
    ck_assert(bytes[24] == 255 && bytes[25] == 0 && bytes[26] == 128 && bytes[27] == 128);
    ck_assert(bytes[28] == 128 && bytes[30] == 128 && bytes[31] == 255);
    splat[1].scale[1] = INFINITY;
    check_error(lt_splat_write(in_folder("t.splat"), splat, 2), LT_EINVAL, "Gaussian 1 is not finite");
    check_error(lt_glb_write_splats(in_folder("t.glb"), "t", splat, 0, 0), LT_EINVAL, "no Gaussians to write");
    lt_arena_free(arena);
}
END_TEST

/* The numbers behind an attribute of the only primitive */
static const float *attribute(const cJSON *root, const uint8_t *binary, const char *name)
{
    const cJSON *mesh = cJSON_GetArrayItem(cJSON_GetObjectItem(root, "meshes"), 0);
    const cJSON *primitive = cJSON_GetArrayItem(cJSON_GetObjectItem(mesh, "primitives"), 0);
    const cJSON *at = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItem(primitive, "attributes"), name);
    const cJSON *accessor, *view;

    ck_assert_msg(cJSON_IsNumber(at), "no attribute %s", name);
    accessor = cJSON_GetArrayItem(cJSON_GetObjectItem(root, "accessors"), at->valueint);
    ck_assert_int_eq(cJSON_GetObjectItem(accessor, "componentType")->valueint, 5126);
    view = cJSON_GetArrayItem(cJSON_GetObjectItem(root, "bufferViews"),
                              cJSON_GetObjectItem(accessor, "bufferView")->valueint);
    return (const float *)(const void *)(binary + cJSON_GetObjectItem(view, "byteOffset")->valueint);
}

/* What KHR_gaussian_splatting requires: points, kernel and colour space, rotations, scales, opacities, and all
 * harmonics of each degree; axes turned to glTF's. */
START_TEST(splats_in_gltf)
{
    static const char *const needed[] = { "kernel", "colorSpace" };
    lt_arena *arena = lt_arena_new();
    const cJSON *primitive, *extension;
    const float *x;
    lt_splat splat[2];
    uint8_t *bytes, *binary;
    cJSON *root;
    size_t n;

    two_splats(splat);
    check_ok(lt_glb_write_splats(in_folder("s.glb"), "both", splat, 2, 3));
    check_ok(lt_read_file(arena, in_folder("s.glb"), 1 << 20, &bytes, &n));
    ck_assert(memcmp(bytes, "glTF", 4) == 0 && u32(bytes + 8) == n);
    root = cJSON_ParseWithLength((const char *)bytes + 20, u32(bytes + 12));
    binary = bytes + 20 + u32(bytes + 12) + 8;
    ck_assert_ptr_nonnull(root);
    ck_assert_str_eq(cJSON_GetArrayItem(cJSON_GetObjectItem(root, "extensionsUsed"), 0)->valuestring,
                     "KHR_gaussian_splatting");
    primitive = cJSON_GetArrayItem(
        cJSON_GetObjectItem(cJSON_GetArrayItem(cJSON_GetObjectItem(root, "meshes"), 0), "primitives"), 0);
    ck_assert_int_eq(cJSON_GetObjectItem(primitive, "mode")->valueint, 0);
    extension = cJSON_GetObjectItem(cJSON_GetObjectItem(primitive, "extensions"), "KHR_gaussian_splatting");
    for (size_t i = 0; i < LT_COUNT(needed); i++)
        ck_assert(cJSON_IsString(cJSON_GetObjectItemCaseSensitive(extension, needed[i])));
    x = attribute(root, binary, "POSITION");
    ck_assert(x[0] == 1 && x[1] == -2 && x[2] == -3);
    x = attribute(root, binary, "KHR_gaussian_splatting:ROTATION");
    ck_assert(x[0] == 0 && x[1] == -1 && x[2] == 0 && x[3] == 0);
    ck_assert_float_eq(attribute(root, binary, "KHR_gaussian_splatting:SCALE")[5], expf(1));
    ck_assert_float_eq(attribute(root, binary, "KHR_gaussian_splatting:OPACITY")[0], 0.5f);
    ck_assert_float_eq(attribute(root, binary, "COLOR_0")[3], 0.5f);
    for (int d = 0, k = 0; d < 4; d++)
        for (int m = 0; m < 2 * d + 1; m++, k++) {
            static const int sign[16] = { 1, -1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1 };
            char name[64];

            snprintf(name, sizeof(name), "KHR_gaussian_splatting:SH_DEGREE_%d_COEF_%d", d, m);
            x = attribute(root, binary, name);
            ck_assert_float_eq(x[2], k ? (float)(sign[k] * (30 + k)) : 0);
        }
    cJSON_Delete(root);
    lt_arena_free(arena);
}
END_TEST

/* ---- masks ----------------------------------------------------------------------------------------------- */

START_TEST(masks)
{
    static const uint8_t small[12] = { 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0 };      /* data.md 6.10 */
    static uint8_t mask[2000];
    lt_arena *arena = lt_arena_new();

    ck_assert_str_eq(lt_rle_encode(arena, mask_40x50, 40, 50), mask_rle);
    check_ok(lt_rle_decode(mask_rle, 40, 50, mask));
    ck_assert(memcmp(mask, mask_40x50, sizeof(mask)) == 0);
    check_ok(lt_rle_decode("435", 3, 4, mask));
    ck_assert(mask[1 * 4 + 1] == 1 && mask[2 * 4 + 1] == 1 && mask[0 * 4 + 2] == 1);
    ck_assert_str_eq(lt_rle_encode(arena, mask, 3, 4), "435");
    ck_assert_str_eq(lt_rle_encode(arena, small, 0, 0), "0");
    check_ok(lt_rle_decode("0", 0, 0, mask));
    check_error(lt_rle_decode("43", 3, 4, mask), LT_EFORMAT, "runs of 7 cells, want 3 x 4");
    check_error(lt_rle_decode("43H", 3, 4, mask), LT_EFORMAT, "does not fit");
    check_error(lt_rle_decode("4!", 3, 4, mask), LT_EFORMAT, "character 1");
    check_error(lt_rle_decode("o", 3, 4, mask), LT_EFORMAT, "character");
    check_error(lt_rle_decode("oooooooo", 3, 4, mask), LT_EFORMAT, "character");
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_loop_test(tc, every_format, 0, LT_COUNT(files));
    tcase_add_test(tc, refused);
    tcase_add_loop_test(tc, mesh_round_trip, 0, 4);
    tcase_add_test(tc, splats_of_degree_1);
    tcase_add_test(tc, splat_round_trip);
    tcase_add_test(tc, splat_file);
    tcase_add_test(tc, splats_in_gltf);
    tcase_add_test(tc, glb);
    tcase_add_test(tc, glb_moves);
    tcase_add_test(tc, glb_refuses);
    tcase_add_test(tc, masks);
}

int main(void)
{
    return run_suite("ply", add_tests);
}
