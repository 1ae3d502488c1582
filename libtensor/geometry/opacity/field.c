/* SPDX-License-Identifier: Apache-2.0 */
/* The field: made of Gaussians, and asked at places. */
#include "libtensor/geometry/opacity/internal.h"

#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/svd3.h"
#include "libtensor/kernels/kernels.h"

static const double VIEW_DISTANCE = 2.4, LEAST_VARIANCE = 1e-12;        /* radii; square metres */
static const double GOLDEN = 1.6180339887498949, PI = 3.14159265358979324;

enum { CHUNK = 1024, BLOCK = 128 };     /* places in a task; of a tile at once */

const char *lt_opacity_rule_name(lt_opacity_rule rule)
{
    return rule == LT_OPACITY_MIN ? "min" : "mean";
}

/* ---- making --------------------------------------------------------------------------------------------------- */

static lt_status check(int64_t n, const lt_gaussian *g)
{
    if (n < 1 || n > UINT32_MAX)
        return lt_error(LT_EINVAL, "opacity field: %lld Gaussians, want at least one", (long long)n);
    for (int64_t i = 0; i < n; i++) {
        if (!lt_all_finite(3, g[i].centre) || !lt_all_finite(9, g[i].axes))
            return lt_error(LT_EINVAL, "opacity field: Gaussian %lld is not finite", (long long)i);
        if (!(g[i].opacity >= 0 && g[i].opacity <= 1))
            return lt_error(LT_EINVAL, "opacity field: Gaussian %lld has opacity %g, want 0 to 1", (long long)i,
                            g[i].opacity);
    }
    return LT_OK;
}

/* The middle of the box around all boxes of three deviations, and the radius around it that they are in */
static double find_middle(int64_t n, const lt_gaussian *g, double middle[3])
{
    double radius = 0;

    for (int k = 0; k < 3; k++) {
        double lo = INFINITY, hi = -INFINITY;

        for (int64_t i = 0; i < n; i++) {
            const double *row = g[i].axes + 3 * k, half = 3 * (fabs(row[0]) + fabs(row[1]) + fabs(row[2]));

            lo = fmin(lo, g[i].centre[k] - half);
            hi = fmax(hi, g[i].centre[k] + half);
        }
        middle[k] = 0.5 * (lo + hi);
    }
    for (int64_t i = 0; i < n; i++)
        for (int corner = 0; corner < 8; corner++) {
            const double s[3] = { corner & 1 ? 3 : -3, corner & 2 ? 3 : -3, corner & 4 ? 3 : -3 };
            double x[3];

            lt_mat3_mulvec(g[i].axes, s, x);
            for (int k = 0; k < 3; k++)
                x[k] += g[i].centre[k] - middle[k];
            radius = fmax(radius, lt_vec3_norm(x));
        }
    return radius;
}

/* On the sphere along Fibonacci's spiral, from pole to pole, looking at the middle */
static void place_view(int k, double distance, opacity_view *v)
{
    const double z = -1 + 2.0 * k / (LT_OPACITY_VIEWS - 1), r = sqrt(fmax(0, 1 - z * z)), angle = 2 * PI * k / GOLDEN;
    const double out[3] = { r * cos(angle), r * sin(angle), z };
    double *right = v->axes, *down = v->axes + 3, *forward = v->axes + 6;
    const double beside[3] = { fabs(z) > 0.9, 0, fabs(z) <= 0.9 };

    for (int i = 0; i < 3; i++) {
        v->eye[i] = distance * out[i];
        forward[i] = -out[i];
    }
    lt_vec3_cross(forward, beside, right);
    lt_vec3_unit(right);
    lt_vec3_cross(forward, right, down);
}

/* M = U S V^T; where U^T x / S is round. In powers of two: alpha = 2^(top - |x|^2). */
static void whiten(const lt_gaussian *g, const double middle[3], lt_splat_round *out, double covariance[9])
{
    const double log2_e = 1.4426950408889634;
    double U[9], S[3], V[9];

    lt_svd3(g->axes, U, S, V);
    memset(covariance, 0, 9 * sizeof(*covariance));
    for (int k = 0; k < 3; k++) {
        const double variance = S[k] * S[k] + LEAST_VARIANCE;

        for (int i = 0; i < 3; i++) {
            out->white[3 * k + i] = (lt_real)(U[3 * i + k] * sqrt(0.5 * log2_e / variance));
            for (int j = 0; j < 3; j++)
                covariance[3 * i + j] += variance * U[3 * i + k] * U[3 * j + k];
        }
        out->centre[k] = (lt_real)(g->centre[k] - middle[k]);
    }
    out->top = (lt_real)log2(fmax(g->opacity, 1e-30));
}

lt_status lt_opacity_field_new(lt_arena *arena, int64_t n, const lt_gaussian *g, lt_opacity_field **out)
{
    lt_opacity_field *f;
    double (*covariance)[9], radius;
    lt_status st = check(n, g);

    if (!st)
        st = lt_kernels_init();
    if (st)
        return st;
    f = lt_arena_alloc(arena, sizeof(*f));
    covariance = lt_alloc((size_t)n * sizeof(*covariance));
    if (f)
        f->gaussian = lt_arena_array(arena, (size_t)n, sizeof(*f->gaussian));
    if (!f || !f->gaussian || !covariance) {
        lt_release(covariance);
        return lt_error(LT_ENOMEM, "no memory for the field of %lld Gaussians", (long long)n);
    }
    f->n = n;
    radius = fmax(find_middle(n, g, f->middle), 1e-9);
    f->reach = 0.75 * VIEW_DISTANCE * radius;
    for (int64_t i = 0; i < n; i++)
        whiten(&g[i], f->middle, &f->gaussian[i], covariance[i]);
    for (int k = 0; k < LT_OPACITY_VIEWS && !st; k++) {
        place_view(k, VIEW_DISTANCE * radius, &f->view[k]);
        st = opacity_look(f, k, g, (const double (*)[9])covariance, arena);
    }
    lt_release(covariance);
    *out = f;
    return st;
}

/* ---- asking --------------------------------------------------------------------------------------------------- */

/* Places [first, first + n) of the order, all in one tile */
typedef struct {
    int32_t tile, first, n;
} block;

/* Places that no view so far has seen bare, by tiles of the view at hand */
typedef struct {
    const lt_opacity_field *f;
    const opacity_view *view;
    const double (*place)[3];
    int64_t n;
    int32_t *open, *order;          /* (n) of them: numbers of places; and the same by tiles */
    int32_t *tile;                  /* (n) of open's */
    lt_real *light;                 /* of a place: what the view's Gaussians leave */
    block *block;                   /* (blocks) */
    int64_t blocks;
} asking;

static void from_middle(const asking *a, int32_t i, double out[3])
{
    lt_vec3_sub(a->place[i], a->f->middle, out);
}

static void find_tiles(void *ctx, int64_t task)
{
    asking *a = ctx;

    for (int64_t i = task * CHUNK; i < lt_min_i64(a->n, (task + 1) * CHUNK); i++) {
        double x[3];

        from_middle(a, a->open[i], x);
        a->tile[i] = opacity_tile(a->view, x);
    }
}

static void sort_by_tile(asking *a)
{
    int32_t first[OPACITY_TILES + 1] = { 0 }, next[OPACITY_TILES];

    for (int64_t i = 0; i < a->n; i++)
        first[a->tile[i] + 1]++;
    a->blocks = 0;
    for (int t = 0; t < OPACITY_TILES; t++) {
        next[t] = first[t];
        first[t + 1] += first[t];
        for (int32_t at = first[t]; at < first[t + 1]; at += BLOCK)
            a->block[a->blocks++] = (block){ t, at, (int32_t)lt_min_i64(BLOCK, first[t + 1] - at) };
    }
    for (int64_t i = 0; i < a->n; i++)
        a->order[next[a->tile[i]]++] = a->open[i];
}

/* The last vector's lanes beyond the places repeat the last one. */
static void look_at_block(void *ctx, int64_t task)
{
    asking *a = ctx;
    const opacity_view *v = a->view;
    const block *b = &a->block[task];
    const int32_t *place = a->order + b->first;
    const int64_t padded = lt_ceil_div(b->n, LT_POINTS) * LT_POINTS;
    const lt_splat_rays rays = {
        .gaussian = a->f->gaussian, .eye = (const lt_real (*)[3])v->met, .number = v->number + v->first[b->tile],
        .n = v->first[b->tile + 1] - v->first[b->tile],
    };
    lt_real x[3][BLOCK], light[BLOCK];

    for (int64_t i = 0; i < padded; i++) {
        double p[3];

        from_middle(a, place[lt_min_i64(i, b->n - 1)], p);
        for (int k = 0; k < 3; k++)
            x[k][i] = (lt_real)p[k];
        light[i] = 1;
    }
    lt_k->splat.dim(light, x[0], BLOCK, padded, &rays);
    for (int32_t i = 0; i < b->n; i++)
        a->light[place[i]] = light[i];
}

/* Places that the view sees bare have no opacity by either rule, and need no other view. */
static void take_view(asking *a, lt_opacity_rule rule, double *opacity)
{
    int64_t n = 0;

    for (int64_t i = 0; i < a->n; i++) {
        const int32_t at = a->open[i];
        const double seen = 1 - (double)a->light[at];

        if (seen == 0) {
            opacity[at] = 0;
            continue;
        }
        opacity[at] = rule == LT_OPACITY_MIN ? fmin(opacity[at], seen) : opacity[at] + seen / LT_OPACITY_VIEWS;
        a->open[n++] = at;
    }
    a->n = n;
}

static void begin(asking *a, lt_opacity_rule rule, int64_t n, double *opacity)
{
    for (int64_t i = 0; i < n; i++) {
        double x[3];

        from_middle(a, (int32_t)i, x);
        opacity[i] = 0;
        if (lt_vec3_norm(x) < a->f->reach) {                    /* NaN is not */
            a->open[a->n++] = (int32_t)i;
            opacity[i] = rule == LT_OPACITY_MIN;
        }
    }
}

lt_status lt_opacity_at(const lt_opacity_field *f, lt_opacity_rule rule, int64_t n, const double (*place)[3],
                        double *opacity)
{
    asking a = { .f = f, .place = place };
    const size_t most_blocks = (size_t)n / BLOCK + OPACITY_TILES;
    int32_t *numbers = n < INT32_MAX ? lt_alloc(3 * (size_t)n * sizeof(*numbers)) : NULL;

    a.light = lt_alloc((size_t)n * sizeof(*a.light));
    a.block = lt_alloc(most_blocks * sizeof(*a.block));
    if (!numbers || !a.light || !a.block) {
        lt_release(a.block), lt_release(a.light), lt_release(numbers);
        return lt_error(LT_ENOMEM, "no memory to ask for opacity at %lld places", (long long)n);
    }
    a.open = numbers, a.order = numbers + n, a.tile = numbers + 2 * n;
    begin(&a, rule, n, opacity);
    for (int k = 0; k < LT_OPACITY_VIEWS && a.n; k++) {
        a.view = &f->view[k];
        lt_parallel_for(lt_ceil_div(a.n, CHUNK), find_tiles, &a);
        sort_by_tile(&a);
        lt_parallel_for(a.blocks, look_at_block, &a);
        take_view(&a, rule, opacity);
    }
    lt_release(a.block), lt_release(a.light), lt_release(numbers);
    return LT_OK;
}
