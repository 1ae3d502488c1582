/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays, .npy and .npz: against NumPy's own files, and against damage. */
#include "libtensor/io/array/npy.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/file.h"
#include "tests/io/hostile.h"
#include "tests/io/io_vectors.h"

#include <math.h>

static lt_status read_npy(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_array a;

    return lt_npy_parse(arena, "x.npy", bytes, n, &a);
}

static lt_status read_npz(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_npz npz;

    return lt_npz_parse(arena, "x.npz", bytes, n, &npz);
}

/* data.md 6.3: 1.0, -2.5, 0.1, 65504; and every 16-bit float there and back */
/* Each element type as a number and as a whole one; what no number is. */
START_TEST(elements)
{
    static const int64_t one[1] = { 1 };
    const uint16_t half = 0xc000, brain = 0xc000;               /* -2 in both */
    const double huge = 1e300;
    const uint64_t most = UINT64_MAX;
    const int64_t minus = -2;
    const struct {
        lt_elem type;
        const void *data;
        double value;
        int64_t whole;
    } cases[] = {
        { LT_ELEM_F2, &half, -2, -2 }, { LT_ELEM_BF16, &brain, -2, -2 }, { LT_ELEM_F8, &huge, 1e300, INT64_MIN },
        { LT_ELEM_U8, &most, 0x1p64, INT64_MIN }, { LT_ELEM_I8, &minus, -2, -2 }, { LT_ELEM_I1, &minus, -2, -2 },
        { LT_ELEM_I2, &minus, -2, -2 }, { LT_ELEM_I4, &minus, -2, -2 }, { LT_ELEM_U1, &minus, 254, 254 },
        { LT_ELEM_U2, &minus, 65534, 65534 }, { LT_ELEM_U4, &minus, 0x1p32 - 2, 4294967294 },
    };
    char text[4];
    lt_array a;
    size_t bytes;

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        a = lt_array_make(cases[i].type, 1, one, cases[i].data);
        ck_assert_msg(lt_array_get(&a, 0) == cases[i].value, "%s", lt_elem_name(a.type));
        ck_assert_msg(lt_array_int(&a, 0) == cases[i].whole, "%s", lt_elem_name(a.type));
        ck_assert(!lt_array_text(&a, 0) && !lt_array_has_shape(&a, 0, NULL) && lt_array_bytes(&a, &bytes));
    }
    a.shape[0] = -1;
    ck_assert(!lt_array_bytes(&a, &bytes));
    a = lt_array_make(LT_ELEM_F8, 2, (int64_t[]){ INT64_MAX, 3 }, NULL);
    ck_assert(!lt_array_bytes(&a, &bytes));
    ck_assert_str_eq(lt_array_shape_text(&a, text, sizeof(text)), "(92");
}
END_TEST

START_TEST(halves)
{
    ck_assert_uint_eq(lt_f32_to_f16(1.0f), 0x3c00);
    ck_assert_uint_eq(lt_f32_to_f16(-2.5f), 0xc100);
    ck_assert_uint_eq(lt_f32_to_f16(0.1f), 0x2e66);
    ck_assert_uint_eq(lt_f32_to_f16(65504.0f), 0x7bff);
    ck_assert_uint_eq(lt_f32_to_f16(65519.99f), 0x7bff);
    ck_assert_uint_eq(lt_f32_to_f16(65520.0f), 0x7c00);
    ck_assert_uint_eq(lt_f32_to_f16(0x1p-25f), 0);              /* a tie, to even */
    ck_assert_uint_eq(lt_f32_to_f16(0x1.8p-24f), 2);
    ck_assert_uint_eq(lt_f32_to_f16(0x1.ffcp-15f), 0x3ff + 1);  /* rounds up into the normal ones */
    ck_assert_uint_eq(lt_f32_to_bf16(0.1f), 0x3dcd);
    for (uint32_t h = 0; h < 0x10000; h++) {
        const float x = lt_f16_to_f32((uint16_t)h), y = lt_bf16_to_f32((uint16_t)h);

        if (isnan(x))
            ck_assert(isnan(lt_f16_to_f32(lt_f32_to_f16(x))));
        else
            ck_assert_uint_eq(lt_f32_to_f16(x), h);
        if (isnan(y))
            ck_assert(isnan(lt_bf16_to_f32(lt_f32_to_bf16(y))));
        else
            ck_assert_uint_eq(lt_f32_to_bf16(y), h);
    }
}
END_TEST

START_TEST(integers)
{
    const double f[4] = { NAN, 1e300, -3.7, 5 };
    const uint64_t u[2] = { UINT64_MAX, 7 };
    const lt_array a = lt_array_make(LT_ELEM_F8, 1, (int64_t[]){ 4 }, f);
    const lt_array b = lt_array_make(LT_ELEM_U8, 1, (int64_t[]){ 2 }, u);
    char text[8];

    ck_assert_int_eq(lt_array_int(&a, 0), INT64_MIN);
    ck_assert_int_eq(lt_array_int(&a, 1), INT64_MIN);
    ck_assert_int_eq(lt_array_int(&a, 2), -3);
    ck_assert_int_eq(lt_array_int(&b, 0), INT64_MIN);
    ck_assert_int_eq(lt_array_int(&b, 1), 7);
    ck_assert(lt_array_has_shape(&a, 1, (int64_t[]){ -1 }) && !lt_array_has_shape(&a, 1, (int64_t[]){ 5 }));
    ck_assert_str_eq(lt_array_shape_text(&a, text, sizeof(text)), "(4)");
    ck_assert_str_eq(lt_array_shape_text(&a, text, 3), "(4");
}
END_TEST

/* data.md 6.1 */
START_TEST(spec_npy)
{
    static const uint8_t head[] = { 0x93, 0x4e, 0x55, 0x4d, 0x50, 0x59, 1, 0, 0x76, 0, 0x7b, 0x27 };
    static const uint8_t tail[] = { 0, 0, 0xc0, 0x3f, 0, 0, 0, 0xc0 };
    const float x[2] = { 1.5f, -2.0f };
    const lt_array a = lt_array_make(LT_ELEM_F4, 1, (int64_t[]){ 2 }, x);
    lt_arena *arena = lt_arena_new();
    uint8_t bytes[200];
    lt_array back;
    FILE *f;

    check_ok(lt_npy_write(in_folder("a.npy"), &a));
    f = fopen(in_folder("a.npy"), "rb");
    ck_assert_uint_eq(fread(bytes, 1, sizeof(bytes), f), 136);
    fclose(f);
    ck_assert_mem_eq(bytes, head, sizeof(head));
    ck_assert_mem_eq(bytes + 128, tail, sizeof(tail));
    check_ok(lt_npy_read(arena, in_folder("a.npy"), &back));
    ck_assert(back.type == LT_ELEM_F4 && lt_array_has_shape(&back, 1, a.shape));
    ck_assert_mem_eq(back.data, x, sizeof(x));
    check_truncated(read_npy, bytes, 136, 0);
    check_flipped(read_npy, bytes, 136, 3000);
    lt_arena_free(arena);
}
END_TEST

START_TEST(foreign_npy)
{
    lt_arena *arena = lt_arena_new();
    lt_array a;

    check_ok(lt_npy_parse(arena, "f", npy_fortran, sizeof(npy_fortran), &a));
    ck_assert(lt_array_has_shape(&a, 3, (int64_t[]){ 2, 3, 4 }));
    for (size_t i = 0; i < 24; i++)
        ck_assert_int_eq(lt_array_int(&a, i), (int64_t)i);
    check_ok(lt_npy_parse(arena, "v2", npy_v2, sizeof(npy_v2), &a));
    ck_assert(a.type == LT_ELEM_F8 && lt_array_get(&a, 2) == 2);
    check_ok(lt_npy_parse(arena, "v3", npy_v3, sizeof(npy_v3), &a));
    ck_assert(a.type == LT_ELEM_U1 && lt_array_get(&a, 2) == 2);
    check_refused(read_npy, npy_complex, sizeof(npy_complex), "complex");
    check_refused(read_npy, npy_struct, sizeof(npy_struct), "structures");
    check_truncated(read_npy, npy_v2, sizeof(npy_v2), 0);
    check_flipped(read_npy, npy_fortran, sizeof(npy_fortran), 3000);
    lt_arena_free(arena);
}
END_TEST

/* A .npy file with this header text. */
static size_t make_npy(uint8_t out[512], const char *header, size_t data)
{
    const size_t n = strlen(header);

    memcpy(out, "\x93NUMPY\1\0", 8);
    out[8] = (uint8_t)n;
    out[9] = (uint8_t)(n >> 8);
    memcpy(out + 10, header, n);
    memset(out + 10 + n, 1, data);
    return 10 + n + data;
}

START_TEST(npy_headers)
{
    static const struct {
        const char *header, *reason;            /* NULL: read */
    } cases[] = {
        { "{'shape': (2L,), 'descr': '|u1', 'fortran_order': False}\n", NULL },
        { "{\"descr\":\"|u1\",\"fortran_order\":True,\"shape\":()}", NULL },
        { "{'descr': '|b1', 'fortran_order': False, 'shape': (0, 2000000000), }", NULL },
        { "{'descr': '<f4', 'fortran_order': False, 'shape': (2147483647, 2147483647), }", "more than" },
        { "{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999,), }", "below 2^31" },
        { "{'descr': '<f4', 'fortran_order': False, 'shape': (1000000,), }", "ends early" },
        { "{'descr': '<f4', 'fortran_order': False, 'shape': (-1,), }", "no number" },
        { "{'descr': '<f4', 'fortran_order': False, 'shape': (1,1,1,1,1,1,1,1,1), }", "more than 8" },
        { "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }", "Python objects" },
        { "{'descr': '<f3', 'fortran_order': False, 'shape': (1,), }", "not read" },
        { "{'descr': '<U9999999', 'fortran_order': False, 'shape': (1,), }", "million" },
        { "{'descr': '<U0', 'fortran_order': False, 'shape': (2000000000,), }", "no characters" },
        { "{'descr': '<f4', 'fortran_order': 0, 'shape': (1,), }", "neither True nor False" },
        { "{'descr': '<f4', 'fortran_order': False, }", "lacks" },
        { "{'descr': '<f4', 'descr': '<f4', 'fortran_order': False, 'shape': (1,)}", "twice" },
        { "{'evil': __import__('os').system('x')}", "none of descr" },
        { "[1]", "no dict" }, { "", "no dict" }, { "{'descr", "string keys" },
    };
    uint8_t bytes[512];

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        const size_t n = make_npy(bytes, cases[i].header, 2);

        if (cases[i].reason)
            check_refused(read_npy, bytes, n, cases[i].reason);
        else
            check_ok(attempt(read_npy, bytes, n));
    }
}
END_TEST

START_TEST(foreign_npz)
{
    lt_arena *arena = lt_arena_new();
    const lt_array *a;
    lt_npz npz;

    check_ok(lt_npz_parse(arena, "n.npz", npz_deflated, sizeof(npz_deflated), &npz));
    ck_assert_uint_eq(npz.n, 4);
    ck_assert_uint_eq(npz.n_refused, 1);
    check_ok(lt_npz_get(&npz, "a", &a));
    ck_assert(lt_array_has_shape(a, 2, (int64_t[]){ 3, 2 }) && lt_array_get(a, 1) == 3);
    check_ok(lt_npz_get(&npz, "be", &a));
    ck_assert(a->type == LT_ELEM_I4 && lt_array_get(a, 3) == 3);
    check_ok(lt_npz_get(&npz, "u", &a));
    ck_assert_str_eq(lt_array_text(a, 0), "synthetic");
    check_error(lt_npz_get(&npz, "o", &a), LT_EFORMAT, "n.npz: \"o\": elements are Python objects");
    check_error(lt_npz_get(&npz, "no", &a), LT_EFORMAT, "n.npz: no array \"no\"");
    check_truncated(read_npz, npz_deflated, sizeof(npz_deflated), 0);
    check_truncated(read_npz, npz_stored, sizeof(npz_stored), 0);
    check_flipped(read_npz, npz_deflated, sizeof(npz_deflated), 5000);
    check_flipped(read_npz, npz_stored, sizeof(npz_stored), 5000);
    lt_arena_free(arena);
}
END_TEST

static void write_sample(const char *path, bool deflate)
{
    static const char *const words[3] = { "a", "\xc3\xa9\xe2\x82\xac", "" };
    static const float x[6] = { 1, 2, 3, 4, 5, 6 };
    static const uint8_t flags[2] = { 1, 0 };
    const lt_named_array list[] = {
        { "x", lt_array_make(LT_ELEM_F4, 2, (int64_t[]){ 2, 3 }, x) },
        { "words", lt_array_make(LT_ELEM_TEXT, 1, (int64_t[]){ 3 }, words) },
        { "flags", lt_array_make(LT_ELEM_BOOL, 1, (int64_t[]){ 2 }, flags) },
        { "nothing", lt_array_make(LT_ELEM_I8, 2, (int64_t[]){ 0, 5 }, NULL) },
        { "scalar", lt_array_make(LT_ELEM_F4, 0, NULL, x) },
    };

    check_ok(lt_npz_write(path, list, LT_COUNT(list), deflate));
}

START_TEST(npz_round_trip)
{
    const bool deflate = _i == 1;
    lt_arena *arena = lt_arena_new();
    const lt_array *words;
    lt_npz npz;
    FILE *a, *b;
    int c;

    write_sample(in_folder("r.npz"), deflate);
    check_ok(lt_npz_read(arena, in_folder("r.npz"), &npz));
    ck_assert_uint_eq(npz.n, 5);
    ck_assert_str_eq(npz.entry[0].name, "x");
    ck_assert(lt_array_get(&npz.entry[0].array, 5) == 6);
    words = lt_npz_find(&npz, "words");
    ck_assert_str_eq(lt_array_text(words, 1), "\xc3\xa9\xe2\x82\xac");
    ck_assert_str_eq(lt_array_text(words, 2), "");
    ck_assert_int_eq(lt_npz_find(&npz, "scalar")->rank, 0);
    ck_assert_uint_eq(lt_array_count(lt_npz_find(&npz, "nothing")), 0);
    check_ok(lt_npz_read_only(arena, in_folder("r.npz"), (const char *const[]){ "words", "none", "x" }, 3, &npz));
    ck_assert_uint_eq(npz.n, 2);
    ck_assert(lt_array_get(lt_npz_find(&npz, "x"), 5) == 6);
    ck_assert_ptr_null(lt_npz_find(&npz, "scalar"));
    check_ok(lt_npz_read_only(arena, in_folder("r.npz"), (const char *const[]){ "word" }, 1, &npz));
    ck_assert_uint_eq(npz.n, 0);

    write_sample(in_folder("again.npz"), deflate);              /* the same bytes, whatever the date */
    a = fopen(in_folder("r.npz"), "rb");
    b = fopen(in_folder("again.npz"), "rb");
    while ((c = fgetc(a)) != EOF)
        ck_assert_int_eq(fgetc(b), c);
    ck_assert_int_eq(fgetc(b), EOF);
    fclose(a);
    fclose(b);
    lt_arena_free(arena);
}
END_TEST

/* Keys that look like paths are keys; one with ".." is refused. */
START_TEST(npz_keys)
{
    static const char *const names[] = { "/w:0", "w:ab", "//ab", "a../", "../a" };
    static const float data[1] = { 7 };
    const lt_array a = lt_array_make(LT_ELEM_F4, 0, NULL, data);
    const char *path = in_folder("keys.npz");
    lt_arena *arena = lt_arena_new();
    uint8_t *bytes;
    lt_npz z;
    size_t n;

    check_ok(lt_npz_write(path, &(lt_named_array){ "abcd", a }, 1, false));
    check_ok(lt_read_file(arena, path, LT_FILE_MAX, &bytes, &n));
    for (size_t i = 0; i < LT_COUNT(names); i++) {
        for (size_t at = 0; at + 8 <= n; at++)
            if (memcmp(bytes + at, i ? names[i - 1] : "abcd", 4) == 0 && memcmp(bytes + at + 4, ".npy", 4) == 0)
                memcpy(bytes + at, names[i], 4);
        if (i + 1 == LT_COUNT(names)) {
            check_error(lt_npz_parse(arena, "k", bytes, n, &z), LT_EFORMAT, "entry whose name is no path inside");
        } else {
            check_ok(lt_npz_parse(arena, "k", bytes, n, &z));
            ck_assert_str_eq(z.entry[0].name, names[i]);
        }
    }
    lt_arena_free(arena);
}
END_TEST

START_TEST(npz_not_written)
{
    const float x = 1;
    const lt_array f4 = lt_array_make(LT_ELEM_F4, 0, NULL, &x), b16 = lt_array_make(LT_ELEM_BF16, 0, NULL, &x);
    const char *path = in_folder("not.npz");

    check_error(lt_npz_write(path, NULL, 0, false), LT_EINVAL, "no arrays");
    check_error(lt_npz_write(path, &(lt_named_array){ "a b", f4 }, 1, false), LT_EINVAL, "array name");
    check_error(lt_npz_write(path, &(lt_named_array){ "", f4 }, 1, false), LT_EINVAL, "array name \"\"");
    check_error(lt_npz_write(path, &(lt_named_array){ "b", b16 }, 1, false), LT_EINVAL, "bf16");
    check_error(lt_npz_write(path, (lt_named_array[]){ { "a", f4 }, { "a", f4 } }, 2, false), LT_EINVAL, "two arrays");
    check_error(lt_npz_write("/nonexistent/a.npz", &(lt_named_array){ "a", f4 }, 1, false), LT_EIO, "No such");
    ck_assert(!exists(path));
}
END_TEST

/* The central directory of npz_stored claims other sizes than the data has. */
START_TEST(zip_lies)
{
    uint8_t bytes[sizeof(npz_stored)];
    size_t central = 0;

    memcpy(bytes, npz_stored, sizeof(bytes));
    for (size_t i = 0; i + 4 < sizeof(bytes); i++)
        if (memcmp(bytes + i, "PK\1\2", 4) == 0)
            central = i;
    ck_assert_uint_gt(central, 0);
    bytes[central + 27] = 0x7f;                 /* unpacked size: 2 GB, stored */
    check_refused(read_npz, bytes, sizeof(bytes), "");
    bytes[central + 10] = 8;                    /* the same, deflated: a bomb */
    check_refused(read_npz, bytes, sizeof(bytes), "");
    memcpy(bytes, npz_stored, sizeof(bytes));
    bytes[central + 8] |= 1;                    /* encrypted */
    check_refused(read_npz, bytes, sizeof(bytes), "encrypted");
    memcpy(bytes, npz_stored, sizeof(bytes));
    bytes[central + 10] = 12;                   /* bzip2 */
    check_refused(read_npz, bytes, sizeof(bytes), "another way");
    memcpy(bytes, npz_stored, sizeof(bytes));
    bytes[central - 1] ^= 1;                    /* the last element's last byte */
    check_refused(read_npz, bytes, sizeof(bytes), "checksum");
    memcpy(bytes, npz_stored, sizeof(bytes));
    bytes[central + 46] = '\\';                 /* the name */
    bytes[30] = '\\';
    check_refused(read_npz, bytes, sizeof(bytes), "name");
}
END_TEST

/* Ten megabytes of zeros pack a thousandfold: honest, so read, and charged to nobody but its arena. */
START_TEST(big_zeros)
{
    const size_t n = 10 << 20;
    uint8_t *zeros = calloc(n, 1);
    lt_arena *arena = lt_arena_new();
    lt_npz npz;

    check_ok(lt_npz_write(in_folder("zeros.npz"),
                          &(lt_named_array){ "z", lt_array_make(LT_ELEM_U1, 1, (int64_t[]){ 10 << 20 }, zeros) },
                          1, true));
    check_ok(lt_npz_read(arena, in_folder("zeros.npz"), &npz));
    ck_assert_uint_eq(lt_array_count(&npz.entry[0].array), n);
    lt_arena_free(arena);
    free(zeros);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, elements);
    tcase_add_test(tc, halves);
    tcase_add_test(tc, integers);
    tcase_add_test(tc, spec_npy);
    tcase_add_test(tc, foreign_npy);
    tcase_add_test(tc, npy_headers);
    tcase_add_test(tc, foreign_npz);
    tcase_add_loop_test(tc, npz_round_trip, 0, 2);
    tcase_add_test(tc, npz_not_written);
    tcase_add_test(tc, npz_keys);
    tcase_add_test(tc, zip_lies);
    tcase_add_test(tc, big_zeros);
}

int main(void)
{
    return run_suite("numpy", add_tests);
}
