/* SPDX-License-Identifier: Apache-2.0 */
/* The loader: order, resume, shares, failures; the same on any number of threads. */
#include "data/loader.h"
#include "tests/suite.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A source whose batch is what it was asked for. */
typedef struct { int count, capacity; int64_t index[64]; uint64_t epoch[64]; bool skipped[64]; } seen;
typedef struct { int64_t bad_from, bad_to; bool slow; } world;

static const char *name(const void *ctx, int64_t index)
{
    (void)ctx;
    (void)index;
    return "sample";
}

static void *batch_new(const void *ctx, int capacity)
{
    seen *b = calloc(1, sizeof(*b));

    (void)ctx;
    b->capacity = capacity;
    return b;
}

static void start(void *batch, int count)
{
    seen *b = batch;

    ck_assert_int_le(count, b->capacity);
    b->count = count;
    memset(b->skipped, 0, sizeof(b->skipped));
}

static lt_status fill(const void *ctx, uint64_t epoch, int64_t index, lt_arena *scratch, void *batch, int slot)
{
    const world *w = ctx;
    seen *b = batch;
    int *place = lt_arena_alloc(scratch, 1 << 15);

    if (!place || *place)
        return lt_error(LT_EINVAL, "scratch holds what another sample left");
    *place = 1;
    if (w->slow)
        usleep((useconds_t)(index * 7919 % 5 * 200));
    if (index >= w->bad_from && index < w->bad_to)
        return lt_error(LT_EFORMAT, "sample %d is torn", (int)index);
    b->index[slot] = index;
    b->epoch[slot] = epoch;
    return LT_OK;
}

static void skip(void *batch, int slot, int64_t index)
{
    seen *b = batch;

    b->index[slot] = index;
    b->skipped[slot] = true;
}

static loader_source source(const world *w, int64_t count)
{
    return (loader_source){ w, count, name, batch_new, free, start, fill, skip, false };
}

static loader *open_loader(const world *w, int64_t count, loader_options o, loader_position at)
{
    const loader_source s = source(w, count);
    loader *l = NULL;

    check_ok(loader_new(&s, &o, at, &l));
    return l;
}

/* The next n samples into out; -1 for the end of an epoch. */
static void collect(loader *l, int64_t *out, int n)
{
    for (int i = 0; i < n;) {
        void *batch;
        check_ok(loader_next(l, &batch));
        if (!batch)
            out[i++] = -1;
        for (int k = 0; batch && k < ((seen *)batch)->count && i < n; k++)
            out[i++] = ((seen *)batch)->index[k];
    }
}

static const world fine = { 0, 0, true };

START_TEST(threads_do_not_matter)
{
    int64_t a[300], b[300];
    loader_options o = { .batch = 7, .threads = 1, .ahead = 1, .shuffle = true, .seed = 5 };
    loader *l = open_loader(&fine, 52, o, (loader_position){ 0 });

    collect(l, a, 300);
    loader_free(l);
    for (int threads = 2; threads <= 5; threads++) {
        o.threads = threads;
        o.ahead = threads;
        l = open_loader(&fine, 52, o, (loader_position){ 0 });
        collect(l, b, 300);
        loader_free(l);
        ck_assert_mem_eq(a, b, sizeof(a));
    }
}
END_TEST

START_TEST(an_epoch_is_a_permutation)
{
    int64_t a[106];
    int count[2][52] = { { 0 } };
    const loader_options o = { .batch = 8, .threads = 2, .ahead = 2, .shuffle = true, .seed = 5 };
    loader *l = open_loader(&fine, 52, o, (loader_position){ 0 });

    collect(l, a, 106);
    for (int e = 0; e < 2; e++) {
        for (int i = 0; i < 52; i++)
            count[e][a[53 * e + i]]++;
        ck_assert_int_eq(a[53 * e + 52], -1);
        for (int i = 0; i < 52; i++)
            ck_assert_int_eq(count[e][i], 1);
    }
    ck_assert_mem_ne(a, a + 53, 52 * sizeof(*a));
    loader_free(l);
}
END_TEST

START_TEST(evaluation_goes_in_order)
{
    int64_t a[24];
    const loader_options o = { .batch = 5, .threads = 3, .ahead = 2 };
    loader *l = open_loader(&fine, 11, o, (loader_position){ 0 });

    collect(l, a, 24);
    for (int i = 0; i < 24; i++)
        ck_assert_int_eq(a[i], i % 12 == 11 ? -1 : i % 12);
    loader_free(l);
}
END_TEST

/* Stop after any batch, go on from the saved position: nothing is lost or seen twice. */
START_TEST(resume)
{
    enum { TOTAL = 12 };
    const loader_options o = { .batch = 4, .threads = 2, .ahead = 3, .shuffle = true, .seed = 9 };
    seen whole[TOTAL];
    loader *l = open_loader(&fine, 10, o, (loader_position){ 0 });

    for (int i = 0; i < TOTAL; i++) {
        void *b;
        ck_assert_int_eq(loader_next(l, &b), LT_OK);
        whole[i] = b ? *(seen *)b : (seen){ .count = -1 };
    }
    loader_free(l);
    for (int stop = 0; stop < TOTAL; stop++) {
        loader_position at = { 0 };
        void *b;
        l = open_loader(&fine, 10, o, at);
        for (int i = 0; i < stop; i++)
            ck_assert_int_eq(loader_next(l, &b), LT_OK);
        at = loader_where(l);
        loader_free(l);
        l = open_loader(&fine, 10, o, at);
        for (int i = stop; i < TOTAL; i++) {
            ck_assert_int_eq(loader_next(l, &b), LT_OK);
            ck_assert_int_eq(b ? ((seen *)b)->count : -1, whole[i].count);
            for (int k = 0; k < whole[i].count; k++) {
                ck_assert_int_eq(((seen *)b)->index[k], whole[i].index[k]);
                ck_assert_int_eq(((seen *)b)->epoch[k], whole[i].epoch[k]);
            }
        }
        loader_free(l);
    }
}
END_TEST

/* Two ranks of 2 and 3 slots see together what one of 5 sees. */
START_TEST(shares)
{
    loader_options o = { .batch = 5, .threads = 2, .ahead = 2, .shuffle = true, .seed = 2 };
    loader *all = open_loader(&fine, 12, o, (loader_position){ 0 }), *part[2];

    o.n_slots = 2;
    part[0] = open_loader(&fine, 12, o, (loader_position){ 0 });
    o.first_slot = 2;
    o.n_slots = 3;
    part[1] = open_loader(&fine, 12, o, (loader_position){ 0 });
    for (int i = 0; i < 8; i++) {
        void *a, *b[2];
        ck_assert_int_eq(loader_next(all, &a), LT_OK);
        for (int r = 0; r < 2; r++)
            ck_assert_int_eq(loader_next(part[r], &b[r]), LT_OK);
        ck_assert_int_eq(!a, !b[0]);
        ck_assert_int_eq(!a, !b[1]);
        for (int k = 0; a && k < ((seen *)a)->count; k++)
            ck_assert_int_eq(((seen *)a)->index[k], k < 2 ? ((seen *)b[0])->index[k]
                                                         : ((seen *)b[1])->index[k - 2]);
        if (a)          /* the epoch's last batch has 2 samples: nothing for the second rank */
            ck_assert_int_eq(((seen *)a)->count, ((seen *)b[0])->count + ((seen *)b[1])->count);
    }
    loader_free(all);
    loader_free(part[0]);
    loader_free(part[1]);
}
END_TEST

START_TEST(a_torn_sample_stops)
{
    const world w = { 6, 7, true };
    const loader_options o = { .batch = 4, .threads = 3, .ahead = 4 };
    loader *l = open_loader(&w, 20, o, (loader_position){ 0 });
    void *b;

    ck_assert_int_eq(loader_next(l, &b), LT_OK);
    for (int i = 0; i < 2; i++) {
        ck_assert_int_eq(loader_next(l, &b), LT_EFORMAT);
        ck_assert_str_eq(lt_last_error(), "sample 6 is torn");
    }
    loader_free(l);
}
END_TEST

START_TEST(torn_samples_are_skipped)
{
    const world w = { 6, 8, false };
    const loader_options o = { .batch = 5, .threads = 2, .ahead = 2, .tolerate = 0.1 };
    loader *l = open_loader(&w, 20, o, (loader_position){ 0 });
    void *b;

    for (int i = 0; i < 15; i++) {          /* three epochs */
        ck_assert_int_eq(loader_next(l, &b), LT_OK);
        for (int k = 0; b && k < ((seen *)b)->count; k++)
            ck_assert_int_eq(((seen *)b)->skipped[k],
                             ((seen *)b)->index[k] == 6 || ((seen *)b)->index[k] == 7);
    }
    ck_assert_int_eq(loader_skipped(l), 2);
    ck_assert_str_eq(loader_skipped_line(l, 1), "sample 7 is torn");
    loader_free(l);
}
END_TEST

START_TEST(too_many_torn_samples)
{
    const world w = { 6, 9, false };
    const loader_options o = { .batch = 20, .threads = 2, .ahead = 1, .tolerate = 0.1 };
    loader *l = open_loader(&w, 20, o, (loader_position){ 0 });
    void *b;

    ck_assert_int_eq(loader_next(l, &b), LT_EFORMAT);
    ck_assert_str_eq(lt_last_error(), "more than 10 % of the samples cannot be read (3 so far); the first: "
                                      "sample 6 is torn");
    loader_free(l);
}
END_TEST

START_TEST(closes_at_any_time)
{
    const loader_options o = { .batch = 3, .threads = 4, .ahead = 5, .shuffle = true };

    for (int n = 0; n < 12; n++) {
        loader *l = open_loader(&fine, 9, o, (loader_position){ 0 });
        void *b;
        for (int i = 0; i < n; i++)
            ck_assert_int_eq(loader_next(l, &b), LT_OK);
        loader_free(l);
    }
    loader_free(NULL);
}
END_TEST

static void refused(int64_t count, loader_options o, loader_position at, const char *line)
{
    const loader_source s = source(&fine, count);
    loader *l;

    ck_assert_int_eq(loader_new(&s, &o, at, &l), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), line);
}

START_TEST(bad_options)
{
    const loader_options o = { .batch = 3, .threads = 1, .ahead = 1 };

    refused(0, o, (loader_position){ 0 }, "loader: the dataset has 0 samples");
    refused(5, (loader_options){ .batch = 0, .threads = 1, .ahead = 1 }, (loader_position){ 0 },
            "loader: batch 0, threads 1, ahead 1: each must be at least 1");
    refused(5, (loader_options){ .batch = 3, .threads = 1, .ahead = 1, .first_slot = 2, .n_slots = 2 },
            (loader_position){ 0 }, "loader: slots 2 to 4 are not within a batch of 3");
    refused(5, o, (loader_position){ 0, 6 },
            "loader: position 6 is not within 5 samples: was it saved with another dataset?");
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_set_timeout(c, 120);
    tcase_add_test(c, threads_do_not_matter);
    tcase_add_test(c, an_epoch_is_a_permutation);
    tcase_add_test(c, evaluation_goes_in_order);
    tcase_add_test(c, resume);
    tcase_add_test(c, shares);
    tcase_add_test(c, a_torn_sample_stops);
    tcase_add_test(c, torn_samples_are_skipped);
    tcase_add_test(c, too_many_torn_samples);
    tcase_add_test(c, closes_at_any_time);
    tcase_add_test(c, bad_options);
}

int main(void)
{
    return run_suite("loader", add_tests);
}
