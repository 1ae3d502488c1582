/* SPDX-License-Identifier: Apache-2.0 */
/* Ten things that a face does: soft displacements around places of it. */
#include "assets/body/internal.h"

typedef struct {
    vec3 at;
    double radius;
    vec3 way;                       /* millimetres per unit */
    bool both;                      /* on the left too, mirrored */
} push;

enum { PUSHES = 3 };

static const push faces[BODY_EXPRESSIONS][PUSHES] = {
    { { { 0, 1505, 92 }, 13, { 0, -4, -1 }, false }, { { 0, 1484, 75 }, 30, { 0, -4, -1 }, false } },
    { { { -25, 1518, 84 }, 13, { -3, 3, -1 }, true }, { { -42, 1556, 72 }, 20, { -0.5, 1, 1.5 }, true } },
    { { { -25, 1518, 84 }, 13, { -0.5, -3, -0.5 }, true } },
    { { { -28, 1614, 88 }, 17, { 0, 3, 0 }, true } },
    { { { -14, 1611, 92 }, 12, { 2, -2, 0.5 }, true } },
    { { { 0, 1517, 96 }, 15, { 0, 0, 3 }, false }, { { -25, 1518, 84 }, 11, { 3, 0, 1.5 }, true } },
    { { { 0, 1515, 94 }, 26, { 3, 0, 0 }, false } },
    { { { 0, 1553, 106 }, 15, { 0, 1.5, 0 }, false }, { { -14, 1535, 92 }, 13, { 0, 2, 0 }, true } },
    { { { -45, 1532, 62 }, 20, { -3, 0, 1.5 }, true } },
    { { { -32, 1601, 88 }, 9, { 0, 1.5, 0 }, true } },
};

static vec3 pushed(const push *e, vec3 p)
{
    const double q = dist(p, e->at) / e->radius;

    return scale(e->way, exp(-q * q));
}

void body_expressions(const body_skin *skin, body_motion motion[BODY_EXPRESSIONS])
{
    for (int k = 0; k < BODY_EXPRESSIONS; k++)
        for (int v = 0; v < V; v++) {
            const vec3 p = skin->vertex[v];
            vec3 *way = &motion[k].vertex[v];

            for (int i = 0; skin->source[v] == FROM_SKIN && i < PUSHES && faces[k][i].radius > 0; i++) {
                *way = add(*way, pushed(&faces[k][i], p));
                if (faces[k][i].both)
                    *way = add(*way, body_mirror(pushed(&faces[k][i], body_mirror(p))));
            }
            if (norm(*way) < 0.01)
                *way = vec(0, 0, 0);
        }
}
