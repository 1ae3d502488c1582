/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/body/sheet.h"

#include "libtensor/io/image/write.h"
#include "vision/drawing/body.h"

enum { W = BODY_PICTURE_WIDTH, H = BODY_PICTURE_HEIGHT, COLUMNS = 6 };

static uint8_t (*drawn(lt_arena *arena, const float *image, const float (*node)[2]))[3]
{
    draw_canvas c = draw_canvas_new(arena, W, H, (draw_color){ 0, 0, 0 });

    for (int i = 0; c.rgb && i < W * H; i++)
        for (int k = 0; k < 3; k++)
            c.rgb[i][k] = (uint8_t)(image[k * W * H + i] * 255 + 0.5f);
    if (c.rgb)
        body_draw(&c, node, 1);
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
