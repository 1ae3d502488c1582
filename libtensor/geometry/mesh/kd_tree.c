/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/geometry/mesh/kd_tree.h"

#include "libtensor/base/arena.h"
#include "libtensor/geometry/mat3.h"

enum { LEAF = 16 };                     /* points that are not worth halving */

static double less(double a, double b) { return a < b ? a : b; }
static double greater(double a, double b) { return a > b ? a : b; }

static bool is_finite(const double p[3])
{
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

/* Places for the boxes of n points: a full tree, whose deepest ranges are the rounded-up halves */
static size_t boxes_of(int n)
{
    size_t boxes = 1;

    for (; n > LEAF; n -= n / 2)
        boxes = 2 * boxes + 1;
    return boxes;
}

static lt_kd_box box_around(const lt_kd_point *p, int n)
{
    lt_kd_box b;

    memcpy(b.lo, p[0].at, sizeof(b.lo));
    memcpy(b.hi, p[0].at, sizeof(b.hi));
    for (int i = 1; i < n; i++)
        for (int k = 0; k < 3; k++) {
            b.lo[k] = less(b.lo[k], p[i].at[k]);
            b.hi[k] = greater(b.hi[k], p[i].at[k]);
        }
    return b;
}

static int widest_axis(const lt_kd_box *b)
{
    int widest = 0;

    for (int k = 1; k < 3; k++)
        if (b->hi[k] - b->lo[k] > b->hi[widest] - b->lo[widest])
            widest = k;
    return widest;
}

static void swap(lt_kd_point *a, lt_kd_point *b)
{
    const lt_kd_point c = *a;

    *a = *b;
    *b = c;
}

/* Order n points so that none before the middle one lies beyond it along the axis, and none behind it before it.
 *                                                                                      [Hoare 1961, "Find"] */
static void halve(lt_kd_point *p, int n, int axis)
{
    const int middle = n / 2;

    for (int lo = 0, hi = n - 1; lo < hi;) {
        const double pivot = p[middle].at[axis];
        int i = lo, j = hi;

        while (i <= j) {
            while (p[i].at[axis] < pivot)
                i++;
            while (p[j].at[axis] > pivot)
                j--;
            if (i <= j)
                swap(&p[i++], &p[j--]);
        }
        if (j < middle)
            lo = i;
        if (i > middle)
            hi = j;
    }
}

/* Points, and the place of the box around them */
typedef struct { int from, n; size_t box; } range;

static range half_of(range r, bool upper)
{
    const int half = r.n / 2;

    return upper ? (range){ r.from + half, r.n - half, 2 * r.box + 2 } : (range){ r.from, half, 2 * r.box + 1 };
}

static void grow(const lt_kd_tree *t, range r)
{
    lt_kd_point *p = t->point + r.from;
    lt_kd_box *box = &t->box[r.box];

    *box = box_around(p, r.n);
    if (r.n <= LEAF)
        return;
    halve(p, r.n, widest_axis(box));
    grow(t, half_of(r, false));
    grow(t, half_of(r, true));
}

lt_status lt_kd_tree_new(int n, const double *points, lt_kd_tree *out)
{
    lt_kd_tree t = { 0 };

    t.point = lt_alloc((size_t)n * sizeof(*t.point));
    t.box = lt_alloc(boxes_of(n) * sizeof(*t.box));
    if (!t.point || !t.box) {
        lt_kd_tree_free(&t);
        return lt_error(LT_ENOMEM, "nearest neighbours of %d points: no memory", n);
    }
    for (int i = 0; i < n; i++)
        if (is_finite(points + 3 * (size_t)i)) {
            memcpy(t.point[t.n].at, points + 3 * (size_t)i, sizeof(t.point[t.n].at));
            t.point[t.n++].index = i;
        }
    if (t.n)
        grow(&t, (range){ 0, t.n, 0 });
    *out = t;
    return LT_OK;
}

void lt_kd_tree_free(lt_kd_tree *t)
{
    lt_release(t->point);
    lt_release(t->box);
    *t = (lt_kd_tree){ 0 };
}

static double square_to_point(const double p[3], const double q[3])
{
    double d[3];

    lt_vec3_sub(p, q, d);
    return lt_vec3_dot(d, d);
}

/* Never more than square_to_point of a point inside, in rounded numbers too */
static double square_to_box(const double p[3], const lt_kd_box *b)
{
    double d[3];

    for (int k = 0; k < 3; k++)
        d[k] = greater(0, greater(b->lo[k] - p[k], p[k] - b->hi[k]));
    return lt_vec3_dot(d, d);
}

/* *least: the smallest square so far */
static void search(const lt_kd_tree *t, range r, const double p[3], double *least)
{
    double square[2];
    bool nearer;

    if (r.n <= LEAF) {
        for (int i = r.from; i < r.from + r.n; i++)
            *least = less(square_to_point(p, t->point[i].at), *least);
        return;
    }
    for (int i = 0; i < 2; i++)
        square[i] = square_to_box(p, &t->box[half_of(r, i).box]);
    nearer = square[1] < square[0];
    if (square[nearer] < *least)
        search(t, half_of(r, nearer), p, least);
    if (square[!nearer] < *least)
        search(t, half_of(r, !nearer), p, least);
}

double lt_kd_tree_distance(const lt_kd_tree *t, const double p[3])
{
    double least = INFINITY;

    if (is_finite(p))
        search(t, (range){ 0, t->n, 0 }, p, &least);
    return sqrt(least);
}

/* ---- the nearest few ---------------------------------------------------------------------------------------- */

typedef struct {
    lt_kd_neighbour *list;      /* n so far, nearest first, of at most room */
    int n, room;
} nearest_few;

static bool nearer(double square, int index, const lt_kd_neighbour *than)
{
    return square < than->square || (square == than->square && index < than->index);
}

static void take(nearest_few *f, double square, int index)
{
    int i = f->n < f->room ? f->n++ : f->room;

    for (; i > 0 && nearer(square, index, &f->list[i - 1]); i--)
        if (i < f->room)
            f->list[i] = f->list[i - 1];
    if (i < f->room)
        f->list[i] = (lt_kd_neighbour){ square, index };
}

/* A box as far as the last of them may hold one with a lower index. */
static bool may_hold(const nearest_few *f, double square)
{
    return f->n < f->room || square <= f->list[f->n - 1].square;
}

static void search_few(const lt_kd_tree *t, range r, const double p[3], nearest_few *f)
{
    double square[2];
    bool nearer_half;

    if (r.n <= LEAF) {
        for (int i = r.from; i < r.from + r.n; i++)
            take(f, square_to_point(p, t->point[i].at), t->point[i].index);
        return;
    }
    for (int i = 0; i < 2; i++)
        square[i] = square_to_box(p, &t->box[half_of(r, i).box]);
    nearer_half = square[1] < square[0];
    if (may_hold(f, square[nearer_half]))
        search_few(t, half_of(r, nearer_half), p, f);
    if (may_hold(f, square[!nearer_half]))
        search_few(t, half_of(r, !nearer_half), p, f);
}

int lt_kd_tree_nearest(const lt_kd_tree *t, const double p[3], int k, lt_kd_neighbour *out)
{
    nearest_few f = { out, 0, k };

    if (k > 0 && t->n && is_finite(p))
        search_few(t, (range){ 0, t->n, 0 }, p, &f);
    return f.n;
}
