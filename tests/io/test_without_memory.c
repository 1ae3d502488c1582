/* SPDX-License-Identifier: Apache-2.0 */
/* Writers and readers of whole files while the first allocation fails, the second, and so on: one line, and no
 * file where there was none. What parses bytes in memory is tested so by tests/fuzz/replay. */
#include "libtensor/io/image.h"
#include "libtensor/io/mesh_io.h"
#include "libtensor/io/npy.h"
#include "libtensor/io/npz.h"
#include "libtensor/io/pickle.h"
#include "libtensor/io/ply.h"
#include "libtensor/io/safetensors.h"
#include "libtensor/io/weights_file.h"
#include "tests/io/hostile.h"
#include "tests/io/torch_vectors.h"

static float numbers[6] = { 1, 2, 3, 4, 5, 6 };
static const char *words[2] = { "a", "\xc3\xa9" };
static int32_t triangle[1][3] = { { 0, 1, 0 } };
static uint8_t pixels[12];
static const int64_t two_by_three[2] = { 2, 3 }, two[1] = { 2 };

static lt_mesh mesh(void)
{
    return (lt_mesh){ .n_vertices = 2, .n_faces = 1, .vertex = (float (*)[3])numbers, .face = triangle };
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
    return lt_xyz_write(path, (const float (*)[3])numbers, 2);
}

static lt_status write_png(lt_arena *arena, const char *path)
{
    (void)arena;
    return lt_png_write(path, &(lt_image){ .width = 2, .height = 2, .channels = 3, .bits = 8, .data = pixels });
}

static lt_status write_jpeg(lt_arena *arena, const char *path)
{
    (void)arena;
    return lt_jpeg_write(path, &(lt_image){ .width = 2, .height = 2, .channels = 3, .bits = 8, .data = pixels }, 90);
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
    { write_png, read_image }, { write_jpeg, read_image },
};

/* How often it failed before it did not. */
static int until_it_works(lt_status (*call)(lt_arena *, const char *), const char *path)
{
    for (long at = 1; at < 1000; at++) {
        lt_arena *arena = lt_arena_new();
        lt_status st;

        lt_alloc_fail_at(at);
        st = call(arena, path);
        lt_alloc_fail_at(0);
        lt_arena_free(arena);
        if (st == LT_OK)
            return (int)at - 1;
        ck_assert_msg(st == LT_ENOMEM, "%s", lt_last_error());
    }
    ck_abort_msg("never succeeded");
}

START_TEST(written_and_read)
{
    const char *path = in_folder("file");

    until_it_works(kinds[_i].write, path);
    ck_assert(exists(path));
    ck_assert_int_gt(until_it_works(kinds[_i].read, path), 0);
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
    ck_assert_int_gt(until_it_works(read_torch, in_folder("x.pth")), 0);
    lt_arena_free(arena);
}
END_TEST

/* What no writer takes is no checkpoint either, whoever asks. */
START_TEST(no_checkpoint)
{
    static const struct {
        const uint8_t *bytes;
        size_t n;
    } files[] = {
        { torch_bomb, sizeof(torch_bomb) }, { torch_sparse, sizeof(torch_sparse) },
        { torch_complex, sizeof(torch_complex) }, { torch_script, sizeof(torch_script) },
    };
    lt_arena *arena = lt_arena_new();

    for (size_t i = 0; i < LT_COUNT(files); i++) {
        put_file(in_folder("x.pth"), files[i].bytes, files[i].n);
        ck_assert_int_eq(read_torch(arena, in_folder("x.pth")), LT_EFORMAT);
    }
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_loop_test(tc, written_and_read, 0, LT_COUNT(kinds));
    tcase_add_loop_test(tc, checkpoints, 0, 7);
    tcase_add_test(tc, no_checkpoint);
}

int main(void)
{
    return run_suite("without_memory", add_tests);
}
