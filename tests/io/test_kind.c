/* SPDX-License-Identifier: Apache-2.0 */
/* First bytes as the formats' specifications have them, and as files on disk begin. */
#include "libtensor/io/kind.h"

#include "libtensor/io/array/npy.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/mesh/ply.h"
#include "libtensor/io/onnx/onnx.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/yaml.h"
#include "libtensor/io/torch/torch.h"
#include "libtensor/io/torch/weights_file.h"
#include "tests/io/io_vectors.h"
#include "tests/io/torch_vectors.h"
#include "tests/suite.h"

#include <cjson/cJSON.h>
#include <string.h>

#define BYTES(text) (const uint8_t *)(text), sizeof(text) - 1

static const struct {
    const uint8_t *bytes;
    size_t n;
    lt_kind kind;
} cases[] = {
    { BYTES(""), LT_KIND_EMPTY },
    { BYTES("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\n"), LT_KIND_LFS },
    { BYTES("\n <!DOCTYPE html><html>"), LT_KIND_HTML }, { BYTES("<HTML lang=en>"), LT_KIND_HTML },
    { BYTES("PK\3\4\x14\0\0\0"), LT_KIND_ZIP }, { BYTES("PK\5\6\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"), LT_KIND_ZIP },
    { BYTES("\x1f\x8b\x08\0\0\0\0\0\0\3"), LT_KIND_GZIP }, { BYTES("\xfd" "7zXZ\0\0\4"), LT_KIND_XZ },
    { BYTES("BZh91AY&SY"), LT_KIND_BZIP2 }, { BYTES("\x28\xb5\x2f\xfd\4\0"), LT_KIND_ZSTD },
    { BYTES("7z\xbc\xaf\x27\x1c\0\4"), LT_KIND_7Z }, { BYTES("Rar!\x1a\7\1\0"), LT_KIND_RAR },
    { BYTES("\x80\4\x95\x0b\0\0\0\0\0\0\0}."), LT_KIND_PICKLE }, { BYTES("\x80\2}q\0."), LT_KIND_PICKLE },
    { BYTES("\x40\0\0\0\0\0\0\0{\"w\":{}}"), LT_KIND_SAFETENSORS },
    { BYTES("\2\0\0\0\0\0\0\0{}"), LT_KIND_SAFETENSORS },
    { BYTES("\x93NUMPY\1\0v\0{'descr'"), LT_KIND_NPY }, { BYTES("\x89HDF\r\n\x1a\n"), LT_KIND_HDF5 },
    { BYTES("MATLAB 5.0 MAT-file"), LT_KIND_MATLAB }, { BYTES("\x89PNG\r\n\x1a\n\0\0\0\rIHDR"), LT_KIND_PNG },
    { BYTES("\xff\xd8\xff\xe1\0\0Exif"), LT_KIND_JPEG }, { BYTES("RIFF\0\0\0\0WEBPVP8 "), LT_KIND_WEBP },
    { BYTES("II*\0\x08\0\0\0"), LT_KIND_TIFF }, { BYTES("MM\0*\0\0\0\x08"), LT_KIND_TIFF },
    { BYTES("GIF89a"), LT_KIND_GIF },
    { BYTES("BM\x36\x0c\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\7\0\0\0\5\0\0\0"), LT_KIND_BMP },
    { BYTES("\0\0\0\x18" "ftypheic\0\0\0\0mif1"), LT_KIND_HEIC },
    { BYTES("\0\0\0\x1c" "ftypmif1\0\0\0\0"), LT_KIND_HEIC },
    { BYTES("\0\0\0\x1c" "ftypavif\0\0\0\0"), LT_KIND_AVIF }, { BYTES("\0\0\0\x20" "ftypisom\0\0\2\0"), LT_KIND_MP4 },
    { BYTES("\0\0\0\x14" "ftypqt  \0\0\2\0"), LT_KIND_MP4 }, { BYTES("\0\1\2\3moov\0\0\0\0"), LT_KIND_MP4 },
    { BYTES("\x1a\x45\xdf\xa3\x9f\x42\x86"), LT_KIND_MATROSKA }, { BYTES("RIFF\0\0\0\0AVI LIST"), LT_KIND_AVI },
    { BYTES("ply\nformat ascii 1.0\n"), LT_KIND_PLY }, { BYTES("ply\r\nformat"), LT_KIND_PLY },
    { BYTES("glTF\2\0\0\0"), LT_KIND_GLB }, { BYTES("%PDF-1.7"), LT_KIND_PDF },
    { BYTES(" {\"weight_map\": {}}"), LT_KIND_JSON }, { BYTES("[[1, 2]]"), LT_KIND_JSON },
    { BYTES("v 1 2 3\nf 1 2 3\n"), LT_KIND_UNKNOWN }, { BYTES("BM, a text"), LT_KIND_UNKNOWN },
    { BYTES("{"), LT_KIND_UNKNOWN }, { BYTES("\x80"), LT_KIND_UNKNOWN }, { BYTES("<htm"), LT_KIND_UNKNOWN },
    { BYTES("(dp0\nS'a'\n"), LT_KIND_UNKNOWN },
#define ZIP(length, name) BYTES("PK\3\4\x14\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0" length "\0\0\0" name)
    { ZIP("\x0a", "a/data.pkl"), LT_KIND_TORCH_ZIP }, { ZIP("\5", "x.npy"), LT_KIND_NPZ },
    { ZIP("\7", "x/a.txt"), LT_KIND_ZIP }, { ZIP("\x0b", "x/a.npy"), LT_KIND_ZIP }, { ZIP("\4", ".npz"), LT_KIND_ZIP },
    { BYTES("\x80\2\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19."), LT_KIND_TORCH_STREAM },
};

/* Read from an allocation of its size, so that a byte behind the end is seen by the sanitizers. */
START_TEST(kinds)
{
    uint8_t *copy = malloc(cases[_i].n + !cases[_i].n);

    memcpy(copy, cases[_i].bytes, cases[_i].n);
    ck_assert_msg(lt_kind_of(copy, cases[_i].n) == cases[_i].kind, "case %d: %s, want %s", _i,
                  lt_kind_name(lt_kind_of(copy, cases[_i].n)), lt_kind_name(cases[_i].kind));
    for (size_t n = 0; n < cases[_i].n; n++) {
        free(copy);
        copy = malloc(n + !n);
        memcpy(copy, cases[_i].bytes, n);
        ck_assert_ptr_nonnull(lt_kind_name(lt_kind_of(copy, n)));
    }
    free(copy);
}
END_TEST

START_TEST(tar)
{
    uint8_t block[512] = { 'a' };

    memcpy(block + 257, "ustar", 5);
    ck_assert_int_eq(lt_kind_of(block, sizeof(block)), LT_KIND_TAR);
    ck_assert_int_eq(lt_kind_of(block, 261), LT_KIND_UNKNOWN);
}
END_TEST

START_TEST(refusals)
{
    check_error(lt_refuse("a.heic", BYTES("\0\0\0\x18" "ftypheic"), "an image"), LT_EFORMAT,
                "a.heic: a HEIC image, want an image; set the camera to Most Compatible, or convert it to JPEG");
    check_error(lt_refuse("a.npy", BYTES("\x89PNG\r\n\x1a\n"), "a .npy array"), LT_EFORMAT,
                "a.npy: a PNG image, want a .npy array");
    check_error(lt_refuse("a.npy", BYTES("what"), "a .npy array"), LT_EFORMAT, "a.npy: not a .npy array");
}
END_TEST

/* ---- every reader -------------------------------------------------------------------------------------- */

static lt_status read_json(lt_arena *arena, const char *path)
{
    cJSON *root = NULL;
    const lt_status st = lt_json_read(path, &root);

    (void)arena;
    cJSON_Delete(root);
    return st;
}

#define READER(name, type, call) static lt_status name(lt_arena *arena, const char *path) { type x; return call; }

READER(read_image, lt_image, lt_image_read(arena, path, &x))
READER(read_yaml, const lt_yaml *, lt_yaml_read(arena, path, &x))
READER(read_obj, lt_mesh, lt_obj_read(arena, path, &x, NULL))
READER(read_ply, lt_ply, lt_ply_read(arena, path, &x))
READER(read_onnx, lt_onnx_model, lt_onnx_read(arena, path, &x))
READER(read_npy, lt_array, lt_npy_read(arena, path, &x))
READER(read_npz, lt_npz, lt_npz_read(arena, path, &x))
READER(read_safetensors, lt_safetensors, lt_safetensors_read(arena, path, &x))
READER(read_pickle, const lt_pvalue *, lt_pickle_read(arena, path, &x))
READER(read_torch, lt_torch_file, lt_torch_read(arena, path, &x))
READER(read_weights, lt_weights_file, lt_weights_read(arena, path, &x))

static lt_status read_xyz(lt_arena *arena, const char *path)
{
    float (*points)[3];
    size_t n;

    return lt_xyz_read(arena, path, &points, &n);
}

static lt_status (*const readers[])(lt_arena *arena, const char *path) = {
    read_json, read_yaml, read_obj, read_ply, read_xyz, read_onnx, read_npy, read_npz, read_safetensors, read_pickle,
    read_torch, read_weights,
};

/* What stands in a file's place has a name, whoever is to read it. */
START_TEST(every_reader)
{
    static const struct {
        const uint8_t *bytes;
        size_t n;
        const char *what;
    } others[] = {
        { BYTES("<!DOCTYPE html><html>not found</html>"), "an HTML page in the place of a file, want " },
        { BYTES("version https://git-lfs.github.com/spec/v1\n"), "a git-lfs pointer in the place of a file, want " },
        { BYTES("\x1f\x8b\x08\0\0\0\0\0\0\3"), "a gzip file, want " },
        { BYTES("\x89HDF\r\n\x1a\n"), "an HDF5 file, want " },
        { BYTES("\x89PNG\r\n\x1a\n\0\0\0\rIHDR"), "a PNG image, want " },
        { BYTES("\0\0\0\x18" "ftypheic\0\0\0\0mif1"), "a HEIC image, want " },
        { BYTES("%PDF-1.7\n"), "a PDF document, want " },
    };
    lt_arena *arena = lt_arena_new();

    for (size_t i = 0; i < LT_COUNT(others); i++) {
        put_file(in_folder("x"), others[i].bytes, others[i].n);
        check_error(readers[_i](arena, in_folder("x")), LT_EFORMAT, others[i].what);
    }
    lt_arena_free(arena);
}
END_TEST

/* A download that broke off is called that, at whichever third it did. */
START_TEST(cut_short)
{
    static const struct {
        const uint8_t *bytes;
        size_t n;
        lt_status (*read)(lt_arena *arena, const char *path);
    } files[] = {
        { torch_zip, sizeof(torch_zip), read_torch }, { torch_stream, sizeof(torch_stream), read_weights },
        { torch_tar, sizeof(torch_tar), read_torch }, { npz_deflated, sizeof(npz_deflated), read_npz },
        { npy_fortran, sizeof(npy_fortran), read_npy }, { pickle_4, sizeof(pickle_4), read_pickle },
        { pickle_0, sizeof(pickle_0), read_pickle }, { png_rgb, sizeof(png_rgb), read_image },
        { jpeg_gray, sizeof(jpeg_gray), read_image }, { jpeg_progressive, sizeof(jpeg_progressive), read_image },
    };
    lt_arena *arena = lt_arena_new();

    for (size_t third = 1; third < 3; third++) {
        put_file(in_folder("x"), files[_i].bytes, files[_i].n * third / 3);
        check_error(files[_i].read(arena, in_folder("x")), LT_EFORMAT, "cut short");
        ck_assert_ptr_nonnull(strstr(lt_last_error(), "download it again"));
    }
    lt_arena_free(arena);
}
END_TEST

START_TEST(files)
{
    put_file(in_folder("a.jpg"), "%PDF-1.7", 8);
    ck_assert_int_eq(lt_kind_of_file(in_folder("a.jpg")), LT_KIND_PDF);
    ck_assert_int_eq(lt_kind_of_file(in_folder("none")), LT_KIND_UNKNOWN);
    ck_assert_int_eq(lt_kind_of_file(scratch_folder), LT_KIND_UNKNOWN);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_loop_test(tc, kinds, 0, (int)LT_COUNT(cases));
    tcase_add_test(tc, tar);
    tcase_add_test(tc, refusals);
    tcase_add_loop_test(tc, every_reader, 0, (int)LT_COUNT(readers));
    tcase_add_loop_test(tc, cut_short, 0, 10);
    tcase_add_test(tc, files);
}

int main(void)
{
    return run_suite("kind", add_tests);
}
