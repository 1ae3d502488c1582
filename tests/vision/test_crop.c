/* SPDX-License-Identifier: Apache-2.0 */
/* Boxes, windows, warps, masks, colours: what happens to a picture before a network sees it. */
#include "tests/suite.h"
#include "tests/vision/augment_vectors.h"
#include "vision/augment.h"
#include "vision/crop.h"
#include "vision/silhouette.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { W = 640, H = 480, S = 256 };

/* An image whose every pixel says where it is. */
static uint8_t *place_image(void)
{
    uint8_t *rgb = malloc((size_t)W * H * 3);

    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            uint8_t *p = rgb + 3 * (y * W + x);
            p[0] = (uint8_t)(x & 255);
            p[1] = (uint8_t)(y & 255);
            p[2] = (uint8_t)(1 + (x >> 8) + 16 * (y >> 8));
        }
    return rgb;
}

/* The pixel that crop pixel (x, y) shows; false where it is black. */
static bool shown(const float *crop, int x, int y, int *sx, int *sy)
{
    const int i = y * S + x;
    const int r = (int)lrintf(crop[i] * 255), g = (int)lrintf(crop[S * S + i] * 255);
    const int b = (int)lrintf(crop[2 * S * S + i] * 255) - 1;

    if (b < 0)
        return false;
    *sx = r + 256 * (b & 15);
    *sy = g + 256 * (b >> 4);
    return true;
}

static const crop_window turned = { .cx = 300, .cy = 210, .side = 220, .angle = 0.7 };

START_TEST(box_is_cut_to_whole_centre)
{
    const float p[3][2] = { { 10.2f, 20 }, { 13.5f, 40 }, { 11, 31.5f } };
    const crop_box b = crop_box_around(p, 3, 1.5);

    ck_assert_float_eq_tol(b.x0, 11 - 3.3f * 0.75f, 1e-5);      /* (10.2 + 13.5) / 2 = 11.85 -> 11 */
    ck_assert_float_eq_tol(b.x1, 11 + 3.3f * 0.75f, 1e-5);
    ck_assert_float_eq_tol(b.y0, 30 - 15, 1e-5);
    ck_assert_float_eq_tol(b.y1, 30 + 15, 1e-5);
}
END_TEST

START_TEST(window_is_clamped)
{
    const crop_box hand = { -50, 100, 200, 301 }, object = { 150, 120, 260, 400 };
    const crop_window w = crop_window_around(hand, object, W, H);

    ck_assert_double_eq(w.cx, 130);
    ck_assert_double_eq(w.cy, 250);
    ck_assert_double_eq(w.side, 300);
    ck_assert_double_eq(w.angle, 0);
}
END_TEST

START_TEST(window_outside_is_a_pixel)
{
    const crop_box far = { 900, 900, 950, 950 };

    ck_assert_double_eq(crop_window_around(far, far, W, H).side, 1);
}
END_TEST

START_TEST(centre_goes_to_the_middle)
{
    const float in[1][2] = { { 300, 210 } };
    float out[1][2];
    double A[6];

    crop_affine(turned, S, A);
    crop_points(A, in, 1, out);
    ck_assert_float_eq_tol(out[0][0], S / 2, 1e-3);
    ck_assert_float_eq_tol(out[0][1], S / 2, 1e-3);
}
END_TEST

/* A point of the image and its place in the crop show the same thing, to the half pixel by which pixel
 * centres differ and the pixel that "nearest" may be off. */
START_TEST(points_follow_the_picture)
{
    uint8_t *rgb = place_image();
    float *crop = malloc(sizeof(float) * 3 * S * S);
    double A[6];
    int seen = 0;

    crop_affine(turned, S, A);
    crop_warp(A, rgb, W, H, NULL, crop, S, false);
    for (int i = 0; i < 500; i++) {
        const float in[1][2] = { { (float)(200 + 37 * i % 200), (float)(110 + 53 * i % 200) } };
        float out[1][2];
        int x, y, sx, sy;
        crop_points(A, in, 1, out);
        x = (int)floorf(out[0][0]);
        y = (int)floorf(out[0][1]);
        if (x < 0 || x >= S || y < 0 || y >= S || !shown(crop, x, y, &sx, &sy))
            continue;
        ck_assert_int_le(abs(sx - (int)in[0][0]), 1);
        ck_assert_int_le(abs(sy - (int)in[0][1]), 1);
        seen++;
    }
    ck_assert_int_gt(seen, 300);
    free(rgb);
    free(crop);
}
END_TEST

/* Output centre (x + 0.5, y + 0.5) mapped back and cut down; worked out here by hand for a window that
 * does not turn: u = (x + 0.5) * side / S + cx - side / 2. */
START_TEST(nearest_is_defined)
{
    const crop_window w = { .cx = 50, .cy = 400, .side = 300 };
    uint8_t *rgb = place_image();
    float *crop = malloc(sizeof(float) * 3 * S * S);
    double A[6];

    crop_affine(w, S, A);
    crop_warp(A, rgb, W, H, NULL, crop, S, false);
    for (int y = 0; y < S; y++)
        for (int x = 0; x < S; x++) {
            const int u = (int)floor((x + 0.5) * 300 / S + 50 - 150);
            const int v = (int)floor((y + 0.5) * 300 / S + 400 - 150);
            int sx = -1, sy = -1;
            const bool in = shown(crop, x, y, &sx, &sy);
            ck_assert_int_eq(in, u >= 0 && v < H);
            if (in) {
                ck_assert_int_eq(sx, u);
                ck_assert_int_eq(sy, v);
            }
        }
    free(rgb);
    free(crop);
}
END_TEST

START_TEST(bilinear_mixes)
{
    uint8_t rgb[2 * 1 * 3] = { 0, 0, 0, 255, 255, 255 };
    float crop[3 * 4];
    const double A[6] = { 1, 0, 0.5, 0, 1, 0 };         /* half a pixel to the right */

    crop_warp(A, rgb, 2, 1, NULL, crop, 2, true);
    ck_assert_float_eq_tol(crop[0], 0, 1e-6);
    ck_assert_float_eq_tol(crop[1], 0.5, 1e-6);
}
END_TEST

START_TEST(intrinsics_follow)
{
    const lt_camera cam = { 610, 612, 318, 243 };
    const double p[3] = { 0.05, -0.02, 0.6 };
    double A[6], uv[2], q[3];
    float K[9];

    crop_affine(turned, S, A);
    crop_intrinsics(A, &cam, K);
    lt_camera_project(&cam, p, uv);
    lt_affine_apply(A, uv, uv);
    for (int i = 0; i < 3; i++)
        q[i] = K[3 * i] * p[0] + K[3 * i + 1] * p[1] + K[3 * i + 2] * p[2];
    ck_assert_double_eq_tol(q[0] / q[2], uv[0], 1e-3);
    ck_assert_double_eq_tol(q[1] / q[2], uv[1], 1e-3);
}
END_TEST

START_TEST(corners_and_units)
{
    const crop_window w = { .cx = 100, .cy = 100, .side = 128 };
    const crop_box b = { 80, 90, 120, 130 };
    const float p[2][2] = { { 8, 12 }, { 28, 17 } };
    float out[2][2];
    double A[6];
    crop_box m;

    crop_affine(w, S, A);
    m = crop_corners(A, b);
    ck_assert_float_eq_tol(m.x0, 88, 1e-4);
    ck_assert_float_eq_tol(m.y1, 188, 1e-4);
    crop_normalise((crop_box){ 8, 7, 28, 17 }, p, 2, out);
    ck_assert_float_eq_tol(out[0][0], 0, 1e-6);
    ck_assert_float_eq_tol(out[0][1], 0.5, 1e-6);
    ck_assert_float_eq_tol(out[1][0], 1, 1e-6);
    crop_normalise((crop_box){ 8, 7, 8, 7 }, p, 2, out);        /* empty: one pixel */
    ck_assert_float_eq_tol(out[1][0], 20, 1e-6);
}
END_TEST

/* The slow way: warp the whole mask as an image, cut, resize. */
static float slow_mask(const float *crop, const long box[4], int i, int j, int cells)
{
    const long x = box[0] + (long)floor((j + 0.5) * (double)(box[2] - box[0]) / cells);
    const long y = box[1] + (long)floor((i + 0.5) * (double)(box[3] - box[1]) / cells);

    return x >= 0 && x < S && y >= 0 && y < S && crop[y * S + x] > 0;
}

START_TEST(mask_is_the_slow_way)
{
    enum { CELLS = 32 };
    const crop_box box = { -12.4f, 60.6f, 180.5f, 270.2f };
    const long cut[4] = { -12, 61, 181, 270 };
    uint8_t *mask = calloc(W * H, 1), *rgb = calloc((size_t)W * H, 3);
    float *crop = malloc(sizeof(float) * 3 * S * S), out[CELLS * CELLS];
    double A[6];
    int set = 0;

    for (int y = 100; y < 260; y++)
        for (int x = 200; x < 380; x++)
            if ((x - 290) * (x - 290) + (y - 180) * (y - 180) < 75 * 75)
                mask[y * W + x] = rgb[3 * (y * W + x)] = 1;
    crop_affine(turned, S, A);
    crop_warp(A, rgb, W, H, NULL, crop, S, false);
    crop_mask(A, mask, W, H, S, box, out, CELLS);
    for (int i = 0; i < CELLS; i++)
        for (int j = 0; j < CELLS; j++) {
            ck_assert_float_eq(out[i * CELLS + j], slow_mask(crop, cut, i, j, CELLS));
            set += out[i * CELLS + j] > 0;
        }
    ck_assert_int_gt(set, 100);
    ck_assert_int_lt(set, CELLS * CELLS - 100);
    free(mask);
    free(rgb);
    free(crop);
}
END_TEST

/* ---- silhouettes ---- */

START_TEST(silhouette_of_a_square)
{
    float vertex[4][3] = { { -.1f, -.1f, 0 }, { .1f, -.1f, 0 }, { .1f, .1f, 0 }, { -.1f, .1f, 0 } };
    int32_t face[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } };
    const lt_mesh mesh = { .n_vertices = 4, .n_faces = 2, .vertex = vertex, .face = face };
    const float R[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, t[3] = { 0, 0, 0.5f };
    const float close[3] = { 0, 0, 0.005f }, behind[3] = { 0, 0, -0.5f };
    const lt_camera cam = { 100, 100, 31.5, 31.5 };
    lt_arena *arena = lt_arena_new();
    uint8_t mask[64 * 64] = { 0 };
    int n = 0;

    ck_assert_int_eq(silhouette_draw(&mesh, R, t, &cam, mask, 64, 64, arena), LT_OK);
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < 64; x++) {
            ck_assert_int_eq(mask[y * 64 + x], x >= 12 && x <= 51 && y >= 12 && y <= 51);
            n += mask[y * 64 + x];
        }
    ck_assert_int_eq(n, 40 * 40);
    memset(mask, 0, sizeof(mask));
    ck_assert_int_eq(silhouette_draw(&mesh, R, close, &cam, mask, 64, 64, arena), LT_OK);
    ck_assert_int_eq(silhouette_draw(&mesh, R, behind, &cam, mask, 64, 64, arena), LT_OK);
    for (int i = 0; i < 64 * 64; i++)
        ck_assert_int_eq(mask[i], 0);
    lt_arena_free(arena);
}
END_TEST

/* Two sheets, the nearer one tilted: its depth is that of the plane, seen through each pixel's centre. */
START_TEST(depth_of_a_tilted_sheet)
{
    float vertex[8][3], depth[64 * 64];
    int32_t face[4][3] = { { 4, 5, 6 }, { 4, 6, 7 }, { 0, 1, 2 }, { 0, 2, 3 } };
    const lt_mesh mesh = { .n_vertices = 8, .n_faces = 4, .vertex = vertex, .face = face };
    const float R[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, t[3] = { 0, 0, 0.5f };
    const lt_camera cam = { 100, 100, 31.5, 31.5 };
    lt_arena *arena = lt_arena_new();

    for (int i = 0; i < 8; i++) {
        vertex[i][0] = i % 4 == 0 || i % 4 == 3 ? -.1f : .1f;
        vertex[i][1] = i % 4 < 2 ? -.1f : .1f;
        vertex[i][2] = i < 4 ? 0.3f * vertex[i][0] : 0.2f;
    }
    ck_assert_int_eq(silhouette_depth(&mesh, R, t, &cam, depth, 64, 64, arena), LT_OK);
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < 64; x++) {
            const double plane = 0.5 / (1 - 0.3 * (x - cam.cx) / cam.fx), at = plane * (x - cam.cx) / cam.fx;
            const double down = fabs(plane * (y - cam.cy) / cam.fy);
            const double far = 0.7 * fmax(fabs(x - cam.cx), fabs(y - cam.cy)) / 100;
            const bool near_sheet = fabs(at) < 0.0999 && down < 0.0999, beside = fabs(at) > 0.1001 || down > 0.1001;
            if (near_sheet)
                ck_assert_float_eq_tol(depth[y * 64 + x], (float)plane, 1e-6f);
            else if (beside)
                ck_assert_float_eq_tol(depth[y * 64 + x], far < 0.1 ? 0.7f : 0, 1e-6f);
        }
    lt_arena_free(arena);
}
END_TEST

/* ---- colours ---- */

enum { N = VECTOR_H * VECTOR_W };

static void expect(const float *got, const float *want)
{
    for (int i = 0; i < 3 * N; i++)
        ck_assert_float_eq_tol(got[i], want[i], 2e-6);
}

START_TEST(colours)
{
    float x[3 * N], scratch[N];
    static const struct {
        void (*change)(float *, int64_t, double);
        double amount;
        const float *want;
    } cases[] = {
        { augment_brightness, 1.4, vector_brightness }, { augment_contrast, 0.6, vector_contrast },
        { augment_saturation, 1.3, vector_saturation }, { augment_hue, 0.12, vector_hue_up },
        { augment_hue, -0.15, vector_hue_down },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        memcpy(x, vector_image, sizeof(x));
        cases[i].change(x, N, cases[i].amount);
        expect(x, cases[i].want);
    }
    memcpy(x, vector_image, sizeof(x));
    augment_blur(x, VECTOR_H, VECTOR_W, 0.5, scratch);
    expect(x, vector_blur);
}
END_TEST

START_TEST(nothing_changes_nothing)
{
    float x[3 * N], scratch[N];

    memcpy(x, vector_image, sizeof(x));
    augment_brightness(x, N, 1);
    augment_contrast(x, N, 1);
    augment_saturation(x, N, 1);
    augment_hue(x, N, 0);
    augment_blur(x, VECTOR_H, VECTOR_W, 0, scratch);
    expect(x, vector_image);
}
END_TEST

START_TEST(jitter_is_keyed_and_stays_in_range)
{
    const augment_limits limits = { 0.5, 0.5, 0.5, 0.5, 0.15 };
    float a[3 * N], b[3 * N], scratch[N];

    for (uint64_t k = 0; k < 50; k++) {
        lt_rng r1 = lt_rng_make(3, k), r2 = lt_rng_make(3, k);
        memcpy(a, vector_image, sizeof(a));
        memcpy(b, vector_image, sizeof(b));
        augment_colour(a, VECTOR_H, VECTOR_W, &limits, &r1, scratch);
        augment_colour(b, VECTOR_H, VECTOR_W, &limits, &r2, scratch);
        ck_assert_mem_eq(a, b, sizeof(a));
        for (int i = 0; i < 3 * N; i++)
            ck_assert(a[i] >= 0 && a[i] <= 1);
    }
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, box_is_cut_to_whole_centre);
    tcase_add_test(c, window_is_clamped);
    tcase_add_test(c, window_outside_is_a_pixel);
    tcase_add_test(c, centre_goes_to_the_middle);
    tcase_add_test(c, points_follow_the_picture);
    tcase_add_test(c, nearest_is_defined);
    tcase_add_test(c, bilinear_mixes);
    tcase_add_test(c, intrinsics_follow);
    tcase_add_test(c, corners_and_units);
    tcase_add_test(c, mask_is_the_slow_way);
    tcase_add_test(c, silhouette_of_a_square);
    tcase_add_test(c, depth_of_a_tilted_sheet);
    tcase_add_test(c, colours);
    tcase_add_test(c, nothing_changes_nothing);
    tcase_add_test(c, jitter_is_keyed_and_stays_in_range);
}

int main(void)
{
    return run_suite("crop", add_tests);
}
