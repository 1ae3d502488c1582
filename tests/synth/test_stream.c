/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures that are made while they are read. */
#include "synth/stream/stream.h"

#include "assets/hand/hand.h"
#include "libtensor/base/parallel.h"
#include "tests/suite.h"

#include <stdlib.h>
#include <string.h>

enum { COUNT = 1000, LANE = 32, TAKE = LANE * SYNTH_STREAM_FRAMES, W = 320, H = 240 };
static const unsigned ALL = SAMPLE_OBJECT | SAMPLE_DEPTH | SAMPLE_SEGMENTS;

static dataset *d;
static lt_arena *arena;

static void setup(void)
{
    arena = lt_arena_new();
    check_ok(synth_stream_open(&(synth_stream_options){ .seed = 5, .count = COUNT, .shrink = 2 }, &d));
}

static void teardown(void)
{
    dataset_free(d);
    lt_arena_free(arena);
}

static dataset_sample sample_of(int64_t index)
{
    dataset_sample s;

    check_ok(dataset_read(d, index, ALL, arena, &s));
    ck_assert_int_eq(s.width, W);
    ck_assert_int_eq(s.height, H);
    return s;
}

static bool same(const dataset_sample *a, const dataset_sample *b)
{
    return !memcmp(a->rgb, b->rgb, 3 * W * H) && !memcmp(a->depth, b->depth, W * H * sizeof(*a->depth))
        && !memcmp(a->silhouette, b->silhouette, W * H) && !memcmp(a->segments, b->segments, W * H)
        && !memcmp(a->rotation, b->rotation, sizeof(a->rotation)) && !memcmp(a->joints, b->joints, sizeof(a->joints))
        && !memcmp(a->R, b->R, sizeof(a->R)) && a->object == b->object;
}

/* A lane that was in another take meanwhile makes the same picture again, and a frame further on another one. */
START_TEST(any_order)
{
    const dataset_sample first = sample_of(3), next = sample_of(3 + LANE), other = sample_of(3 + TAKE);
    const dataset_sample again = sample_of(3);

    ck_assert(same(&first, &again));
    ck_assert(!same(&first, &next) && !same(&first, &other));
    ck_assert_int_eq(first.object, next.object);        /* of the same take */
    ck_assert_str_eq(first.name, "stream/0000000003");
}
END_TEST

typedef struct { dataset_sample *out; lt_arena **arena; } reading;

static void read_one(void *ctx, int64_t i)
{
    const reading *r = ctx;

    check_ok(dataset_read(d, i % 4 + i / 4 * LANE, ALL, r->arena[i], &r->out[i]));
}

START_TEST(any_number_of_threads)
{
    enum { N = 8 };
    dataset_sample one[N], four[N];
    lt_arena *a[N], *b[N];

    for (int i = 0; i < N; i++)
        a[i] = lt_arena_new(), b[i] = lt_arena_new();
    lt_set_threads(1);
    lt_parallel_for(N, read_one, &(reading){ one, a });
    lt_set_threads(4);
    lt_parallel_for(N, read_one, &(reading){ four, b });
    lt_set_threads(0);
    for (int i = 0; i < N; i++) {
        ck_assert(same(&one[i], &four[i]));
        lt_arena_free(a[i]);
        lt_arena_free(b[i]);
    }
}
END_TEST

static int pixels(const uint8_t *x, uint8_t value)
{
    int n = 0;

    for (int i = 0; i < W * H; i++)
        n += x[i] == value;
    return n;
}

/* What is said of a picture is what is in it. */
START_TEST(truth_fits)
{
    double rms;
    lt_hand_model *hand;

    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
    check_ok(dataset_check_tips(d, hand, &rms));
    ck_assert_double_lt(rms, 0.01);
    for (int i = 0; i < 6; i++) {
        dataset_sample s = sample_of(i), drawn = s;
        int both = 0, either = 0, wrong = 0;

        ck_assert_int_gt(pixels(s.segments, SEGMENT_HAND), 0);
        check_ok(dataset_draw_silhouette(d, arena, &drawn));
        for (int k = 0; k < W * H; k++) {
            both += s.silhouette[k] && drawn.silhouette[k];
            either += s.silhouette[k] || drawn.silhouette[k];
            wrong += s.segments[k] == SEGMENT_OBJECT && !s.silhouette[k];
        }
        ck_assert_int_gt(either, 0);
        ck_assert_msg(both > 0.9 * either, "%d of %d pixels", both, either);
        ck_assert_int_eq(wrong, 0);
    }
}
END_TEST

static bool is_of_hand(const dataset_sample *s, int i)
{
    const int x = (int)(s->joints2d[i][0] + 0.5f), y = (int)(s->joints2d[i][1] + 0.5f);

    return x >= 0 && y >= 0 && x < s->segments_width && y < s->segments_height
        && s->segments[y * s->segments_width + x] == SEGMENT_HAND;
}

/* Hands from near by: left and right, with an object or without, and the joints lie in what is seen of the hand. A
 * picture is the same when it is kept from the first reading, and when more is wanted, so that it is drawn again. */
START_TEST(near_hands)
{
    enum { N = 10 };
    int mirrored = 0, held = 0, within = 0;
    dataset *near;

    check_ok(synth_stream_open(&(synth_stream_options){ .seed = 6, .count = COUNT, .shrink = 2, .near = 1,
                                                          .keep = 1 << 20 }, &near));
    for (int i = 0; i < N; i++) {
        const int64_t index = i % 2 + i / 2 * LANE;
        dataset_sample s, kept, again;

        check_ok(dataset_read(near, index, i < 2 ? SAMPLE_OBJECT : ALL, arena, &kept));
        check_ok(dataset_read(near, index, ALL, arena, &s));
        ck_assert_mem_eq(s.rgb, kept.rgb, 3 * (size_t)s.width * (size_t)s.height);
        ck_assert(i < 2 || !memcmp(s.depth, kept.depth, (size_t)s.width * (size_t)s.height * sizeof(*s.depth)));
        ck_assert(s.flags & SAMPLE_HAND_POSE && s.flags & SAMPLE_SEGMENTS && s.flags & SAMPLE_DEPTH);
        ck_assert_int_eq(s.object >= 0, (s.flags & SAMPLE_OBJECT) != 0);
        ck_assert_int_eq(s.silhouette != NULL, s.object >= 0);
        mirrored += (s.flags & SAMPLE_MIRRORED) != 0;
        held += s.object >= 0;
        for (int k = 0; k < LT_HAND_KEYPOINTS; k++)
            within += is_of_hand(&s, k);
        check_ok(dataset_annotation(near, index, arena, &again));
        ck_assert_mem_eq(s.joints, again.joints, sizeof(s.joints));
    }
    ck_assert(mirrored > 0 && mirrored < N);
    ck_assert(held > 0 && held < N / 2 + 1);
    ck_assert_msg(within > N * LT_HAND_KEYPOINTS * 6 / 10, "%d joints", within);
    dataset_free(near);
}
END_TEST

START_TEST(bad_options)
{
    dataset *none;

    ck_assert_int_eq(synth_stream_open(&(synth_stream_options){ .count = 0, .shrink = 2 }, &none), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "a stream of 0 pictures of 640 x 480 over 2, expected some, over 1 to 4");
    ck_assert_int_eq(synth_stream_open(&(synth_stream_options){ .count = 1, .shrink = 5 }, &none), LT_EINVAL);
    ck_assert_int_eq(dataset_open(&(dataset_options){ .kind = &synth_stream_kind }, &none), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "stream: a stream of pictures has no folder");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 300);
    tcase_add_unchecked_fixture(tc, setup, teardown);
    tcase_add_test(tc, any_order);
    tcase_add_test(tc, any_number_of_threads);
    tcase_add_test(tc, truth_fits);
    tcase_add_test(tc, near_hands);
    tcase_add_test(tc, bad_options);
}

int main(void)
{
    return run_suite("stream", add_tests);
}
