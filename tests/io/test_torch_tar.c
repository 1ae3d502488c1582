/* SPDX-License-Identifier: Apache-2.0 */
/* PyTorch's oldest container, put together by hand: what its three files may say, and what they may not. That what
 * PyTorch wrote is read is tests/io/test_torch. */
#include "libtensor/io/torch/torch.h"
#include "tests/io/hostile.h"

enum { BLOCK = 512, ROOM = 8 * BLOCK };

typedef struct {
    const char *bytes;
    size_t n;
} part;

/* How the size of a member is written */
static const char *size_format = "%011zo";

static size_t put_member(uint8_t *out, const char *name, part p)
{
    const size_t whole = (p.n + BLOCK - 1) / BLOCK * BLOCK;

    memset(out, 0, BLOCK + whole);
    strcpy((char *)out, name);
    sprintf((char *)out + 124, size_format, p.n);
    memcpy(out + 257, "ustar", 6);
    memcpy(out + BLOCK, p.bytes, p.n);
    return BLOCK + whole;
}

static size_t put_tar(uint8_t *out, part storages, part tensors, part pickle)
{
    size_t n = put_member(out, "storages", storages);

    n += put_member(out + n, "tensors", tensors);
    return n + put_member(out + n, "pickle", pickle);
}

static lt_status read_tar(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_torch_file f;

    return lt_torch_parse(arena, "x.pth", bytes, n, &f);
}

#define TEXT(s) { s, sizeof(s) - 1 }
#define I64(byte) byte "\0\0\0\0\0\0\0"
#define MINUS_ONE "\xff\xff\xff\xff\xff\xff\xff\xff"
#define COUNT(byte) "\x80\2K" byte "."
#define KEY(key, of, class) "\x80\2(" key of "ctorch\n" class "\nt."
#define CPU "X\3\0\0\0cpu"
#define FOUR KEY("K\1", CPU, "FloatStorage") I64("\4") "\0\0\0\0\0\0\x80\x3f\0\0\0\x40\0\0\x40\x40"
#define VIEWS(list) "\x80\2](" list "e."
#define S COUNT("\1") FOUR "\x80\2]."
#define TENSOR(begin) KEY("K\7", "K\1", "FloatTensor") I64("\1") I64("\2") I64("\1") begin
#define T COUNT("\1") TENSOR(I64("\2"))
#define P "\x80\2}X\1\0\0\0xK\7Qs."

/* Elements 2 and 3 of four: 2, 3 */
START_TEST(tensors_are_named)
{
    static const part pickles[] = {
        TEXT(P), TEXT("\x80\2}X\1\0\0\0xX\1\0\0\0" "7Qs."), TEXT("}S'x'\nP7\ns."),
        TEXT("\x80\2}(X\1\0\0\0xK\7QX\1\0\0\0y(K\5NtQu."),       /* y: a class with its source */
    };
    uint8_t bytes[ROOM];
    const size_t n = put_tar(bytes, (part)TEXT(S), (part)TEXT(T), pickles[_i]);
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;

    check_ok(lt_torch_parse(arena, "x.pth", bytes, n, &f));
    ck_assert(f.container == LT_TORCH_TAR && f.n == 1);
    ck_assert_str_eq(f.entry[0].name, "x");
    ck_assert(lt_array_get(&f.entry[0].array, 0) == 2 && lt_array_get(&f.entry[0].array, 1) == 3);
    lt_arena_free(arena);
}
END_TEST

/* Storage 2 is elements 1 and 2 of storage 1. */
START_TEST(a_view_is_a_storage)
{
    static const part storages[] = {
        TEXT(COUNT("\1") FOUR VIEWS("(K\2K\1K\1K\2t")), TEXT(COUNT("\1") FOUR "\x80\2((K\2K\1K\1K\2tt."),
    };
    static const part tensor = TEXT(COUNT("\1") KEY("K\7", "K\2", "FloatTensor") I64("\1") I64("\2") I64("\1")
                                    I64("\0"));
    uint8_t bytes[ROOM];
    const size_t n = put_tar(bytes, storages[_i], tensor, (part)TEXT(P));
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;

    check_ok(lt_torch_parse(arena, "x.pth", bytes, n, &f));
    ck_assert(lt_array_get(&f.entry[0].array, 0) == 1 && lt_array_get(&f.entry[0].array, 1) == 2);
    lt_arena_free(arena);
}
END_TEST

START_TEST(nothing_at_all_is_read)
{
    uint8_t bytes[ROOM];
    const size_t n = put_tar(bytes, (part)TEXT(COUNT("\0") "\x80\2]."), (part)TEXT(COUNT("\0")),
                             (part)TEXT("\x80\2}."));
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;

    check_ok(lt_torch_parse(arena, "x.pth", bytes, n, &f));
    ck_assert_uint_eq(f.n, 0);
    lt_arena_free(arena);
}
END_TEST

#define ONE_S(text, reason) { TEXT(text), TEXT(T), TEXT(P), reason }
#define ONE_T(text, reason) { TEXT(S), TEXT(text), TEXT(P), reason }
#define ONE_P(text, reason) { TEXT(S), TEXT(T), TEXT(text), reason }
#define VIEW(view, reason) ONE_S(COUNT("\1") FOUR VIEWS(view), reason)
#define LARGE "\xff\xff\xff\xff\xff\xff\xff\x7f"

static const struct {
    part storages, tensors, pickle;
    const char *reason;
} refusals[] = {
    ONE_S("", "x.pth: storages"), ONE_S("\x80\2N.", "a count that the file cannot hold"),
    ONE_S("\x80\2J\xff\xff\xff\xff.", "a count that the file cannot hold"),
    ONE_S(COUNT("\x09"), "a count that the file cannot hold"),
    ONE_S(COUNT("\1") "\x80\2N.aaaa", "not a key with two things"),
    ONE_S(COUNT("\1") "\x80\2K\1K\2\x86.", "not a key with two things about it"),
    ONE_S(COUNT("\1") KEY("N", CPU, "FloatStorage") I64("\0"), "not a key with two things about it"),
    ONE_S(COUNT("\1") KEY("K\1", CPU, "FloatStorage") "\1\0\0", "ends early"),
    ONE_S(COUNT("\1") KEY("K\1", CPU, "QInt8Storage") I64("\0"), "a storage of a class that is not read"),
    ONE_S(COUNT("\1") "\x80\2K\1NN\x87." I64("\0"), "a storage of a class that is not read"),
    ONE_S(COUNT("\1") KEY("K\1", CPU, "FloatStorage") MINUS_ONE, "more elements than the file has"),
    ONE_S(COUNT("\1") KEY("K\1", CPU, "FloatStorage") LARGE, "more elements than the file has"),
    ONE_S(COUNT("\1") KEY("K\1", CPU, "FloatStorage") I64("\1") "abc", "more elements than the file has"),
    ONE_S(COUNT("\1") FOUR, "ends early"), ONE_S(COUNT("\1") FOUR "\x80\2N.", "no list of views"),
    VIEW("N", "a view that is not of four numbers"), VIEW("K\1K\1\x86", "a view that is not of four numbers"),
    VIEW("(K\2K\1K\1Nt", "a view that is not of four numbers"), VIEW("(K\2K\3K\1K\2t", "a view beyond its storage"),
    VIEW("(K\2K\1J\xff\xff\xff\xffK\2t", "a view beyond its storage"),
    VIEW("(K\2K\1K\1J\xff\xff\xff\xfft", "a view beyond its storage"),
    VIEW("(K\2K\1K\5K\0t", "a view beyond its storage"), VIEW("(K\2K\1K\1K\4t", "a view beyond its storage"),
    ONE_T("\x80\2N.", "a count that the file cannot hold"), ONE_T(COUNT("\1") "\x80\2N.aaaa", "not a key with two"),
    ONE_T(COUNT("\1") KEY("K\7", "N", "FloatTensor") I64("\1"), "a tensor without storage"),
    ONE_T(COUNT("\1") KEY("K\7", "K\2", "FloatTensor") I64("\1"), "a tensor without storage"),
    ONE_T(COUNT("\1") KEY("K\7", "K\1", "FloatTensor") I64("\x09"), "or of more than 8 dimensions"),
    ONE_T(COUNT("\1") KEY("K\7", "K\1", "FloatTensor"), "ends early"),
    ONE_T(COUNT("\1") KEY("K\7", "K\1", "FloatTensor") I64("\1"), "ends early"),
    ONE_T(COUNT("\1") KEY("K\7", "K\1", "FloatTensor") I64("\1") I64("\1"), "ends early"),
    ONE_T(COUNT("\1") TENSOR(""), "ends early"), ONE_T(COUNT("\1") TENSOR(MINUS_ONE), "a negative offset"),
    ONE_T(COUNT("\1") TENSOR(I64("\3")), "an element beyond its storage"),
    ONE_P("\x80\2K\5Q.", "a tensor that is not among the file's"),
    ONE_P("\x80\2X\1\0\0\0aQ.", "a tensor that is not among the file's"),
    ONE_P("\x80\2X\2\0\0\0" "7aQ.", "a tensor that is not among the file's"),
    ONE_P("\x80\2)Q.", "a tensor that is not among the file's"), ONE_P("\x80\2NQ.", "a tensor that is not among"),
    /* as the newer containers say it: nothing in this one holds such a storage's elements */
    ONE_P("\x80\2}X\1\0\0\0xctorch._utils\n_rebuild_tensor_v2\n((X\7\0\0\0storagectorch\nFloatStorage\nX\1\0\0\0k"
          "X\3\0\0\0cpuK\4tQK\0K\4\x85K\1\x85\x89}tRs.", "storage \"k\" is not in the file"),
};

START_TEST(refuses)
{
    uint8_t bytes[ROOM];
    const size_t n = put_tar(bytes, refusals[_i].storages, refusals[_i].tensors, refusals[_i].pickle);

    check_refused(read_tar, bytes, n, refusals[_i].reason);
}
END_TEST

/* ---- the archive itself ---------------------------------------------------------------------------------------- */

START_TEST(sizes_are_octal)
{
    static const struct {
        const char *format, *reason;
    } cases[] = {
        { "%012zo", NULL }, { "%zo ", NULL }, { "%zo", NULL }, { "%011zo9", "a size beyond the file" },
        { "0x%zx", "a size beyond the file" }, { " %zo", "a size beyond the file" },
        { "7777777%zo", "a size beyond the file" },
    };
    uint8_t bytes[ROOM];

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        size_t n;

        size_format = cases[i].format;
        n = put_tar(bytes, (part)TEXT(S), (part)TEXT(T), (part)TEXT(P));
        if (cases[i].reason)
            check_refused(read_tar, bytes, n, cases[i].reason);
        else
            check_ok(attempt(read_tar, bytes, n));
    }
}
END_TEST

START_TEST(all_three_files_are_wanted)
{
    static const char *const names[] = { "storages", "tensors", "pickle" };
    char reason[32];

    for (int missing = 0; missing < 3; missing++) {
        uint8_t bytes[ROOM];
        size_t n = 0;

        for (int i = 0; i < 3; i++)
            n += put_member(bytes + n, i == missing ? "other" : names[i], (part)TEXT(S));
        snprintf(reason, sizeof(reason), "without \"%s\"", names[missing]);
        check_refused(read_tar, bytes, n, reason);
    }
}
END_TEST

START_TEST(without_memory)
{
    uint8_t bytes[ROOM];
    const size_t n = put_tar(bytes, (part)TEXT(COUNT("\1") FOUR VIEWS("(K\2K\1K\1K\2t")), (part)TEXT(T), (part)TEXT(P));

    ck_assert_int_gt(check_without_memory(read_tar, bytes, n), 0);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_loop_test(tc, tensors_are_named, 0, 4);
    tcase_add_loop_test(tc, a_view_is_a_storage, 0, 2);
    tcase_add_test(tc, nothing_at_all_is_read);
    tcase_add_loop_test(tc, refuses, 0, LT_COUNT(refusals));
    tcase_add_test(tc, sizes_are_octal);
    tcase_add_test(tc, all_three_files_are_wanted);
    tcase_add_test(tc, without_memory);
}

int main(void)
{
    return run_suite("torch_tar", add_tests);
}
