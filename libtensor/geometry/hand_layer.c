/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The hand layer that networks learn through. The wrist stands at the origin:
 *
 *   posed_i = template_i + sum of c_k blend_k,i         c = beta (10), then R_k - I (135)
 *   A_k, p_k                                            frames of the joints, p_0 = 0
 *   v_i = sum of w_ik (A_k posed_i + s_k)               s_k = p_k - A_k rest_k
 *
 * Everything over vertices is one row per coordinate, so that the loops run along contiguous memory; what
 * is over joints is small, and in double. The sum over blends is one product for all samples, as their table
 * is more than a megabyte.
 */
#include "libtensor/geometry/hand_layer.h"

#include "libtensor/base/parallel.h"
#include "libtensor/geometry/hand_chain.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/kernels/gemm.h"

enum {
    V = LT_HAND_VERTICES, PAD = LT_HAND_PADDED, J = LT_HAND_JOINTS, B = LT_HAND_BETAS, BLENDS = LT_HAND_BLENDS,
    SAMPLE = sizeof(lt_hand_scratch) / sizeof(lt_real),     /* from one sample's numbers to the next one's */
    FEW = 4,                                                /* samples that are no product's worth ... */
    PIECES = 6, PIECE = 3 * PAD / PIECES,                   /* ... but go piece by piece */
    GROUPS = PAD / LT_SKIN_GROUP,
};

struct lt_hand_layer {
    lt_real blend[BLENDS][3][PAD];      /* shape directions, then pose directions */
    lt_real *packed;                    /* the same as a product reads it ... */
    lt_isa isa;                         /* ... with this instruction set */
    lt_real template[3][PAD];
    lt_real weight[J][PAD];
    lt_skin group[GROUPS];              /* the same weights without most of the zeros */
    double rest[J][3], rest_beta[J][3][B];      /* rest joints, and how they follow beta */
    int tips[5];
};

/* ---- layout --------------------------------------------------------------------------------------- */

static void lay_vertex(lt_hand_layer *layer, const lt_hand_model *m, int i)
{
    for (int a = 0; a < 3; a++) {
        layer->template[a][i] = m->v_template[i][a];
        for (int k = 0; k < B; k++)
            layer->blend[k][a][i] = m->shapedirs[i][a][k];
        for (int k = B; k < BLENDS; k++)
            layer->blend[k][a][i] = m->posedirs[i][a][k - B];
    }
    for (int j = 0; j < J; j++)
        layer->weight[j][i] = m->weights[i][j];
}

static void lay_joint(lt_hand_layer *layer, const lt_hand_model *m, int j)
{
    for (int i = 0; i < V; i++)
        for (int a = 0; a < 3; a++) {
            const double w = m->J_regressor[j][i];
            layer->rest[j][a] += w * m->v_template[i][a];
            for (int k = 0; k < B; k++)
                layer->rest_beta[j][a][k] += w * m->shapedirs[i][a][k];
        }
}

static void lay_group(lt_skin *g, const lt_real weight[J][PAD], int first)
{
    for (int j = 0; j < J; j++) {
        bool any = false;

        for (int i = 0; i < LT_SKIN_GROUP; i++)
            any = any || weight[j][first + i] != 0;
        if (!any)
            continue;
        g->joint[g->n] = j;
        memcpy(g->weight[g->n++], weight[j] + first, sizeof(g->weight[0]));
    }
}

lt_status lt_hand_layer_new(lt_arena *arena, const lt_hand_model *model, const int tips[5],
                            lt_hand_layer **out)
{
    lt_hand_layer *layer;

    for (int i = 0; i < 5; i++)
        if (tips[i] < 0 || tips[i] >= V)
            return lt_error(LT_EINVAL, "hand layer: finger tip %d is vertex %d, want 0 to %d", i, tips[i],
                            V - 1);
    layer = lt_arena_alloc(arena, sizeof(*layer));
    if (layer)
        layer->packed = lt_arena_array(arena, (size_t)lt_gemm_packed_count(3 * PAD, BLENDS), sizeof(lt_real));
    if (!layer || !layer->packed)
        return lt_error(LT_ENOMEM, "hand layer: no memory for its tables");
    for (int i = 0; i < V; i++)
        lay_vertex(layer, model, i);
    for (int j = 0; j < J; j++)
        lay_joint(layer, model, j);
    for (int i = 0; i < GROUPS; i++)
        lay_group(&layer->group[i], layer->weight, i * LT_SKIN_GROUP);
    memcpy(layer->tips, tips, sizeof(layer->tips));
    lt_gemm_pack(LT_NO_TRANS, 3 * PAD, BLENDS, layer->blend[0][0], 3 * PAD, layer->packed);
    layer->isa = lt_k->isa;
    *out = layer;
    return LT_OK;
}

lt_hand_tables lt_hand_layer_tables(const lt_hand_layer *layer)
{
    return (lt_hand_tables){
        .blend = layer->blend, .mean = layer->template, .weight = layer->weight, .rest = layer->rest,
        .rest_beta = layer->rest_beta, .tips = layer->tips,
    };
}

/* ---- forward -------------------------------------------------------------------------------------- */

static void rest_joints(const lt_hand_layer *layer, const lt_real *beta, double rest[J][3])
{
    for (int j = 0; j < J; j++)
        for (int a = 0; a < 3; a++) {
            rest[j][a] = layer->rest[j][a];
            for (int k = 0; k < B; k++)
                rest[j][a] += layer->rest_beta[j][a][k] * beta[k];
        }
}

static void fill_coefficients(const lt_real *R, const lt_real *beta, lt_real coef[BLENDS])
{
    memcpy(coef, beta, B * sizeof(*coef));
    for (int k = 0; k < LT_HAND_POSE_FEATURES; k++)
        coef[B + k] = R[9 + k] - (k % 9 % 4 == 0);
}

/* A_k, then s_k, of each joint */
static void find_frames(const lt_hand_scratch *s, lt_real frame[J][LT_SKIN_FRAME])
{
    for (int k = 0; k < J; k++) {
        double turned[3];
        lt_mat3_mulvec(s->world_R[k], s->rest[k], turned);
        for (int r = 0; r < 9; r++)
            frame[k][r] = (lt_real)s->world_R[k][r];
        for (int a = 0; a < 3; a++)
            frame[k][9 + a] = (lt_real)(s->world_t[k][a] - turned[a]);
    }
}

static void gather_keypoints(const lt_hand_layer *layer, const lt_hand_scratch *s,
                             const lt_real *vertices, lt_real *keypoints)
{
    for (int i = 0; i < 3 * LT_HAND_KEYPOINTS; i++) {
        const int mano = lt_mano_to_simple[i / 3], a = i % 3;
        keypoints[i] = mano < J ? (lt_real)s->world_t[mano][a] : vertices[3 * layer->tips[mano - J] + a];
    }
}

static void widen(const lt_real *x, int n, double *out)
{
    for (int i = 0; i < n; i++)
        out[i] = x[i];
}

typedef struct {
    const lt_hand_layer *layer;
    const lt_real *R, *beta;
    lt_real *vertices, *keypoints;
    lt_hand_scratch *scratch;
} forward_job;

static void pose_sample(void *ctx, int64_t i)
{
    const forward_job *j = ctx;
    const lt_real *R = j->R + i * 9 * J, *beta = j->beta + i * B;
    const double origin[3] = { 0 };
    lt_hand_scratch *s = j->scratch + i;
    double R_wide[9 * J];

    widen(R, 9 * J, R_wide);
    rest_joints(j->layer, beta, s->rest);
    lt_hand_chain(s->rest, R_wide, origin, s->world_R, s->world_t);
    fill_coefficients(R, beta, s->coef);
}

typedef struct { const lt_hand_layer *layer; lt_hand_scratch *scratch; } blend_job;

static void blend_piece(void *ctx, int64_t task)
{
    const blend_job *j = ctx;
    lt_hand_scratch *s = j->scratch + task / PIECES;
    const int64_t at = task % PIECES * PIECE;

    lt_k->combine(s->posed[0] + at, j->layer->blend[0][0] + at, 3 * PAD, s->coef, BLENDS, PIECE, false);
    lt_k->add_to(s->posed[0] + at, j->layer->template[0] + at, PIECE);
}

/* posed = template + coefficients times blends: the same chain of multiply-adds each way */
static void blend_offsets(const lt_hand_layer *layer, int64_t n, lt_hand_scratch *s)
{
    const lt_epilogue template = { .col_bias = layer->template[0] };
    blend_job j = { layer, s };

    if (n >= FEW && layer->isa == lt_k->isa)
        lt_gemm_packed(LT_NO_TRANS, n, 3 * PAD, BLENDS, s->coef, SAMPLE, layer->packed, false, s->posed[0], SAMPLE,
                       &template);
    else if (n >= FEW)
        lt_gemm(LT_NO_TRANS, LT_NO_TRANS, n, 3 * PAD, BLENDS, s->coef, SAMPLE, layer->blend[0][0], 3 * PAD, false,
                s->posed[0], SAMPLE, &template);
    else
        lt_parallel_for(PIECES * n, blend_piece, &j);
}

static void skin_sample(void *ctx, int64_t i)
{
    const forward_job *j = ctx;
    const lt_hand_scratch *s = j->scratch + i;
    lt_real *vertices = j->vertices + i * 3 * V, frame[J][LT_SKIN_FRAME];

    find_frames(s, frame);
    lt_k->skin(vertices, NULL, s->posed[0], PAD, j->layer->group, V, frame);
    gather_keypoints(j->layer, s, vertices, j->keypoints + i * 3 * LT_HAND_KEYPOINTS);
}

void lt_hand_layer_forward(const lt_hand_layer *layer, int64_t n, const lt_real *R, const lt_real *beta,
                           lt_real *vertices, lt_real *keypoints, lt_hand_scratch *scratch)
{
    forward_job j = { layer, R, beta, vertices, keypoints, scratch };

    lt_parallel_for(n, pose_sample, &j);
    blend_offsets(layer, n, scratch);
    lt_parallel_for(n, skin_sample, &j);
}

/* ---- backward ------------------------------------------------------------------------------------- */

/* Gradients of the joints' frames and rest places. */
typedef struct {
    double A[J][9], p[J][3], rest[J][3];
} joint_grads;

/* Keypoints are joints or vertices: their gradients join those of what they are. dv goes behind
 * the vertices' matrices. */
static void spread_gradients(const lt_hand_layer *layer, const lt_real *d_vertices,
                             const lt_real *d_keypoints, lt_real dv[3][PAD], joint_grads *g)
{
    memset(dv, 0, 3 * sizeof(dv[0]));
    for (int i = 0; d_vertices && i < V; i++)
        for (int a = 0; a < 3; a++)
            dv[a][i] = d_vertices[3 * i + a];
    for (int i = 0; d_keypoints && i < 3 * LT_HAND_KEYPOINTS; i++) {
        const int mano = lt_mano_to_simple[i / 3], a = i % 3;
        if (mano < J)
            g->p[mano][a] += d_keypoints[i];
        else
            dv[a][layer->tips[mano - J]] += d_keypoints[i];
    }
}

/* Each vertex's matrix, made again */
static void blend_matrices(const lt_hand_layer *layer, lt_hand_scratch *s)
{
    lt_real frame[J][LT_SKIN_FRAME];

    find_frames(s, frame);
    lt_k->skin(NULL, s->skin[0], s->posed[0], PAD, layer->group, V, frame);
}

/* In one sweep, in place: skin's matrix of each vertex becomes dv posed^T, posed becomes its gradient
 * skin^T dv. */
static void unskin_vertices(lt_hand_scratch *s)
{
    lt_real (*dv)[PAD] = s->skin + 9;

    for (int i = 0; i < PAD; i++) {
        lt_real x[3], dx[3] = { 0 };
        for (int b = 0; b < 3; b++)
            x[b] = s->posed[b][i];
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) {
                dx[b] += s->skin[3 * a + b][i] * dv[a][i];
                s->skin[3 * a + b][i] = dv[a][i] * x[b];
            }
        for (int b = 0; b < 3; b++)
            s->posed[b][i] = dx[b];
    }
}

/* dA_k += sum of w_ik dv_i posed_i^T, and through s_k = p_k - A_k rest_k with ds_k = sum of w_ik dv_i */
static void unblend_frames(const lt_hand_layer *layer, const lt_hand_scratch *s, joint_grads *g)
{
    lt_real sum[12][J];                 /* of A_k, then of s_k */

    lt_gemm(LT_NO_TRANS, LT_TRANS, 12, J, PAD, s->skin[0], PAD, layer->weight[0], PAD, false, sum[0], J, NULL);
    for (int k = 0; k < J; k++)
        for (int a = 0; a < 3; a++) {
            const double ds = sum[9 + a][k];
            g->p[k][a] += ds;
            for (int b = 0; b < 3; b++) {
                g->A[k][3 * a + b] += sum[3 * a + b][k] - ds * s->rest[k][b];
                g->rest[k][b] -= s->world_R[k][3 * a + b] * ds;
            }
        }
}

/* From tip to wrist: A_k = A_parent R_k, p_k = p_parent + A_parent (rest_k - rest_parent) */
static void unchain(const double *R, lt_hand_scratch *s, joint_grads *g, double *dR)
{
    for (int k = J - 1; k > 0; k--) {
        const int parent = lt_hand_parent[k];
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

/* Coefficients below 10 are beta, the others R_k - I. */
static void give_coefficients(const lt_real *d_coef, lt_real *d_R, lt_real *d_beta)
{
    for (int k = 0; d_beta && k < B; k++)
        d_beta[k] += d_coef[k];
    for (int k = B; d_R && k < BLENDS; k++)
        d_R[9 + k - B] += d_coef[k];
}

static void unrest(const lt_hand_layer *layer, double d_rest[J][3], lt_real *d_beta)
{
    for (int k = 0; k < B; k++) {
        double sum = 0;
        for (int j = 0; j < J; j++)
            for (int a = 0; a < 3; a++)
                sum += layer->rest_beta[j][a][k] * d_rest[j][a];
        d_beta[k] += (lt_real)sum;
    }
}

typedef struct {
    const lt_hand_layer *layer;
    const lt_real *R, *d_vertices, *d_keypoints;
    lt_real *d_R, *d_beta;
    lt_hand_scratch *scratch;
} backward_job;

/* All but the blends, whose gradient of posed is left where posed was. */
static void unpose_sample(void *ctx, int64_t i)
{
    const backward_job *j = ctx;
    lt_hand_scratch *s = j->scratch + i;
    joint_grads g = { .p = { { 0 } } };
    double R_wide[9 * J], dR[9 * J];

    widen(j->R + i * 9 * J, 9 * J, R_wide);
    spread_gradients(j->layer, j->d_vertices ? j->d_vertices + i * 3 * V : NULL,
                     j->d_keypoints ? j->d_keypoints + i * 3 * LT_HAND_KEYPOINTS : NULL, s->skin + 9, &g);
    blend_matrices(j->layer, s);
    unskin_vertices(s);
    unblend_frames(j->layer, s, &g);
    unchain(R_wide, s, &g, dR);
    for (int r = 0; j->d_R && r < 9 * J; r++)
        j->d_R[i * 9 * J + r] += (lt_real)dR[r];
    if (j->d_beta)
        unrest(j->layer, g.rest, j->d_beta + i * B);
}

void lt_hand_layer_backward(const lt_hand_layer *layer, int64_t n, const lt_real *R, const lt_real *d_vertices,
                            const lt_real *d_keypoints, lt_real *d_R, lt_real *d_beta,
                            lt_hand_scratch *scratch)
{
    backward_job j = { layer, R, d_vertices, d_keypoints, d_R, d_beta, scratch };

    if (n == 0)
        return;                         /* there may be no scratch */
    lt_parallel_for(n, unpose_sample, &j);
    lt_gemm(LT_NO_TRANS, LT_TRANS, n, BLENDS, 3 * PAD, scratch->posed[0], SAMPLE, layer->blend[0][0], 3 * PAD,
            false, scratch->coef, SAMPLE, NULL);
    for (int64_t i = 0; i < n; i++)
        give_coefficients(scratch[i].coef, d_R ? d_R + i * 9 * J : NULL, d_beta ? d_beta + i * B : NULL);
}
