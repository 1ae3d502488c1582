/* SPDX-License-Identifier: Apache-2.0 */
#include "models/splats/gaussians.h"

#include "libtensor/geometry/harmonics.h"
#include "libtensor/geometry/mesh/kd_tree.h"

#include <math.h>
#include <string.h>

enum { NEIGHBOURS = 3 };

static const double FIRST_OPACITY = 0.1;
static const double LEAST_SQUARE = 1e-7;            /* of a distance between neighbours, square metres */

void gaussians_new(gaussians *g, lt_params *set, const char *prefix, int sets, int64_t each, int features)
{
    const int64_t rows = sets * lt_rows_capacity(each);

    *g = (gaussians){
        .sets = sets,
        .centre = lt_params_add_rows(set, prefix, "centre", LT_SHAPE(rows, 3)),
        .log_scale = lt_params_add_rows(set, prefix, "log_scale", LT_SHAPE(rows, 3)),
        .quaternion = lt_params_add_rows(set, prefix, "quaternion", LT_SHAPE(rows, 4)),
        .opacity = lt_params_add_rows(set, prefix, "opacity", LT_SHAPE(rows, 1)),
        .dc = lt_params_add_rows(set, prefix, "dc", LT_SHAPE(rows, 1, 3)),
        .rest = lt_params_add_rows(set, prefix, "rest", LT_SHAPE(rows, GAUSSIANS_SH - 1, 3)),
        .feature = features ? lt_params_add_rows(set, prefix, "feature", LT_SHAPE(rows, features)) : NULL,
        .count = lt_params_add(set, prefix, "count", LT_WEIGHT, LT_SHAPE(sets)),
    };
    g->count->frozen = true;
}

int gaussians_kinds(const gaussians *g, lt_param *out[GAUSSIANS_KINDS])
{
    lt_param *const kinds[GAUSSIANS_KINDS] = { g->centre, g->log_scale, g->quaternion, g->opacity, g->dc, g->rest,
                                               g->feature };

    memcpy(out, kinds, sizeof(kinds));
    return g->feature ? GAUSSIANS_KINDS : GAUSSIANS_KINDS - 1;
}

int64_t gaussians_capacity(const gaussians *g)
{
    return g->centre->shape.dim[0] / g->sets;
}

int64_t gaussians_first(const gaussians *g, int set)
{
    return set * gaussians_capacity(g);
}

int64_t gaussians_count(const gaussians *g, int set)
{
    return (int64_t)g->count->data[set];
}

double gaussians_scale(const gaussians *g, int64_t row)
{
    const lt_real *s = g->log_scale->data + 3 * row;

    return exp(fmax((double)s[0], fmax((double)s[1], (double)s[2])));
}

/* ---- initial values -------------------------------------------------------------------------------------- */

/* The root of the mean square of the distances to the three nearest others */
static double spacing(const lt_kd_tree *tree, const double at[3])
{
    lt_kd_neighbour near[NEIGHBOURS + 1];
    const int n = lt_kd_tree_nearest(tree, at, NEIGHBOURS + 1, near);
    double sum = 0;

    for (int k = 1; k < n; k++)                     /* the first one is the point itself */
        sum += near[k].square;
    return sqrt(fmax(n > 1 ? sum / (n - 1) : 0, LEAST_SQUARE));
}

static void place_row(const gaussians *g, int64_t row, const float at[3], double scale)
{
    for (int k = 0; k < 3; k++) {
        g->centre->data[3 * row + k] = (lt_real)at[k];
        g->log_scale->data[3 * row + k] = (lt_real)log(scale);
        g->dc->data[3 * row + k] = (lt_real)(0.5 / LT_SH_C0);
    }
    g->quaternion->data[4 * row] = 1;
    g->opacity->data[row] = (lt_real)log(FIRST_OPACITY / (1 - FIRST_OPACITY));
}

lt_status gaussians_place(const gaussians *g, int set, const float (*place)[3], int64_t n)
{
    double (*at)[3] = lt_alloc((size_t)n * sizeof(*at));
    lt_kd_tree tree = { 0 };
    lt_status st;

    if (!at)
        return lt_error(LT_ENOMEM, "no memory for %lld Gaussians", (long long)n);
    for (int64_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            at[i][k] = (double)place[i][k];
    st = n > gaussians_capacity(g)
        ? lt_error(LT_EINVAL, "%lld Gaussians in a set, found room for %lld", (long long)n,
                   (long long)gaussians_capacity(g))
        : lt_kd_tree_new((int)n, &at[0][0], &tree);
    for (int64_t i = 0; i < n && !st; i++)
        place_row(g, gaussians_first(g, set) + i, place[i], spacing(&tree, at[i]));
    if (!st)
        g->count->data[set] = (lt_real)n;
    lt_kd_tree_free(&tree);
    lt_release(at);
    return st;
}

/* ---- for files ------------------------------------------------------------------------------------------ */

static void take(const lt_param *p, int64_t row, int64_t n, float *out)
{
    for (int64_t k = 0; k < n; k++)
        out[k] = (float)p->data[row * n + k];
}

lt_status gaussians_splats(const gaussians *g, int set, lt_arena *arena, lt_splat **out, size_t *n)
{
    const int64_t first = gaussians_first(g, set), count = gaussians_count(g, set);
    lt_splat *all = lt_arena_array(arena, (size_t)count, sizeof(*all));

    if (!all)
        return lt_error(LT_ENOMEM, "no memory for %lld Gaussians", (long long)count);
    for (int64_t i = 0; i < count; i++) {
        float rest[GAUSSIANS_SH - 1][3];
        lt_splat *s = &all[i];

        take(g->centre, first + i, 3, s->x);
        take(g->log_scale, first + i, 3, s->scale);
        take(g->quaternion, first + i, 4, s->rotation);
        take(g->opacity, first + i, 1, &s->opacity);
        take(g->dc, first + i, 3, s->dc);
        take(g->rest, first + i, 3 * (GAUSSIANS_SH - 1), rest[0]);
        for (int k = 0; k < 3 * (GAUSSIANS_SH - 1); k++)
            s->rest[k % 3][k / 3] = rest[k / 3][k % 3];
    }
    *out = all;
    *n = (size_t)count;
    return LT_OK;
}

/* ---- in graphs ------------------------------------------------------------------------------------------- */

static lt_tensor *rows_of(lt_param *p, lt_tensor *first, int64_t n)
{
    return lt_rows(lt_use(first->graph, p), first, n);
}

gaussian_rows gaussians_rows(const gaussians *g, lt_tensor *first, lt_tensor *alive)
{
    const int64_t N = gaussians_capacity(g);
    lt_tensor *const sh[] = { rows_of(g->dc, first, N), rows_of(g->rest, first, N) };

    return (gaussian_rows){
        .centre = rows_of(g->centre, first, N), .log_scale = rows_of(g->log_scale, first, N),
        .quaternion = rows_of(g->quaternion, first, N),
        .opacity = lt_mul(lt_sigmoid(rows_of(g->opacity, first, N)), alive),
        .sh = lt_concat(sh, 2, 1), .feature = g->feature ? rows_of(g->feature, first, N) : NULL,
    };
}
