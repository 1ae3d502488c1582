/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/metrics/shape.h"

#include "eval/metrics/metrics.h"
#include "libtensor/geometry/icp.h"
#include "libtensor/geometry/mesh/surface.h"

#include <string.h>

enum { SEED = 30000, SURFACE = 0, ALIGNING = 1, VERTICES = 2 };        /* streams of one seed */

static const lt_icp_opts hold = { .within = 0.01, .rounds = 30, .tolerance = 1e-6 };

static lt_status no_memory(int n)
{
    return lt_error(LT_ENOMEM, "no memory to compare %d points", n);
}

lt_status eval_shape_of_points(int np, const double (*p)[3], int ng, const double (*g)[3], eval_shape_score *out)
{
    double *d_p = lt_alloc((size_t)np * sizeof(*d_p)), *d_g = lt_alloc((size_t)ng * sizeof(*d_g));
    lt_status st = d_p && d_g ? eval_nearest(np, p[0], ng, g[0], d_p, d_g) : no_memory(np + ng);

    if (!st)
        *out = (eval_shape_score){
            .cd_cm2 = eval_chamfer_cm2(np, d_p, ng, d_g), .f_1mm = eval_f_score(np, d_p, ng, d_g, 0.001).f,
            .f_5mm = eval_f_score(np, d_p, ng, d_g, 0.005).f, .f_10mm = eval_f_score(np, d_p, ng, d_g, 0.01).f,
        };
    lt_release(d_g);
    lt_release(d_p);
    return st;
}

/* n samples of a surface as doubles, which are lt_release's; NULL after an error */
static double (*samples_of(const lt_mesh *m, int stream, int n, lt_status *st))[3]
{
    lt_rng rng = lt_rng_make(SEED, (uint64_t)stream);
    double (*x)[3] = lt_alloc((size_t)n * sizeof(*x));
    float (*narrow)[3] = lt_alloc((size_t)n * sizeof(*narrow));

    *st = x && narrow ? lt_mesh_sample(m, &rng, n, narrow, NULL) : no_memory(n);
    if (!*st)
        eval_widen(3 * (int64_t)n, narrow[0], x[0]);
    lt_release(narrow);
    if (!*st)
        return x;
    lt_release(x);
    return NULL;
}

static lt_status align(eval_shape_alignment how, const lt_mesh *p, const lt_mesh *g, lt_similarity *out)
{
    const int n = EVAL_ALIGNING_SAMPLES;
    double (*x)[3], (*y)[3] = NULL;
    lt_status st;

    x = samples_of(p, ALIGNING, n, &st);
    if (!st)
        y = samples_of(g, ALIGNING, n, &st);
    if (!st && how == EVAL_BY_SIMILARITY)
        st = lt_icp_best_similarity(n, (const double (*)[3])x, n, (const double (*)[3])y, &hold, out);
    else if (!st)
        st = lt_icp_scale_translation(n, (const double (*)[3])x, n, (const double (*)[3])y, out);
    lt_release(y);
    lt_release(x);
    return st;
}

lt_status eval_shape(eval_shape_alignment how, const lt_mesh *p, const lt_mesh *g, eval_shape_score *out)
{
    const int n = EVAL_SURFACE_SAMPLES;
    double (*x)[3], (*y)[3] = NULL;
    lt_similarity s;
    lt_status st;

    x = samples_of(p, SURFACE, n, &st);
    if (!st)
        y = samples_of(g, SURFACE, n, &st);
    if (!st && how != EVAL_AS_IT_IS) {
        st = align(how, p, g, &s);
        if (!st)
            lt_similarity_apply(&s, n, x[0], x[0]);
    }
    if (!st)
        st = eval_shape_of_points(n, (const double (*)[3])x, n, (const double (*)[3])y, out);
    lt_release(y);
    lt_release(x);
    return st;
}

/* A mesh's vertices as doubles, which are lt_release's; NULL without memory */
static double (*vertices_of(const lt_mesh *m))[3]
{
    double (*x)[3] = lt_alloc((size_t)m->n_vertices * sizeof(*x));

    if (x)
        eval_widen(3 * (int64_t)m->n_vertices, m->vertex[0], x[0]);
    return x;
}

lt_status eval_shape_of_vertices(const lt_mesh *p, const lt_mesh *g, eval_shape_score *out)
{
    double (*x)[3] = vertices_of(p), (*y)[3] = vertices_of(g);
    lt_similarity s;
    lt_status st = x && y ? align(EVAL_BY_SIMILARITY, p, g, &s) : no_memory(p->n_vertices + g->n_vertices);

    if (!st) {
        lt_similarity_apply(&s, p->n_vertices, x[0], x[0]);
        st = eval_shape_of_points(p->n_vertices, (const double (*)[3])x, g->n_vertices, (const double (*)[3])y, out);
    }
    lt_release(y);
    lt_release(x);
    return st;
}

static void draw_vertices(const lt_mesh *m, const float wrist[3], double (*out)[3])
{
    lt_rng rng = lt_rng_make(SEED, VERTICES);

    for (int i = 0; i < EVAL_POSE_VERTICES; i++) {
        const float *v = m->vertex[lt_rng_below(&rng, (uint32_t)m->n_vertices)];

        for (int k = 0; k < 3; k++)
            out[i][k] = (double)v[k] - (double)wrist[k];
    }
}

lt_status eval_pose_chamfer_cm2(const lt_mesh *p, const float wrist_p[3], const lt_mesh *g, const float wrist_g[3],
                                double *out)
{
    const int n = EVAL_POSE_VERTICES;
    double (*x)[3] = lt_alloc(2 * (size_t)n * sizeof(*x));
    eval_shape_score score;
    lt_status st;

    if (!x)
        return no_memory(n);
    draw_vertices(p, wrist_p, x);
    draw_vertices(g, wrist_g, x + n);
    st = eval_shape_of_points(n, (const double (*)[3])x, n, (const double (*)[3])(x + n), &score);
    if (!st)
        *out = score.cd_cm2;
    lt_release(x);
    return st;
}
