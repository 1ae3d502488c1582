/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/drawing/body.h"

enum { OF_BODY = 25, WRIST = 12, FINGERS = 5, OF_FINGER = 4, OF_HAND = FINGERS * OF_FINGER };

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
    if (node >= OF_BODY)
        return node < OF_BODY + OF_HAND ? LEFT : RIGHT;
    if (node >= 14 && node < 20)
        return node < 17 ? LEFT : RIGHT;
    return node >= 20 ? (node % 2 == 0 ? LEFT : RIGHT) : node < 7 ? (node % 2 ? LEFT : RIGHT)
                                                                  : (node % 2 == 0 ? LEFT : RIGHT);
}

void body_draw(draw_canvas *c, const float (*node)[2], float width)
{
    for (size_t i = 0; i < LT_COUNT(bone); i++)
        draw_line(c, node[bone[i][0]], node[bone[i][1]], 2 * width, side_of(bone[i][1]), 0.85f);
    for (int side = 0; side < 2; side++)
        for (int i = 0; i < OF_HAND; i++) {
            const int to = OF_BODY + OF_HAND * side + i;

            draw_line(c, node[i % OF_FINGER ? to - 1 : WRIST + side], node[to], width, side_of(to), 0.85f);
        }
    for (int i = 0; i < OF_BODY; i++)
        draw_disc(c, node[i], 2 * width, side_of(i), 1);
}
