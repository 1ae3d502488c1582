/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How like two pictures are: PSNR and SSIM, of all of it, of a rectangle, or where a mask is.
 *
 * Values are in [0, 1]. LPIPS is a network: lpips_score.h.
 */
#ifndef EVAL_METRICS_IMAGE_H
#define EVAL_METRICS_IMAGE_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Two pictures of one size, channel by channel: value (channel, y, x) is a[channel * plane + y * row + x] */
typedef struct {
    const float *a, *b;
    int channels, height, width;
    int64_t plane, row;
} eval_pictures;

/* Columns x0 to x1, rows y0 to y1, ends exclusive */
typedef struct { int x0, y0, x1, y1; } eval_box;

/* eval_mask_box - the smallest box with all of a mask (height, width), where it is not 0; false: it is empty */
bool eval_mask_box(const uint8_t *mask, int height, int width, eval_box *out);

/* eval_pictures_within - the same two, cut out of them */
eval_pictures eval_pictures_within(const eval_pictures *p, eval_box box);

/**
 * eval_psnr - 10 log10(1 / mean squared difference) of all values, dB
 *
 * mask (height, width), or NULL, says which pixels count: where it is not 0. Infinite where nothing differs, which a
 * mean over pictures leaves out; NaN where no pixel counts or a value is not finite.
 */
double eval_psnr(const eval_pictures *p, const uint8_t *mask);

typedef enum {
    EVAL_SSIM_VALID,        /* windows that are inside the picture: its border of 5 pixels has no value of its own */
    EVAL_SSIM_ZERO_PADDED,  /* each pixel's, with zeros around the picture: the 3DGS family's */
} eval_ssim_form;

const char *eval_ssim_name(eval_ssim_form form);        /* "ssim valid", "ssim zero-padded" */

/**
 * eval_ssim - mean structural similarity of windows of 11 x 11 pixels, a Gaussian of deviation 1.5, to *out
 *
 * K1 0.01, K2 0.03, biased variances; the mean over windows and channels. NaN where no window fits, or a value is not
 * finite. Errors: LT_ENOMEM.
 *
 * Source: Wang et al. 2004, "Image quality assessment: from error visibility to structural similarity", section III-B.
 */
lt_status eval_ssim(const eval_pictures *p, eval_ssim_form form, double *out);

#ifdef __cplusplus
}
#endif
#endif
