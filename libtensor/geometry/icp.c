/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/geometry/icp.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/kd_tree.h"
#include "libtensor/geometry/principal.h"

enum { CUBE = 24, STARTS = CUBE + 1, ROUNDS = 100 };

static const double LEAST_RMS = 1e-3, LEAST_GAIN = 1e-5;

static lt_status check_points(int n, const double (*x)[3])
{
    if (n < 1)
        return lt_error(LT_EINVAL, "closest points: a set of %d points", n);
    if (!lt_all_finite(3 * (int64_t)n, x[0]))
        return lt_error(LT_EINVAL, "closest points: a coordinate is not finite");
    return LT_OK;
}

static lt_status no_memory(int n)
{
    return lt_error(LT_ENOMEM, "closest points: no memory for %d points", n);
}

/* ---- similarities --------------------------------------------------------------------------------------------- */

/* Both sets, and a tree of y */
typedef struct {
    int n, m;
    const double (*x)[3], (*y)[3];
    lt_kd_tree tree;
} sets;

typedef struct { double share, rms; } fit;

/* Pairs under s into from, to (n, 3): how many */
static int pair_up(const sets *p, const lt_similarity *s, double within, double (*from)[3], double (*to)[3], fit *out)
{
    double sum = 0;
    int pairs = 0;

    for (int i = 0; i < p->n; i++) {
        lt_kd_neighbour nearest;
        double moved[3];

        lt_similarity_apply(s, 1, p->x[i], moved);
        if (!lt_kd_tree_nearest(&p->tree, moved, 1, &nearest) || !(nearest.square <= within * within))
            continue;
        memcpy(from[pairs], p->x[i], sizeof(from[pairs]));
        memcpy(to[pairs++], p->y[nearest.index], sizeof(to[pairs]));
        sum += nearest.square;
    }
    *out = (fit){ (double)pairs / p->n, pairs ? sqrt(sum / pairs) : 0 };
    return pairs;
}

static bool has_settled(const fit *a, const fit *b, double tolerance)
{
    return fabs(a->share - b->share) <= tolerance && fabs(a->rms - b->rms) <= tolerance * a->rms;
}

static lt_status iterate(const sets *p, const lt_icp_opts *o, lt_similarity *s)
{
    double (*pair)[3] = lt_alloc(2 * (size_t)p->n * sizeof(*pair));
    fit last = { 0, INFINITY };
    lt_status st = pair ? LT_OK : no_memory(p->n);

    for (int round = 0; round < o->rounds && !st; round++) {
        fit now;
        const int pairs = pair_up(p, s, o->within, pair, pair + p->n, &now);

        if (pairs < 3 || has_settled(&last, &now, o->tolerance))
            break;
        last = now;
        st = lt_procrustes_umeyama(pairs, pair[0], pair[p->n], s);
    }
    lt_release(pair);
    return st;
}

static lt_status open_sets(int n, const double (*x)[3], int m, const double (*y)[3], sets *out)
{
    lt_status st = check_points(n, x);

    *out = (sets){ .n = n, .m = m, .x = x, .y = y };
    if (!st)
        st = check_points(m, y);
    return st ? st : lt_kd_tree_new(m, y[0], &out->tree);
}

lt_status lt_icp_similarity(int n, const double (*x)[3], int m, const double (*y)[3], const lt_similarity *start,
                            const lt_icp_opts *opts, lt_similarity *out)
{
    lt_similarity s = *start;
    sets p;
    lt_status st = open_sets(n, x, m, y, &p);

    if (!st)
        st = iterate(&p, opts, &s);
    lt_kd_tree_free(&p.tree);
    if (!st)
        *out = s;
    return st;
}

/* ---- the best of many ------------------------------------------------------------------------------------------- */

/* Row k of the result is row k of a cube's rotation: an axis, or its opposite */
static void cube_rotation(int which, double R[9])
{
    static const int order[6][3] = { { 0, 1, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 0, 2, 1 }, { 2, 1, 0 }, { 1, 0, 2 } };
    const int *o = order[which / 4];
    const double a = which & 1 ? -1 : 1, b = which & 2 ? -1 : 1;

    memset(R, 0, 9 * sizeof(*R));
    R[o[0]] = a;
    R[3 + o[1]] = b;
    R[6 + o[2]] = which / 4 < 3 ? a * b : -a * b;       /* determinant 1 */
}

static double size_of(const lt_principal *p)
{
    return sqrt(lt_vec3_dot(p->spread, p->spread));
}

/* Axes as rows, right-handed */
static void frame_of(const lt_principal *p, double R[9])
{
    memcpy(R, p->axis, 9 * sizeof(*R));
    if (lt_mat3_det(R) < 0)
        for (int k = 6; k < 9; k++)
            R[k] = -R[k];
}

static void put_mean(lt_similarity *s, const double from[3], const double to[3])
{
    double moved[3];

    lt_mat3_mulvec(s->R, from, moved);
    for (int k = 0; k < 3; k++)
        s->t[k] = to[k] - s->scale * moved[k];
}

static lt_similarity start_of(int which, const lt_principal *x, const lt_principal *y)
{
    lt_similarity s = { .scale = 1 };
    double X[9], Y[9], C[9], back[9];

    lt_mat3_identity(s.R);
    if (which > 0 && size_of(x) > 0) {
        s.scale = size_of(y) / size_of(x);
        frame_of(x, X), frame_of(y, Y);
        cube_rotation(which - 1, C);
        lt_mat3_transpose(Y, back);
        lt_mat3_mul(C, X, s.R);
        lt_mat3_mul(back, s.R, s.R);
    }
    put_mean(&s, x->centre, y->centre);
    return s;
}

static double mean_square(const lt_kd_tree *t, int n, const double (*p)[3])
{
    double sum = 0;

    for (int i = 0; i < n; i++) {
        const double d = lt_kd_tree_distance(t, p[i]);

        sum += d * d;
    }
    return sum / n;
}

/* Both ways */
static lt_status what_is_left(const sets *p, const lt_similarity *s, double *out)
{
    double (*moved)[3] = lt_alloc((size_t)p->n * sizeof(*moved));
    lt_kd_tree tree = { 0 };
    lt_status st = moved ? LT_OK : no_memory(p->n);

    if (!st) {
        lt_similarity_apply(s, p->n, p->x[0], moved[0]);
        st = lt_kd_tree_new(p->n, moved[0], &tree);
    }
    if (!st)
        *out = mean_square(&p->tree, p->n, (const double (*)[3])moved) + mean_square(&tree, p->m, p->y);
    lt_kd_tree_free(&tree);
    lt_release(moved);
    return st;
}

typedef struct {
    sets p;
    const lt_icp_opts *opts;
    lt_similarity s[STARTS];
    double left[STARTS];
    lt_status st[STARTS];
} contest;

static void try_start(void *ctx, int64_t i)
{
    contest *c = ctx;

    c->st[i] = iterate(&c->p, c->opts, &c->s[i]);
    if (!c->st[i])
        c->st[i] = what_is_left(&c->p, &c->s[i], &c->left[i]);
}

lt_status lt_icp_best_similarity(int n, const double (*x)[3], int m, const double (*y)[3], const lt_icp_opts *opts,
                                 lt_similarity *out)
{
    contest c = { .opts = opts };
    lt_principal of_x, of_y;
    int best = 0;
    lt_status st = open_sets(n, x, m, y, &c.p);

    if (!st) {
        lt_principal_of(n, x[0], &of_x);
        lt_principal_of(m, y[0], &of_y);
        for (int i = 0; i < STARTS; i++)
            c.s[i] = start_of(i, &of_x, &of_y);
        lt_parallel_for(STARTS, try_start, &c);
    }
    lt_kd_tree_free(&c.p.tree);
    for (int i = 0; i < STARTS && !st; i++) {
        st = c.st[i] ? no_memory(n) : LT_OK;
        best = c.left[i] < c.left[best] ? i : best;
    }
    if (!st)
        *out = c.s[best];
    return st;
}

/* ---- scale and translation -------------------------------------------------------------------------------------- */

static double centre_and_size(int n, const double (*x)[3], double centre[3])
{
    double sum = 0;

    for (int k = 0; k < 3; k++) {
        centre[k] = 0;
        for (int i = 0; i < n; i++)
            centre[k] += x[i][k] / n;
    }
    for (int i = 0; i < n; i++) {
        const double d = lt_vec3_distance(x[i], centre);

        sum += d * d;
    }
    return sqrt(sum / n);
}

static void make_unit(int n, const double (*x)[3], const double centre[3], double size, double (*out)[3])
{
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            out[i][k] = (x[i][k] - centre[k]) / size;
}

/* Least squares of scale a + shift = b over the pairs */
typedef struct { double scale, shift[3]; } step;

static step fit_pairs(int n, const double (*a)[3], const double (*b)[3])
{
    double of_a[3], of_b[3], cross = 0, square = 0;
    step s;

    centre_and_size(n, a, of_a);
    centre_and_size(n, b, of_b);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) {
            cross += (a[i][k] - of_a[k]) * (b[i][k] - of_b[k]);
            square += (a[i][k] - of_a[k]) * (a[i][k] - of_a[k]);
        }
    s.scale = square > 0 ? cross / square : 1;
    for (int k = 0; k < 3; k++)
        s.shift[k] = of_b[k] - s.scale * of_a[k];
    return s;
}

/* Each point of x with the nearest of y, each of y with the nearest of x: n + m pairs, and the root of their mean
 * square */
static lt_status pair_both_ways(int n, const double (*x)[3], const lt_kd_tree *of_y, int m, const double (*y)[3],
                                double (*a)[3], double (*b)[3], double *rms)
{
    lt_kd_tree of_x;
    lt_kd_neighbour nearest;
    double sum = 0;
    lt_status st = lt_kd_tree_new(n, x[0], &of_x);

    for (int i = 0; i < n + m && !st; i++) {
        const bool back = i >= n;

        if (!lt_kd_tree_nearest(back ? &of_x : of_y, back ? y[i - n] : x[i], 1, &nearest)) {
            st = lt_error(LT_EINVAL, "closest points: the fit went to infinity");
            break;
        }
        memcpy(a[i], back ? x[nearest.index] : x[i], sizeof(a[i]));
        memcpy(b[i], back ? y[i - n] : y[nearest.index], sizeof(b[i]));
        sum += nearest.square;
    }
    lt_kd_tree_free(&of_x);
    *rms = sqrt(sum / (n + m));
    return st;
}

/* u, v: x and y of size 1 around their means; u moves, *total says how. pair has room for 2 (n + m). */
static lt_status settle(int n, double (*u)[3], int m, double (*v)[3], double (*pair)[3], step *total)
{
    lt_kd_tree of_v;
    double last = INFINITY, rms;
    lt_status st = lt_kd_tree_new(m, v[0], &of_v);

    *total = (step){ .scale = 1 };
    for (int round = 0; round < ROUNDS && !st; round++) {
        step s;

        st = pair_both_ways(n, (const double (*)[3])u, &of_v, m, (const double (*)[3])v, pair, pair + n + m, &rms);
        if (st || rms < LEAST_RMS || last - rms < LEAST_GAIN)
            break;
        last = rms;
        s = fit_pairs(n + m, (const double (*)[3])pair, (const double (*)[3])(pair + n + m));
        for (int i = 0; i < n; i++)
            for (int k = 0; k < 3; k++)
                u[i][k] = s.scale * u[i][k] + s.shift[k];
        total->scale *= s.scale;
        for (int k = 0; k < 3; k++)
            total->shift[k] = s.scale * total->shift[k] + s.shift[k];
    }
    lt_kd_tree_free(&of_v);
    return st;
}

lt_status lt_icp_scale_translation(int n, const double (*x)[3], int m, const double (*y)[3], lt_similarity *out)
{
    double (*u)[3], of_x[3], of_y[3], size_x, size_y;
    step total;
    lt_status st = check_points(n, x);

    if (!st)
        st = check_points(m, y);
    if (st)
        return st;
    size_x = centre_and_size(n, x, of_x), size_y = centre_and_size(m, y, of_y);
    if (!(size_x > 0 && size_y > 0))
        return lt_error(LT_EINVAL, "closest points: all of a set's points are one");
    u = lt_alloc(3 * ((size_t)n + (size_t)m) * sizeof(*u));
    if (!u)
        return no_memory(n + m);
    make_unit(n, x, of_x, size_x, u);
    make_unit(m, y, of_y, size_y, u + n);
    st = settle(n, u, m, u + n, u + n + m, &total);
    lt_release(u);
    if (st)
        return st;
    *out = (lt_similarity){ .scale = total.scale * size_y / size_x };
    lt_mat3_identity(out->R);
    for (int k = 0; k < 3; k++)
        out->t[k] = of_y[k] + size_y * total.shift[k] - out->scale * of_x[k];
    return LT_OK;
}
