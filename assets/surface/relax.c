/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Better triangles on the same skin: flip edges that leave sharp corners, slide vertices to the middle
 * of their surroundings, put them back on the skin, and again.
 *
 * Source: Botsch and Kobbelt 2004, "A remeshing approach to multiresolution modeling".
 */
#include "assets/surface/surface.h"

#include "libtensor/base/parallel.h"

#include <stdlib.h>
#include <string.h>

/* An edge with the corners opposite to it: faces (a, b, c) and (b, a, d). */
typedef struct { int32_t a, b, f, g; } edge;

static double smallest_cosine_loss(vec3 a, vec3 b, vec3 c)
{
    const double ab = dist(a, b), bc = dist(b, c), ca = dist(c, a);
    const double at_a = dot(sub(b, a), sub(c, a)) / (ab * ca),
                 at_b = dot(sub(a, b), sub(c, b)) / (ab * bc);
    const double at_c = dot(sub(a, c), sub(b, c)) / (bc * ca);

    return 1 - fmax(at_a, fmax(at_b, at_c));    /* grows with the smallest angle */
}

static int by_ends(const void *x, const void *y)
{
    const edge *e = x, *g = y;

    if (e->a != g->a)
        return e->a < g->a ? -1 : 1;
    if (e->b != g->b)
        return e->b < g->b ? -1 : 1;
    return (e->f > g->f) - (e->f < g->f);
}

/* All edges with their two faces (g = -1 on a rim), sorted by their ends a < b. */
static int list_edges(const surface_mesh *m, edge *out)
{
    int n = 0, unique = 0;

    for (int f = 0; f < m->n_faces; f++)
        for (int k = 0; k < 3; k++) {
            const int32_t a = m->face[f][k], b = m->face[f][(k + 1) % 3];
            out[n++] = (edge){ a < b ? a : b, a < b ? b : a, f, -1 };
        }
    qsort(out, (size_t)n, sizeof(*out), by_ends);
    for (int i = 0; i < n; i++)
        if (unique && out[unique - 1].a == out[i].a && out[unique - 1].b == out[i].b)
            out[unique - 1].g = out[i].f;
        else
            out[unique++] = out[i];
    return unique;
}

static bool joined(const edge *edges, int n, int32_t a, int32_t b)
{
    int lo = 0, hi = n;

    if (a > b)
        return joined(edges, n, b, a);
    while (lo < hi) {
        const int mid = (lo + hi) / 2;

        if (edges[mid].a < a || (edges[mid].a == a && edges[mid].b < b))
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo < n && edges[lo].a == a && edges[lo].b == b;
}

static int32_t opposite(const int32_t f[3], int32_t a, int32_t b)
{
    return f[0] != a && f[0] != b ? f[0] : f[1] != a && f[1] != b ? f[1] : f[2];
}

static vec3 face_normal(const vec3 *v, int32_t a, int32_t b, int32_t c)
{
    return unit(cross(sub(v[b], v[a]), sub(v[c], v[a])));
}

/* Whether face f runs from a to b rather than from b to a. */
static bool runs(const int32_t f[3], int32_t a, int32_t b)
{
    return (f[0] == a && f[1] == b) || (f[1] == a && f[2] == b) || (f[2] == a && f[0] == b);
}

static bool better_flipped(const surface_mesh *m, int32_t a, int32_t b, int32_t c, int32_t d)
{
    const vec3 *v = m->vertex;
    const double now =
        fmin(smallest_cosine_loss(v[a], v[b], v[c]), smallest_cosine_loss(v[a], v[b], v[d]));
    const double then =
        fmin(smallest_cosine_loss(v[c], v[d], v[a]), smallest_cosine_loss(v[c], v[d], v[b]));
    const vec3 n = add(face_normal(v, a, b, c), face_normal(v, b, a, d));

    return then > now * 1.02 && dot(face_normal(v, c, a, d), n) > 1
           && dot(face_normal(v, d, b, c), n) > 1;
}

/* One pass over the edges; a face is touched once, so that the list stays true. */
static int flip_edges(surface_mesh *m, edge *edges, bool *touched)
{
    const int n = list_edges(m, edges);
    int flips = 0;

    memset(touched, 0, (size_t)m->n_faces);
    for (int i = 0; i < n; i++) {
        const edge *e = &edges[i];
        int32_t f, g, c, d;

        if (e->g < 0 || touched[e->f] || touched[e->g])
            continue;
        f = runs(m->face[e->f], e->a, e->b) ? e->f : e->g;
        g = f == e->f ? e->g : e->f;
        c = opposite(m->face[f], e->a, e->b);
        d = opposite(m->face[g], e->a, e->b);
        if (!better_flipped(m, e->a, e->b, c, d) || joined(edges, n, c, d))
            continue;
        memcpy(m->face[f], (int32_t[]){ c, e->a, d }, sizeof(int32_t[3]));
        memcpy(m->face[g], (int32_t[]){ d, e->b, c }, sizeof(int32_t[3]));
        touched[f] = touched[g] = true;
        flips++;
    }
    return flips;
}

/* Where each vertex would like to be: the middle of its faces, those too large for their place first. */
static void middles(const surface_skin *skin, const surface_mesh *m, vec3 *sum, double *weight)
{
    memset(sum, 0, (size_t)m->n_vertices * sizeof(*sum));
    memset(weight, 0, (size_t)m->n_vertices * sizeof(*weight));
    for (int f = 0; f < m->n_faces; f++) {
        const vec3 a = m->vertex[m->face[f][0]], b = m->vertex[m->face[f][1]],
                   c = m->vertex[m->face[f][2]];
        const vec3 mid = scale(add(add(a, b), c), 1.0 / 3);
        const double h = skin->spacing(skin->ctx, mid),
                     w = norm(cross(sub(b, a), sub(c, a))) / (h * h);

        for (int k = 0; k < 3; k++) {
            sum[m->face[f][k]] = madd(sum[m->face[f][k]], mid, w);
            weight[m->face[f][k]] += w;
        }
    }
}

/* A rim: each vertex towards the middle of its two neighbours on it. */
static void border_middles(const surface_mesh *m, const edge *edges, int n, vec3 *sum,
                           double *weight)
{
    for (int v = 0; v < m->n_vertices; v++)
        if (m->loop[v]) {
            sum[v] = vec(0, 0, 0);
            weight[v] = 0;
        }
    for (int i = 0; i < n; i++)
        if (edges[i].g < 0) {
            sum[edges[i].a] = add(sum[edges[i].a], m->vertex[edges[i].b]);
            sum[edges[i].b] = add(sum[edges[i].b], m->vertex[edges[i].a]);
            weight[edges[i].a]++;
            weight[edges[i].b]++;
        }
}

typedef struct {
    const surface_skin *skin;
    surface_mesh *m;
    const vec3 *sum;
    const double *weight;
    unsigned held;
} slide_job;

enum { PIECE = 64 };                /* vertices of a task */

static void slide(void *ctx, int64_t i)
{
    const slide_job *job = ctx;
    const surface_skin *skin = job->skin;
    surface_mesh *m = job->m;

    for (int v = (int)i * PIECE; v < (i + 1) * PIECE && v < m->n_vertices; v++) {
        const int loop = m->loop[v];
        const vec3 p = m->vertex[v], n = skin->normal(skin->ctx, p);
        const vec3 move = sub(scale(job->sum[v], 1 / job->weight[v]), p);

        if (!loop || !(job->held >> loop & 1))
            m->vertex[v] = skin->snap(skin->ctx, madd(p, loop ? move : reject(move, n), 0.6), loop);
    }
}

lt_status surface_relax(lt_arena *arena, const surface_skin *skin, int rounds, unsigned held, surface_mesh *m)
{
    edge *edges = lt_arena_array(arena, 3 * (size_t)m->n_faces, sizeof(edge));
    bool *touched = lt_arena_array(arena, (size_t)m->n_faces, sizeof(bool));
    vec3 *sum = lt_arena_array(arena, (size_t)m->n_vertices, sizeof(vec3));
    double *weight = lt_arena_array(arena, (size_t)m->n_vertices, sizeof(double));
    slide_job job = { skin, m, sum, weight, held };

    if (!edges || !touched || !sum || !weight)
        return lt_error(LT_ENOMEM, "%s: no memory to relax the mesh", skin->name);
    for (int round = 0; round < rounds; round++) {
        while (flip_edges(m, edges, touched))
            ;
        middles(skin, m, sum, weight);
        border_middles(m, edges, list_edges(m, edges), sum, weight);
        lt_parallel_for(lt_ceil_div(m->n_vertices, PIECE), slide, &job);
    }
    while (flip_edges(m, edges, touched))
        ;
    return LT_OK;
}
