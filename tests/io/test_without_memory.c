/* SPDX-License-Identifier: Apache-2.0 */
/* Writers and readers of whole files while the first allocation fails, the second, and so on; writers without a folder
 * and without a disk: one line, and no file where there was none. What parses bytes in memory is
 * tested so by tests/fuzz/replay. */
#include "libtensor/io/array/npy.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/mesh/glb.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/mesh/ply.h"
#include "libtensor/io/pickle/dense.h"
#include "libtensor/io/pickle/pickle.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/yaml.h"
#include "libtensor/io/torch/weights_file.h"
#include "tests/io/hostile.h"
#include "tests/io/io_vectors.h"
#include "tests/io/torch_vectors.h"

#include <cjson/cJSON.h>
#include <signal.h>
#include <sys/resource.h>

/* Enough of everything that each array is a block of its own */
enum { VERTICES = 2100 };

static float numbers[6] = { 1, 2, 3, 4, 5, 6 };
static const char *words[2] = { "a", "\xc3\xa9" };
static float vertex[VERTICES][3], uv[VERTICES][2], color[VERTICES][3], normal[VERTICES][3];
static int32_t triangle[VERTICES][3];
static uint8_t pixels[64 * 64 * 3];
static const int64_t two_by_three[2] = { 2, 3 }, two[1] = { 2 };

static lt_mesh mesh(void)
{
    for (int i = 0; i < VERTICES; i++) {
        triangle[i][1] = i;
        normal[i][2] = 1;
    }
    return (lt_mesh){ .n_vertices = VERTICES, .n_faces = VERTICES, .vertex = vertex, .face = triangle, .uv = uv,
                      .color = color, .normal = normal };
}

/* Noise: more bytes than a stream keeps to itself */
static const lt_image *picture(void)
{
    static const lt_image img = { .width = 64, .height = 64, .channels = 3, .bits = 8, .data = pixels };
    lt_rng rng = lt_rng_make(1, 1);

    for (size_t i = 0; i < sizeof(pixels); i++)
        pixels[i] = (uint8_t)lt_rng_u32(&rng);
    return &img;
}

static lt_named_array sample(bool text)
{
    return text ? (lt_named_array){ "t", lt_array_make(LT_ELEM_TEXT, 1, two, words) }
                : (lt_named_array){ "x", lt_array_make(LT_ELEM_F4, 2, two_by_three, numbers) };
}

static lt_status write_npy(lt_arena *arena, const char *path)
{
    const lt_named_array a = sample(false);

    (void)arena;
    return lt_npy_write(path, &a.array);
}

static lt_status write_npz(lt_arena *arena, const char *path)
{
    const lt_named_array list[2] = { sample(true), sample(false) };

    (void)arena;
    return lt_npz_write(path, list, 2, true);
}

static lt_status write_safetensors(lt_arena *arena, const char *path)
{
    const lt_named_array a = sample(false);

    (void)arena;
    return lt_safetensors_write(path, &a, 1, &(lt_text_pair){ "k", "v" }, 1);
}

static lt_status write_pickle(lt_arena *arena, const char *path)
{
    const lt_pwrite item = { .kind = LT_PW_INT, .integer = 70000 };
    const lt_pwrite list[2] = { { .key = "x", .kind = LT_PW_ARRAY, .array = sample(false).array },
                                { .key = "l", .kind = LT_PW_LIST, .item = &item, .n_items = 1 } };

    (void)arena;
    return lt_pickle_write_dict(path, list, 2);
}

static lt_status write_obj(lt_arena *arena, const char *path)
{
    const lt_mesh m = mesh();

    (void)arena;
    return lt_obj_write(path, &m, "skin.png");
}

static lt_status write_ply(lt_arena *arena, const char *path)
{
    const lt_mesh m = mesh();

    (void)arena;
    return lt_ply_write_mesh(path, &m);
}

static lt_status write_xyz(lt_arena *arena, const char *path)
{
    (void)arena;
    return lt_xyz_write(path, (const float (*)[3])vertex, VERTICES);
}

static lt_status write_glb(lt_arena *arena, const char *path)
{
    const lt_mesh m = mesh();

    (void)arena;
    return lt_glb_write(path, &(lt_glb_part){ .name = "n", .mesh = &m, .color = { 1, 1, 1, 1 } }, 1);
}

static lt_status write_json(lt_arena *arena, const char *path)
{
    cJSON *root = cJSON_Parse("{\"a\": [1, {\"b\": \"c\"}]}");
    const lt_status st = root ? lt_json_write(path, root) : LT_ENOMEM;

    (void)arena;
    cJSON_Delete(root);
    return st;
}

static lt_status write_yaml(lt_arena *arena, const char *path)
{
    (void)arena;
    put_file(path, "a: [1, 2]\nb: {c: d}\n", 20);
    return LT_OK;
}

static lt_status write_chumpy(lt_arena *arena, const char *path)
{
    (void)arena;
    put_file(path, pickle_expressions, sizeof(pickle_expressions));
    return LT_OK;
}

static lt_status write_png(lt_arena *arena, const char *path)
{
    (void)arena;
    return lt_png_write(path, picture());
}

static lt_status write_jpeg(lt_arena *arena, const char *path)
{
    (void)arena;
    return lt_jpeg_write(path, picture(), 90);
}

static lt_status read_npy(lt_arena *arena, const char *path)
{
    lt_array a;

    return lt_npy_read(arena, path, &a);
}

static lt_status read_npz(lt_arena *arena, const char *path)
{
    lt_npz z;

    return lt_npz_read(arena, path, &z);
}

static lt_status read_safetensors(lt_arena *arena, const char *path)
{
    lt_weights_file w;

    return lt_weights_read(arena, path, &w);
}

static lt_status read_pickle(lt_arena *arena, const char *path)
{
    const lt_pvalue *v;

    return lt_pickle_read(arena, path, &v);
}

static lt_status read_chumpy(lt_arena *arena, const char *path)
{
    const lt_pvalue *v;
    lt_status st = lt_pickle_read(arena, path, &v);

    for (size_t i = 0; !st && i < v->n; i++) {
        lt_array a;

        st = lt_pickle_dense(arena, v->u.item[2 * i + 1], &a);
    }
    return st;
}

static lt_status read_json(lt_arena *arena, const char *path)
{
    cJSON *root;
    const lt_status st = lt_json_read(path, &root);

    (void)arena;
    if (st == LT_OK)
        cJSON_Delete(root);
    return st;
}

static lt_status read_yaml(lt_arena *arena, const char *path)
{
    const lt_yaml *v;

    return lt_yaml_read(arena, path, &v);
}

static lt_status read_obj(lt_arena *arena, const char *path)
{
    const char *texture;
    lt_mesh m;

    return lt_obj_read(arena, path, &m, &texture);
}

static lt_status read_ply(lt_arena *arena, const char *path)
{
    lt_mesh m;
    lt_ply p;
    const lt_status st = lt_ply_read(arena, path, &p);

    return st ? st : lt_ply_mesh(arena, &p, &m);
}

static lt_status read_xyz(lt_arena *arena, const char *path)
{
    float (*points)[3];
    size_t n;

    return lt_xyz_read(arena, path, &points, &n);
}

static lt_status read_image(lt_arena *arena, const char *path)
{
    lt_image img, rgb;
    const lt_status st = lt_image_read(arena, path, &img);

    return st ? st : lt_image_to_rgb8(arena, &img, &rgb);
}

static const struct {
    lt_status (*write)(lt_arena *arena, const char *path);
    lt_status (*read)(lt_arena *arena, const char *path);
} kinds[] = {
    { write_npy, read_npy }, { write_npz, read_npz }, { write_safetensors, read_safetensors },
    { write_pickle, read_pickle }, { write_obj, read_obj }, { write_ply, read_ply }, { write_xyz, read_xyz },
    { write_png, read_image }, { write_jpeg, read_image }, { write_json, read_json }, { write_glb, NULL },
    { write_yaml, read_yaml }, { write_chumpy, read_chumpy },           /* no writers of ours */
};
enum { WRITERS = LT_COUNT(kinds) - 2 };

/* How often it failed before it did not, in an arena with this much room. */
static int until_it_works(lt_status (*call)(lt_arena *, const char *), const char *path, int room)
{
    for (long at = 1; at < 1000; at++) {
        lt_arena *arena = arena_with_room(room);
        lt_status st;

        lt_alloc_fail_at(at);
        st = call(arena, path);
        lt_alloc_fail_at(0);
        lt_arena_free(arena);
        if (st == LT_OK)
            return (int)at - 1;
        ck_assert_msg(st == LT_ENOMEM, "room %d, block %ld: %s", room, at, lt_last_error());
    }
    ck_abort_msg("never succeeded");
}

/* Small pieces share blocks: with less and less room, each of them is the one that has none. */
static int with_any_room(lt_status (*call)(lt_arena *, const char *), const char *path)
{
    enum { ROOMS = 60 };
    int refused = 0;

    for (int room = 0; room < ROOMS; room++)
        refused += until_it_works(call, path, room);
    return refused;
}

START_TEST(written_and_read)
{
    const char *path = in_folder("file");

    cJSON_InitHooks(&(cJSON_Hooks){ lt_alloc, lt_release });    /* its memory counts while it builds */
    until_it_works(kinds[_i].write, path, 0);
    cJSON_InitHooks(NULL);
    ck_assert(exists(path));
    if (kinds[_i].read)
        ck_assert_int_gt(with_any_room(kinds[_i].read, path), 0);
}
END_TEST

START_TEST(without_a_folder)
{
    lt_arena *arena = lt_arena_new();

    check_error(kinds[_i].write(arena, in_folder("missing/file")), LT_EIO, "cannot write: No such file or directory");
    lt_arena_free(arena);
}
END_TEST

/* A limit on file sizes behaves as a full disk does. */
START_TEST(without_a_disk)
{
    const struct rlimit limit = { 0, RLIM_INFINITY }, none = { RLIM_INFINITY, RLIM_INFINITY };
    const char *path = in_folder("full");
    lt_arena *arena = lt_arena_new();
    lt_status st;

    signal(SIGXFSZ, SIG_IGN);
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
    st = kinds[_i].write(arena, path);
    setrlimit(RLIMIT_FSIZE, &none);
    check_error(st, LT_ENOSPC, "cannot write: File too large");
    ck_assert(!exists(path));
    lt_arena_free(arena);
}
END_TEST

static lt_status read_torch(lt_arena *arena, const char *path)
{
    lt_weights_file w;

    return lt_weights_read(arena, path, &w);
}

START_TEST(checkpoints)
{
    static const struct {
        const uint8_t *bytes;
        size_t n;
    } files[] = {
        { torch_zip, sizeof(torch_zip) }, { torch_stream, sizeof(torch_stream) }, { torch_tar, sizeof(torch_tar) },
        { torch_wrapped, sizeof(torch_wrapped) }, { torch_module, sizeof(torch_module) },
        { torch_module_stream, sizeof(torch_module_stream) }, { torch_other_order, sizeof(torch_other_order) },
    };
    lt_arena *arena = lt_arena_new();

    put_file(in_folder("x.pth"), files[_i].bytes, files[_i].n);
    ck_assert_int_gt(with_any_room(read_torch, in_folder("x.pth")), 0);
    lt_arena_free(arena);
}
END_TEST

/* What no writer takes is no checkpoint either, whoever asks. */
START_TEST(no_checkpoint)
{
    lt_arena *arena = lt_arena_new();

    put_file(in_folder("x.pth"), torch_bomb, sizeof(torch_bomb));
    ck_assert_int_eq(read_torch(arena, in_folder("x.pth")), LT_EFORMAT);
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_loop_test(tc, written_and_read, 0, LT_COUNT(kinds));
    tcase_add_loop_test(tc, without_a_folder, 0, WRITERS);
    tcase_add_loop_test(tc, without_a_disk, 0, WRITERS);
    tcase_add_loop_test(tc, checkpoints, 0, 7);
    tcase_add_test(tc, no_checkpoint);
}

int main(void)
{
    return run_suite("without_memory", add_tests);
}
