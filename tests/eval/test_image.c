/* SPDX-License-Identifier: Apache-2.0 */
/* PSNR and SSIM against NumPy and SciPy, and against the figures of formulas that a pencil can do. */
#include "eval/metrics/image.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"
#include "tests/eval/image_vectors.h"
#include "tests/eval/lcg.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { MOST = 3 * 64 * 96 };

static float a[MOST], b[MOST];

static eval_pictures pictures(int channels, int height, int width)
{
    return (eval_pictures){ a, b, channels, height, width, (int64_t)height * width, width };
}

static double ssim(const eval_pictures *p, eval_ssim_form form)
{
    double s;

    check_ok(eval_ssim(p, form, &s));
    return s;
}

/* The twin of images() in scripts/vectors/metrics.py */
static eval_pictures draw(int kind)
{
    static const int size[5][3] = { { 3, 37, 53 }, { 1, 11, 11 }, { 3, 16, 90 }, { 2, 40, 12 }, { 3, 45, 33 } };
    static const float noise[5] = { 0.02f, 0.3f, 1, 0.1f, 0.005f };
    const eval_pictures p = pictures(size[kind][0], size[kind][1], size[kind][2]);
    const int n = p.channels * p.height * p.width;
    uint32_t state = 400 + (uint32_t)kind;

    for (int i = 0; i < n; i++)
        a[i] = (float)(0.5 + 0.5 * lcg(&state));
    for (int i = 0; i < n && kind == 4; i++)
        if (i / p.width % p.height >= 9 && i % p.width >= 8)
            a[i] = 0.9f;
    for (int i = 0; i < n; i++)
        b[i] = a[i] + noise[kind] * (float)lcg(&state);
    return p;
}

START_TEST(as_numpy_has_it)
{
    const eval_pictures p = draw(_i);
    uint8_t mask[64 * 96];

    for (int i = 0; i < p.height * p.width; i++)
        mask[i] = a[i] > 0.5f;
    ck_assert_double_eq_tol(eval_psnr(&p, NULL), image_wanted[_i][0], 1e-6);
    ck_assert_double_eq_tol(eval_psnr(&p, mask), image_wanted[_i][1], 1e-6);
    ck_assert_double_eq_tol(ssim(&p, EVAL_SSIM_VALID), image_wanted[_i][2], 2e-6);
    ck_assert_double_eq_tol(ssim(&p, EVAL_SSIM_ZERO_PADDED), image_wanted[_i][3], 2e-6);
}
END_TEST

START_TEST(known_pictures)
{
    const eval_pictures p = pictures(1, 16, 16);

    for (int i = 0; i < 16; i++)
        for (int j = 0; j < 16; j++) {
            a[16 * i + j] = (float)((3 * i + 5 * j) % 16) / 15;
            b[16 * i + j] = 0.9f * a[16 * i + j] + 0.05f;
        }
    ck_assert_double_eq_tol(eval_psnr(&p, NULL), 30.248236, 1e-5);
    ck_assert_double_eq_tol(ssim(&p, EVAL_SSIM_ZERO_PADDED), 0.995697, 1e-6);
    ck_assert_double_eq_tol(ssim(&p, EVAL_SSIM_VALID), 0.994501, 1e-6);
    for (int i = 0; i < 256; i++)
        a[i] = 0.5f, b[i] = 0.6f;
    ck_assert_double_eq_tol(eval_psnr(&p, NULL), 20, 1e-5);             /* d^2 = 0.01 less D^2 rounds to 2e-9, ... */
    ck_assert_double_eq_tol(ssim(&p, EVAL_SSIM_VALID), 0.983609, 4e-6);         /* ... twice of it over 2 C2 */
    ck_assert_double_eq_tol(ssim(&p, EVAL_SSIM_ZERO_PADDED), 0.971204, 4e-6);
    ck_assert_str_eq(eval_ssim_name(EVAL_SSIM_VALID), "ssim valid");
    ck_assert_str_eq(eval_ssim_name(EVAL_SSIM_ZERO_PADDED), "ssim zero-padded");
}
END_TEST

START_TEST(alike_and_beyond)
{
    const eval_pictures p = draw(0);
    const uint8_t none[37 * 53] = { 0 };

    memcpy(b, a, sizeof(b));
    ck_assert_double_infinite(eval_psnr(&p, NULL));
    ck_assert_double_nan(eval_psnr(&p, none));
    ck_assert_double_eq_tol(ssim(&p, EVAL_SSIM_VALID), 1, 1e-7);
    b[700] = NAN;
    ck_assert_double_nan(eval_psnr(&p, NULL));
    ck_assert_double_nan(ssim(&p, EVAL_SSIM_VALID));
    ck_assert_double_nan(ssim(&(eval_pictures){ a, b, 1, 10, 20, 200, 20 }, EVAL_SSIM_VALID));      /* no window fits */
}
END_TEST

/* A part is what a picture of its own would be. */
START_TEST(within_the_box_of_a_mask)
{
    eval_pictures p = draw(0), part;
    uint8_t mask[37 * 53] = { 0 };
    float own[2][3 * 21 * 30];
    eval_box box;

    ck_assert(!eval_mask_box(mask, 37, 53, &box));
    mask[4 * 53 + 40] = mask[24 * 53 + 11] = 1;
    ck_assert(eval_mask_box(mask, 37, 53, &box));
    ck_assert(box.x0 == 11 && box.y0 == 4 && box.x1 == 41 && box.y1 == 25);
    part = eval_pictures_within(&p, box);
    for (int i = 0; i < 3 * 21 * 30; i++) {
        const int at = i / 630 * 37 * 53 + (4 + i / 30 % 21) * 53 + 11 + i % 30;

        own[0][i] = a[at];
        own[1][i] = b[at];
    }
    p = (eval_pictures){ own[0], own[1], 3, 21, 30, 630, 30 };
    ck_assert_double_eq(eval_psnr(&part, NULL), eval_psnr(&p, NULL));
    ck_assert_double_eq(ssim(&part, EVAL_SSIM_ZERO_PADDED), ssim(&p, EVAL_SSIM_ZERO_PADDED));
}
END_TEST

START_TEST(any_number_of_threads)
{
    const eval_pictures p = draw(0);
    double one;

    lt_set_threads(1);
    one = ssim(&p, EVAL_SSIM_VALID);
    lt_set_threads(3);
    ck_assert_double_eq(ssim(&p, EVAL_SSIM_VALID), one);
    lt_set_threads(0);
}
END_TEST

START_TEST(without_memory)
{
    const eval_pictures p = draw(0);
    double s;

    lt_alloc_fail_at(1);
    check_error(eval_ssim(&p, EVAL_SSIM_VALID, &s), LT_ENOMEM, "no memory to compare pictures");
    lt_alloc_fail_at(2);
    check_error(eval_ssim(&p, EVAL_SSIM_VALID, &s), LT_ENOMEM, "no memory to compare pictures");
    lt_alloc_fail_at(0);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_loop_test(t, as_numpy_has_it, 0, 5);
    tcase_add_test(t, known_pictures);
    tcase_add_test(t, alike_and_beyond);
    tcase_add_test(t, within_the_box_of_a_mask);
    tcase_add_test(t, any_number_of_threads);
    tcase_add_test(t, without_memory);
}

int main(void)
{
    return run_suite("image metrics", add_tests);
}
