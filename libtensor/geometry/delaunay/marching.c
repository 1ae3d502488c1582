/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/geometry/delaunay/marching.h"

#include <string.h>

enum { EMPTY = -1 };

/* Corners that leave a tetrahedron right-handed: the one that stands alone, then the others */
static const int one[4][4] = { { 0, 1, 2, 3 }, { 1, 0, 3, 2 }, { 2, 0, 1, 3 }, { 3, 0, 2, 1 } };

/* Two and two; by the corners inside, as bits */
static const int two[16][4] = {
    [3] = { 0, 1, 2, 3 }, [5] = { 0, 2, 3, 1 }, [9] = { 0, 3, 1, 2 }, [6] = { 1, 2, 0, 3 }, [10] = { 1, 3, 2, 0 },
    [12] = { 2, 3, 0, 1 },
};

typedef struct {
    lt_level_surface *out;
    int32_t *slot;                  /* a vertex, by its edge */
    uint64_t mask;
} marcher;

/* How many edges cross, each once for each tetrahedron that has it, and how many faces there will be */
static void count(int64_t n, const int32_t (*tet)[4], const double *value, double level, int64_t *edges, int64_t *faces)
{
    *edges = *faces = 0;
    for (int64_t i = 0; i < n; i++) {
        int in = 0;

        for (int k = 0; k < 4; k++)
            in += value[tet[i][k]] > level;
        *edges += in * (4 - in);
        *faces += in == 2 ? 2 : in == 1 || in == 3;
    }
}

/* The vertex on the edge from a point inside to one outside */
static int32_t vertex_at(marcher *m, int32_t in, int32_t out)
{
    uint64_t at = ((uint64_t)in << 32 | (uint64_t)out) * UINT64_C(0x9e3779b97f4a7c15) >> 20;

    for (;; at++) {
        int32_t *v = &m->slot[at & m->mask];

        if (*v == EMPTY) {
            *v = (int32_t)m->out->n_vertices++;
            m->out->edge[*v][0] = in;
            m->out->edge[*v][1] = out;
        }
        if (m->out->edge[*v][0] == in && m->out->edge[*v][1] == out)
            return *v;
    }
}

static void add_face(marcher *m, int32_t a, int32_t b, int32_t c)
{
    int32_t *f = m->out->face[m->out->n_faces++];

    f[0] = a, f[1] = b, f[2] = c;
}

/* One corner inside, or one outside */
static void cut_off(marcher *m, const int32_t *tet, int alone, bool inside)
{
    const int *c = one[alone];
    int32_t v[3];

    for (int k = 0; k < 3; k++)
        v[k] = inside ? vertex_at(m, tet[alone], tet[c[k + 1]]) : vertex_at(m, tet[c[k + 1]], tet[alone]);
    add_face(m, v[0], inside ? v[1] : v[2], inside ? v[2] : v[1]);
}

static void cut_through(marcher *m, const int32_t *tet, int in)
{
    const int *c = two[in];
    const int32_t ux = vertex_at(m, tet[c[0]], tet[c[2]]), uy = vertex_at(m, tet[c[0]], tet[c[3]]);
    const int32_t vx = vertex_at(m, tet[c[1]], tet[c[2]]), vy = vertex_at(m, tet[c[1]], tet[c[3]]);

    add_face(m, ux, uy, vy);
    add_face(m, ux, vy, vx);
}

static void march(marcher *m, const int32_t *tet, const double *value, double level)
{
    int in = 0, n = 0;

    for (int k = 0; k < 4; k++)
        if (value[tet[k]] > level)
            in |= 1 << k, n++;
    if (n == 2)
        cut_through(m, tet, in);
    for (int k = 0; k < 4 && (n == 1 || n == 3); k++)
        if ((in >> k & 1) == (n == 1))
            cut_off(m, tet, k, n == 1);
}

lt_status lt_marching_tetrahedra(lt_arena *arena, int64_t n, const int32_t (*tet)[4], const double *value, double level,
                                 lt_level_surface *out)
{
    marcher m = { .out = out, .mask = 15 };
    int64_t edges, faces;

    count(n, tet, value, level, &edges, &faces);
    while (m.mask < 2 * (uint64_t)edges)
        m.mask = 2 * m.mask + 1;
    *out = (lt_level_surface){
        .edge = lt_arena_array(arena, (size_t)edges, sizeof(*out->edge)),
        .face = lt_arena_array(arena, (size_t)faces, sizeof(*out->face)),
    };
    m.slot = lt_alloc((size_t)(m.mask + 1) * sizeof(*m.slot));
    if ((edges && (!out->edge || !out->face)) || edges > INT32_MAX || !m.slot) {
        lt_release(m.slot);
        return lt_error(LT_ENOMEM, "no memory for a surface of %lld faces", (long long)faces);
    }
    memset(m.slot, 0xff, (size_t)(m.mask + 1) * sizeof(*m.slot));
    for (int64_t i = 0; i < n; i++)
        march(&m, tet[i], value, level);
    lt_release(m.slot);
    return LT_OK;
}
