/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The part of a picture that a network for whole bodies is given: about a person's box, of a fixed shape.
 *
 * A pixel's centre is a whole number, in the picture as in what is cut out.
 */
#ifndef VISION_PERSON_WINDOW_H
#define VISION_PERSON_WINDOW_H

#include "libtensor/io/image/image.h"

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Where the picture's pixel u goes: scale R u + shift, R a turn by `turn` radians, from x to y */
typedef struct { double scale, shift[2], turn; } person_window;

/* person_window_place - of a pixel */
static inline void person_window_place(const person_window *w, const double u[2], double out[2])
{
    const double c = cos(w->turn), s = sin(w->turn);

    out[0] = w->scale * (c * u[0] - s * u[1]) + w->shift[0];
    out[1] = w->scale * (s * u[0] + c * u[1]) + w->shift[1];
}

/**
 * person_window_around - a box x0 y0 x1 y1, not empty: one side grown until it has the shape of width x height,
 * then larger by a quarter about its middle
 *
 * Source: Lin et al. 2023; IDEA-Research/OSX common/utils/preprocessing.py, process_bbox.
 */
person_window person_window_around(const double box[4], int width, int height);

/**
 * person_window_cut - what lies in the window, black where there is no picture
 *
 *   rgb   of 8 bits
 *   out   (3, height, width) in [0, 1]
 *
 * The four nearest pixels are mixed; where the picture becomes less than half as large, the mean of several such places
 * stands for a pixel, so that nothing is skipped.
 */
void person_window_cut(const person_window *w, const lt_image *rgb, int width, int height, float *out);

#ifdef __cplusplus
}
#endif
#endif
