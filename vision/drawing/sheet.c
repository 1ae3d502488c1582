/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures in a grid, with titles. */
#include "vision/drawing/draw.h"

enum { GAP = 4 };               /* pixels around each picture */

draw_canvas draw_sheet(lt_arena *arena, const draw_canvas *picture, const char *const *title, int n,
                       int columns, int w, int h)
{
    const draw_color paper = { 250, 250, 250 }, ink = { 40, 40, 40 };
    const int head = title ? DRAW_GLYPH_HEIGHT + GAP : 0;
    draw_canvas c = { NULL, 0, 0 };
    int rows;

    if (n < 1 || columns < 1 || w < 1 || h < 1 || w > DRAW_MAX_SIDE || h > DRAW_MAX_SIDE)
        return c;
    columns = columns < n ? columns : n;
    rows = (n + columns - 1) / columns;
    if (columns > DRAW_MAX_SIDE / (w + GAP) || rows > DRAW_MAX_SIDE / (h + head + GAP))
        return c;
    c = draw_canvas_new(arena, GAP + columns * (w + GAP), GAP + rows * (h + head + GAP), paper);
    for (int i = 0; i < n && c.rgb; i++) {
        const int x = GAP + i % columns * (w + GAP), y = GAP + i / columns * (h + head + GAP);

        if (title && title[i])
            draw_text(&c, x, y + 2, 1, ink, title[i]);
        draw_picture(&c, x, y + head, w, h, &picture[i]);
    }
    return c;
}
