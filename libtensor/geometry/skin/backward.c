/* SPDX-License-Identifier: Apache-2.0 */
/* Skinning, backward: each line of internal.h's formula undone, from the last to the first. */
#include "libtensor/geometry/skin/internal.h"

#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/kernels/gemm/gemm.h"

/* Gradients of the joints' frames and rest places */
typedef struct {
    double A[LT_RIG_JOINTS][9], p[LT_RIG_JOINTS][3], rest[LT_RIG_JOINTS][3];
} joint_grads;

static void clear(joint_grads *g, int J)
{
    memset(g->A, 0, (size_t)J * sizeof(g->A[0]));
    memset(g->p, 0, (size_t)J * sizeof(g->p[0]));
    memset(g->rest, 0, (size_t)J * sizeof(g->rest[0]));
}

/* Points are joints or vertices: their gradients join those of what they are. dv is (3, padded). */
static void spread_gradients(const lt_skin_tables *t, const lt_real *d_vertices, const lt_real *d_points,
                             lt_real *dv, joint_grads *g)
{
    memset(dv, 0, 3 * (size_t)t->padded * sizeof(*dv));
    for (int i = 0; d_vertices && i < t->V; i++)
        for (int a = 0; a < 3; a++)
            dv[a * t->padded + i] = d_vertices[3 * i + a];
    for (int i = 0; d_points && i < 3 * t->n_points; i++) {
        const int point = t->points[i / 3], a = i % 3;

        if (point < t->J)
            g->p[point][a] += d_points[i];
        else
            dv[a * t->padded + point - t->J] += d_points[i];
    }
}

/* In one sweep, in place: skin's matrix of each vertex becomes dv posed^T, posed becomes its gradient skin^T dv. dv are
 * the three rows behind skin's nine. */
static void unskin_group(lt_real *restrict posed, lt_real *restrict skin, int64_t row)
{
    for (int lane = 0; lane < GROUP; lane++) {
        lt_real x[3], dx[3] = { 0 };

        for (int b = 0; b < 3; b++)
            x[b] = posed[b * GROUP + lane];
        for (int a = 0; a < 3; a++) {
            const lt_real dv = skin[(9 + a) * row + lane];

            for (int b = 0; b < 3; b++) {
                dx[b] += skin[(3 * a + b) * row + lane] * dv;
                skin[(3 * a + b) * row + lane] = dv * x[b];
            }
        }
        for (int b = 0; b < 3; b++)
            posed[b * GROUP + lane] = dx[b];
    }
}

/* dA_k += sum of w_ik dv_i posed_i^T, and through s_k = p_k - A_k rest_k with ds_k = sum of w_ik dv_i */
static void unblend_frames(const lt_skin_tables *t, const skin_sample *s, joint_grads *g)
{
    lt_real sum[12 * LT_RIG_JOINTS];            /* (12, J): of A_k, then of s_k */

    lt_gemm(LT_NO_TRANS, LT_TRANS, 12, t->J, t->padded, s->skin, t->padded, t->weight, t->padded, false, sum, t->J,
            NULL);
    for (int k = 0; k < t->J; k++)
        for (int a = 0; a < 3; a++) {
            const double ds = sum[(9 + a) * t->J + k];

            g->p[k][a] += ds;
            for (int b = 0; b < 3; b++) {
                g->A[k][3 * a + b] += sum[(3 * a + b) * t->J + k] - ds * s->rest[k][b];
                g->rest[k][b] -= s->world_R[k][3 * a + b] * ds;
            }
        }
}

/* From the tips to the root: A_k = A_parent R_k, p_k = p_parent + A_parent (rest_k - rest_parent) */
static void unchain(const lt_skin_tables *t, const double *R, const skin_sample *s, joint_grads *g, double *dR)
{
    for (int k = t->J - 1; k > 0; k--) {
        const int parent = t->parents[k];
        double At[9], Rt[9], bone[3], dbone[3], dA[9];

        lt_mat3_transpose(s->world_R[parent], At);
        lt_mat3_transpose(R + 9 * k, Rt);
        lt_vec3_sub(s->rest[k], s->rest[parent], bone);
        lt_mat3_mul(At, g->A[k], dR + 9 * k);
        lt_mat3_mul(g->A[k], Rt, dA);
        lt_mat3_mulvec(At, g->p[k], dbone);
        for (int r = 0; r < 9; r++)
            g->A[parent][r] += dA[r] + g->p[k][r / 3] * bone[r % 3];
        for (int a = 0; a < 3; a++) {
            g->p[parent][a] += g->p[k][a];
            g->rest[k][a] += dbone[a];
            g->rest[parent][a] -= dbone[a];
        }
    }
    memcpy(dR, g->A[0], sizeof(g->A[0]));
}

static void unrest(const lt_skin_tables *t, double (*d_rest)[3], lt_real *d_shape)
{
    for (int k = 0; k < t->S; k++) {
        double sum = 0;

        for (int j = 0; j < t->J; j++)
            for (int a = 0; a < 3; a++)
                sum += t->rest_shape[k * t->J + j][a] * d_rest[j][a];
        d_shape[k] += (lt_real)sum;
    }
}

typedef struct {
    const lt_skin_layer *layer;
    const lt_real *R, *d_vertices, *d_points;
    lt_real *d_R, *d_shape;
    void *scratch;
} backward_job;

/* All but the blends, whose gradient of posed is left where posed was */
static void unpose_sample(void *ctx, int64_t i)
{
    const backward_job *j = ctx;
    const lt_skin_tables *t = &j->layer->t;
    const skin_sample s = skin_sample_at(j->layer, j->scratch, i);
    joint_grads g;
    double R_wide[9 * LT_RIG_JOINTS], dR[9 * LT_RIG_JOINTS];

    clear(&g, t->J);
    skin_widen(j->layer, j->R + i * 9 * t->J, R_wide);
    spread_gradients(t, j->d_vertices ? j->d_vertices + i * 3 * t->V : NULL,
                     j->d_points ? j->d_points + i * 3 * t->n_points : NULL, s.skin + 9 * t->padded, &g);
    lt_k->skin(NULL, s.skin, t->padded, s.posed, j->layer->group, t->V, (const lt_real (*)[LT_SKIN_FRAME])s.frame);
    for (int64_t group = 0; group < t->groups; group++)
        unskin_group(s.posed + group * COLUMNS, s.skin + group * GROUP, t->padded);
    unblend_frames(t, &s, &g);
    unchain(t, R_wide, &s, &g, dR);
    for (int r = 0; j->d_R && r < 9 * t->J; r++)
        j->d_R[i * 9 * t->J + r] += (lt_real)dR[r];
    if (j->d_shape)
        unrest(t, g.rest, j->d_shape + i * t->S);
}

static void give_coefficients(const lt_skin_tables *t, const lt_real *d_coef, lt_real *d_R, lt_real *d_shape)
{
    for (int k = 0; d_shape && k < t->S; k++)
        d_shape[k] += d_coef[1 + k];
    for (int k = 0; d_R && k < t->P; k++)
        d_R[9 + k] += d_coef[1 + t->S + k];
}

void lt_skin_backward(const lt_skin_layer *layer, int64_t n, const lt_real *R, const lt_real *d_vertices,
                      const lt_real *d_points, lt_real *d_R, lt_real *d_shape, void *scratch)
{
    const lt_skin_tables *t = &layer->t;
    const int64_t stride = skin_stride(layer);
    backward_job j = { layer, R, d_vertices, d_points, d_R, d_shape, scratch };
    skin_sample s;

    if (n == 0)
        return;                         /* there may be no scratch */
    s = skin_sample_at(layer, scratch, 0);
    lt_parallel_for(n, unpose_sample, &j);
    lt_gemm(LT_NO_TRANS, LT_TRANS, n, layer->blends, layer->columns, s.posed, stride, t->blend, layer->columns, false,
            s.coef, stride, NULL);
    for (int64_t i = 0; i < n; i++)
        give_coefficients(t, s.coef + i * stride, d_R ? d_R + i * 9 * t->J : NULL, d_shape ? d_shape + i * t->S : NULL);
}
