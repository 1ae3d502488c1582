/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/body/sheet.h"

#include "libtensor/io/image/write.h"
#include "vision/draw.h"

enum { W = BODY_PICTURE_WIDTH, H = BODY_PICTURE_HEIGHT, COLUMNS = 6, FINGERS = 5 };

static const draw_color LEFT = { 90, 170, 255 }, RIGHT = { 255, 140, 60 }, MIDDLE = { 120, 230, 120 };

/* Bones between nodes: the right side's follow the left side's */
static const int bone[][2] = {
    { 0, 1 }, { 0, 2 }, { 1, 3 }, { 2, 4 }, { 3, 5 }, { 4, 6 }, { 0, 7 }, { 7, 8 }, { 7, 9 }, { 8, 10 }, { 9, 11 },
    { 10, 12 }, { 11, 13 }, { 5, 14 }, { 6, 17 }, { 5, 16 }, { 6, 19 }, { 7, 24 }, { 24, 22 }, { 24, 23 }, { 22, 20 },
    { 23, 21 },
};

static draw_color side_of(int node)
{
    if (node == 0 || node == 7 || node == 24)
        return MIDDLE;
    if (node >= 25)
        return node < 45 ? LEFT : RIGHT;
    if (node >= 14 && node < 20)
        return node < 17 ? LEFT : RIGHT;
    return node >= 20 ? (node % 2 == 0 ? LEFT : RIGHT) : node < 7 ? (node % 2 ? LEFT : RIGHT)
                                                                  : (node % 2 == 0 ? LEFT : RIGHT);
}

static void draw_nodes(draw_canvas *c, const float (*node)[2])
{
    for (size_t i = 0; i < LT_COUNT(bone); i++)
        draw_line(c, node[bone[i][0]], node[bone[i][1]], 2, side_of(bone[i][1]), 0.85f);
    for (int side = 0; side < 2; side++)
        for (int i = 0; i < 4 * FINGERS; i++) {
            const int to = 25 + 4 * FINGERS * side + i, from = i % 4 ? to - 1 : 12 + side;

            draw_line(c, node[from], node[to], 1, side_of(to), 0.85f);
        }
    for (int i = 0; i < 25; i++)
        draw_disc(c, node[i], 2, side_of(i), 1);
}

static uint8_t (*drawn(lt_arena *arena, const float *image, const float (*node)[2]))[3]
{
    draw_canvas c = draw_canvas_new(arena, W, H, (draw_color){ 0, 0, 0 });

    for (int i = 0; c.rgb && i < W * H; i++)
        for (int k = 0; k < 3; k++)
            c.rgb[i][k] = (uint8_t)(image[k * W * H + i] * 255 + 0.5f);
    if (c.rgb)
        draw_nodes(&c, node);
    return c.rgb;
}

lt_status body_sheet_add(body_sheet *s, const float *image, const float (*true_nodes)[2], const float (*nodes)[2],
                         const char *name, double error_mm)
{
    const int i = 2 * s->n;

    if (s->n == SHEET_MOST)
        return LT_OK;
    s->rgb[i] = drawn(s->arena, image, true_nodes);
    s->rgb[i + 1] = drawn(s->arena, image, nodes);
    s->title[i] = lt_arena_strdup(s->arena, name);
    s->title[i + 1] = lt_arena_printf(s->arena, "joints %.0f mm", error_mm);
    if (!s->rgb[i] || !s->rgb[i + 1] || !s->title[i] || !s->title[i + 1])
        return lt_error(LT_ENOMEM, "no memory for pictures");
    s->n++;
    return LT_OK;
}

lt_status body_sheet_write(body_sheet *s, const char *path)
{
    draw_canvas picture[2 * SHEET_MOST], sheet;

    for (int i = 0; i < 2 * s->n; i++)
        picture[i] = (draw_canvas){ s->rgb[i], W, H };
    sheet = draw_sheet(s->arena, picture, s->title, 2 * s->n, COLUMNS, W, H);
    return sheet.rgb ? lt_png_write(path, &(lt_image){ sheet.width, sheet.height, 3, 8, sheet.rgb[0] })
                     : lt_error(LT_ENOMEM, "no memory for pictures");
}
