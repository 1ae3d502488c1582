/* SPDX-License-Identifier: Apache-2.0 */
/* Average precision: cases by hand, and scripts/vectors/ap.py's after pycocotools. */
#include "eval/metrics/ap.h"
#include "libtensor/io/array/npz.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>

static const ap_range any = { 0, 1e10 };

static double ap50(const ap_image *image, int n, ap_range area)
{
    double ap[AP_THRESHOLDS];

    check_ok(ap_measure(image, n, 1, area, ap));
    return ap[0];
}

/* Two objects: one found at once, the other behind a wrong one. Precision 1 up to a recall of 0.5, 2/3 beyond. */
START_TEST(by_hand)
{
    const ap_found found[] = { { 0, 0.9, 100 }, { 0, 0.8, 100 }, { 0, 0.7, 100 } };
    const ap_truth truth[] = { { 0, 100, false }, { 0, 100, false } };
    const float iou[] = { 0.6f, 0, 0, 0.1f, 0, 0.99f };
    const ap_image image = { found, truth, 3, 2, iou };
    double ap[AP_THRESHOLDS];

    ck_assert_double_eq_tol(ap50(&image, 1, any), (51 + 50 * 2.0 / 3) / 101, 1e-12);
    check_ok(ap_measure(&image, 1, 1, any, ap));
    ck_assert_double_eq_tol(ap[3], 51 * (1.0 / 3) / 101, 1e-12);        /* at 0.65 the first is wrong, too */
    ck_assert_double_eq(ap_mean(ap, 0, 1, 1), ap[0]);
}
END_TEST

/* The second finding of one object is wrong; what lies in a crowd is neither right nor wrong. */
START_TEST(twice_and_crowds)
{
    const ap_found found[] = { { 0, 0.9, 100 }, { 0, 0.8, 100 }, { 0, 0.7, 100 } };
    const ap_truth truth[] = { { 0, 100, false }, { 0, 900, true } };
    const float twice[] = { 0.9f, 0, 0.8f, 0, 0, 0 }, crowd[] = { 0, 0.9f, 0.8f, 0.9f, 0, 0.8f };

    ck_assert_double_eq(ap50(&(ap_image){ found, truth, 2, 2, twice }, 1, any), 1);
    ck_assert_double_eq(ap50(&(ap_image){ found + 1, truth, 2, 2, twice }, 1, any), 1);
    ck_assert_double_eq(ap50(&(ap_image){ found, truth, 3, 2, crowd }, 1, any), 1);
}
END_TEST

START_TEST(nothing)
{
    const ap_found found[] = { { 0, 0.9, 100 } };
    const ap_truth truth[] = { { 0, 100, false } };
    const float iou[] = { 1 };

    ck_assert_double_nan(ap50(NULL, 0, any));
    ck_assert_double_nan(ap50(&(ap_image){ found, NULL, 1, 0, iou }, 1, any));
    ck_assert_double_eq(ap50(&(ap_image){ NULL, truth, 0, 1, iou }, 1, any), 0);
    ck_assert_double_nan(ap50(&(ap_image){ found, truth, 1, 1, iou }, 1, (ap_range){ 200, 300 }));
    ck_assert_double_eq(ap50(&(ap_image){ found, truth, 1, 1, iou }, 1, any), 1);
}
END_TEST

/* cocoeval's evaluateImg cuts at 100 findings of an image and a class. The 100th is right, after 99 that are wrong:
 * precision 0.01 at every recall; the 101st does not count. Another class has its own hundred. */
START_TEST(a_hundred_of_a_class)
{
    static float iou[2 * 121];
    static ap_found found[121];
    const ap_truth truth[] = { { 0, 100, false }, { 1, 100, false } };
    const ap_image image = { found, truth, 121, 2, iou };
    double ap[2 * AP_THRESHOLDS];

    for (int i = 0; i < 121; i++)
        found[i] = (ap_found){ i == 120, 0.99 - 0.001 * i, 100 };
    iou[2 * 120 + 1] = 1;
    iou[2 * 99] = 1;
    check_ok(ap_measure(&image, 1, 2, any, ap));
    ck_assert_double_eq_tol(ap[0], 0.01, 1e-12);
    ck_assert_double_eq(ap[AP_THRESHOLDS], 1);
    iou[2 * 99] = 0;
    iou[2 * 100] = 1;
    check_ok(ap_measure(&image, 1, 2, any, ap));
    ck_assert_double_eq(ap[0], 0);
}
END_TEST

/* ---- many images ---- */

enum { IMAGES = 30, CLASSES = 3, MOST = 64 };

static ap_found found[IMAGES][MOST];
static ap_truth truth[IMAGES][MOST];
static ap_image images[IMAGES];

static void read_images(const lt_npz *npz, lt_arena *arena)
{
    const lt_array *f, *t, *iou;
    float *all;

    check_ok(lt_npz_get(npz, "found", &f));
    check_ok(lt_npz_get(npz, "truth", &t));
    check_ok(lt_npz_get(npz, "iou", &iou));
    for (size_t k = 0; k < lt_array_count(f) / 4; k++) {
        ap_image *to = &images[lt_array_int(f, 4 * k)];

        found[to - images][to->n_found++] = (ap_found){ (int)lt_array_get(f, 4 * k + 1), lt_array_get(f, 4 * k + 2),
                                                        lt_array_get(f, 4 * k + 3) };
    }
    for (size_t k = 0; k < lt_array_count(t) / 4; k++) {
        ap_image *to = &images[lt_array_int(t, 4 * k)];

        truth[to - images][to->n_truth++] = (ap_truth){ (int)lt_array_get(t, 4 * k + 1), lt_array_get(t, 4 * k + 2),
                                                        lt_array_get(t, 4 * k + 3) > 0 };
    }
    all = lt_arena_array(arena, lt_array_count(iou) + 1, sizeof(*all));
    for (size_t k = 0; k < lt_array_count(iou); k++)
        all[k] = (float)lt_array_get(iou, k);
    for (int i = 0; i < IMAGES; i++) {
        images[i].found = found[i];
        images[i].truth = truth[i];
        images[i].iou = all;
        all += images[i].n_found * images[i].n_truth;
    }
}

START_TEST(as_pycocotools)
{
    static const struct { const char *name; ap_range area; } ranges[] = {
        { "all", { 0, 1e10 } }, { "small", { 0, 32 * 32 } }, { "large", { 96 * 96, 1e10 } },
    };
    const char *srcdir = getenv("srcdir");
    lt_arena *arena = lt_arena_new();
    lt_npz npz;

    check_ok(lt_npz_read(arena, lt_arena_printf(arena, "%s/tests/vectors/ap.npz", srcdir ? srcdir : ".."), &npz));
    read_images(&npz, arena);
    for (size_t r = 0; r < LT_COUNT(ranges); r++) {
        double ap[CLASSES * AP_THRESHOLDS];
        const lt_array *want;

        check_ok(lt_npz_get(&npz, ranges[r].name, &want));
        check_ok(ap_measure(images, IMAGES, CLASSES, ranges[r].area, ap));
        for (size_t k = 0; k < LT_COUNT(ap); k++)
            ck_assert_msg(fabs(ap[k] - lt_array_get(want, k)) < 1e-12, "%s[%zu]: %.15g, want %.15g", ranges[r].name, k,
                          ap[k], lt_array_get(want, k));
    }
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_test(tc, by_hand);
    tcase_add_test(tc, twice_and_crowds);
    tcase_add_test(tc, nothing);
    tcase_add_test(tc, a_hundred_of_a_class);
    tcase_add_test(tc, as_pycocotools);
}

int main(void)
{
    return run_suite("ap", add_tests);
}
