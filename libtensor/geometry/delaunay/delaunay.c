/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One point after the other: the cells whose spheres it lies in go, and it is joined to what was around them. Outside
 * of the hull there are cells as well, with a corner that is nowhere: the half-space beyond a facet is their sphere.
 */
#include "libtensor/geometry/delaunay/internal.h"

#include <math.h>
#include <string.h>

enum { NOWHERE = -1, NONE = -1 };

/* Right-handed, as if NOWHERE were far outside; near[i] is the cell beyond the facet that v[i] is not in. */
typedef struct {
    int32_t v[4], near[4];
} cell;

/* A facet of a new cell that waits for the other one at its edge; both have the new point in them. */
typedef struct {
    uint64_t edge;
    int32_t cell, facet, stamp;
} waiting;

typedef struct {
    const int32_t (*grid)[3];
    cell *cell;
    int32_t *seen;                  /* of a cell: the insertion that last looked at it, below 0 if it stays */
    int64_t n, room;
    int32_t *spare, n_spare;        /* cells that went */
    int32_t *gone, n_gone, room_gone;       /* of this insertion */
    waiting *table;
    int64_t table_size;
    int32_t now, last;              /* insertions so far; a cell to begin the next walk at */
    bool no_memory;
} builder;

/* ---- growing ------------------------------------------------------------------------------------------------ */

static bool grow(void **array, int64_t from, int64_t to, size_t size)
{
    void *more = lt_alloc((size_t)to * size);

    if (!more)
        return false;
    if (*array)
        memcpy(more, *array, (size_t)from * size);
    lt_release(*array);
    *array = more;
    return true;
}

static int32_t new_cell(builder *b)
{
    if (b->n_spare)
        return b->spare[--b->n_spare];
    if (b->n == b->room) {
        const int64_t more = b->room ? 2 * b->room : 1024;

        if (more > INT32_MAX || !grow((void **)&b->cell, b->n, more, sizeof(*b->cell))
            || !grow((void **)&b->seen, b->n, more, sizeof(*b->seen))
            || !grow((void **)&b->spare, b->n_spare, more, sizeof(*b->spare))) {
            b->no_memory = true;
            return NONE;
        }
        b->room = more;
    }
    b->seen[b->n] = 0;
    return (int32_t)b->n++;
}

static void remember_gone(builder *b, int32_t c)
{
    if (b->n_gone == b->room_gone) {
        const int32_t more = b->room_gone ? 2 * b->room_gone : 256;

        if (!grow((void **)&b->gone, b->n_gone, more, sizeof(*b->gone))) {
            b->no_memory = true;
            return;
        }
        b->room_gone = more;
    }
    b->gone[b->n_gone++] = c;
}

/* ---- where a point is --------------------------------------------------------------------------------------- */

static int nowhere_in(const cell *c)
{
    for (int i = 0; i < 4; i++)
        if (c->v[i] == NOWHERE)
            return i;
    return NONE;
}

/* On which side of the facet without v[i] the place is: 1 where v[i] is */
static int side_of(const builder *b, const cell *c, int i, grid_place p)
{
    grid_place x[4];

    for (int k = 0; k < 4; k++)
        x[k] = k == i ? p : b->grid[c->v[k]];
    return delaunay_orient(x[0], x[1], x[2], x[3]);
}

/* Whether the place lies in the cell's sphere. In the plane of a facet of the hull that is the sphere of the cell
 * inside. */
static bool conflicts(const builder *b, int32_t at, grid_place p)
{
    const cell *c = &b->cell[at];
    const int i = nowhere_in(c);
    const int side = i == NONE ? 0 : side_of(b, c, i, p);

    if (side)
        return side > 0;
    if (i != NONE)
        c = &b->cell[c->near[i]];
    return delaunay_insphere(b->grid[c->v[0]], b->grid[c->v[1]], b->grid[c->v[2]], b->grid[c->v[3]], p) > 0;
}

/* A facet that the place is beyond; NONE: it is in the cell, or that is outside of the hull */
static int way_out(const builder *b, const cell *c, int32_t from, grid_place p)
{
    if (nowhere_in(c) != NONE)
        return NONE;
    for (int i = 0; i < 4; i++)
        if (c->near[i] != from && side_of(b, c, i, p) < 0)
            return i;
    return NONE;
}

/* Cell by cell towards the place: the spheres' order forbids circles. */
static int32_t walk(const builder *b, grid_place p)
{
    int32_t at = b->last, from = NONE;
    int out;

    while ((out = way_out(b, &b->cell[at], from, p)) != NONE) {
        from = at;
        at = b->cell[at].near[out];
    }
    return at;
}

/* ---- one point ---------------------------------------------------------------------------------------------- */

/* All cells whose spheres the place lies in; they hang together. */
static void clear_around(builder *b, int32_t first, grid_place p)
{
    b->n_gone = 0;
    b->seen[first] = b->now;
    remember_gone(b, first);
    for (int32_t k = 0; k < b->n_gone && !b->no_memory; k++)
        for (int i = 0; i < 4; i++) {
            const int32_t next = b->cell[b->gone[k]].near[i];

            if (b->seen[next] == b->now || b->seen[next] == -b->now)
                continue;
            b->seen[next] = conflicts(b, next, p) ? b->now : -b->now;
            if (b->seen[next] == b->now)
                remember_gone(b, next);
        }
}

static bool make_table(builder *b)
{
    const int64_t need = 32 * (int64_t)b->n_gone;

    if (b->table_size >= need)
        return true;
    lt_release(b->table);
    for (b->table_size = b->table_size ? b->table_size : 1024; b->table_size < need;)
        b->table_size *= 2;
    b->table = lt_alloc((size_t)b->table_size * sizeof(*b->table));
    if (!b->table) {
        b->table_size = 0;
        return false;
    }
    memset(b->table, 0, (size_t)b->table_size * sizeof(*b->table));
    return true;
}

/* The two new cells at an edge of the hole meet here. */
static void join(builder *b, int32_t at, int facet, int32_t u, int32_t v)
{
    const uint64_t lo = (uint64_t)(u < v ? u : v) + 1, hi = (uint64_t)(u < v ? v : u) + 1, edge = hi << 32 | lo;
    uint64_t slot = (edge * UINT64_C(0x9e3779b97f4a7c15)) >> 20;

    for (;; slot++) {
        waiting *w = &b->table[slot & (uint64_t)(b->table_size - 1)];

        if (w->stamp == b->now && w->edge != edge)
            continue;
        if (w->stamp != b->now) {
            *w = (waiting){ edge, at, facet, b->now };
            return;
        }
        b->cell[at].near[facet] = w->cell;
        b->cell[w->cell].near[w->facet] = at;
        return;
    }
}

/* A new cell on the facet of an old one that the hole ends at */
static void raise_on(builder *b, int32_t old, int facet, int32_t point)
{
    const int32_t beyond = b->cell[old].near[facet], at = new_cell(b);
    cell *c;
    int back = 0;

    if (at == NONE)
        return;
    c = &b->cell[at];
    memcpy(c->v, b->cell[old].v, sizeof(c->v));
    c->v[facet] = point;
    c->near[facet] = beyond;
    while (b->cell[beyond].near[back] != old)
        back++;
    b->cell[beyond].near[back] = at;
    b->seen[at] = 0;
    for (int k = 1; k < 4; k++) {                   /* the facets that the point is in, by their edges of the old one */
        const int own = (facet + k) % 4, u = (facet + k % 3 + 1) % 4, v = (facet + (k + 1) % 3 + 1) % 4;

        join(b, at, own, c->v[u], c->v[v]);
    }
    if (nowhere_in(c) == NONE)
        b->last = at;
}

/* Its number; or that of the one that was at its place before */
static int32_t insert(builder *b, int32_t point)
{
    grid_place p = b->grid[point];
    const int32_t first = walk(b, p);

    for (int i = 0; i < 4; i++) {
        const int32_t v = b->cell[first].v[i];

        if (v != NOWHERE && memcmp(b->grid[v], p, sizeof(b->grid[0])) == 0)
            return v;
    }
    b->now++;
    clear_around(b, first, p);
    if (b->no_memory || !make_table(b)) {
        b->no_memory = true;
        return point;
    }
    for (int32_t k = 0; k < b->n_gone && !b->no_memory; k++)
        for (int i = 0; i < 4; i++)
            if (b->seen[b->cell[b->gone[k]].near[i]] != b->now)
                raise_on(b, b->gone[k], i, point);
    for (int32_t k = 0; k < b->n_gone && !b->no_memory; k++)
        b->spare[b->n_spare++] = b->gone[k];
    return point;
}

/* ---- the first cell ----------------------------------------------------------------------------------------- */

static bool in_line(grid_place a, grid_place b, grid_place c)
{
    for (int k = 0; k < 3; k++) {
        const int i = k, j = (k + 1) % 3;
        const int64_t p = (int64_t)(b[i] - a[i]) * (c[j] - a[j]), q = (int64_t)(b[j] - a[j]) * (c[i] - a[i]);

        if (p != q)
            return false;
    }
    return true;
}

/* Four points in the order that span a volume; false: there are none */
static bool find_corners(const builder *b, const int32_t *order, int64_t n, int32_t corner[4])
{
    int found = 1;

    corner[0] = order[0];
    for (int64_t i = 1; i < n && found < 4; i++) {
        const grid_place p = b->grid[order[i]], x = b->grid[corner[0]];
        bool spans;

        if (found == 1)
            spans = memcmp(p, x, 3 * sizeof(*p)) != 0;
        else if (found == 2)
            spans = !in_line(x, b->grid[corner[1]], p);
        else
            spans = delaunay_orient(x, b->grid[corner[1]], b->grid[corner[2]], p) != 0;
        if (spans)
            corner[found++] = order[i];
    }
    if (found < 4)
        return false;
    if (delaunay_orient(b->grid[corner[0]], b->grid[corner[1]], b->grid[corner[2]], b->grid[corner[3]]) < 0) {
        const int32_t first = corner[0];

        corner[0] = corner[1];
        corner[1] = first;
    }
    return true;
}

/* The cell, and one beyond each of its facets: number 1 + i beyond the one without corner i, where that is nowhere and
 * two others have changed places */
static void begin(builder *b, const int32_t corner[4])
{
    for (int i = 0; i < 5; i++)
        new_cell(b);
    if (b->no_memory)
        return;
    for (int i = 0; i < 4; i++) {
        cell *out = &b->cell[1 + i];
        const int x = (i + 1) % 4, y = (i + 2) % 4;

        b->cell[0].v[i] = corner[i];
        b->cell[0].near[i] = 1 + i;
        for (int k = 0; k < 4; k++) {
            const int is = k == x ? y : k == y ? x : k;

            out->v[k] = is == i ? NOWHERE : corner[is];
            out->near[k] = is == i ? 0 : 1 + is;
        }
    }
    b->last = 0;
}

/* ---- all ---------------------------------------------------------------------------------------------------- */

static lt_status make_grid(lt_arena *arena, int64_t n, const double (*point)[3], lt_tetrahedra *out)
{
    double hi[3] = { -INFINITY, -INFINITY, -INFINITY }, longest = 0;

    for (int k = 0; k < 3; k++)
        out->lo[k] = INFINITY;
    for (int64_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) {
            if (!isfinite(point[i][k]))
                return lt_error(LT_EINVAL, "point %lld of a triangulation is not finite", (long long)i);
            out->lo[k] = fmin(out->lo[k], point[i][k]);
            hi[k] = fmax(hi[k], point[i][k]);
        }
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, hi[k] - out->lo[k]);
    out->step = longest > 0 ? longest / ((1 << LT_DELAUNAY_BITS) - 1) : 1;
    out->grid = lt_arena_array(arena, (size_t)n, sizeof(*out->grid));
    out->same = lt_arena_array(arena, (size_t)n, sizeof(*out->same));
    if (!out->grid || !out->same || !isfinite(longest))
        return isfinite(longest) ? lt_error(LT_ENOMEM, "no memory for %lld points", (long long)n)
                                 : lt_error(LT_EINVAL, "points of a triangulation are too far from each other");
    for (int64_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            out->grid[i][k] = (int32_t)lrint((point[i][k] - out->lo[k]) / out->step);
    return LT_OK;
}

/* The cells of the hull's inside, each from its lowest corner on */
static lt_status take_cells(lt_arena *arena, builder *b, lt_tetrahedra *out)
{
    int64_t n = 0;

    for (int32_t k = 0; k < b->n_spare; k++)
        b->cell[b->spare[k]].v[0] = b->cell[b->spare[k]].v[1] = NOWHERE;
    for (int64_t c = 0; c < b->n; c++)
        n += nowhere_in(&b->cell[c]) == NONE;
    out->tet = lt_arena_array(arena, (size_t)n, sizeof(*out->tet));
    if (!out->tet)
        return lt_error(LT_ENOMEM, "no memory for %lld tetrahedra", (long long)n);
    out->n = 0;
    for (int64_t c = 0; c < b->n; c++)
        if (nowhere_in(&b->cell[c]) == NONE)
            memcpy(out->tet[out->n++], b->cell[c].v, sizeof(*out->tet));
    return LT_OK;
}

static void free_builder(builder *b)
{
    lt_release(b->cell);
    lt_release(b->seen);
    lt_release(b->spare);
    lt_release(b->gone);
    lt_release(b->table);
}

static lt_status build(lt_arena *arena, int64_t n, const int32_t *order, lt_tetrahedra *out)
{
    builder b = { .grid = (const int32_t (*)[3])out->grid };
    int32_t corner[4];
    lt_status st;

    if (!find_corners(&b, order, n, corner))
        return lt_error(LT_EINVAL, "all %lld points of a triangulation are in one plane", (long long)n);
    begin(&b, corner);
    for (int64_t i = 0; i < n && !b.no_memory; i++)
        out->same[order[i]] = insert(&b, order[i]);     /* the first four are found to be there */
    st = b.no_memory ? lt_error(LT_ENOMEM, "no memory for the tetrahedra of %lld points", (long long)n)
                     : take_cells(arena, &b, out);
    free_builder(&b);
    return st;
}

lt_status lt_delaunay(lt_arena *arena, int64_t n, const double (*point)[3], lt_tetrahedra *out)
{
    int32_t *order;
    lt_status st;

    *out = (lt_tetrahedra){ .n = 0 };
    if (n < 4 || n > LT_DELAUNAY_MOST)
        return lt_error(LT_EINVAL, "a triangulation of %lld points, expected 4 to %d", (long long)n, LT_DELAUNAY_MOST);
    st = make_grid(arena, n, point, out);
    if (!st)
        st = delaunay_order(arena, n, (const int32_t (*)[3])out->grid, &order);
    return st ? st : build(arena, n, order, out);
}
