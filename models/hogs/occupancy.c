/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hogs/occupancy.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"

#include <math.h>
#include <string.h>

enum { SIDE = OCCUPANCY_SIDE, PLANE = SIDE * SIDE };

static const double PADDING = 0.05, SHELL = 0.5, SEEN = 0.5, DEVIATIONS = 4;

/* ---- how much opacity there is ---------------------------------------------------------------------------- */

typedef struct {
    double centre[3], inverse[9];   /* inverse: of the axes, so that m = |inverse (x - centre)|^2 */
    double reach[3];                /* how far from the centre it counts along x, y, z */
    double opacity;
} blob;

static bool blob_of(const occupancy_gaussians *g, int64_t i, blob *out)
{
    const lt_real *M = g->axes[i];
    const double a = M[0], b = M[1], c = M[2], d = M[3], e = M[4], f = M[5], p = M[6], q = M[7], r = M[8];
    const double det = a * (e * r - f * q) - b * (d * r - f * p) + c * (d * q - e * p);
    const double inverse[9] = { e * r - f * q, c * q - b * r, b * f - c * e, f * p - d * r, a * r - c * p,
                                c * d - a * f, d * q - e * p, b * p - a * q, a * e - b * d };

    for (int k = 0; k < 9; k++)
        out->inverse[k] = inverse[k] / det;
    for (int k = 0; k < 3; k++) {
        const lt_real *row = M + 3 * k;

        out->centre[k] = g->centre[i][k];
        out->reach[k] = DEVIATIONS * sqrt((double)row[0] * row[0] + (double)row[1] * row[1] + (double)row[2] * row[2]);
    }
    out->opacity = g->opacity[i];
    return isfinite(1 / det) && isfinite(out->centre[0] + out->centre[1] + out->centre[2] + out->reach[0]
                                         + out->reach[1] + out->reach[2] + out->opacity);
}

typedef struct {
    const occupancy *grid;
    const blob *list;
    int64_t n;
    double *sum;
} density_job;

static double middle(const occupancy *o, int axis, int64_t cell)
{
    return (double)o->lo[axis] + ((double)cell + 0.5) / (double)o->per_metre[axis];
}

/* Cells from *from to *to along an axis have their middle within reach. */
static void cells_within(const occupancy *o, const blob *b, int axis, int64_t *from, int64_t *to)
{
    const double at = (b->centre[axis] - (double)o->lo[axis]) * (double)o->per_metre[axis] - 0.5;
    const double reach = b->reach[axis] * (double)o->per_metre[axis];

    *from = (int64_t)fmax(0, fmin(SIDE, ceil(at - reach)));
    *to = (int64_t)fmax(0, fmin(SIDE, floor(at + reach) + 1));
}

static double squared_distance(const blob *b, double x, double y, double z)
{
    const double d[3] = { x - b->centre[0], y - b->centre[1], z - b->centre[2] };
    double m = 0;

    for (int k = 0; k < 3; k++) {
        const double *row = b->inverse + 3 * k, along = row[0] * d[0] + row[1] * d[1] + row[2] * d[2];

        m += along * along;
    }
    return m;
}

static void add_to_plane(const density_job *job, const blob *b, int64_t z)
{
    int64_t x0, x1, y0, y1;

    cells_within(job->grid, b, 0, &x0, &x1);
    cells_within(job->grid, b, 1, &y0, &y1);
    for (int64_t y = y0; y < y1; y++)
        for (int64_t x = x0; x < x1; x++) {
            const double m = squared_distance(b, middle(job->grid, 0, x), middle(job->grid, 1, y),
                                              middle(job->grid, 2, z));

            if (m <= DEVIATIONS * DEVIATIONS)
                job->sum[z * PLANE + y * SIDE + x] += b->opacity * exp(-m / 2);
        }
}

/* A task owns a plane and adds the Gaussians in their order. */
static void fill_plane(void *ctx, int64_t z)
{
    const density_job *job = ctx;

    for (int64_t i = 0; i < job->n; i++) {
        int64_t from, to;

        cells_within(job->grid, &job->list[i], 2, &from, &to);
        if (z >= from && z < to)
            add_to_plane(job, &job->list[i], z);
    }
}

/* ---- what is inside ---------------------------------------------------------------------------------------- */

typedef struct {
    uint8_t *inside;                /* 1 until a cell is reached from outside */
    const double *sum;
    int32_t *stack;                 /* n cells whose neighbours are still to be reached */
    int64_t n;
} flood;

static void reach(flood *f, int64_t cell)
{
    if (!f->inside[cell] || f->sum[cell] > SHELL)
        return;
    f->inside[cell] = 0;
    f->stack[f->n++] = (int32_t)cell;
}

/* From the border on, over sides of cells, as far as there is no shell */
static void reach_all(flood *f)
{
    static const int step[3] = { 1, SIDE, PLANE };

    for (int64_t i = 0; i < OCCUPANCY_CELLS; i++) {
        const int64_t at[3] = { i % SIDE, i / SIDE % SIDE, i / PLANE };

        for (int k = 0; k < 3; k++)
            if (at[k] == 0 || at[k] == SIDE - 1)
                reach(f, i);
    }
    while (f->n) {
        const int64_t cell = f->stack[--f->n], at[3] = { cell % SIDE, cell / SIDE % SIDE, cell / PLANE };

        for (int k = 0; k < 3; k++) {
            if (at[k] > 0)
                reach(f, cell - step[k]);
            if (at[k] < SIDE - 1)
                reach(f, cell + step[k]);
        }
    }
}

static lt_status check_box(const double lo[3], const double hi[3])
{
    for (int k = 0; k < 3; k++)
        if (!(hi[k] > lo[k]) || !isfinite(hi[k] - lo[k]))
            return lt_error(LT_EINVAL, "occupancy grid: the box goes from %g to %g along axis %d, want an extent",
                            lo[k], hi[k], k);
    return LT_OK;
}

static void place_grid(occupancy *o, const double lo[3], const double hi[3])
{
    for (int k = 0; k < 3; k++) {
        const double extent = hi[k] - lo[k];

        o->lo[k] = (lt_real)(lo[k] - PADDING * extent);
        o->per_metre[k] = (lt_real)(SIDE / ((1 + 2 * PADDING) * extent));
    }
}

lt_status occupancy_build(const occupancy_gaussians *g, const double lo[3], const double hi[3], occupancy *out)
{
    blob *list = lt_alloc((size_t)lt_max_i64(1, g->n) * sizeof(*list));
    double *sum = lt_alloc(OCCUPANCY_CELLS * sizeof(*sum));
    int32_t *stack = lt_alloc(OCCUPANCY_CELLS * sizeof(*stack));
    density_job job = { .grid = out, .list = list, .sum = sum };
    lt_status st = list && sum && stack ? LT_OK : lt_error(LT_ENOMEM, "no memory for an object's occupancy grid");

    if (!st)
        st = check_box(lo, hi);
    if (st)
        goto done;
    for (int64_t i = 0; i < g->n; i++)
        job.n += blob_of(g, i, &list[job.n]);
    place_grid(out, lo, hi);
    memset(sum, 0, OCCUPANCY_CELLS * sizeof(*sum));
    lt_parallel_for(SIDE, fill_plane, &job);
    memset(out->inside, 1, sizeof(out->inside));
    reach_all(&(flood){ .inside = out->inside, .sum = sum, .stack = stack });
done:
    lt_release(list);
    lt_release(sum);
    lt_release(stack);
    return st;
}

/* ---- asking it --------------------------------------------------------------------------------------------- */

/* The cell of a place; false outside of the grid */
static bool cell_of(const occupancy *o, const lt_real place[3], int64_t cell[3])
{
    for (int k = 0; k < 3; k++) {
        const lt_real at = (place[k] - o->lo[k]) * o->per_metre[k];

        if (!(at >= 0 && at < SIDE))
            return false;
        cell[k] = (int64_t)at;
    }
    return true;
}

bool occupancy_inside(const occupancy *o, const lt_real place[3])
{
    int64_t cell[3];

    return cell_of(o, place, cell) && o->inside[(cell[2] * SIDE + cell[1]) * SIDE + cell[0]];
}

/* Whether of a cell and those around it some are inside and some are not; outside of the grid none is. */
static bool at_border(const occupancy *o, const int64_t cell[3])
{
    int in = 0, all = 27;

    for (int i = 0; i < all; i++) {
        const int64_t x = cell[0] + i % 3 - 1, y = cell[1] + i / 3 % 3 - 1, z = cell[2] + i / 9 - 1;

        if (x >= 0 && x < SIDE && y >= 0 && y < SIDE && z >= 0 && z < SIDE)
            in += o->inside[(z * SIDE + y) * SIDE + x];
    }
    return in > 0 && in < all;
}

int64_t occupancy_surface(const occupancy *o, const occupancy_gaussians *g, int32_t *index)
{
    int64_t n = 0, cell[3];

    for (int64_t i = 0; i < g->n; i++)
        if (g->opacity[i] > SEEN && cell_of(o, g->centre[i], cell) && at_border(o, cell))
            index[n++] = (int32_t)i;
    return n;
}
