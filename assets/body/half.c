/* SPDX-License-Identifier: Apache-2.0 */
/* The right half of the body's skin as a mesh. */
#include "assets/body/internal.h"

#include "assets/hand/hand.h"

typedef struct { double angle; int vertex; } spoke;

static void sort_spokes(spoke *list)
{
    for (int i = 1; i < WRIST_EDGES; i++)
        for (int k = i; k > 0 && list[k].angle < list[k - 1].angle; k--) {
            const spoke t = list[k];

            list[k] = list[k - 1];
            list[k - 1] = t;
        }
}

static vec3 hand_vertex(const body_skeleton *s, const lt_hand_model *hand, int v)
{
    return madd(s->hand, vec(hand->v_template[v][0], hand->v_template[v][1], hand->v_template[v][2]), 1000);
}

/* The rim's vertices become the hand's, whose loop begins where the sum of squared ways is least. */
static void weld(const body_skeleton *s, const lt_hand_model *hand, surface_mesh *m, int wrist[WRIST_EDGES])
{
    const vec3 middle = s->joint[BODY_WRIST + 1];
    spoke rim[WRIST_EDGES], loop[WRIST_EDGES];
    double least = INFINITY;
    int n = 0, shift = 0;

    for (int v = 0; v < m->n_vertices; v++)
        if (m->loop[v] == RIM_WRIST)
            rim[n++] = (spoke){ atan2(m->vertex[v].y - middle.y, m->vertex[v].z - middle.z), v };
    for (int i = 0; i < WRIST_EDGES; i++) {
        const vec3 p = hand_vertex(s, hand, synth_hand_wrist_loop[i]);

        loop[i] = (spoke){ atan2(p.y - middle.y, p.z - middle.z), i };
    }
    sort_spokes(rim);
    sort_spokes(loop);
    for (int k = 0; k < WRIST_EDGES; k++) {
        double sum = 0;

        for (int i = 0; i < WRIST_EDGES; i++) {
            const int to = synth_hand_wrist_loop[loop[(i + k) % WRIST_EDGES].vertex];
            const vec3 way = sub(m->vertex[rim[i].vertex], hand_vertex(s, hand, to));

            sum += dot(way, way);
        }
        shift = sum < least ? k : shift;
        least = fmin(least, sum);
    }
    for (int i = 0; i < WRIST_EDGES; i++) {
        const int at = loop[(i + shift) % WRIST_EDGES].vertex;

        wrist[at] = rim[i].vertex;
        m->vertex[rim[i].vertex] = hand_vertex(s, hand, synth_hand_wrist_loop[at]);
    }
}

lt_status body_half(lt_arena *arena, const body_skeleton *s, const lt_hand_model *hand, surface_mesh *m,
                    int wrist[WRIST_EDGES])
{
    const surface_skin skin = body_shape_skin(s);
    const surface_grid grid = { .origin = { -744, -24, -138 }, .cell = 6, .n = { 127, 292, 56 }, .low = true,
                                .cut = { s->wrist_cut, 0 }, .loop = { RIM_WRIST, RIM_MIDDLE } };
    const int rim[SURFACE_LOOPS] = { MIDDLE_EDGES, WRIST_EDGES, EYE_EDGES };
    lt_status st = surface_nets(arena, &skin, &grid, m);

    if (!st)
        st = surface_open(arena, &skin, body_shape_in_eye, RIM_EYE, m);
    if (!st)
        st = surface_decimate(arena, &skin, HALF_VERTICES, rim, m);
    if (st)
        return st;
    weld(s, hand, m, wrist);
    return surface_relax(arena, &skin, 14, 1u << RIM_WRIST, m);
}
