/* SPDX-License-Identifier: Apache-2.0 */
/* A window of X11. */
#include "pipeline/window/module.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/keysym.h>
#include <stdlib.h>

typedef struct {
    Display *display;
    Window window;
    GC context;
    XImage *image;                  /* owns the pixels */
    Atom closing;
    int width, height;
} x11;

static void close_x11(void *window)
{
    x11 *w = window;

    if (w->image)
        XDestroyImage(w->image);
    if (w->context)
        XFreeGC(w->display, w->context);
    if (w->window)
        XDestroyWindow(w->display, w->window);
    if (w->display)
        XCloseDisplay(w->display);
    free(w);
}

/* Of 24 bits, as displays are; others have no window. */
static bool make_image(x11 *w)
{
    const int screen = DefaultScreen(w->display);
    Visual *visual = DefaultVisual(w->display, screen);
    char *pixels;

    if (DefaultDepth(w->display, screen) != 24 || visual->red_mask != 0xff0000 || visual->blue_mask != 0xff)
        return false;
    pixels = calloc((size_t)w->width * (size_t)w->height, 4);
    if (!pixels)
        return false;
    w->image = XCreateImage(w->display, visual, 24, ZPixmap, 0, pixels, (unsigned)w->width, (unsigned)w->height, 32, 0);
    if (!w->image)
        free(pixels);
    return w->image && w->image->bits_per_pixel == 32;
}

static void *open_x11(const char *title, int width, int height)
{
    x11 *w = calloc(1, sizeof(*w));

    if (!w)
        return NULL;
    w->width = width;
    w->height = height;
    w->display = XOpenDisplay(NULL);
    if (!w->display || !make_image(w)) {
        close_x11(w);
        return NULL;
    }
    w->window = XCreateSimpleWindow(w->display, DefaultRootWindow(w->display), 0, 0, (unsigned)width, (unsigned)height,
                                    0, 0, 0);
    w->context = XCreateGC(w->display, w->window, 0, NULL);
    w->closing = XInternAtom(w->display, "WM_DELETE_WINDOW", False);
    XSetWMProtocols(w->display, w->window, &w->closing, 1);
    XStoreName(w->display, w->window, title);
    XSelectInput(w->display, w->window, KeyPressMask);
    XMapWindow(w->display, w->window);
    return w;
}

/* Whether whoever looks wants no more */
static bool is_over(x11 *w)
{
    bool over = false;

    while (XPending(w->display)) {
        XEvent e;

        XNextEvent(w->display, &e);
        if (e.type == ClientMessage)
            over = over || (Atom)e.xclient.data.l[0] == w->closing;
        if (e.type == KeyPress)
            over = over || XLookupKeysym(&e.xkey, 0) == XK_q || XLookupKeysym(&e.xkey, 0) == XK_Escape;
    }
    return over;
}

static bool show_x11(void *window, const uint8_t *rgb)
{
    x11 *w = window;
    uint32_t *to = (uint32_t *)(void *)w->image->data;
    const int64_t n = (int64_t)w->width * w->height;
    const uint8_t *end = rgb + 3 * n;

    for (; rgb < end; rgb += 3)
        *to++ = (uint32_t)rgb[0] << 16 | (uint32_t)rgb[1] << 8 | rgb[2];
    w->image->byte_order = LSBFirst;            /* as the processors are that palmar is built for */
    XPutImage(w->display, w->window, w->context, w->image, 0, 0, 0, 0, (unsigned)w->width, (unsigned)w->height);
    XFlush(w->display);
    return !is_over(w);
}

__attribute__((visibility("default"))) const window_module window_x11 = { open_x11, show_x11, close_x11 };
