/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Near the surface every triangle writes its distance into the cells around it, and a row of cells knows
 * from the faces that it has crossed whether it is inside; both part by part, because the distance to a face
 * inside another part says nothing. Farther away a coarse grid of distances is interpolated.
 */
#include "synth/grasp/sdf.h"

#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mesh/surface.h"

#include <math.h>
#include <string.h>

enum { COARSE = 4, MAX_PARTS = 32 };

#define STEP 2e-3
#define MARGIN 24e-3
#define BAND 6e-3
#define MAX_SIZE 0.5

typedef struct {
    const lt_mesh *mesh;
    synth_sdf *grid;
    float *value;
    int n_parts;
    const uint8_t *part;            /* of each face */
    lt_mesh_index *index;
    float *coarse;
    int nc[3];                      /* reaches past the fine grid */
    float *d2;                      /* as large as the fine grid: squared distance to one part */
    int8_t *turn;                   /* how the winding number changes at each cell along x */
} job;

/* ---- parts ---------------------------------------------------------------------------------------- */

static int find_root(int *parent, int i)
{
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

static void connect(const lt_mesh *m, int *root)
{
    for (int i = 0; i < m->n_vertices; i++)
        root[i] = i;
    for (int f = 0; f < m->n_faces; f++)
        for (int k = 1; k < 3; k++) {
            const int a = find_root(root, m->face[f][0]), b = find_root(root, m->face[f][k]);
            root[a > b ? a : b] = a > b ? b : a;
        }
}

/* Numbers the connected parts; part (n_faces). */
static lt_status number_parts(lt_arena *arena, const lt_mesh *m, uint8_t *part, int *n_parts)
{
    int *root = lt_arena_array(arena, (size_t)m->n_vertices, sizeof(*root)), known[MAX_PARTS], n = 0;

    if (!root)
        return lt_error(LT_ENOMEM, "no memory for a distance field");
    connect(m, root);
    for (int f = 0; f < m->n_faces; f++) {
        const int r = find_root(root, m->face[f][0]);
        int i = 0;
        while (i < n && known[i] != r)
            i++;
        if (i == MAX_PARTS)
            return lt_error(LT_EINVAL, "distance field: the mesh has more than %d parts", MAX_PARTS);
        if (i == n)
            known[n++] = r;
        part[f] = (uint8_t)i;
    }
    *n_parts = n;
    return LT_OK;
}

/* ---- near: triangles into a slab of cells ----------------------------------------------------------- */

/* A layer of cells with the same z; the job's memory for it. */
typedef struct {
    const synth_sdf *grid;
    double z;
    float *d2;
    int8_t *turn;
} slab;

static int first_cell(const synth_sdf *g, int k, double x)
{
    return (int)fmax(0, ceil((x - g->origin[k]) / g->step));
}

static int last_cell(const synth_sdf *g, int k, double x)
{
    return (int)fmin(g->n[k] - 1, floor((x - g->origin[k]) / g->step));
}

static void write_distance(slab *s, double t[3][3], const double lo[3], const double hi[3])
{
    const synth_sdf *g = s->grid;
    const int i1 = last_cell(g, 0, hi[0] + BAND), j1 = last_cell(g, 1, hi[1] + BAND);
    double q[3];

    for (int j = first_cell(g, 1, lo[1] - BAND); j <= j1; j++)
        for (int i = first_cell(g, 0, lo[0] - BAND); i <= i1; i++) {
            const double p[3] = { g->origin[0] + i * g->step, g->origin[1] + j * g->step, s->z };
            float *best = &s->d2[(size_t)j * g->n[0] + i];
            double d2 = 0;
            lt_closest_on_triangle(p, t[0], t[1], t[2], q);
            for (int k = 0; k < 3; k++)
                d2 += (p[k] - q[k]) * (p[k] - q[k]);
            if (d2 < *best)
                *best = (float)d2;
        }
}

/* Twice the area of (a, b, p) in the yz plane. Both faces at an edge ask with its ends in the same order and
 * get the same bits, so no row slips through between them. */
static double side_of(const lt_mesh *m, int ia, int ib, double y, double z)
{
    const bool swap = ia > ib;
    const float *a = m->vertex[swap ? ib : ia], *b = m->vertex[swap ? ia : ib];
    const double d = ((double)b[1] - a[1]) * (z - a[2]) - ((double)b[2] - a[2]) * (y - a[1]);

    return swap ? -d : d;
}

/* Where rows pierce the face the winding number changes: seen along +x, one more behind a face that looks to
 * -x. Rows are shifted by a hair so that they never meet a vertex. */
static void write_crossings(slab *s, const lt_mesh *m, const int32_t *face, double t[3][3], const double lo[3],
                            const double hi[3])
{
    const synth_sdf *g = s->grid;
    const int j1 = last_cell(g, 1, hi[1] + 1e-6);
    const double z = s->z + 1.7320508e-8;

    for (int j = first_cell(g, 1, lo[1] - 1e-6); j <= j1; j++) {
        const double y = g->origin[1] + j * g->step + 1.4142136e-8;
        double w[3], sum = 0, x = 0;
        int i;
        for (int k = 0; k < 3; k++) {
            w[k] = side_of(m, face[(k + 1) % 3], face[(k + 2) % 3], y, z);
            sum += w[k];
            x += w[k] * t[k][0];
        }
        if (!((w[0] > 0 && w[1] > 0 && w[2] > 0) || (w[0] < 0 && w[1] < 0 && w[2] < 0)))
            continue;
        i = first_cell(g, 0, x / sum);
        if (i < g->n[0])
            s->turn[(size_t)j * g->n[0] + i] += sum < 0 ? 1 : -1;
    }
}

static void write_part(const job *jb, slab *s, int part)
{
    const lt_mesh *m = jb->mesh;

    for (int f = 0; f < m->n_faces; f++) {
        double t[3][3], lo[3], hi[3];
        if (jb->part[f] != part)
            continue;
        for (int k = 0; k < 3; k++) {
            for (int c = 0; c < 3; c++)
                t[c][k] = m->vertex[m->face[f][c]][k];
            lo[k] = fmin(t[0][k], fmin(t[1][k], t[2][k]));
            hi[k] = fmax(t[0][k], fmax(t[1][k], t[2][k]));
        }
        if (s->z < lo[2] - BAND || s->z > hi[2] + BAND)
            continue;
        write_distance(s, t, lo, hi);
        if (s->z >= lo[2] - 1e-6 && s->z <= hi[2] + 1e-6)
            write_crossings(s, m, m->face[f], t, lo, hi);
    }
}

/* The nearer to the inside of what the parts so far say and what this one says. */
static void merge_part(const slab *s, float *value)
{
    const synth_sdf *g = s->grid;

    for (int j = 0; j < g->n[1]; j++) {
        int winding = 0;
        for (int i = 0; i < g->n[0]; i++) {
            const size_t c = (size_t)j * g->n[0] + i;
            const float d = sqrtf(s->d2[c]);
            winding += s->turn[c];
            value[c] = fminf(value[c], winding > 0 ? -d : d);
        }
    }
}

/* ---- far ------------------------------------------------------------------------------------------ */

static void coarse_slab(void *ctx, int64_t k)
{
    job *jb = ctx;
    const synth_sdf *g = jb->grid;
    float *out = &jb->coarse[(size_t)k * jb->nc[1] * jb->nc[0]];

    for (int j = 0; j < jb->nc[1]; j++)
        for (int i = 0; i < jb->nc[0]; i++) {
            const double s = COARSE * g->step;
            const double p[3] = { g->origin[0] + i * s, g->origin[1] + j * s, g->origin[2] + (double)k * s };
            *out++ = (float)lt_mesh_closest(jb->index, p).distance;
        }
}

static double interpolate(const job *jb, int i, int j, int k)
{
    const int at[3] = { i, j, k };
    int c[3];
    double f[3], sum = 0;

    for (int a = 0; a < 3; a++) {
        c[a] = at[a] / COARSE;
        f[a] = (double)(at[a] % COARSE) / COARSE;
    }
    for (int n = 0; n < 8; n++) {
        const int x = n & 1, y = n >> 1 & 1, z = n >> 2;
        const double d = jb->coarse[((size_t)(c[2] + z) * jb->nc[1] + c[1] + y) * jb->nc[0] + c[0] + x];
        sum += d * (x ? f[0] : 1 - f[0]) * (y ? f[1] : 1 - f[1]) * (z ? f[2] : 1 - f[2]);
    }
    return sum;
}

static void fine_slab(void *ctx, int64_t k)
{
    job *jb = ctx;
    const synth_sdf *g = jb->grid;
    const size_t n = (size_t)g->n[0] * g->n[1];
    float *value = &jb->value[(size_t)k * n];
    slab s = { g, g->origin[2] + (double)k * g->step, &jb->d2[(size_t)k * n], &jb->turn[(size_t)k * n] };

    for (size_t i = 0; i < n; i++)
        value[i] = INFINITY;
    for (int part = 0; part < jb->n_parts; part++) {
        for (size_t i = 0; i < n; i++)
            s.d2[i] = (float)(BAND * BAND);
        memset(s.turn, 0, n);
        write_part(jb, &s, part);
        merge_part(&s, value);
    }
    for (int j = 0; j < g->n[1]; j++)
        for (int i = 0; i < g->n[0]; i++) {
            float *v = &value[(size_t)j * g->n[0] + i];
            if (fabs(*v) >= BAND * (1 - 1e-6))
                *v = copysignf((float)fmax(BAND, interpolate(jb, i, j, (int)k)), *v);
        }
}

static lt_status size_grid(const lt_mesh *m, synth_sdf *out, int nc[3])
{
    if (m->n_vertices < 1 || m->n_faces < 1)
        return lt_error(LT_EINVAL, "distance field: the mesh is empty");
    *out = (synth_sdf){ .step = STEP };
    for (int k = 0; k < 3; k++) {
        double lo = INFINITY, hi = -INFINITY;
        for (int i = 0; i < m->n_vertices; i++) {
            lo = fmin(lo, m->vertex[i][k]);
            hi = fmax(hi, m->vertex[i][k]);
        }
        if (!(hi - lo < MAX_SIZE))
            return lt_error(LT_EINVAL, "distance field: the mesh is %g m wide, at most %g", hi - lo, MAX_SIZE);
        out->origin[k] = lo - MARGIN;
        out->n[k] = (int)ceil((hi - lo + 2 * MARGIN) / STEP) + 1;
        nc[k] = (out->n[k] - 1) / COARSE + 2;
    }
    return LT_OK;
}

static lt_status make_memory(lt_arena *arena, lt_arena *scratch, job *jb)
{
    const synth_sdf *g = jb->grid;
    const size_t n = (size_t)g->n[0] * (size_t)g->n[1] * (size_t)g->n[2];
    uint8_t *part = lt_arena_array(scratch, (size_t)jb->mesh->n_faces, sizeof(*part));

    jb->value = lt_arena_array(arena, n, sizeof(*jb->value));
    jb->d2 = lt_arena_array(scratch, n, sizeof(*jb->d2));
    jb->turn = lt_arena_array(scratch, n, sizeof(*jb->turn));
    jb->coarse = lt_arena_array(scratch, (size_t)jb->nc[0] * (size_t)jb->nc[1] * (size_t)jb->nc[2],
                                sizeof(*jb->coarse));
    if (!part || !jb->value || !jb->d2 || !jb->turn || !jb->coarse)
        return lt_error(LT_ENOMEM, "no memory for a distance field");
    jb->part = part;
    return number_parts(scratch, jb->mesh, part, &jb->n_parts);
}

lt_status synth_sdf_new(lt_arena *arena, const lt_mesh *mesh, synth_sdf *out)
{
    synth_sdf grid;
    job jb = { .mesh = mesh, .grid = &grid };
    lt_arena *scratch = lt_arena_new();
    lt_status st;

    if (!scratch)
        return lt_error(LT_ENOMEM, "no memory for a distance field");
    st = size_grid(mesh, &grid, jb.nc);
    if (!st)
        st = lt_mesh_index_new(scratch, mesh, &jb.index);
    if (!st)
        st = make_memory(arena, scratch, &jb);
    if (st)
        goto done;
    lt_parallel_for(jb.nc[2], coarse_slab, &jb);
    lt_parallel_for(grid.n[2], fine_slab, &jb);
    grid.value = jb.value;
    *out = grid;
done:
    lt_arena_free(scratch);
    return st;
}

/* Value and, unless NULL, gradient in the cell whose lowest corner is c, at f of its edges. */
static double in_cell(const synth_sdf *s, const float *c, const double f[3], double gradient[3])
{
    const size_t row = (size_t)s->n[0], layer = row * (size_t)s->n[1];
    const double v000 = c[0], v100 = c[1], v010 = c[row], v110 = c[row + 1];
    const double v001 = c[layer], v101 = c[layer + 1], v011 = c[layer + row], v111 = c[layer + row + 1];
    const double x00 = v000 + f[0] * (v100 - v000), x10 = v010 + f[0] * (v110 - v010);
    const double x01 = v001 + f[0] * (v101 - v001), x11 = v011 + f[0] * (v111 - v011);
    const double y0 = x00 + f[1] * (x10 - x00), y1 = x01 + f[1] * (x11 - x01);

    if (gradient) {
        const double g0 = v100 - v000 + f[1] * (v110 - v010 - v100 + v000);
        const double g1 = v101 - v001 + f[1] * (v111 - v011 - v101 + v001);
        gradient[0] = (g0 + f[2] * (g1 - g0)) / s->step;
        gradient[1] = (x10 - x00 + f[2] * (x11 - x01 - x10 + x00)) / s->step;
        gradient[2] = (y1 - y0) / s->step;
    }
    return y0 + f[2] * (y1 - y0);
}

double synth_sdf_at(const synth_sdf *sdf, const double p[3], double gradient[3])
{
    double f[3], way[3], out = 0, d;
    size_t i[3];

    for (int k = 0; k < 3; k++) {
        const double at = (p[k] - sdf->origin[k]) / sdf->step, in = fmax(0, fmin(sdf->n[k] - 1, at));
        i[k] = (size_t)fmin(in, sdf->n[k] - 2);
        f[k] = in - (double)i[k];
        way[k] = sdf->step * (at - in);
        out += way[k] * way[k];
    }
    d = in_cell(sdf, &sdf->value[(i[2] * (size_t)sdf->n[1] + i[1]) * (size_t)sdf->n[0] + i[0]], f, gradient);
    if (out > 0) {
        out = sqrt(out);
        for (int k = 0; k < 3 && gradient; k++)
            gradient[k] = way[k] / out;
    }
    return d + out;
}

lt_status synth_sdf_mirror(lt_arena *arena, const synth_sdf *sdf, synth_sdf *out)
{
    const int64_t nx = sdf->n[0], rows = (int64_t)sdf->n[1] * sdf->n[2];
    float *value = lt_arena_array(arena, (size_t)(nx * rows), sizeof(*value));

    if (!value)
        return lt_error(LT_ENOMEM, "synth: no memory for a distance field");
    for (int64_t r = 0; r < rows; r++)
        for (int64_t i = 0; i < nx; i++)
            value[r * nx + i] = sdf->value[r * nx + nx - 1 - i];
    *out = *sdf;
    out->origin[0] = -(sdf->origin[0] + sdf->step * (double)(nx - 1));
    out->value = value;
    return LT_OK;
}
