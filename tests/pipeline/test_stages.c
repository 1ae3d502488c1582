/* SPDX-License-Identifier: Apache-2.0 */
/* Stages in a row: which may follow which, a frame through them, and one that is lost on the way. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

#include "tests/estimate/tiny_model.h"
#include "tests/suite.h"

static tiny_model tiny;
static lt_arena *arena;
static uint8_t pixels[3 * 80 * 60];

static predict_options options(void)
{
    return (predict_options){ .m = &tiny.m, .hand = tiny.hand };
}

/* Every stage has a name of its own and does something. */
START_TEST(table)
{
    for (const stage *const *s = stages; *s; s++) {
        ck_assert_ptr_nonnull((*s)->run);
        for (const stage *const *other = stages; other < s; other++)
            ck_assert_str_ne((*other)->name, (*s)->name);
    }
}
END_TEST

START_TEST(order)
{
    const char *const unknown[] = { "read", "think", NULL }, *const early[] = { "read", "solve", NULL };
    const char *const given[] = { "estimate", NULL };
    const predict_options o = options();
    pipeline *p;

    check_error(pipeline_open(&o, 0, unknown, &p), LT_EINVAL, "no stage is called \"think\"");
    check_error(pipeline_open(&o, 0, early, &p), LT_EINVAL, "stage \"solve\" needs what no stage before it gives");
    check_error(pipeline_open(&o, 0, given, &p), LT_EINVAL, "stage \"estimate\" needs");
    check_ok(pipeline_open(&o, FRAME_VIEWS, given, &p));
    pipeline_close(p);
}
END_TEST

static predict_view view_of(float x)
{
    return (predict_view){
        .path = "a frame", .rgb = pixels, .width = 80, .height = 60, .camera = { 100, 100, 39.5, 29.5 },
        .hand_box = { x, 10, x + 40, 50 }, .object_box = { x, 10, x + 40, 50 },
    };
}

/* The numbers of a hand do not depend on which others are in the frame, nor on the side that these are of. */
START_TEST(hands_apart)
{
    const char *const names[] = { "estimate", "solve", NULL };
    const predict_options o = options();
    predict_view v[3] = { view_of(5), view_of(30), view_of(5) };
    predict_frame all = { .o = &o, .arena = arena, .n = 3, .view = v };
    predict_frame one = { .o = &o, .arena = arena, .n = 1, .view = &v[1] };
    pipeline *p;

    for (size_t i = 0; i < sizeof(pixels); i++)
        pixels[i] = (uint8_t)(i * i / 7);
    v[0].left = true;
    check_ok(pipeline_open(&o, FRAME_VIEWS, names, &p));
    check_ok(pipeline_run(p, &all));
    check_ok(pipeline_run(p, &one));
    ck_assert_uint_eq(all.has, FRAME_ESTIMATES | FRAME_POSES);
    ck_assert_mem_eq(all.result[1].e.joints, one.result->e.joints, sizeof(one.result->e.joints));
    ck_assert_mem_ne(all.result[0].e.joints, all.result[2].e.joints, sizeof(one.result->e.joints));
    pipeline_close(p);
}
END_TEST

static const predict_result *looked_at(predict_options *o, predict_view *v)
{
    const char *const names[] = { "estimate", "solve", NULL };
    predict_frame f = { .o = o, .arena = arena, .n = 1, .view = v };
    pipeline *p;

    check_ok(pipeline_open(o, FRAME_VIEWS, names, &p));
    check_ok(pipeline_run(p, &f));
    pipeline_close(p);
    return f.result;
}

/* A hand that may stand any way up, or be of either side, is told as the look that agrees best has it: never worse than
 * the first look, on the side that the view then says, and the same for whoever asks for that side and no other. */
START_TEST(the_best_look)
{
    predict_options once = options(), any = once;
    predict_view first = view_of(20), v = first, sure = first;
    const predict_result *best, *same;

    for (size_t i = 0; i < sizeof(pixels); i++)
        pixels[i] = (uint8_t)(i * i / 11);
    any.any_way_up = v.any_side = true;
    best = looked_at(&any, &v);
    ck_assert(!best->placed || !(best->agreement_px > looked_at(&once, &first)->agreement_px));
    sure.left = v.left;
    same = looked_at(&any, &sure);
    ck_assert_mem_eq(best->e.joints, same->e.joints, sizeof(same->e.joints));
    ck_assert_mem_eq(best->heatmap2d, same->heatmap2d, sizeof(same->heatmap2d));
}
END_TEST

/* In a film a hand of unknown side is looked at from both when it is new, and then stays what it was. */
START_TEST(a_film_keeps_the_side)
{
    const char *const names[] = { "estimate", "solve", "smooth", NULL };
    predict_options o = options();
    const predict_detection seen = { .kind = DETECTED_HAND };
    predict_followed film = { .arena = arena, .dt = 1.0 / 30 };
    predict_view v = view_of(20), still = v;
    predict_frame f = { .o = &o, .arena = arena, .film = &film, .n = 1, .view = &v };
    pipeline *p;

    for (size_t i = 0; i < sizeof(pixels); i++)
        pixels[i] = (uint8_t)(i * i / 11);
    v.any_side = still.any_side = true;
    v.hand_seen = &seen;
    looked_at(&o, &still);
    check_ok(pipeline_open(&o, FRAME_VIEWS, names, &p));
    check_ok(pipeline_run(p, &f));
    ck_assert(v.left == still.left);
    for (int left = 0; left < 2; left++) {
        film.smoother[0].left = left;
        v.left = !left;
        f.has = 0;
        check_ok(pipeline_run(p, &f));
        ck_assert_int_eq(v.left, left);
        ck_assert_uint_eq(film.n, 1);
    }
    pipeline_close(p);
}
END_TEST

/* A frame that cannot be read is one in which a film's hands are not seen. */
START_TEST(missed)
{
    const char *const names[] = { "read", "look", "estimate", "solve", "smooth", NULL };
    const predict_options o = options();
    predict_followed film = { .arena = arena, .dt = 1.0 / 30 };
    predict_frame f = { .o = &o, .arena = arena, .notes.arena = arena, .film = &film, .input.path = "nowhere.png" };
    const lt_image picture = { 80, 60, 3, 8, pixels };
    predict_frame seen = f;
    pipeline *p;

    seen.picture = &picture;
    check_ok(pipeline_open(&o, 0, names, &p));
    check_ok(pipeline_run(p, &seen));
    ck_assert_uint_eq(film.n, 1);
    for (int k = 0; k <= PREDICT_COAST; k++) {
        ck_assert_uint_eq(film.n, 1);
        ck_assert_int_eq(pipeline_run(p, &f), LT_EIO);
        ck_assert(f.forgiven);
    }
    ck_assert_uint_eq(film.n, 0);
    pipeline_close(p);
}
END_TEST

static void setup(void)
{
    arena = lt_arena_new();
    tiny_model_init(&tiny);
}

static void teardown(void)
{
    tiny_model_fini(&tiny);
    lt_arena_free(arena);
}

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 60);
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_add_test(t, table);
    tcase_add_test(t, order);
    tcase_add_test(t, hands_apart);
    tcase_add_test(t, the_best_look);
    tcase_add_test(t, a_film_keeps_the_side);
    tcase_add_test(t, missed);
}

int main(void)
{
    return run_suite("stages", add_tests);
}
