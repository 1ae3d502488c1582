/* SPDX-License-Identifier: Apache-2.0 */
/* Random numbers, arenas, error lines, tasks, sizes, order, instruction sets. */
#include "libtensor/base/arena.h"
#include "libtensor/base/cpu.h"
#include "libtensor/base/order.h"
#include "libtensor/base/parallel.h"
#include "libtensor/base/printable.h"
#include "libtensor/base/rng.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Known answers of philox4x32-10 from the Random123 distribution. */
START_TEST(philox_known_answers)
{
    static const struct {
        uint32_t ctr[4], key[2], want[4];
    } kat[] = {
        { { 0 }, { 0 }, { 0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8 } },
        { { UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX }, { UINT32_MAX, UINT32_MAX },
          { 0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd } },
        { { 0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344 }, { 0xa4093822, 0x299f31d0 },
          { 0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1 } },
    };
    uint32_t out[4];

    lt_philox(kat[_i].key, kat[_i].ctr, out);
    ck_assert(memcmp(out, kat[_i].want, sizeof(out)) == 0);
}
END_TEST

START_TEST(a_draw_is_a_function_of_its_index)
{
    lt_rng a = lt_rng_make(1, 2), b = lt_rng_make(1, 2), other = lt_rng_make(1, 3);
    uint32_t tenth = 0;

    for (int i = 0; i < 10; i++)
        tenth = lt_rng_u32(&a);
    b.index = 9;
    ck_assert_uint_eq(lt_rng_u32(&b), tenth);
    other.index = 9;
    ck_assert_uint_ne(lt_rng_u32(&other), tenth);
}
END_TEST

START_TEST(draws_stay_in_range)
{
    lt_rng r = lt_rng_make(7, 0);
    double sum = 0, squares = 0;
    uint32_t order[50], seen[50] = { 0 };

    for (int i = 0; i < 20000; i++) {
        const double u = lt_rng_uniform(&r), n = lt_rng_normal(&r);

        ck_assert(u >= 0 && u < 1);
        ck_assert_uint_lt(lt_rng_below(&r, 7), 7);
        sum += n;
        squares += n * n;
    }
    ck_assert_double_eq_tol(sum / 20000, 0, 0.03);
    ck_assert_double_eq_tol(squares / 20000, 1, 0.05);
    ck_assert_uint_eq(lt_rng_below(&r, 0), 0);
    lt_rng_permute(&r, order, 50);
    for (int i = 0; i < 50; i++)
        seen[order[i]]++;
    for (int i = 0; i < 50; i++)
        ck_assert_uint_eq(seen[i], 1);
}
END_TEST

START_TEST(arenas_give_zeroed_aligned_memory)
{
    lt_arena *a = lt_arena_new();
    void *out = NULL;

    for (size_t n = 0; n < 300000; n = 3 * n + 1) {
        unsigned char *p = lt_arena_alloc(a, n);

        ck_assert_ptr_nonnull(p);
        ck_assert_uint_eq((uintptr_t)p % LT_ALIGN, 0);
        for (size_t i = 0; i < n; i++)
            ck_assert(p[i] == 0);
        memset(p, 0xa5, n);
    }
    ck_assert_ptr_null(lt_arena_array(a, SIZE_MAX / 2, 3));
    ck_assert_ptr_null(lt_arena_alloc(a, SIZE_MAX));
    ck_assert_int_eq(lt_arena_try(a, SIZE_MAX - 70, &out), LT_ENOMEM);
    ck_assert_str_eq(lt_arena_printf(a, "%d-%s", 3, "x"), "3-x");
    ck_assert_str_eq(lt_arena_strdup(a, "text"), "text");
    lt_arena_free(a);
    lt_arena_free(NULL);
    lt_release(NULL);
}
END_TEST

/* A spare block that is larger than what it is used for is full: what follows begins aligned, in another. */
START_TEST(arenas_stay_aligned)
{
    lt_arena *a = lt_arena_new();

    ck_assert_ptr_nonnull(lt_arena_alloc(a, 40000));
    lt_arena_reset(a);
    ck_assert_ptr_nonnull(lt_arena_alloc(a, 30001));
    for (int i = 0; i < 3; i++)
        ck_assert_uint_eq((uintptr_t)lt_arena_alloc(a, 8) % LT_ALIGN, 0);
    lt_arena_free(a);
}
END_TEST

START_TEST(arenas_use_memory_again)
{
    static const size_t sizes[] = { 1000, 1 << 20, 40000, 64, 1 << 18 };
    lt_arena *a = lt_arena_new();
    size_t bytes = 0;

    for (int round = 0; round < 4; round++) {
        for (size_t i = 0; i < LT_COUNT(sizes); i++) {
            unsigned char *p = lt_arena_alloc(a, sizes[i]);
            size_t written = 0;
            for (size_t k = 0; k < sizes[i]; k++)
                written += p[k] != 0;
            ck_assert_uint_eq(written, 0);
            memset(p, 0xa5, sizes[i]);
        }
        if (round == 0)
            bytes = lt_arena_bytes(a);
        ck_assert_uint_eq(lt_arena_bytes(a), bytes);
        lt_arena_reset(a);
    }
    lt_alloc_fail_at(1);                        /* what fits is not asked of the system, what does not is */
    ck_assert_ptr_nonnull(lt_arena_alloc(a, 1 << 20));
    ck_assert_ptr_null(lt_arena_alloc(a, 1 << 21));
    lt_alloc_fail_at(0);
    lt_arena_reset(a);
    ck_assert_uint_lt(lt_arena_bytes(a), bytes);        /* nothing but the megabyte was used */
    lt_arena_reset(a);
    ck_assert_uint_eq(lt_arena_bytes(a), 0);
    lt_arena_free(a);
}
END_TEST

/* The first request after a reset may be a large one: what it takes must be among the spare blocks no more. */
START_TEST(arenas_keep_used_and_spare_blocks_apart)
{
    enum { N = 3, SIZE = 100000 };
    lt_arena *a = lt_arena_new();
    unsigned char *p[N];

    for (int round = 0; round < 4; round++) {
        for (int i = 0; i < N; i++) {
            p[i] = lt_arena_alloc(a, SIZE);
            ck_assert_ptr_nonnull(p[i]);
            memset(p[i], i + 1, SIZE);
        }
        ck_assert_ptr_nonnull(lt_arena_alloc(a, SIZE / 4));        /* fits none of them */
        for (int i = 0; i < N; i++)
            ck_assert(p[i][0] == i + 1 && p[i][SIZE - 1] == i + 1);
        lt_arena_reset(a);
    }
    lt_arena_free(a);
}
END_TEST

/* A large block that is used again for many small pieces is clear to its end. */
START_TEST(arenas_clear_blocks_used_again)
{
    lt_arena *a = lt_arena_new();
    size_t written = 0;

    memset(lt_arena_alloc(a, 100000), 0xa5, 100000);
    lt_arena_reset(a);
    for (int i = 0; i < 90; i++) {
        const unsigned char *p = lt_arena_alloc(a, 1000);
        for (size_t k = 0; k < 1000; k++)
            written += p[k] != 0;
    }
    ck_assert_uint_eq(written, 0);
    lt_arena_free(a);
}
END_TEST

START_TEST(lists_grow_and_keep_what_they_hold)
{
    lt_arena *a = lt_arena_new();
    size_t room = 0;
    int *list = NULL;

    for (int i = 0; i < 1000; i++) {
        int *longer = lt_arena_grow(a, list, (size_t)i, &room, sizeof(*list));

        ck_assert(longer && room > (size_t)i && room <= (size_t)(2 * i + 64));
        list = longer;
        list[i] = i;
    }
    for (int i = 0; i < 1000; i++)
        ck_assert_int_eq(list[i], i);
    room = SIZE_MAX / 2;                                /* twice as many do not fit any memory */
    ck_assert_ptr_null(lt_arena_grow(a, list, room, &room, sizeof(*list)));
    ck_assert(room == SIZE_MAX / 2);
    lt_arena_free(a);
}
END_TEST

START_TEST(allocations_fail_on_demand)
{
    void *p;

    lt_alloc_fail_at(2);
    p = lt_alloc(8);
    ck_assert_ptr_nonnull(p);
    ck_assert_ptr_null(lt_alloc(8));
    lt_release(p);
    p = lt_alloc(8);
    ck_assert_ptr_nonnull(p);
    lt_release(p);
}
END_TEST

START_TEST(error_lines)
{
    char longest[3000];

    ck_assert_int_eq(lt_error(LT_EIO, "%s: %d\n\tbad", "file", 3), LT_EIO);
    ck_assert_str_eq(lt_last_error(), "file: 3??bad");
    ck_assert_int_eq(lt_error_prefix(LT_EIO, "while %s", "reading"), LT_EIO);
    ck_assert_str_eq(lt_last_error(), "while reading: file: 3??bad");
    memset(longest, 'x', sizeof(longest) - 1);
    longest[sizeof(longest) - 1] = '\0';
    lt_error(LT_EINVAL, "%s", longest);
    ck_assert_uint_eq(strlen(lt_last_error()), 1023);
}
END_TEST

static void fail_at_odd(void *ctx, int64_t i)
{
    lt_outcome_keep((lt_outcome *)ctx + i, i % 2 ? lt_error(LT_EIO, "piece %d", (int)i) : LT_OK);
}

/* Of pieces that several threads did, each one's line, told on this thread. */
START_TEST(errors_come_over_from_other_threads)
{
    enum { PIECES = 40 };
    lt_outcome of[PIECES];

    lt_set_threads(3);
    lt_parallel_for(PIECES, fail_at_odd, of);
    lt_set_threads(1);
    for (int i = 0; i < PIECES; i++) {
        char want[32];

        lt_error(LT_EINVAL, "before");
        snprintf(want, sizeof(want), "piece %d", i);
        ck_assert_int_eq(lt_outcome_tell(&of[i]), i % 2 ? LT_EIO : LT_OK);
        ck_assert_str_eq(lt_last_error(), i % 2 ? want : "before");
    }
}
END_TEST

static void count(void *ctx, int64_t i)
{
    ((int *)ctx)[i]++;
}

static void nested(void *ctx, int64_t i)
{
    lt_parallel_for(10, count, (int *)ctx + 10 * i);
}

START_TEST(every_task_runs_once)
{
    int done[1000] = { 0 };

    lt_set_threads(3);
    ck_assert_int_eq(lt_threads(), 3);
    lt_parallel_for(0, count, done);
    lt_parallel_for(-5, count, done);
    lt_parallel_for(1000, count, done);
    lt_parallel_for(100, nested, done);
    for (int i = 0; i < 1000; i++)
        ck_assert_int_eq(done[i], 2);
    lt_set_threads(0);
    ck_assert_int_ge(lt_threads(), 1);
}
END_TEST

START_TEST(sizes_know_when_they_overflow)
{
    size_t out;

    ck_assert(lt_size_mul(SIZE_MAX / 3, 3, &out) && out == SIZE_MAX / 3 * 3);
    ck_assert(!lt_size_mul(SIZE_MAX / 3 + 1, 3, &out));
    ck_assert(lt_size_add(SIZE_MAX - 1, 1, &out) && out == SIZE_MAX);
    ck_assert(!lt_size_add(SIZE_MAX, 1, &out));
    ck_assert_int_eq(lt_ceil_div(0, 7), 0);
    ck_assert_int_eq(lt_ceil_div(8, 7), 2);
}
END_TEST

START_TEST(numbers_ascend_before_nan)
{
    double x[] = { 3, NAN, -INFINITY, 0, INFINITY, NAN, -2 };
    static const double want[] = { -INFINITY, -2, 0, 3, INFINITY };

    qsort(x, LT_COUNT(x), sizeof(*x), lt_ascending);
    ck_assert(!memcmp(x, want, sizeof(want)));
    ck_assert(isnan(x[5]) && isnan(x[6]));
}
END_TEST

/* What is shown stays; what steers a terminal does not, however it is written; nor half a character. */
START_TEST(text_that_reaches_a_terminal)
{
    static const char *const cases[][2] = {
        { "", "" },
        { "plain, \xc3\xa9 \xe2\x82\xac \xf0\x9f\x96\x90",
          "plain, \xc3\xa9 \xe2\x82\xac \xf0\x9f\x96\x90" },
        { "\033[31mred\a\n\177", "?[31mred???" },
        { "\302\233" "31m", "??31m" },                  /* U+009B, CSI, in UTF-8 */
        { "\233" "31m", "?31m" },                       /* the same as a byte */
        { "\302\240", "\302\240" },                     /* U+00A0, a blank */
        { "a\xe2\x80\xae" "b", "a???b" },              /* U+202E, right to left from here on */
        { "\xe2\x82", "??" }, { "\xff\xfe", "??" }, { "\xc0\x9b", "??" }, { "\xe0\x82\x9b", "???" },
        { "\xed\xa0\x80", "???" }, { "\xf4\x90\x80\x80", "????" },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        char text[64];

        strcpy(text, cases[i][0]);
        ck_assert_str_eq(lt_printable(text), cases[i][1]);
    }
    lt_error(LT_EINVAL, "%s", "x\302\233y");
    ck_assert_str_eq(lt_last_error(), "x??y");
}
END_TEST

START_TEST(medians)
{
    double odd[3] = { 3, 1, 2 }, even[4] = { 4, 1, 3, 2 };

    ck_assert_double_eq(lt_median(3, odd), 2);
    ck_assert_double_eq(lt_median(4, even), 2.5);
    ck_assert(isnan(lt_median(0, NULL)));
}
END_TEST

START_TEST(instruction_sets_have_names)
{
    for (int isa = LT_ISA_GENERIC; isa <= LT_ISA_AMX; isa++) {
        lt_isa found;

        ck_assert_int_eq(lt_isa_parse(lt_isa_name(isa), &found), LT_OK);
        ck_assert_int_eq((int)found, isa);
    }
    ck_assert_int_eq(lt_isa_parse("sse9", &(lt_isa){ 0 }), LT_EINVAL);
    ck_assert_int_gt((int)strlen(lt_cpu_model()), 0);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_loop_test(tc, philox_known_answers, 0, 3);
    tcase_add_test(tc, a_draw_is_a_function_of_its_index);
    tcase_add_test(tc, draws_stay_in_range);
    tcase_add_test(tc, arenas_give_zeroed_aligned_memory);
    tcase_add_test(tc, arenas_stay_aligned);
    tcase_add_test(tc, arenas_use_memory_again);
    tcase_add_test(tc, arenas_keep_used_and_spare_blocks_apart);
    tcase_add_test(tc, arenas_clear_blocks_used_again);
    tcase_add_test(tc, lists_grow_and_keep_what_they_hold);
    tcase_add_test(tc, allocations_fail_on_demand);
    tcase_add_test(tc, error_lines);
    tcase_add_test(tc, errors_come_over_from_other_threads);
    tcase_add_test(tc, every_task_runs_once);
    tcase_add_test(tc, sizes_know_when_they_overflow);
    tcase_add_test(tc, numbers_ascend_before_nan);
    tcase_add_test(tc, text_that_reaches_a_terminal);
    tcase_add_test(tc, medians);
    tcase_add_test(tc, instruction_sets_have_names);
}

int main(void)
{
    return run_suite("base", add_tests);
}
