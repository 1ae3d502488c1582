/* SPDX-License-Identifier: Apache-2.0 */
#include "pipeline/window/window.h"

#include "libtensor/io/module.h"
#include "pipeline/window/module.h"

struct window {
    const window_module *by;
    void *window;
    int width, height;
};

window *window_open(const char *title, int width, int height)
{
    const window_module *by = lt_module_symbol(WINDOW_MODULE, WINDOW_SYMBOL);
    window *w = by ? lt_alloc(sizeof(*w)) : NULL;

    if (!w)
        return NULL;
    *w = (window){ .by = by, .window = by->open(title, width, height), .width = width, .height = height };
    if (w->window)
        return w;
    lt_release(w);
    return NULL;
}

bool window_show(window *w, const lt_image *p)
{
    return p->width != w->width || p->height != w->height || w->by->show(w->window, p->data);
}

void window_close(window *w)
{
    if (w)
        w->by->close(w->window);
    lt_release(w);
}
