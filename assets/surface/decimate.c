/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Edge collapses, cheapest first, down to a given number of vertices, and of edges around each opening.
 *
 * An edge is cheap when it is short for its place and its collapse leaves the planes around it little.
 * Source: Garland and Heckbert 1997, "Surface simplification using quadric error metrics".
 */
#include "assets/surface/surface.h"

#include <assert.h>

enum { MAX_RING = 24 }; /* faces around a vertex; a collapse that makes more is refused */

typedef struct { double a[10]; } quadric;       /* upper triangle of the 4 x 4 form */

typedef struct { double cost; int32_t a, b, stamp_a, stamp_b; } candidate;

typedef struct {
    const surface_skin *skin;
    surface_mesh *m;
    quadric *q;
    int32_t (*ring)[MAX_RING];      /* faces around each vertex */
    int32_t *ring_n, *stamp;        /* stamp: bumped when a vertex changes, -1 when it is gone */
    double *spacing;
    candidate *heap;
    size_t heap_n, heap_cap;
    int inside, rim[SURFACE_LOOPS + 1];     /* how many are left: on no rim, on each */
} decimation;

static void add_plane(quadric *q, vec3 n, double d, double w)
{
    const double p[4] = { n.x, n.y, n.z, d };
    int at = 0;

    for (int i = 0; i < 4; i++)
        for (int j = i; j < 4; j++)
            q->a[at++] += w * p[i] * p[j];
}

static double quadric_at(const quadric *q, vec3 v)
{
    const double p[4] = { v.x, v.y, v.z, 1 };
    double sum = 0;
    int at = 0;

    for (int i = 0; i < 4; i++)
        for (int j = i; j < 4; j++)
            sum += (i == j ? 1 : 2) * q->a[at++] * p[i] * p[j];
    return sum;
}

static void add_face_quadric(decimation *d, const int32_t f[3])
{
    const vec3 *v = d->m->vertex;
    const vec3 c = cross(sub(v[f[1]], v[f[0]]), sub(v[f[2]], v[f[0]])), n = unit(c);

    for (int k = 0; k < 3; k++)
        add_plane(&d->q[f[k]], n, -dot(n, v[f[0]]), norm(c) / 2);
}

/* Vertices joined to v; at most 2 * MAX_RING, without repeats. */
static int neighbours(const decimation *d, int32_t v, int32_t out[2 * MAX_RING])
{
    int n = 0;

    for (int r = 0; r < d->ring_n[v]; r++)
        for (int k = 0; k < 3; k++) {
            const int32_t u = d->m->face[d->ring[v][r]][k];
            bool known = u == v;

            for (int i = 0; i < n && !known; i++)
                known = out[i] == u;
            if (!known)
                out[n++] = u;
        }
    return n;
}

static vec3 merged_place(const decimation *d, int32_t a, int32_t b)
{
    const surface_mesh *m = d->m;

    if (m->loop[a] != m->loop[b])
        return m->vertex[m->loop[a] ? a : b];
    return mix(m->vertex[a], m->vertex[b], 0.5);
}

static double cost(const decimation *d, int32_t a, int32_t b)
{
    const vec3 *v = d->m->vertex, p = merged_place(d, a, b);
    const double h = (d->spacing[a] + d->spacing[b]) / 2, len = dist(v[a], v[b]) / h;
    const double err = quadric_at(&d->q[a], p) + quadric_at(&d->q[b], p);

    return len * len * (1 + 0.1 * err / (h * h));
}

static void sift_up(candidate *h, size_t i)
{
    const candidate c = h[i];

    for (; i > 0 && h[(i - 1) / 2].cost > c.cost; i = (i - 1) / 2)
        h[i] = h[(i - 1) / 2];
    h[i] = c;
}

static void push(decimation *d, int32_t a, int32_t b)
{
    assert(d->heap_n < d->heap_cap);
    d->heap[d->heap_n] = (candidate){ cost(d, a, b), a, b, d->stamp[a], d->stamp[b] };
    sift_up(d->heap, d->heap_n++);
}

static candidate pop(decimation *d)
{
    const candidate top = d->heap[0], last = d->heap[--d->heap_n];
    size_t i = 0;

    for (;;) {
        size_t child = 2 * i + 1;

        if (child >= d->heap_n)
            break;
        if (child + 1 < d->heap_n && d->heap[child + 1].cost < d->heap[child].cost)
            child++;
        if (d->heap[child].cost >= last.cost)
            break;
        d->heap[i] = d->heap[child];
        i = child;
    }
    d->heap[i] = last;
    return top;
}

static int shared_faces(const decimation *d, int32_t a, int32_t b)
{
    int n = 0;

    for (int r = 0; r < d->ring_n[a]; r++) {
        const int32_t *f = d->m->face[d->ring[a][r]];
        n += f[0] == b || f[1] == b || f[2] == b;
    }
    return n;
}

/* The link condition: a and b may share only the corners opposite to their edge. */
static bool keeps_topology(const decimation *d, int32_t a, int32_t b)
{
    int32_t na[2 * MAX_RING], nb[2 * MAX_RING];
    const int ka = neighbours(d, a, na), kb = neighbours(d, b, nb), faces = shared_faces(d, a, b);
    int common = 0;

    for (int i = 0; i < ka; i++)
        for (int j = 0; j < kb; j++)
            common += na[i] == nb[j];
    if (d->m->loop[a] && d->m->loop[b] && (faces != 1 || d->m->loop[a] != d->m->loop[b]))
        return false;
    return common == faces && d->ring_n[a] + d->ring_n[b] - 2 * faces < MAX_RING;
}

/* No face around v but those that vanish with other may turn over when v moves to p. */
static bool keeps_sides(const decimation *d, int32_t v, int32_t other, vec3 p)
{
    const vec3 *x = d->m->vertex;

    for (int r = 0; r < d->ring_n[v]; r++) {
        const int32_t *f = d->m->face[d->ring[v][r]];
        const int k = f[0] == v ? 0 : f[1] == v ? 1 : 2;
        const int32_t b = f[(k + 1) % 3], c = f[(k + 2) % 3];
        vec3 was, is;

        if (b == other || c == other)
            continue;
        was = unit(cross(sub(x[b], x[v]), sub(x[c], x[v])));
        is = unit(cross(sub(x[b], p), sub(x[c], p)));
        if (dot(was, is) < 0.3)
            return false;
    }
    return true;
}

static void drop_face(decimation *d, int32_t v, int32_t face)
{
    int r = 0;

    while (d->ring[v][r] != face)
        r++;
    d->ring[v][r] = d->ring[v][--d->ring_n[v]];
}

/* Merge b into a. Faces on the edge keep b, which is gone. */
static void collapse(decimation *d, int32_t a, int32_t b)
{
    surface_mesh *m = d->m;
    int32_t near[2 * MAX_RING];
    int n;

    m->vertex[a] = merged_place(d, a, b);
    for (int i = 0; i < 10; i++)
        d->q[a].a[i] += d->q[b].a[i];
    for (int r = 0; r < d->ring_n[b]; r++) {
        const int32_t face = d->ring[b][r];
        int32_t *f = m->face[face];

        if (f[0] == a || f[1] == a || f[2] == a) {
            for (int k = 0; k < 3; k++)
                if (f[k] != b)
                    drop_face(d, f[k], face);
            f[0] = b;
            continue;
        }
        for (int k = 0; k < 3; k++)
            f[k] = f[k] == b ? a : f[k];
        d->ring[a][d->ring_n[a]++] = face;
    }
    if (m->loop[a] && m->loop[b])
        d->rim[m->loop[a]]--;
    else
        d->inside--;
    m->loop[a] |= m->loop[b];
    m->vertex[a] = d->skin->snap(d->skin->ctx, m->vertex[a], m->loop[a]);
    d->stamp[b] = -1;
    d->stamp[a]++;
    n = neighbours(d, a, near);
    for (int i = 0; i < n; i++)
        push(d, a, near[i]);
}

static bool allowed(const decimation *d, int32_t a, int32_t b, int inside, const int rim[SURFACE_LOOPS])
{
    const uint8_t *loop = d->m->loop;
    const vec3 p = merged_place(d, a, b);

    if (loop[a] && loop[b] ? d->rim[loop[a]] <= rim[loop[a] - 1] : d->inside <= inside)
        return false;
    return keeps_topology(d, a, b) && keeps_sides(d, a, b, p) && keeps_sides(d, b, a, p);
}

static lt_status prepare(lt_arena *arena, decimation *d)
{
    const surface_mesh *m = d->m;
    const size_t n = (size_t)m->n_vertices;

    d->heap_cap = 32 * n; /* an edge per face corner at first, some six per collapse after */
    d->q = lt_arena_array(arena, n, sizeof(quadric));
    d->ring = lt_arena_array(arena, n, sizeof(*d->ring));
    d->ring_n = lt_arena_array(arena, n, sizeof(int32_t));
    d->stamp = lt_arena_array(arena, n, sizeof(int32_t));
    d->spacing = lt_arena_array(arena, n, sizeof(double));
    d->heap = lt_arena_array(arena, d->heap_cap, sizeof(candidate));
    if (!d->q || !d->ring || !d->ring_n || !d->stamp || !d->spacing || !d->heap)
        return lt_error(LT_ENOMEM, "%s: no memory to simplify the mesh", d->skin->name);
    for (int f = 0; f < m->n_faces; f++)
        for (int k = 0; k < 3; k++) {
            const int32_t v = m->face[f][k];

            if (d->ring_n[v] == MAX_RING)
                return lt_error(LT_ENUMERIC, "%s: over %d faces around a vertex", d->skin->name, MAX_RING);
            d->ring[v][d->ring_n[v]++] = f;
        }
    for (int v = 0; v < m->n_vertices; v++) {
        d->spacing[v] = d->skin->spacing(d->skin->ctx, m->vertex[v]);
        d->rim[m->loop[v]]++;
    }
    d->inside = d->rim[0];
    return LT_OK;
}

static void push_all(decimation *d)
{
    const surface_mesh *m = d->m;

    for (int f = 0; f < m->n_faces; f++)
        add_face_quadric(d, m->face[f]);
    for (int f = 0; f < m->n_faces; f++)
        for (int k = 0; k < 3; k++)
            push(d, m->face[f][k], m->face[f][(k + 1) % 3]);
}

lt_status surface_decimate(lt_arena *arena, const surface_skin *skin, int n_vertices, const int rim[SURFACE_LOOPS],
                           surface_mesh *m)
{
    decimation d = { .skin = skin, .m = m };
    const lt_status st = prepare(arena, &d);
    int inside = n_vertices, over, missed;

    if (st)
        return st;
    for (int i = 0; i < SURFACE_LOOPS; i++)
        inside -= rim[i];
    push_all(&d);
    do {
        const candidate c = pop(&d);

        if (d.stamp[c.a] == c.stamp_a && d.stamp[c.b] == c.stamp_b && allowed(&d, c.a, c.b, inside, rim))
            collapse(&d, c.a, c.b);
        over = d.inside > inside;
        for (int i = 0; i < SURFACE_LOOPS; i++)
            over |= d.rim[1 + i] > rim[i];
    } while (d.heap_n && over);
    surface_compact(m, d.stamp);
    missed = d.inside != inside;
    for (int i = 0; i < SURFACE_LOOPS; i++)
        missed |= d.rim[1 + i] != rim[i];
    if (missed)
        return lt_error(LT_ENUMERIC,
                        "%s: simplified to %d vertices, with %d, %d, %d on the rims, want %d and %d, %d, %d",
                        skin->name, m->n_vertices, d.rim[1], d.rim[2], d.rim[3], n_vertices, rim[0], rim[1], rim[2]);
    return LT_OK;
}
