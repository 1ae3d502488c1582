/* SPDX-License-Identifier: Apache-2.0 */
/* PSNR and SSIM. The windows' means are products with a Gaussian down and then along rows. */
#include "eval/metrics/image.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/kernels.h"

#include <math.h>
#include <string.h>

bool eval_mask_box(const uint8_t *mask, int height, int width, eval_box *out)
{
    eval_box box = { width, height, 0, 0 };

    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            if (!mask[(int64_t)y * width + x])
                continue;
            box.x0 = x < box.x0 ? x : box.x0;
            box.y0 = y < box.y0 ? y : box.y0;
            box.x1 = x + 1 > box.x1 ? x + 1 : box.x1;
            box.y1 = y + 1;
        }
    *out = box;
    return box.x0 < box.x1;
}

eval_pictures eval_pictures_within(const eval_pictures *p, eval_box box)
{
    eval_pictures part = *p;

    part.a += box.y0 * p->row + box.x0;
    part.b += box.y0 * p->row + box.x0;
    part.height = box.y1 - box.y0;
    part.width = box.x1 - box.x0;
    return part;
}

/* ---- PSNR ------------------------------------------------------------------------------------------------- */

/* Sum of squared differences of a row, and how many there are */
static double row_error(const float *a, const float *b, const uint8_t *mask, int width, int64_t *n)
{
    double sum = 0;

    for (int x = 0; x < width; x++) {
        const double d = (double)a[x] - (double)b[x];

        if (mask && !mask[x])
            continue;
        sum += d * d;
        ++*n;
    }
    return sum;
}

double eval_psnr(const eval_pictures *p, const uint8_t *mask)
{
    double sum = 0;
    int64_t n = 0;

    for (int c = 0; c < p->channels; c++)
        for (int y = 0; y < p->height; y++)
            sum += row_error(p->a + c * p->plane + y * p->row, p->b + c * p->plane + y * p->row,
                             mask ? mask + (int64_t)y * p->width : NULL, p->width, &n);
    if (n == 0 || !isfinite(sum))
        return NAN;
    return -10 * log10(sum / (double)n);
}

/* ---- SSIM ------------------------------------------------------------------------------------------------- */

enum { WINDOW = 11, RADIUS = WINDOW / 2, STRIP = 16 };      /* rows of the result that one task makes */

/* What a window is looked at through: the sum s = a + b and the difference d = a - b, and their squares. With means S
 * and D, and variances V_s and V_d, SSIM is
 *   (S^2 - D^2 + 2 C1) / (S^2 + D^2 + 2 C1) * (V_s - V_d + 2 C2) / (V_s + V_d + 2 C2),
 * where rounding in V_s, as large as V_d is small where the pictures are alike, is above and below the line. */
enum { SUM, DIFFERENCE, SUM_SQUARED, DIFFERENCE_SQUARED, MAPS };

typedef struct {
    const eval_pictures *p;
    int pad, rows, cols;            /* zeros around the pictures; sides of the result */
    int strips;                     /* of a channel */
    float tap[WINDOW];
    float *scratch;                 /* a part for each thread */
    int64_t each;                   /* elements of such a part */
    double *sum;                    /* one a task */
} ssim_job;

const char *eval_ssim_name(eval_ssim_form form)
{
    return form == EVAL_SSIM_VALID ? "ssim valid" : "ssim zero-padded";
}

/* Row y of the padded pictures, into the four maps' rows, which lie `map` elements apart */
static void fill_row(const ssim_job *j, int channel, int y, float *out, int64_t map)
{
    const eval_pictures *p = j->p;
    const int64_t width = p->width + 2 * j->pad;
    const float *a = p->a + channel * p->plane + (int64_t)(y - j->pad) * p->row;
    const float *b = p->b + channel * p->plane + (int64_t)(y - j->pad) * p->row;

    for (int m = 0; m < MAPS; m++)
        memset(out + m * map, 0, (size_t)width * sizeof(*out));
    if (y < j->pad || y >= j->pad + p->height)
        return;
    out += j->pad;
    lt_k->add(out + SUM * map, a, b, (size_t)p->width);
    lt_k->sub(out + DIFFERENCE * map, a, b, (size_t)p->width);
    lt_k->mul(out + SUM_SQUARED * map, out + SUM * map, out + SUM * map, (size_t)p->width);
    lt_k->mul(out + DIFFERENCE_SQUARED * map, out + DIFFERENCE * map, out + DIFFERENCE * map, (size_t)p->width);
}

/* Of one row of windows, their means by map */
static double sum_similarity(const float *const mean[MAPS], int n)
{
    const float c1 = 2 * 0.01f * 0.01f, c2 = 2 * 0.03f * 0.03f;
    double sum = 0;

    for (int x = 0; x < n; x++) {
        const float s = mean[SUM][x] * mean[SUM][x], d = mean[DIFFERENCE][x] * mean[DIFFERENCE][x];
        const float vs = mean[SUM_SQUARED][x] - s, vd = mean[DIFFERENCE_SQUARED][x] - d;

        sum += (double)((s - d + c1) * (vs - vd + c2) / ((s + d + c1) * (vs + vd + c2)));
    }
    return sum;
}

static void ssim_task(void *ctx, int64_t task)
{
    const ssim_job *j = ctx;
    const int64_t width = j->p->width + 2 * j->pad, map = (STRIP + WINDOW - 1) * width;
    const int channel = (int)(task / j->strips), first = (int)(task % j->strips) * STRIP;
    const int rows = first + STRIP < j->rows ? STRIP : j->rows - first;
    float *maps = j->scratch + lt_thread_index() * j->each, *down = maps + MAPS * map, *mean[MAPS];
    double sum = 0;

    for (int y = 0; y < rows + WINDOW - 1; y++)
        fill_row(j, channel, first + y, maps + y * width, map);
    for (int m = 0; m < MAPS; m++)
        mean[m] = down + (m + 1) * width;
    for (int y = 0; y < rows; y++) {
        for (int m = 0; m < MAPS; m++) {
            lt_k->combine(down, maps + m * map + y * width, width, j->tap, WINDOW, (size_t)width, false);
            lt_k->combine(mean[m], down, 1, j->tap, WINDOW, (size_t)j->cols, false);
        }
        sum += sum_similarity((const float *const *)mean, j->cols);
    }
    j->sum[task] = sum;
}

static void gaussian(float tap[WINDOW])
{
    double g[WINDOW], sum = 0;

    for (int i = 0; i < WINDOW; i++) {
        g[i] = exp(-(i - RADIUS) * (i - RADIUS) / (2 * 1.5 * 1.5));
        sum += g[i];
    }
    for (int i = 0; i < WINDOW; i++)
        tap[i] = (float)(g[i] / sum);
}

lt_status eval_ssim(const eval_pictures *p, eval_ssim_form form, double *out)
{
    ssim_job j = { .p = p, .pad = form == EVAL_SSIM_VALID ? 0 : RADIUS };
    const int64_t width = p->width + 2 * j.pad;
    lt_status st = LT_OK;
    double total = 0;
    int64_t tasks;

    j.rows = p->height + 2 * j.pad - (WINDOW - 1);
    j.cols = (int)width - (WINDOW - 1);
    *out = NAN;
    if (j.rows < 1 || j.cols < 1 || p->channels < 1)
        return LT_OK;
    j.strips = (j.rows + STRIP - 1) / STRIP;
    j.each = (MAPS * (STRIP + WINDOW - 1) + MAPS + 1) * width;
    tasks = (int64_t)p->channels * j.strips;
    j.scratch = lt_alloc((size_t)(j.each * lt_threads()) * sizeof(*j.scratch));
    j.sum = lt_alloc((size_t)tasks * sizeof(*j.sum));
    if (j.scratch && j.sum) {
        gaussian(j.tap);
        lt_parallel_for(tasks, ssim_task, &j);
        for (int64_t i = 0; i < tasks; i++)
            total += j.sum[i];
        *out = total / ((double)p->channels * j.rows * j.cols);
    } else {
        st = lt_error(LT_ENOMEM, "no memory to compare pictures");
    }
    lt_release(j.scratch);
    lt_release(j.sum);
    return st;
}
