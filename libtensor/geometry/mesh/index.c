/* SPDX-License-Identifier: Apache-2.0 */
/* A tree of boxes over triangles: split at the median of the longest axis, down to a few per leaf. */
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/internal.h"

enum { LEAF = 4 };          /* triangles */

/* ---- building ------------------------------------------------------------------------------------- */

static lt_status copy_triangles(const lt_mesh *mesh, lt_mesh_triangle *out)
{
    for (int f = 0; f < mesh->n_faces; f++)
        for (int k = 0; k < 3; k++) {
            const int v = mesh->face[f][k];
            if (v < 0 || v >= mesh->n_vertices)
                return lt_error(LT_EINVAL, "mesh index: face %d names vertex %d of %d", f, v,
                                mesh->n_vertices);
            out[f].face = f;
            for (int a = 0; a < 3; a++) {
                out[f].corner[k][a] = mesh->vertex[v][a];
                if (!isfinite(out[f].corner[k][a]))
                    return lt_error(LT_EINVAL, "mesh index: vertex %d has a coordinate that is not finite",
                                    v);
            }
        }
    return LT_OK;
}

static double middle(const lt_mesh_triangle *t, int axis)
{
    return t->corner[0][axis] + t->corner[1][axis] + t->corner[2][axis];
}

/* A total order, so that the tree does not depend on how it is sorted. */
static bool before(const lt_mesh_triangle *a, const lt_mesh_triangle *b, int axis)
{
    const double ma = middle(a, axis), mb = middle(b, axis);

    return ma < mb || (ma == mb && a->face < b->face);
}

static void swap(lt_mesh_triangle *a, lt_mesh_triangle *b)
{
    const lt_mesh_triangle t = *a;

    *a = *b;
    *b = t;
}

/* Quickselect: the first `half` of n triangles come before the others along the axis. */
static void split(lt_mesh_triangle *t, int n, int half, int axis)
{
    int lo = 0, hi = n - 1;

    while (lo < hi) {
        const lt_mesh_triangle pivot = t[lo + (hi - lo) / 2];
        int i = lo, j = hi;
        while (i <= j) {
            while (before(&t[i], &pivot, axis))
                i++;
            while (before(&pivot, &t[j], axis))
                j--;
            if (i <= j)
                swap(&t[i++], &t[j--]);
        }
        if (half <= j)
            hi = j;
        else if (half >= i)
            lo = i;
        else
            return;
    }
}

static void bound(lt_mesh_node *b, const lt_mesh_triangle *t, int n)
{
    for (int a = 0; a < 3; a++) {
        b->lo[a] = INFINITY;
        b->hi[a] = -INFINITY;
    }
    for (int i = 0; i < 3 * n; i++)
        for (int a = 0; a < 3; a++) {
            b->lo[a] = fmin(b->lo[a], t[i / 3].corner[i % 3][a]);
            b->hi[a] = fmax(b->hi[a], t[i / 3].corner[i % 3][a]);
        }
}

static int longest_axis(const lt_mesh_node *b)
{
    int axis = 0;

    for (int a = 1; a < 3; a++)
        if (b->hi[a] - b->lo[a] > b->hi[axis] - b->lo[axis])
            axis = a;
    return axis;
}

static void build(lt_mesh_index *index, int at, int first, int count)
{
    lt_mesh_node *b = &index->nodes[at];
    const int half = count / 2;

    bound(b, index->triangles + first, count);
    lt_mesh_measure_node(b, index->triangles + first, count);
    if (count <= LEAF) {
        b->first = first;
        b->count = count;
        return;
    }
    split(index->triangles + first, count, half, longest_axis(b));
    b->first = index->n_nodes;
    index->n_nodes += 2;
    build(index, b->first, first, half);
    build(index, b->first + 1, first + half, count - half);
}

lt_status lt_mesh_index_new(lt_arena *arena, const lt_mesh *mesh, lt_mesh_index **out)
{
    lt_mesh_index *index;
    lt_status st;

    if (mesh->n_faces < 1)
        return lt_error(LT_EINVAL, "mesh index: %d faces, want at least 1", mesh->n_faces);
    index = lt_arena_alloc(arena, sizeof(*index));
    if (!index)
        return lt_error(LT_ENOMEM, "mesh index: no memory");
    index->triangles = lt_arena_array(arena, (size_t)mesh->n_faces, sizeof(lt_mesh_triangle));
    index->nodes = lt_arena_array(arena, 2 * (size_t)mesh->n_faces, sizeof(lt_mesh_node));
    if (!index->triangles || !index->nodes)
        return lt_error(LT_ENOMEM, "mesh index: no memory for %d faces", mesh->n_faces);
    st = copy_triangles(mesh, index->triangles);
    if (st)
        return st;
    index->n_nodes = 1;
    build(index, 0, 0, mesh->n_faces);
    *out = index;
    return LT_OK;
}

/* ---- the nearest point ---------------------------------------------------------------------------- */

static double box_distance(const lt_mesh_node *b, const double p[3])
{
    double d[3];

    for (int a = 0; a < 3; a++)
        d[a] = fmax(fmax(b->lo[a] - p[a], p[a] - b->hi[a]), 0);
    return lt_vec3_norm(d);
}

static void try_triangle(const lt_mesh_triangle *t, const double p[3], lt_mesh_hit *best)
{
    double q[3], d;

    lt_closest_on_triangle(p, t->corner[0], t->corner[1], t->corner[2], q);
    d = lt_vec3_distance(p, q);
    if (d > best->distance || (d == best->distance && t->face > best->face))
        return;
    best->distance = d;
    best->face = t->face;
    memcpy(best->point, q, sizeof(q));
}

lt_mesh_hit lt_mesh_closest(const lt_mesh_index *index, const double p[3])
{
    lt_mesh_hit best = { .point = { p[0], p[1], p[2] }, .distance = INFINITY };
    int stack[LT_MESH_STACK], depth = 0;

    stack[depth++] = 0;
    while (depth > 0) {
        const lt_mesh_node *b = &index->nodes[stack[--depth]];
        const double slack = 1e-12 * best.distance;     /* a box and its triangle round apart */
        int nearer;
        if (box_distance(b, p) > best.distance + slack)
            continue;
        for (int i = 0; i < b->count; i++)
            try_triangle(&index->triangles[b->first + i], p, &best);
        if (b->count > 0)
            continue;
        nearer = box_distance(&index->nodes[b->first + 1], p) < box_distance(&index->nodes[b->first], p);
        stack[depth++] = b->first + !nearer;
        stack[depth++] = b->first + nearer;             /* taken first */
    }
    return best;
}

/* ---- inside --------------------------------------------------------------------------------------- */

/* Whether the ray p + s d, s > 0, meets the box. */
static bool ray_meets_box(const lt_mesh_node *b, const double p[3], const double d[3])
{
    double enter = 0, leave = INFINITY;

    for (int a = 0; a < 3; a++) {
        const double s0 = (b->lo[a] - p[a]) / d[a], s1 = (b->hi[a] - p[a]) / d[a];
        enter = fmax(enter, fmin(s0, s1));
        leave = fmin(leave, fmax(s0, s1));
    }
    return enter <= leave * (1 + 1e-12) + 1e-300;
}

/* Moller and Trumbore 1997: solve p + s d = a + u ab + v ac */
static bool ray_meets_triangle(const lt_mesh_triangle *t, const double p[3], const double d[3])
{
    double ab[3], ac[3], ap[3], h[3], q[3], det, u, v;

    lt_vec3_sub(t->corner[1], t->corner[0], ab);
    lt_vec3_sub(t->corner[2], t->corner[0], ac);
    lt_vec3_sub(p, t->corner[0], ap);
    lt_vec3_cross(d, ac, h);
    lt_vec3_cross(ap, ab, q);
    det = lt_vec3_dot(ab, h);
    if (det == 0)
        return false;
    u = lt_vec3_dot(ap, h) / det;
    v = lt_vec3_dot(d, q) / det;
    return u >= 0 && v >= 0 && u + v <= 1 && lt_vec3_dot(ac, q) / det > 0;
}

static bool odd_crossings(const lt_mesh_index *index, const double p[3], const double d[3])
{
    int stack[LT_MESH_STACK], depth = 0;
    bool odd = false;

    stack[depth++] = 0;
    while (depth > 0) {
        const lt_mesh_node *b = &index->nodes[stack[--depth]];
        if (!ray_meets_box(b, p, d))
            continue;
        for (int i = 0; i < b->count; i++)
            odd ^= ray_meets_triangle(&index->triangles[b->first + i], p, d);
        if (b->count > 0)
            continue;
        stack[depth++] = b->first;
        stack[depth++] = b->first + 1;
    }
    return odd;
}

bool lt_mesh_inside(const lt_mesh_index *index, const double p[3])
{
    /* Directions that run along nothing people model, so that edges are not met exactly. */
    static const double direction[3][3] = {
        { .5773, .2113, .7887 }, { -.6547, .7319, .1891 }, { .1409, -.8711, -.4704 },
    };
    int votes = 0;

    for (int k = 0; k < 3; k++)
        votes += odd_crossings(index, p, direction[k]);
    return votes >= 2;
}
