/* SPDX-License-Identifier: Apache-2.0 */
/* safetensors: the format's own sample, round trips, and headers that lie. */
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/file.h"
#include "tests/io/hostile.h"

static lt_status read_it(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_safetensors s;

    return lt_safetensors_parse(arena, "x.safetensors", bytes, n, &s);
}

/* A file with this header and so many bytes of data. */
static size_t make(uint8_t out[1024], const char *header, size_t data)
{
    const size_t n = strlen(header);

    memset(out, 0, 8);
    out[0] = (uint8_t)n;
    out[1] = (uint8_t)(n >> 8);
    memcpy(out + 8, header, n);
    memset(out + 8 + n, 0, data);
    return 8 + n + data;
}

/* data.md 6.5: F32 [1.5, -2.0] named t */
START_TEST(spec_vector)
{
    static const char header[] = "{\"t\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]}}  ";
    lt_arena *arena = lt_arena_new();
    uint8_t bytes[1024];
    size_t n = make(bytes, header, 8);
    lt_safetensors s;
    const lt_array *t;

    memcpy(bytes + n - 8, "\0\0\xc0\x3f\0\0\0\xc0", 8);
    ck_assert_uint_eq(n, 72);
    check_ok(lt_safetensors_parse(arena, "spec", bytes, n, &s));
    t = lt_safetensors_find(&s, "t");
    ck_assert(t->type == LT_ELEM_F4 && lt_array_get(t, 0) == 1.5 && lt_array_get(t, 1) == -2);
    ck_assert_ptr_null(lt_safetensors_find(&s, "u"));
    check_truncated(read_it, bytes, n, 0);
    check_flipped(read_it, bytes, n, 5000);
    lt_arena_free(arena);
}
END_TEST

START_TEST(round_trip)
{
    static const float w[3] = { 1, 2, 3 };
    static const uint16_t h[1] = { 0x3dcd };
    static const uint8_t b[3] = { 1, 0, 1 };
    static const int64_t big[1] = { INT64_MIN };
    const lt_named_array list[] = {
        { "flags", lt_array_make(LT_ELEM_BOOL, 1, (int64_t[]){ 3 }, b) },       /* leaves w unaligned */
        { "layer.\"w\"\n", lt_array_make(LT_ELEM_F4, 2, (int64_t[]){ 3, 1 }, w) },
        { "empty", lt_array_make(LT_ELEM_F8, 1, (int64_t[]){ 0 }, NULL) },
        { "half", lt_array_make(LT_ELEM_BF16, 0, NULL, h) },
        { "big", lt_array_make(LT_ELEM_I8, 1, (int64_t[]){ 1 }, big) },
    };
    const lt_text_pair meta[] = { { "model", "hoca\xc3\xa9" }, { "step", "7" } };
    lt_arena *arena = lt_arena_new();
    lt_safetensors s;
    uint8_t *bytes;
    size_t n;

    check_ok(lt_safetensors_write(in_folder("a"), list, LT_COUNT(list), meta, 2));
    check_ok(lt_safetensors_read(arena, in_folder("a"), &s));
    ck_assert_uint_eq(s.n, 5);
    ck_assert_str_eq(lt_safetensors_meta(&s, "model"), "hoca\xc3\xa9");
    ck_assert_ptr_null(lt_safetensors_meta(&s, "no"));
    for (size_t i = 0; i < s.n; i++) {
        size_t size;

        ck_assert_str_eq(s.entry[i].name, list[i].name);
        ck_assert(s.entry[i].array.type == list[i].array.type);
        ck_assert(lt_array_has_shape(&s.entry[i].array, list[i].array.rank, list[i].array.shape));
        ck_assert(lt_array_bytes(&list[i].array, &size));
        if (size)
            ck_assert_mem_eq(s.entry[i].array.data, list[i].array.data, size);
    }
    check_ok(lt_read_file(arena, in_folder("a"), 10000, &bytes, &n));
    ck_assert_uint_eq((8 + bytes[0] + 256u * bytes[1]) % 64, 0);
    check_truncated(read_it, bytes, n, 0);
    check_flipped(read_it, bytes, n, 5000);
    lt_arena_free(arena);
}
END_TEST

START_TEST(lies)
{
#define T(place) "{\"a\":{\"dtype\":\"U8\",\"shape\":[4],\"data_offsets\":[0,4]}," \
                 "\"b\":{\"dtype\":\"U8\",\"shape\":[4],\"data_offsets\":" place "}}"
    static const struct {
        const char *header, *reason;
        size_t data;
    } cases[] = {
        { T("[4,8]"), NULL, 8 }, { T("[4,8]"), "cover 8", 9 }, { T("[4,8]"), "outside the data", 7 },
        { T("[3,7]"), "no gaps", 8 }, { T("[5,9]"), "no gaps", 9 }, { T("[8,4]"), "outside", 8 },
        { T("[4,\"8\"]"), "no two numbers", 8 }, { T("{}"), "no two numbers", 8 },
        { "{\"a\":{\"dtype\":\"U8\",\"shape\":[\"1\"],\"data_offsets\":[0,1]}}", "no number below 2^31", 1 },
        { "{\"a\":{\"dtype\":\"U8\",\"shape\":[2147483648],\"data_offsets\":[0,1]}}", "no number below 2^31", 1 },
        { "{\"b\":{\"dtype\":\"U8\",\"shape\":[1],\"data_offsets\":[1,2]},"
          "\"a\":{\"dtype\":\"U8\",\"shape\":[1],\"data_offsets\":[0,1]}}", NULL, 2 },
        { "{\"b\":{\"dtype\":\"U8\",\"shape\":[1],\"data_offsets\":[0,1]},"
          "\"a\":{\"dtype\":\"U8\",\"shape\":[0],\"data_offsets\":[0,0]}}", NULL, 1 },
        { "{\"b\":{\"dtype\":\"U8\",\"shape\":[0],\"data_offsets\":[0,0]},"
          "\"a\":{\"dtype\":\"U8\",\"shape\":[1],\"data_offsets\":[0,1]}}", NULL, 1 },
        { "{\"b\":{\"dtype\":\"U8\",\"shape\":[0],\"data_offsets\":[0,0]},"
          "\"a\":{\"dtype\":\"U8\",\"shape\":[0],\"data_offsets\":[0,0]}}", NULL, 0 },
        { T("[4,9]"), "disagree", 9 }, { T("[4]"), "no two numbers", 8 }, { T("[4.5,8.5]"), "no two", 9 },
        { T("[-4,0]"), "no two numbers", 8 }, { T("[1e300,1e300]"), "no two numbers", 8 },
        { "{\"a\":{\"dtype\":\"U8\",\"shape\":[0],\"data_offsets\":[0,0]},"
          "\"a\":{\"dtype\":\"U8\",\"shape\":[0],\"data_offsets\":[0,0]}}", "two entries named \"a\"", 0 },
        { "{\"a\":{\"dtype\":\"F8_E4M3\",\"shape\":[1],\"data_offsets\":[0,2]}}", "outside the data, up to 2 of 1", 1 },
        { "{\"a\":{\"dtype\":5,\"shape\":[1],\"data_offsets\":[0,1]}}", "\"a\": dtype is no text", 1 },
        { "{\"a\":{\"dtype\":\"U8\",\"shape\":[1,1,1,1,1,1,1,1,1],\"data_offsets\":[0,1]}}", "more than 8", 1 },
        { "{\"a\":{\"dtype\":\"U8\",\"shape\":[2147483647,2147483647,2147483647],\"data_offsets\":[0,1]}}",
          "disagree", 1 },
        { "{\"a\":{\"dtype\":\"U8\",\"shape\":5,\"data_offsets\":[0,1]}}", "no array", 1 },
        { "{\"a\":5}", "no object", 0 }, { "{\"__metadata__\":{\"k\":5}}", "map of strings", 0 },
        { "{\"__metadata__\":[\"k\"]}", "", 0 }, { "{\"a\":", "not valid JSON", 0 }, { "{}", NULL, 0 },
        { "[]", "not a safetensors", 0 },
    };
    uint8_t bytes[1024];

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        const size_t n = make(bytes, cases[i].header, cases[i].data);

        if (cases[i].reason)
            check_refused(read_it, bytes, n, cases[i].reason);
        else
            check_ok(attempt(read_it, bytes, n));
    }
    memset(bytes, 0xff, 8);
    check_refused(read_it, bytes, 100, "not a safetensors file: header of 18446744073709551615 bytes");
}
END_TEST

/* A dtype that nobody here reads, or that comes next year, leaves the others as they are. */
START_TEST(other_dtypes)
{
    static const char header[] = "{\"a\":{\"dtype\":\"U8\",\"shape\":[2],\"data_offsets\":[3,5]},"
                                 "\"b\":{\"dtype\":\"F8_E4M3\",\"shape\":[2],\"data_offsets\":[0,2]},"
                                 "\"c\":{\"dtype\":\"F4\",\"shape\":[2],\"data_offsets\":[2,3]}}";
    lt_arena *arena = lt_arena_new();
    uint8_t bytes[1024];
    const size_t n = make(bytes, header, 5);
    lt_safetensors s;

    bytes[n - 1] = 7;
    check_ok(lt_safetensors_parse(arena, "x", bytes, n, &s));
    ck_assert_uint_eq(s.n, 1);
    ck_assert(lt_array_get(lt_safetensors_find(&s, "a"), 1) == 7);
    ck_assert_uint_eq(s.n_refused, 2);
    ck_assert_str_eq(lt_refused_find(s.refused, 2, "c")->reason, "dtype \"F4\" is not read, want one of F32 F64 F16 "
                     "BF16 I8 I16 I32 I64 U8 U16 U32 U64 BOOL");
    ck_assert_ptr_null(lt_refused_find(s.refused, 2, "a"));
    check_truncated(read_it, bytes, n, 0);
    lt_arena_free(arena);
}
END_TEST

START_TEST(no_file)
{
    lt_arena *arena = lt_arena_new();
    lt_safetensors s;

    check_error(lt_safetensors_read(arena, in_folder("none"), &s), LT_EIO, "none: No such file");
    lt_arena_free(arena);
}
END_TEST

START_TEST(not_written)
{
    const lt_array a = lt_array_make(LT_ELEM_U1, 0, NULL, "x"), text = lt_array_make(LT_ELEM_TEXT, 0, NULL, NULL);
    const char *path = in_folder("no");

    check_error(lt_safetensors_write(path, (lt_named_array[]){ { "a", a }, { "a", a } }, 2, NULL, 0), LT_EINVAL,
                "two entries named \"a\"");
    check_error(lt_safetensors_write(path, &(lt_named_array){ "t", text }, 1, NULL, 0), LT_EINVAL, "no dtype");
    check_error(lt_safetensors_write(path, &(lt_named_array){ "__metadata__", a }, 1, NULL, 0), LT_EINVAL, "named");
    ck_assert(!exists(path));
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, spec_vector);
    tcase_add_test(tc, round_trip);
    tcase_add_test(tc, lies);
    tcase_add_test(tc, other_dtypes);
    tcase_add_test(tc, no_file);
    tcase_add_test(tc, not_written);
}

int main(void)
{
    return run_suite("safetensors", add_tests);
}
