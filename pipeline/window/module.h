/* SPDX-License-Identifier: Apache-2.0 */
/* What the program and the module for X11 say to each other. */
#ifndef PIPELINE_WINDOW_MODULE_H
#define PIPELINE_WINDOW_MODULE_H

#include <stdbool.h>
#include <stdint.h>

#define WINDOW_MODULE "window-x11.so"
#define WINDOW_SYMBOL "window_x11"              /* a window_module */

/* As window.h has them; rgb (height, width, 3) */
typedef struct {
    void *(*open)(const char *title, int width, int height);
    bool (*show)(void *window, const uint8_t *rgb);
    void (*close)(void *window);
} window_module;

#endif
