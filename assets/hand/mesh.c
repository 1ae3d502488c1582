/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The zero set of the hand's signed distance as a dense triangle mesh, open at the wrist.
 *
 * One vertex in every cell that the skin crosses, one quad across every grid edge that it crosses.
 * Source: Gibson 1998, "Constrained elastic surface nets".
 */
#include "assets/hand/internal.h"

#include "libtensor/base/parallel.h"

enum { NX = 104, NY = 44, NZ = 92, BLOCK = 4 };     /* grid points; far blocks are not looked at */

static const double CELL_MM = 2;
static const vec3 origin = { -98, -40, -73 };

typedef struct {
    float *field;                   /* at grid points; NZ fastest */
    int32_t *vertex;                /* of each cell, -1 when the skin does not cross it */
    hand_surface *out;
    int last;                       /* the layer of cells that becomes the wrist loop */
} net;

static size_t at(int i, int j, int k) { return ((size_t)i * NY + j) * NZ + k; }

static vec3 grid_point(int i, int j, int k) { return madd(origin, vec(i, j, k), CELL_MM); }

/* Distances of one block of grid points, exact only where the skin may pass. */
static void fill_block(const hand_skeleton *s, net *n, int bi, int bj, int bk)
{
    const double half = (BLOCK - 1) / 2.0;
    const vec3 center = madd(origin, vec(bi + half, bj + half, bk + half), CELL_MM);
    const double far = hand_shape_distance(s, center);
    const bool skip = fabs(far) > 1.5 * BLOCK * CELL_MM;

    for (int i = bi; i < bi + BLOCK && i < NX; i++)
        for (int j = bj; j < bj + BLOCK && j < NY; j++)
            for (int k = bk; k < bk + BLOCK && k < NZ; k++)
                n->field[at(i, j, k)] =
                    (float)(skip ? far : hand_shape_distance(s, grid_point(i, j, k)));
}

typedef struct { const hand_skeleton *s; net *n; } fill_job;

static void fill_slab(void *ctx, int64_t slab)
{
    const fill_job *job = ctx;

    for (int j = 0; j < NY; j += BLOCK)
        for (int k = 0; k < NZ; k += BLOCK)
            fill_block(job->s, job->n, (int)slab * BLOCK, j, k);
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
            fa = n->field[at(i + ca[0], j + ca[1], k + ca[2])];
            fb = n->field[at(i + cb[0], j + cb[1], k + cb[2])];
            if ((fa < 0) == (fb < 0))
                continue;
            sum = add(sum, mix(vec(ca[0], ca[1], ca[2]), vec(cb[0], cb[1], cb[2]), fa / (fa - fb)));
            crossings++;
        }
    if (crossings)
        *out = madd(grid_point(i, j, k), sum, CELL_MM / crossings);
    return crossings > 0;
}

static void add_face(hand_surface *m, int32_t a, int32_t b, int32_t c)
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

/* The three grid edges that start at (i, j, k). Those beyond the wrist's layer make no quad. */
static void add_quads(net *n, int i, int j, int k)
{
    const float *f = n->field;
    const int32_t *v = n->vertex;
    const bool in = f[at(i, j, k)] < 0;

    if (i < n->last && in != (f[at(i + 1, j, k)] < 0))
        add_quad(n, (int32_t[]){ v[at(i, j - 1, k - 1)], v[at(i, j, k - 1)], v[at(i, j, k)],
                                 v[at(i, j - 1, k)] }, in);
    if (in != (f[at(i, j + 1, k)] < 0))
        add_quad(n, (int32_t[]){ v[at(i - 1, j, k - 1)], v[at(i - 1, j, k)], v[at(i, j, k)],
                                 v[at(i, j, k - 1)] }, in);
    if (in != (f[at(i, j, k + 1)] < 0))
        add_quad(n, (int32_t[]){ v[at(i - 1, j - 1, k)], v[at(i, j - 1, k)], v[at(i, j, k)],
                                 v[at(i - 1, j, k)] }, in);
}

/* A cell of the last layer carries a vertex only where the skin crosses its near side. */
static bool on_near_side(const net *n, int i, int j, int k)
{
    const bool a = n->field[at(i, j, k)] < 0, b = n->field[at(i, j + 1, k)] < 0;
    const bool c = n->field[at(i, j, k + 1)] < 0, d = n->field[at(i, j + 1, k + 1)] < 0;

    return !(a == b && b == c && c == d);
}

static void add_vertices(const hand_skeleton *s, net *n)
{
    hand_surface *m = n->out;
    vec3 p;

    for (int i = 0; i <= n->last; i++)
        for (int j = 0; j < NY - 1; j++)
            for (int k = 0; k < NZ - 1; k++) {
                const bool border = i == n->last;

                if (!cell_vertex(n, i, j, k, &p) || (border && !on_near_side(n, i, j, k)))
                    continue;
                n->vertex[at(i, j, k)] = m->n_vertices;
                m->border[m->n_vertices] = border;
                m->vertex[m->n_vertices++] = border ? hand_shape_snap(s, p, true) : p;
            }
}

lt_status hand_mesh_dense(lt_arena *arena, const hand_skeleton *s, hand_surface *out)
{
    enum { MAX_VERTICES = 40000 };
    const size_t cells = (size_t)NX * NY * NZ;
    net n = { lt_arena_array(arena, cells, sizeof(float)),
              lt_arena_array(arena, cells, sizeof(int32_t)), out,
              (int)lround((s->cut_x - origin.x) / CELL_MM) };
    fill_job job = { s, &n };

    *out = (hand_surface){ .vertex = lt_arena_array(arena, MAX_VERTICES, sizeof(vec3)),
                           .face = lt_arena_array(arena, 2 * MAX_VERTICES, sizeof(int32_t[3])),
                           .border = lt_arena_array(arena, MAX_VERTICES, sizeof(bool)) };
    if (!n.field || !n.vertex || !out->vertex || !out->face || !out->border)
        return lt_error(LT_ENOMEM, "synthetic hand: no memory for the dense mesh");
    lt_parallel_for(lt_ceil_div(NX, BLOCK), fill_slab, &job);
    add_vertices(s, &n);
    for (int i = 1; i <= n.last; i++)
        for (int j = 1; j < NY - 1; j++)
            for (int k = 1; k < NZ - 1; k++)
                add_quads(&n, i, j, k);
    return LT_OK;
}
