/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The zero set of a signed distance as a dense triangle mesh, open where planes cut it.
 *
 * One vertex in every cell that the skin crosses, one quad across every grid edge that it crosses.
 * Source: Gibson 1998, "Constrained elastic surface nets".
 */
#include "assets/surface/surface.h"

#include "libtensor/base/parallel.h"

enum { BLOCK = 4 };                 /* grid points; far blocks are not looked at */

typedef struct {
    const surface_skin *skin;
    const surface_grid *grid;
    float *field;                   /* at grid points; z fastest */
    int32_t *vertex;                /* of each cell, -1 when the skin does not cross it */
    surface_mesh *out;
    int first, last;                /* the layers of cells that become rims; first -1: there is none */
} net;

static size_t at(const net *n, int i, int j, int k)
{
    return ((size_t)i * (size_t)n->grid->n[1] + (size_t)j) * (size_t)n->grid->n[2] + (size_t)k;
}

static vec3 grid_point(const net *n, double i, double j, double k)
{
    return madd(n->grid->origin, vec(i, j, k), n->grid->cell);
}

/* Distances of one block of grid points, exact only where the skin may pass. */
static void fill_block(net *n, int bi, int bj, int bk)
{
    const double half = (BLOCK - 1) / 2.0;
    const int *size = n->grid->n;
    const double far = n->skin->distance(n->skin->ctx, grid_point(n, bi + half, bj + half, bk + half));
    const bool skip = fabs(far) > 1.5 * BLOCK * n->grid->cell;

    for (int i = bi; i < bi + BLOCK && i < size[0]; i++)
        for (int j = bj; j < bj + BLOCK && j < size[1]; j++)
            for (int k = bk; k < bk + BLOCK && k < size[2]; k++)
                n->field[at(n, i, j, k)] =
                    (float)(skip ? far : n->skin->distance(n->skin->ctx, grid_point(n, i, j, k)));
}

static void fill_slab(void *ctx, int64_t slab)
{
    net *n = ctx;

    for (int j = 0; j < n->grid->n[1]; j += BLOCK)
        for (int k = 0; k < n->grid->n[2]; k += BLOCK)
            fill_block(n, (int)slab * BLOCK, j, k);
}

/* The mean of the points where the skin crosses the edges of a cell. */
static bool cell_vertex(const net *n, int i, int j, int k, vec3 *out)
{
    static const int corner[8][3] = { { 0, 0, 0 }, { 0, 0, 1 }, { 0, 1, 0 }, { 0, 1, 1 },
                                      { 1, 0, 0 }, { 1, 0, 1 }, { 1, 1, 0 }, { 1, 1, 1 } };
    vec3 sum = { 0, 0, 0 };
    int crossings = 0;

    for (int a = 0; a < 8; a++)
        for (int axis = 1; axis < 8; axis <<= 1) {
            const int b = a | axis;
            const int *ca = corner[a], *cb = corner[b];
            double fa, fb;

            if (b == a)
                continue;
            fa = n->field[at(n, i + ca[0], j + ca[1], k + ca[2])];
            fb = n->field[at(n, i + cb[0], j + cb[1], k + cb[2])];
            if ((fa < 0) == (fb < 0))
                continue;
            sum = add(sum, mix(vec(ca[0], ca[1], ca[2]), vec(cb[0], cb[1], cb[2]), fa / (fa - fb)));
            crossings++;
        }
    if (crossings)
        *out = madd(grid_point(n, i, j, k), sum, n->grid->cell / crossings);
    return crossings > 0;
}

static void add_face(surface_mesh *m, int32_t a, int32_t b, int32_t c)
{
    m->face[m->n_faces][0] = a;
    m->face[m->n_faces][1] = b;
    m->face[m->n_faces++][2] = c;
}

/* The quad of four cells around a grid edge, cut along its shorter diagonal. */
static void add_quad(net *n, const int32_t q[4], bool inside_first)
{
    const vec3 *v = n->out->vertex;
    const int32_t a = q[0], b = q[inside_first ? 1 : 3], c = q[2], d = q[inside_first ? 3 : 1];

    if (dist(v[a], v[c]) < dist(v[b], v[d])) {
        add_face(n->out, a, b, c);
        add_face(n->out, a, c, d);
    } else {
        add_face(n->out, a, b, d);
        add_face(n->out, b, c, d);
    }
}

/* The three grid edges that start at (i, j, k). Those beyond the rims' layers make no quad. */
static void add_quads(net *n, int i, int j, int k)
{
    const float *f = n->field;
    const int32_t *v = n->vertex;
    const bool in = f[at(n, i, j, k)] < 0;

    if (i < n->last && in != (f[at(n, i + 1, j, k)] < 0))
        add_quad(n, (int32_t[]){ v[at(n, i, j - 1, k - 1)], v[at(n, i, j, k - 1)], v[at(n, i, j, k)],
                                 v[at(n, i, j - 1, k)] }, in);
    if (in != (f[at(n, i, j + 1, k)] < 0))
        add_quad(n, (int32_t[]){ v[at(n, i - 1, j, k - 1)], v[at(n, i - 1, j, k)], v[at(n, i, j, k)],
                                 v[at(n, i, j, k - 1)] }, in);
    if (in != (f[at(n, i, j, k + 1)] < 0))
        add_quad(n, (int32_t[]){ v[at(n, i - 1, j - 1, k)], v[at(n, i, j - 1, k)], v[at(n, i, j, k)],
                                 v[at(n, i - 1, j, k)] }, in);
}

/* A cell of a rim's layer carries a vertex only where the skin crosses the side that is in the mesh: at i. */
static bool on_side(const net *n, int i, int j, int k)
{
    const bool a = n->field[at(n, i, j, k)] < 0, b = n->field[at(n, i, j + 1, k)] < 0;
    const bool c = n->field[at(n, i, j, k + 1)] < 0, d = n->field[at(n, i, j + 1, k + 1)] < 0;

    return !(a == b && b == c && c == d);
}

static void add_vertices(net *n)
{
    surface_mesh *m = n->out;
    vec3 p;

    for (int i = n->first < 0 ? 0 : n->first; i <= n->last; i++)
        for (int j = 0; j < n->grid->n[1] - 1; j++)
            for (int k = 0; k < n->grid->n[2] - 1; k++) {
                const int rim = i == n->last ? n->grid->loop[1] : i == n->first ? n->grid->loop[0] : 0;

                if (!cell_vertex(n, i, j, k, &p) || (rim && !on_side(n, i == n->last ? i : i + 1, j, k)))
                    continue;
                n->vertex[at(n, i, j, k)] = m->n_vertices;
                m->loop[m->n_vertices] = (uint8_t)rim;
                m->vertex[m->n_vertices++] = rim ? n->skin->snap(n->skin->ctx, p, rim) : p;
            }
}

/* At most one vertex in a cell, and few cells have any: those that hold the skin. */
static size_t count_vertices(const net *n)
{
    size_t count = 0;
    vec3 p;

    for (int i = 0; i <= n->last; i++)
        for (int j = 0; j < n->grid->n[1] - 1; j++)
            for (int k = 0; k < n->grid->n[2] - 1; k++)
                count += cell_vertex(n, i, j, k, &p);
    return count;
}

static lt_status get_mesh(lt_arena *arena, const net *n, surface_mesh *out)
{
    const size_t most = count_vertices(n);

    *out = (surface_mesh){ .vertex = lt_arena_array(arena, most, sizeof(vec3)),
                           .face = lt_arena_array(arena, 3 * most, sizeof(int32_t[3])),
                           .loop = lt_arena_array(arena, most, sizeof(uint8_t)) };
    if (!out->vertex || !out->face || !out->loop)
        return lt_error(LT_ENOMEM, "%s: no memory for the dense mesh", n->skin->name);
    return LT_OK;
}

lt_status surface_nets(lt_arena *arena, const surface_skin *skin, const surface_grid *grid, surface_mesh *out)
{
    const size_t cells = (size_t)grid->n[0] * (size_t)grid->n[1] * (size_t)grid->n[2];
    net n = { .skin = skin, .grid = grid, .out = out, .field = lt_arena_array(arena, cells, sizeof(float)),
              .vertex = lt_arena_array(arena, cells, sizeof(int32_t)),
              .first = grid->low ? (int)lround((grid->cut[0] - grid->origin.x) / grid->cell) - 1 : -1,
              .last = (int)lround((grid->cut[1] - grid->origin.x) / grid->cell) };
    lt_status st;

    if (!n.field || !n.vertex)
        return lt_error(LT_ENOMEM, "%s: no memory for the dense mesh", skin->name);
    lt_parallel_for(lt_ceil_div(grid->n[0], BLOCK), fill_slab, &n);
    st = get_mesh(arena, &n, out);
    if (st)
        return st;
    add_vertices(&n);
    for (int i = n.first < 0 ? 1 : n.first + 1; i <= n.last; i++)
        for (int j = 1; j < grid->n[1] - 1; j++)
            for (int k = 1; k < grid->n[2] - 1; k++)
                add_quads(&n, i, j, k);
    return LT_OK;
}
