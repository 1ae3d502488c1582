/* SPDX-License-Identifier: Apache-2.0 */
/* Holes in a mesh, and what is left of one. */
#include "assets/surface/surface.h"

void surface_compact(surface_mesh *m, int32_t *to)
{
    int n = 0, nf = 0;

    for (int v = 0; v < m->n_vertices; v++) {
        if (to[v] < 0)
            continue;
        m->vertex[n] = m->vertex[v];
        m->loop[n] = m->loop[v];
        to[v] = n++;
    }
    for (int f = 0; f < m->n_faces; f++) {
        const int32_t *c = m->face[f];

        if (to[c[0]] < 0 || to[c[1]] < 0 || to[c[2]] < 0)
            continue;
        for (int k = 0; k < 3; k++)
            m->face[nf][k] = to[m->face[f][k]];
        nf++;
    }
    m->n_vertices = n;
    m->n_faces = nf;
}

lt_status surface_open(lt_arena *arena, const surface_skin *skin, bool (*inside)(const void *ctx, vec3 p), int loop,
                       surface_mesh *m)
{
    int32_t *to = lt_arena_array(arena, (size_t)m->n_vertices, sizeof(*to));

    if (!to)
        return lt_error(LT_ENOMEM, "%s: no memory to open the mesh", skin->name);
    for (int v = 0; v < m->n_vertices; v++)
        to[v] = inside(skin->ctx, m->vertex[v]) ? -1 : 0;
    for (int f = 0; f < m->n_faces; f++) {
        const int32_t *c = m->face[f];

        for (int k = 0; k < 3; k++)
            if (to[c[0]] < 0 || to[c[1]] < 0 || to[c[2]] < 0)
                m->loop[c[k]] = (uint8_t)loop;
    }
    for (int v = 0; v < m->n_vertices; v++)
        if (m->loop[v] == loop && to[v] >= 0)
            m->vertex[v] = skin->snap(skin->ctx, m->vertex[v], loop);
    surface_compact(m, to);
    return LT_OK;
}
