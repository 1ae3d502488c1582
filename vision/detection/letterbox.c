/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/detection/letterbox.h"

#include "vision/crop.h"

#include <math.h>

letterbox letterbox_of(int width, int height, int size)
{
    const double scale = fmin((double)size / width, (double)size / height);

    return (letterbox){ scale, floor((size - width * scale) / 2), floor((size - height * scale) / 2) };
}

void letterbox_picture(const letterbox *l, const lt_image *rgb, int size, float *out)
{
    const double A[6] = { l->scale, 0, l->left, 0, l->scale, l->top };
    const float grey[3] = { LETTERBOX_GREY, LETTERBOX_GREY, LETTERBOX_GREY };

    crop_warp(A, rgb->data, rgb->width, rgb->height, grey, out, size, true);
}

void letterbox_back(const letterbox *l, int width, int height, const float box[4], float out[4])
{
    const double shift[2] = { l->left, l->top }, limit[2] = { width, height };

    for (int k = 0; k < 4; k++)
        out[k] = (float)fmin(fmax(((double)box[k] - shift[k % 2]) / l->scale, 0), limit[k % 2]);
}
