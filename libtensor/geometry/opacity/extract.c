/* SPDX-License-Identifier: Apache-2.0 */
/* The surface of a field: tetrahedra, marching, bisection, and what is too small to count taken away. */
#include "libtensor/geometry/opacity/opacity.h"

#include "libtensor/geometry/delaunay/delaunay.h"
#include "libtensor/geometry/delaunay/marching.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/kd_tree.h"
#include "libtensor/geometry/mesh/parts.h"

static const double LEAST_OPACITY = 0.05, MERGED = 1e-6, DEVIATIONS = 3, LEAST_PART = 0.01;

enum { BISECTIONS = 8, EACH = 9, AROUND = 8 };

/* Points of a tetrahedralisation: of each Gaussian its centre and the corners of its box, then eight around them all,
 * where nothing is */
typedef struct {
    double (*at)[3];
    int64_t n;                      /* without those around */
} points;

/* To the nearest of places a micrometre apart, of which each is one point */
static double rounded(double x)
{
    return MERGED * rint(x / MERGED);
}

static void put_gaussian(points *p, const lt_gaussian *g)
{
    for (int i = 0; i < EACH; i++, p->n++) {
        const double s[3] = { i & 1 ? DEVIATIONS : -DEVIATIONS, i & 2 ? DEVIATIONS : -DEVIATIONS,
                              i & 4 ? DEVIATIONS : -DEVIATIONS };
        double x[3] = { 0 };

        if (i < EACH - 1)
            lt_mat3_mulvec(g->axes, s, x);
        for (int k = 0; k < 3; k++)
            p->at[p->n][k] = rounded(g->centre[k] + x[k]);
    }
}

/* The corners of a box with half of its extents around it */
static void put_around(points *p)
{
    double lo[3], hi[3];

    for (int k = 0; k < 3; k++) {
        lo[k] = INFINITY, hi[k] = -INFINITY;
        for (int64_t i = 0; i < p->n; i++) {
            lo[k] = fmin(lo[k], p->at[i][k]);
            hi[k] = fmax(hi[k], p->at[i][k]);
        }
    }
    for (int i = 0; i < AROUND; i++)
        for (int k = 0; k < 3; k++) {
            const double beyond = 0.5 * (hi[k] - lo[k]) + MERGED;

            p->at[p->n + i][k] = i >> k & 1 ? hi[k] + beyond : lo[k] - beyond;
        }
}

static lt_status make_points(lt_arena *arena, int64_t n, const lt_gaussian *g, points *out)
{
    *out = (points){ .at = lt_arena_array(arena, (size_t)n * EACH + AROUND, sizeof(*out->at)) };
    if (!out->at)
        return lt_error(LT_ENOMEM, "no memory for the points of %lld Gaussians", (long long)n);
    for (int64_t i = 0; i < n; i++)
        if (g[i].opacity >= LEAST_OPACITY)
            put_gaussian(out, &g[i]);
    if (!out->n)
        return lt_error(LT_EINVAL, "opacity mesh: none of %lld Gaussians is as opaque as %g", (long long)n,
                        LEAST_OPACITY);
    put_around(out);
    return LT_OK;
}

/* ---- where the field crosses an edge ---------------------------------------------------------------------------- */

typedef struct {
    const lt_opacity_field *field;
    lt_opacity_rule rule;
    double iso;
} level;

static void set_middles(int64_t n, double (*end)[2][3], double (*middle)[3])
{
    for (int64_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            middle[i][k] = 0.5 * (end[i][0][k] + end[i][1][k]);
}

/* Halve the way from what is inside to what is outside. */
static lt_status bisect(const level *l, const points *p, const lt_level_surface *s, double (*end)[2][3],
                        double (*middle)[3], double *value)
{
    const int64_t n = s->n_vertices;

    for (int64_t i = 0; i < n; i++)
        for (int side = 0; side < 2; side++)
            memcpy(end[i][side], p->at[s->edge[i][side]], sizeof(end[i][side]));
    for (int step = 0; step < BISECTIONS; step++) {
        lt_status st;

        set_middles(n, end, middle);
        st = lt_opacity_at(l->field, l->rule, n, (const double (*)[3])middle, value);
        if (st)
            return st;
        for (int64_t i = 0; i < n; i++)
            memcpy(end[i][value[i] > l->iso ? 0 : 1], middle[i], sizeof(middle[i]));
    }
    set_middles(n, end, middle);
    return LT_OK;
}

static lt_status find_crossings(const level *l, const points *p, const lt_level_surface *s, lt_arena *arena,
                                float (*vertex)[3])
{
    const size_t n = (size_t)s->n_vertices;
    double (*end)[2][3] = lt_arena_array(arena, n, sizeof(*end));
    double (*middle)[3] = lt_arena_array(arena, n, sizeof(*middle));
    double *value = lt_arena_array(arena, n, sizeof(*value));
    lt_status st;

    if (!end || !middle || !value)
        return lt_error(LT_ENOMEM, "no memory for a surface of %lld vertices", (long long)n);
    st = bisect(l, p, s, end, middle, value);
    for (size_t i = 0; i < n && !st; i++)
        for (int k = 0; k < 3; k++)
            vertex[i][k] = (float)middle[i][k];
    return st;
}

/* ---- all of it -------------------------------------------------------------------------------------------------- */

static lt_status make_surface(const level *l, const points *p, lt_arena *scratch, lt_level_surface *out)
{
    double *value = lt_arena_array(scratch, (size_t)p->n + AROUND, sizeof(*value));     /* 0 around */
    lt_tetrahedra t;
    lt_status st = value ? LT_OK : lt_error(LT_ENOMEM, "no memory for a field at %lld points", (long long)p->n);

    if (!st)
        st = lt_delaunay(scratch, p->n + AROUND, (const double (*)[3])p->at, &t);
    if (!st)
        st = lt_opacity_at(l->field, l->rule, p->n, (const double (*)[3])p->at, value);
    if (!st)
        st = lt_marching_tetrahedra(scratch, t.n, (const int32_t (*)[4])t.tet, value, l->iso, out);
    if (!st && (out->n_faces < 1 || out->n_faces > INT32_MAX))
        st = lt_error(LT_EINVAL, "opacity mesh: no place is as opaque as %g by the rule %s", l->iso,
                      lt_opacity_rule_name(l->rule));
    return st;
}

static lt_status color_vertices(lt_arena *arena, int64_t n, const lt_gaussian *g, const float (*color)[3], lt_mesh *m)
{
    double (*centre)[3] = lt_alloc((size_t)n * sizeof(*centre));
    lt_kd_tree tree = { 0 };
    lt_status st;

    m->color = lt_arena_array(arena, (size_t)m->n_vertices, sizeof(*m->color));
    if (!centre || !m->color) {
        lt_release(centre);
        return lt_error(LT_ENOMEM, "no memory for the colours of %d vertices", m->n_vertices);
    }
    for (int64_t i = 0; i < n; i++)                     /* what is hardly seen colours nothing */
        for (int k = 0; k < 3; k++)
            centre[i][k] = g[i].opacity >= LEAST_OPACITY ? g[i].centre[k] : (double)NAN;
    st = lt_kd_tree_new((int)n, centre[0], &tree);
    for (int i = 0; i < m->n_vertices && !st; i++) {
        const double p[3] = { (double)m->vertex[i][0], (double)m->vertex[i][1], (double)m->vertex[i][2] };
        lt_kd_neighbour nearest;

        if (lt_kd_tree_nearest(&tree, p, 1, &nearest))
            memcpy(m->color[i], color[nearest.index], sizeof(m->color[i]));
    }
    lt_kd_tree_free(&tree);
    lt_release(centre);
    return st;
}

static lt_status extract(lt_arena *arena, lt_arena *scratch, const level *l, const points *p, lt_mesh *out)
{
    lt_level_surface s;
    lt_mesh all = { 0 };
    lt_status st = make_surface(l, p, scratch, &s);

    if (st)
        return st;
    all = (lt_mesh){ .n_vertices = (int)s.n_vertices, .n_faces = (int)s.n_faces, .face = s.face,
                     .vertex = lt_arena_array(scratch, (size_t)s.n_vertices, sizeof(*all.vertex)) };
    if (!all.vertex)
        return lt_error(LT_ENOMEM, "no memory for a surface of %lld vertices", (long long)s.n_vertices);
    st = find_crossings(l, p, &s, scratch, all.vertex);
    return st ? st : lt_mesh_without_small_parts(arena, &all, LEAST_PART, out);
}

lt_status lt_opacity_mesh(lt_arena *arena, int64_t n, const lt_gaussian *g, const float (*color)[3],
                          lt_opacity_rule rule, double iso, lt_mesh *out)
{
    level l = { .rule = rule, .iso = iso };
    lt_opacity_field *field;
    lt_arena *scratch;
    points p;
    lt_mesh m;
    lt_status st;

    if (!(iso > 0 && iso < 1))
        return lt_error(LT_EINVAL, "opacity mesh: iso is %g, want a number between 0 and 1", iso);
    scratch = lt_arena_new();
    st = scratch ? lt_opacity_field_new(scratch, n, g, &field) : lt_error(LT_ENOMEM, "no memory for a mesh");
    if (!st)
        st = make_points(scratch, n, g, &p);
    if (!st) {
        l.field = field;
        st = extract(arena, scratch, &l, &p, &m);
    }
    if (!st && color)
        st = color_vertices(arena, n, g, color, &m);
    if (!st)
        *out = m;
    lt_arena_free(scratch);
    return st;
}
