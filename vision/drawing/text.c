/* SPDX-License-Identifier: Apache-2.0 */
/* A font of 5 x 7 dots. */
#include "vision/drawing/draw.h"

/* Seven rows a letter, top first: a row's five dots, leftmost highest, are added to '@'. */
static const char glyph[95][8] = {
    "@@@@@@@", "DDDD@@D", "JJJ@@@@", "JJ_J_JJ", "DOTNE^D", "XYBDHSC", "LRTHURM", "DDH@@@@",  /*   to ' */
    "BDHHHDB", "HDBBBDH", "@DUNUD@", "@DD_DD@", "@@@@LDH", "@@@_@@@", "@@@@@LL", "@ABDHP@",  /* ( to / */
    "NQSUYQN", "DLDDDDN", "NQABDH_", "_BDBAQN", "BFJR_BB", "_P^AAQN", "FHP^QQN", "_ABDHHH",  /* 0 to 7 */
    "NQQNQQN", "NQQOABL", "@LL@LL@", "@LL@LDH", "BDHPHDB", "@@_@_@@", "HDBABDH", "NQABD@D",  /* 8 to ? */
    "NQAMUUN", "NQQ_QQQ", "^QQ^QQ^", "NQPPPQN", "\\RQQQR\\", "_PP^PP_", "_PP^PPP", "NQPWQQO",  /* @ to G */
    "QQQ_QQQ", "NDDDDDN", "GBBBBRL", "QRTXTRQ", "PPPPPP_", "Q[UUQQQ", "QQYUSQQ", "NQQQQQN",  /* H to O */
    "^QQ^PPP", "NQQQURM", "^QQ^TRQ", "OPPNAA^", "_DDDDDD", "QQQQQQN", "QQQQQJD", "QQQUUUJ",  /* P to W */
    "QQJDJQQ", "QQQJDDD", "_ABDHP_", "NHHHHHN", "@PHDBA@", "NBBBBBN", "DJQ@@@@", "@@@@@@_",  /* X to _ */
    "HDB@@@@", "@@NAOQO", "PPVYQQ^", "@@NPPQN", "AAMSQQO", "@@NQ_PN", "FIH\\HHH", "@OQQOAN",  /* ` to g */
    "PPVYQQQ", "D@LDDDN", "B@FBBRL", "PPRTXTR", "LDDDDDN", "@@ZUUQQ", "@@VYQQQ", "@@NQQQN",  /* h to o */
    "@@^Q^PP", "@@MSOAA", "@@VYPPP", "@@NPNA^", "HH\\HHIF", "@@QQQSM", "@@QQQJD", "@@QQUUJ",  /* p to w */
    "@@QJDJQ", "@@QQOAN", "@@_BDH_", "BDDHDDB", "DDDDDDD", "HDDBDDH", "@@HUB@@",             /* x to ~ */
};

int draw_text(draw_canvas *c, int x, int y, int scale, draw_color color, const char *text)
{
    for (; *text && x < c->width; text++, x += DRAW_GLYPH_WIDTH * scale) {
        const unsigned char byte = (unsigned char)*text;
        const char *rows = glyph[byte >= ' ' && byte <= '~' ? byte - ' ' : '?' - ' '];

        for (int dot = 0; dot < 7 * 5; dot++) {
            const int left = x + dot % 5 * scale, top = y + dot / 5 * scale;

            if ((rows[dot / 5] - '@') >> (4 - dot % 5) & 1)
                draw_rect(c, left, top, left + scale, top + scale, color, 1);
        }
    }
    return x;
}
