/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A window that shows one picture after the other.
 */
#ifndef PIPELINE_WINDOW_WINDOW_H
#define PIPELINE_WINDOW_WINDOW_H

#include "libtensor/io/image/pixels.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct window window;

/* window_open - for pictures of one size; NULL: there is no display, or no module for it */
window *window_open(const char *title, int width, int height);

/* window_show - RGB of 8 bits, of that size. False: whoever looks has closed it, or pressed q or Escape */
bool window_show(window *w, const lt_image *picture);

/* window_close - NULL is fine */
void window_close(window *w);

#ifdef __cplusplus
}
#endif
#endif
