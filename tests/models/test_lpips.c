/* SPDX-License-Identifier: Apache-2.0 */
/* LPIPS against its PyTorch twin of scripts/peers, of whole images and of boxes that are data. */
#include "libtensor/base/parallel.h"
#include "libtensor/graph/plan.h"
#include "libtensor/io/array/npz.h"
#include "models/backbones/lpips.h"
#include "tests/geometry/hashed_hand.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { B = 2, H = 45, W = 61, N = B * 3 * H * W };

static lt_arena *arena;
static lt_params *params;
static lpips m;
static lt_npz npz;

/* ---- the numbers of scripts/vectors/models.py ---------------------------------------------------------- */

static uint32_t seed_of(const char *name)
{
    uint32_t h = 2166136261u;

    for (; *name; name++)
        h = (h ^ (unsigned char)*name) * 16777619u;
    return h;
}

static void fill_parameter(lt_param *p)
{
    const int64_t n = lt_param_numel(p);
    const double scale = p->shape.rank > 1 ? sqrt(3 / (double)(n / p->shape.dim[0])) : 0.125;

    for (int64_t i = 0; i < n; i++)
        p->data[i] = (lt_real)(scale * hashed(seed_of(p->name), (uint32_t)i));
}

static void fill_image(const char *name, lt_real *x)
{
    for (uint32_t i = 0; i < N; i++)
        x[i] = (lt_real)(hashed(seed_of(name), i) / 2 + 0.5);
}

static void start(void)
{
    const char *srcdir = getenv("srcdir");

    arena = lt_arena_new();
    check_ok(lt_npz_read(arena, lt_arena_printf(arena, "%s/tests/vectors/models/lpips.npz", srcdir ? srcdir : ".."),
                         &npz));
    params = lt_params_new();
    lpips_new(&m, params, "");
    check_ok(lt_params_status(params));
    for (lt_param *p = lt_params_first(params); p; p = p->next)
        fill_parameter(p);
}

static void stop(void)
{
    lt_params_free(params);
    lt_arena_free(arena);
}

static double wanted(const char *name, size_t i)
{
    const lt_array *a;

    check_ok(lt_npz_get(&npz, name, &a));
    return lt_array_get(a, i);
}

/* ---- one run ------------------------------------------------------------------------------------------- */

/* The hashed images, cut to w x h from (x, y) on, at distance y[B]; with dx the gradient of sum(dy * distance). boxes
 * may be NULL. */
typedef struct { int x, y, w, h; } cut;

static void copy_cut(cut c, const char *name, lt_real *to)
{
    lt_real all[N];

    fill_image(name, all);
    for (int i = 0; i < B * 3 * c.h; i++)
        memcpy(to + i * c.w, all + (i / c.h * H + c.y + i % c.h) * W + c.x, (size_t)c.w * sizeof(*to));
}

static void distances(cut c, lpips_range range, const lt_real *boxes, const lt_real *dy, lt_real y[B], lt_real *dx)
{
    lt_graph *g = lt_graph_new();
    const int64_t shape[] = { B, 3, c.h, c.w }, four[] = { B, 4 }, one[] = { B };
    lt_tensor *image = lt_input(g, "image", LT_F32, 4, shape), *truth = lt_input(g, "truth", LT_F32, 4, shape);
    lt_tensor *box = boxes ? lt_input(g, "boxes", LT_F32, 2, four) : NULL, *loss = NULL, *out, *weight;
    lt_plan *p;

    if (dx)
        lt_want_grad(image);
    out = lt_output(lpips_distance(&m, range, image, truth, box), "distance");
    if (dx) {
        weight = lt_input(g, "weight", LT_F32, 1, one);
        loss = lt_sum(lt_mul(out, weight));
    }
    p = lt_compile(g, &(lt_compile_opts){ .train = dx != NULL, .loss = loss });
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    copy_cut(c, "image", lt_plan_data(p, image));
    copy_cut(c, "truth", lt_plan_data(p, truth));
    if (boxes)
        memcpy(lt_plan_data(p, box), boxes, B * 4 * sizeof(*boxes));
    if (dx)
        memcpy(lt_plan_data(p, weight), dy, B * sizeof(*dy));
    lt_run(p);
    lt_run(p);                                      /* nothing is left behind by a run */
    memcpy(y, lt_plan_data(p, out), B * sizeof(*y));
    if (dx)
        memcpy(dx, lt_plan_grad(p, image), (size_t)lt_numel(image) * sizeof(*dx));
    lt_plan_free(p);
    lt_graph_free(g);
}

static const cut whole = { 0, 0, W, H };
static const lt_real the_boxes[B * 4] = { 3, 5, 40, 44, 0, 0, 61, 45 }, weights[B] = { 1, -0.5f };

static void expect_distances(const char *name, const lt_real y[B])
{
    for (size_t i = 0; i < B; i++)
        ck_assert_double_eq_tol(y[i], wanted(name, i), 2e-6 * fabs(wanted("distance", 0)));
}

START_TEST(as_pytorch_has_it)
{
    const lt_array *names;
    lt_real y[B];

    check_ok(lt_npz_get(&npz, "names", &names));
    for (size_t i = 0; i < lt_array_count(names); i++)
        ck_assert_msg(lt_params_find(params, lt_array_text(names, i)) != NULL, "%s", lt_array_text(names, i));
    distances(whole, LPIPS_SYM, NULL, NULL, y, NULL);
    expect_distances("distance", y);
    distances(whole, LPIPS_RAW01, NULL, NULL, y, NULL);
    expect_distances("raw01", y);
}
END_TEST

START_TEST(a_box_as_pytorch_has_the_cut)
{
    static lt_real dx[N];
    double most = 0, largest = 0;
    lt_real y[B];

    distances(whole, LPIPS_SYM, the_boxes, weights, y, dx);
    expect_distances("boxed", y);
    for (size_t i = 0; i < N; i++) {
        const double want = wanted("gradient", i);

        most = fmax(most, fabs((double)dx[i] - want));
        largest = fmax(largest, fabs(want));
    }
    ck_assert_double_lt(most, 1e-5 * largest);
}
END_TEST

/* Whatever lies around a box: the same bits as of images that were cut, in training too, with any number of threads. */
START_TEST(a_box_is_a_cut)
{
    static const cut c = { 3, 5, 37, 39 };
    static const lt_real both[B * 4] = { 3, 5, 40, 44, 3, 5, 40, 44 };
    static lt_real dx[N], dx_cut[N];
    lt_real y[B], y_cut[B];

    lt_set_threads(1);
    distances(whole, LPIPS_SYM, both, weights, y, dx);
    lt_set_threads(3);
    distances(c, LPIPS_SYM, NULL, weights, y_cut, dx_cut);
    lt_set_threads(0);
    ck_assert_mem_eq(y, y_cut, sizeof(y));
    for (int i = 0; i < N; i++) {
        const int row = i / W % H - c.y, column = i % W - c.x;
        const bool inside = row >= 0 && row < c.h && column >= 0 && column < c.w;

        ck_assert(dx[i] == (inside ? dx_cut[(i / W / H * c.h + row) * c.w + column] : 0));
    }
    distances(c, LPIPS_SYM, NULL, NULL, y, NULL);
    ck_assert_mem_eq(y, y_cut, sizeof(y));
}
END_TEST

START_TEST(boxes_grow_and_may_be_empty)
{
    static const lt_real small[B * 4] = { 58, 10, 60, 20, -5, -5, 3, 3 };
    static const lt_real grown[B * 4] = { 30, 0, 61, 31, 0, 0, 31, 31 };
    static const lt_real rounded[B * 4] = { 3.5f, 5.2f, 39.5f, 43.1f, -1, -2, 80, 90 };
    static const lt_real nothing[B * 4] = { 10, 10, 10, 40, NAN, 0, 50, 40 };
    static lt_real dx[N];
    lt_real y[B], z[B];

    distances(whole, LPIPS_SYM, small, NULL, y, NULL);
    distances(whole, LPIPS_SYM, grown, NULL, z, NULL);
    ck_assert_mem_eq(y, z, sizeof(y));
    distances(whole, LPIPS_SYM, rounded, NULL, y, NULL);
    expect_distances("boxed", y);
    distances(whole, LPIPS_SYM, nothing, weights, y, dx);
    ck_assert(y[0] == 0 && y[1] == 0);
    for (int i = 0; i < N; i++)
        ck_assert(dx[i] == 0);
}
END_TEST

START_TEST(a_random_trunk_says_so)
{
    ck_assert_str_eq(lpips_name(&m), "lpips");
    lpips_init(&m);
    ck_assert_str_eq(lpips_name(&m), "lpips (random trunk)");
    for (lt_param *p = lt_params_first(params); p; p = p->next)
        if (strstr(p->name, "features"))
            fill_parameter(p);
    ck_assert(lpips_is_random(&m));                 /* the channels are all alike still */
    for (lt_param *p = lt_params_first(params); p; p = p->next)
        fill_parameter(p);
    ck_assert(!lpips_is_random(&m));
}
END_TEST

static void expect_refusal(lt_shape image, lt_shape truth, lt_shape boxes, const char *reason)
{
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, image.rank, image.dim);
    lt_tensor *y = lt_input(g, "y", LT_F32, truth.rank, truth.dim);
    lt_tensor *box = lt_input(g, "boxes", LT_F32, boxes.rank, boxes.dim);

    lt_output(lpips_distance(&m, LPIPS_SYM, x, y, box), "distance");
    ck_assert_ptr_null(lt_compile(g, NULL));
    ck_assert_msg(strstr(lt_last_error(), reason) != NULL, "%s", lt_last_error());
    lt_graph_free(g);
}

START_TEST(bad_images)
{
    const lt_shape image = LT_SHAPE(2, 3, 40, 50), boxes = LT_SHAPE(2, 4);

    expect_refusal(LT_SHAPE(2, 3, 40), image, boxes, "lpips: image is (2, 3, 40), want 4 dimensions");
    expect_refusal(image, LT_SHAPE(2, 3, 40, 51), boxes, "lpips: truth is (2, 3, 40, 51), want (2, 3, 40, 50)");
    expect_refusal(LT_SHAPE(2, 1, 40, 50), LT_SHAPE(2, 1, 40, 50), boxes,
                   "lpips: image has 1 channels, want red, green and blue");
    expect_refusal(LT_SHAPE(2, 3, 30, 50), LT_SHAPE(2, 3, 30, 50), boxes,
                   "lpips: image is 50 x 30 pixels, want sides of 31 to 4096");
    expect_refusal(image, image, LT_SHAPE(3, 4), "lpips: boxes is (3, 4), want (2, 4)");
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, start, stop);
    tcase_add_test(t, as_pytorch_has_it);
    tcase_add_test(t, a_box_as_pytorch_has_the_cut);
    tcase_add_test(t, a_box_is_a_cut);
    tcase_add_test(t, boxes_grow_and_may_be_empty);
    tcase_add_test(t, a_random_trunk_says_so);
    tcase_add_test(t, bad_images);
}

int main(void)
{
    return run_suite("lpips", add_tests);
}
