/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Skinning, forward. The sum over blends is a product for all samples, as their table is more than a megabyte. A task
 * makes some groups of many samples and skins them at once: they stay with its thread.
 */
#include "libtensor/geometry/skin/internal.h"

#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/kernels/gemm/gemm.h"
#include "libtensor/kernels/gemm/tiles.h"

enum {
    BAND = 64,                          /* samples of a task */
    FEW = 4, FEW_FOR_TILES = 16,        /* samples that are no product's worth */
};

typedef struct {
    const lt_skin_layer *layer;
    int64_t n;
    const lt_real *R, *shape;
    lt_real *vertices, *points;
    void *scratch;
} forward_job;

/* ---- over joints --------------------------------------------------------------------------------------- */

static void rest_joints(const lt_skin_tables *t, const lt_real *shape, double (*rest)[3])
{
    double *sum = rest[0];

    memcpy(sum, t->rest, (size_t)t->J * sizeof(*rest));
    for (int k = 0; k < t->S; k++) {
        const double *direction = t->rest_shape[k * t->J], coef = shape[k];

        for (int i = 0; i < 3 * t->J; i++)
            sum[i] += direction[i] * coef;
    }
}

static void fill_coefficients(const lt_skin_tables *t, const lt_real *R, const lt_real *shape, lt_real *coef)
{
    coef[0] = 1;
    memcpy(coef + 1, shape, (size_t)t->S * sizeof(*coef));
    coef += 1 + t->S;
    memcpy(coef, R + 9, (size_t)t->P * sizeof(*coef));
    for (int k = 0; k < t->P; k += 9)
        coef[k] -= 1, coef[k + 4] -= 1, coef[k + 8] -= 1;
}

/* A_k, then s_k, of each joint */
static void find_frames(int J, const skin_sample *s)
{
    for (int k = 0; k < J; k++) {
        double turned[3];

        lt_mat3_mulvec(s->world_R[k], s->rest[k], turned);
        for (int r = 0; r < 9; r++)
            s->frame[k][r] = (lt_real)s->world_R[k][r];
        for (int a = 0; a < 3; a++)
            s->frame[k][9 + a] = (lt_real)(s->world_t[k][a] - turned[a]);
    }
}

static void pose_sample(void *ctx, int64_t i)
{
    const forward_job *j = ctx;
    const lt_skin_tables *t = &j->layer->t;
    const lt_real *R = j->R + i * 9 * t->J, *shape = j->shape + i * t->S;
    const double origin[3] = { 0 };
    const skin_sample s = skin_sample_at(j->layer, j->scratch, i);
    lt_real *points = j->points + i * 3 * t->n_points;
    double R_wide[9 * LT_RIG_JOINTS];

    skin_widen(j->layer, R, R_wide);
    rest_joints(t, shape, s.rest);
    lt_rig_chain(t->J, t->parents, (const double (*)[3])s.rest, R_wide, origin, s.world_R, s.world_t);
    find_frames(t->J, &s);
    fill_coefficients(t, R, shape, s.coef);
    for (int p = 0; p < t->n_points; p++)
        for (int a = 0; t->points[p] < t->J && a < 3; a++)
            points[3 * p + a] = (lt_real)s.world_t[t->points[p]][a];
}

/* ---- over vertices ------------------------------------------------------------------------------------- */

/* posed = coefficients times blends, of n samples: the same chain of multiply-adds each way, but by tiles */
static void blend_piece(const lt_skin_layer *layer, int64_t index, int64_t n, const skin_sample *s)
{
    const skin_piece p = skin_piece_at(layer, index);
    const int64_t at = p.first * COLUMNS, columns = p.groups * COLUMNS, row = layer->columns, K = layer->blends;
    const int64_t stride = skin_stride(layer);
    const lt_real *blend = layer->t.blend + at, *packed = layer->packed[index];
    lt_real *posed = s->posed + at;

    if (n < (lt_k->gemm_tiles ? FEW_FOR_TILES : FEW))
        for (int64_t i = 0; i < n; i++)
            lt_k->combine(posed + i * stride, blend, row, s->coef + i * stride, K, (size_t)columns, false);
    else if (layer->isa != lt_k->isa)
        lt_gemm(LT_NO_TRANS, LT_NO_TRANS, n, columns, K, s->coef, stride, blend, row, false, posed, stride, NULL);
    else if (lt_k->gemm_tiles)
        lt_gemm_tiles(n, columns, K, s->coef, stride, packed, false, posed, stride, NULL);
    else
        lt_gemm_packed(LT_NO_TRANS, n, columns, K, s->coef, stride, packed, false, posed, stride, NULL);
}

static void skin_vertices(const forward_job *j, int64_t index, int64_t sample)
{
    const lt_skin_layer *layer = j->layer;
    const lt_skin_tables *t = &layer->t;
    const skin_piece p = skin_piece_at(layer, index);
    const int64_t first = p.first * GROUP, n = lt_min_i64(p.groups * GROUP, t->V - first);
    const skin_sample s = skin_sample_at(layer, j->scratch, sample);
    lt_real *vertices = j->vertices + 3 * (sample * t->V + first), *points = j->points + sample * 3 * t->n_points;

    lt_k->skin(vertices, NULL, 0, s.posed + p.first * COLUMNS, layer->group + p.first, n,
               (const lt_real (*)[LT_SKIN_FRAME])s.frame);
    for (int i = 0; i < layer->n_vertex_points; i++) {
        const skin_vertex_point *v = &layer->vertex_points[i];

        if (v->vertex >= first && v->vertex < first + n)
            memcpy(points + 3 * v->point, vertices + 3 * (v->vertex - first), 3 * sizeof(*points));
    }
}

/* A piece of some samples */
static void run_piece(void *ctx, int64_t task)
{
    const forward_job *j = ctx;
    const int64_t pieces = j->layer->pieces, index = task % pieces;
    const int64_t from = task / pieces * BAND, to = lt_min_i64(j->n, from + BAND);
    const skin_sample s = skin_sample_at(j->layer, j->scratch, from);

    blend_piece(j->layer, index, to - from, &s);
    for (int64_t i = from; i < to; i++)
        skin_vertices(j, index, i);
}

void lt_skin_forward(const lt_skin_layer *layer, int64_t n, const lt_real *R, const lt_real *shape,
                     lt_real *vertices, lt_real *points, void *scratch)
{
    forward_job j = { layer, n, R, shape, vertices, points, scratch };

    lt_parallel_for(n, pose_sample, &j);
    lt_parallel_for(layer->pieces * lt_ceil_div(n, BAND), run_piece, &j);
}
