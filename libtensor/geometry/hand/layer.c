/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The hand layer that networks learn through. The wrist stands at the origin:
 *
 *   posed_i = sum of c_k blend_k,i                      c = 1 for the template, beta (10), then R_k - I (135)
 *   A_k, p_k                                            frames of the joints, p_0 = 0
 *   v_i = sum of w_ik (A_k posed_i + s_k)               s_k = p_k - A_k rest_k
 *
 * Vertices go by groups, each coordinate a whole vector; what is over joints is small, and in double. The sum over
 * blends is a product for all samples, as their table is more than a megabyte. A task makes some groups of many samples
 * and skins them at once: they stay with its thread.
 */
#include "libtensor/geometry/hand/layer.h"

#include "libtensor/base/parallel.h"
#include "libtensor/geometry/hand/chain.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/kernels/gemm/gemm.h"
#include "libtensor/kernels/gemm/tiles.h"

enum {
    V = LT_HAND_VERTICES, PAD = LT_HAND_PADDED, J = LT_HAND_JOINTS, B = LT_HAND_BETAS, POSE = LT_HAND_POSE_FEATURES,
    BLENDS = LT_HAND_BLENDS,
    SAMPLE = sizeof(lt_hand_scratch) / sizeof(lt_real),     /* from one sample's numbers to the next one's */
    GROUPS = LT_HAND_GROUPS, GROUP = LT_HAND_GROUP, COLUMNS = 3 * GROUP,
    PIECE = 8, PIECES = (GROUPS + PIECE - 1) / PIECE,       /* groups of a task, */
    BAND = 64,                                              /* and samples */
    FEW = 4, FEW_FOR_TILES = 16,                            /* samples that are no product's worth */
};
_Static_assert((int)GROUP == (int)LT_SKIN_GROUP, "groups are the kernels'");

struct lt_hand_layer {
    lt_hand_vertices blend[BLENDS];     /* the template, shape directions, pose directions */
    lt_real *packed[PIECES];            /* the same as products read it ... */
    lt_isa isa;                         /* ... with this instruction set */
    lt_real weight[J][PAD];
    lt_skin skin[GROUPS];               /* the same weights without most of the zeros */
    double rest[J][3], rest_beta[B][J][3];      /* rest joints, and how they follow beta */
    int tips[5];
};

/* ---- layout --------------------------------------------------------------------------------------- */

static void lay_vertex(lt_hand_layer *layer, const lt_hand_model *m, int i)
{
    const int g = i / GROUP, lane = i % GROUP;

    for (int a = 0; a < 3; a++) {
        layer->blend[0].group[g][a][lane] = m->v_template[i][a];
        for (int k = 0; k < B; k++)
            layer->blend[1 + k].group[g][a][lane] = m->shapedirs[i][a][k];
        for (int k = 0; k < POSE; k++)
            layer->blend[1 + B + k].group[g][a][lane] = m->posedirs[i][a][k];
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
                layer->rest_beta[k][j][a] += w * m->shapedirs[i][a][k];
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

/* A piece of the vertices: its first group, and how many */
typedef struct { int first, groups; } piece;

static piece piece_at(int64_t i)
{
    const int first = (int)i * PIECE;

    return (piece){ first, GROUPS - first < PIECE ? GROUPS - first : PIECE };
}

static int64_t packed_count(int64_t columns)
{
    return lt_k->gemm_tiles ? lt_gemm_tiles_packed(columns, BLENDS) : lt_gemm_packed_count(columns, BLENDS);
}

static bool pack_piece(lt_hand_layer *layer, lt_arena *arena, int i)
{
    const piece p = piece_at(i);
    const int64_t columns = p.groups * COLUMNS;

    layer->packed[i] = lt_arena_array(arena, (size_t)packed_count(columns), sizeof(lt_real));
    if (layer->packed[i])
        (lt_k->gemm_tiles ? lt_gemm_tiles_pack : lt_gemm_pack)(
            LT_NO_TRANS, columns, BLENDS, layer->blend[0].group[p.first][0], GROUPS * COLUMNS, layer->packed[i]);
    return layer->packed[i];
}

lt_status lt_hand_layer_new(lt_arena *arena, const lt_hand_model *model, const int tips[5],
                            lt_hand_layer **out)
{
    lt_hand_layer *layer;
    bool whole;

    for (int i = 0; i < 5; i++)
        if (tips[i] < 0 || tips[i] >= V)
            return lt_error(LT_EINVAL, "hand layer: finger tip %d is vertex %d, want 0 to %d", i, tips[i],
                            V - 1);
    if (lt_kernels_init())                  /* its tables are packed for the kernels that will read them */
        return lt_last_status();
    layer = lt_arena_alloc(arena, sizeof(*layer));
    whole = layer;
    for (int i = 0; whole && i < V; i++)
        lay_vertex(layer, model, i);
    for (int i = 0; whole && i < PIECES; i++)
        whole = pack_piece(layer, arena, i);
    if (!whole)
        return lt_error(LT_ENOMEM, "hand layer: no memory for its tables");
    for (int j = 0; j < J; j++)
        lay_joint(layer, model, j);
    for (int i = 0; i < GROUPS; i++)
        lay_group(&layer->skin[i], layer->weight, i * GROUP);
    memcpy(layer->tips, tips, sizeof(layer->tips));
    layer->isa = lt_k->isa;
    *out = layer;
    return LT_OK;
}

lt_hand_tables lt_hand_layer_tables(const lt_hand_layer *layer)
{
    return (lt_hand_tables){
        .blend = layer->blend, .weight = layer->weight, .rest = layer->rest,
        .rest_beta = layer->rest_beta, .tips = layer->tips,
    };
}

/* ---- forward -------------------------------------------------------------------------------------- */

static void rest_joints(const lt_hand_layer *layer, const lt_real *beta, double rest[J][3])
{
    double sum[3 * J];

    memcpy(sum, layer->rest, sizeof(sum));
    for (int k = 0; k < B; k++) {
        const double *direction = layer->rest_beta[k][0], coef = beta[k];

        for (int i = 0; i < 3 * J; i++)
            sum[i] += direction[i] * coef;
    }
    memcpy(rest, sum, sizeof(sum));
}

static void fill_coefficients(const lt_real *R, const lt_real *beta, lt_real coef[BLENDS])
{
    coef[0] = 1;
    memcpy(coef + 1, beta, B * sizeof(*coef));
    memcpy(coef + 1 + B, R + 9, POSE * sizeof(*coef));
    for (lt_real *c = coef + 1 + B; c < coef + BLENDS; c += 9)
        c[0] -= 1, c[4] -= 1, c[8] -= 1;
}

/* A_k, then s_k, of each joint */
static void find_frames(lt_hand_scratch *s)
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

static void widen(const lt_real *R, double out[9 * J])
{
    for (int i = 0; i < 9 * J; i++)
        out[i] = R[i];
}

typedef struct {
    const lt_hand_layer *layer;
    int64_t n;
    const lt_real *R, *beta;
    lt_real *vertices, *keypoints;
    lt_hand_scratch *scratch;
} forward_job;

/* All that is over joints */
static void pose_sample(void *ctx, int64_t i)
{
    const forward_job *j = ctx;
    const lt_real *R = j->R + i * 9 * J, *beta = j->beta + i * B;
    const double origin[3] = { 0 };
    lt_real *keypoints = j->keypoints + i * 3 * LT_HAND_KEYPOINTS;
    lt_hand_scratch *s = j->scratch + i;
    double R_wide[9 * J];

    widen(R, R_wide);
    rest_joints(j->layer, beta, s->rest);
    lt_hand_chain(s->rest, R_wide, origin, s->world_R, s->world_t);
    find_frames(s);
    fill_coefficients(R, beta, s->coef);
    for (int k = 0; k < J; k++)
        for (int a = 0; a < 3; a++)
            keypoints[3 * lt_simple_to_mano[k] + a] = (lt_real)s->world_t[k][a];
}

/* posed = coefficients times blends, of n samples: the same chain of multiply-adds each way, but by tiles */
static void blend_piece(const lt_hand_layer *layer, int64_t index, int64_t n, lt_hand_scratch *s)
{
    const piece p = piece_at(index);
    const int64_t columns = p.groups * COLUMNS, row = GROUPS * COLUMNS;
    const lt_real *blend = layer->blend[0].group[p.first][0], *packed = layer->packed[index];
    lt_real *posed = s->posed.group[p.first][0];

    if (n < (lt_k->gemm_tiles ? FEW_FOR_TILES : FEW))
        for (int64_t i = 0; i < n; i++)
            lt_k->combine(posed + i * SAMPLE, blend, row, s[i].coef, BLENDS, (size_t)columns, false);
    else if (layer->isa != lt_k->isa)
        lt_gemm(LT_NO_TRANS, LT_NO_TRANS, n, columns, BLENDS, s->coef, SAMPLE, blend, row, false, posed, SAMPLE, NULL);
    else if (lt_k->gemm_tiles)
        lt_gemm_tiles(n, columns, BLENDS, s->coef, SAMPLE, packed, false, posed, SAMPLE, NULL);
    else
        lt_gemm_packed(LT_NO_TRANS, n, columns, BLENDS, s->coef, SAMPLE, packed, false, posed, SAMPLE, NULL);
}

static void skin_piece(const forward_job *j, int64_t index, int64_t sample)
{
    const lt_hand_layer *layer = j->layer;
    const piece p = piece_at(index);
    const int first = p.first * GROUP, n = (int)lt_min_i64(p.groups * GROUP, V - first);
    const lt_hand_scratch *s = j->scratch + sample;
    lt_real *vertices = j->vertices + 3 * (sample * V + first);
    lt_real *keypoints = j->keypoints + sample * 3 * LT_HAND_KEYPOINTS;

    lt_k->skin(vertices, NULL, 0, s->posed.group[p.first][0], layer->skin + p.first, n, s->frame);
    for (int i = 0; i < 5; i++)
        if (layer->tips[i] >= first && layer->tips[i] < first + n)
            memcpy(keypoints + 3 * lt_simple_to_mano[J + i], vertices + 3 * (layer->tips[i] - first),
                   3 * sizeof(lt_real));
}

/* A piece of some samples */
static void run_piece(void *ctx, int64_t task)
{
    const forward_job *j = ctx;
    const int64_t index = task % PIECES, from = task / PIECES * BAND, to = lt_min_i64(j->n, from + BAND);

    blend_piece(j->layer, index, to - from, j->scratch + from);
    for (int64_t i = from; i < to; i++)
        skin_piece(j, index, i);
}

void lt_hand_layer_forward(const lt_hand_layer *layer, int64_t n, const lt_real *R, const lt_real *beta,
                           lt_real *vertices, lt_real *keypoints, lt_hand_scratch *scratch)
{
    forward_job j = { layer, n, R, beta, vertices, keypoints, scratch };

    lt_parallel_for(n, pose_sample, &j);
    lt_parallel_for(PIECES * lt_ceil_div(n, BAND), run_piece, &j);
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

/* In one sweep, in place: skin's matrix of each vertex becomes dv posed^T, posed becomes its gradient
 * skin^T dv. */
static void unskin_group(lt_hand_scratch *s, int g)
{
    lt_real (*posed)[GROUP] = s->posed.group[g], (*dv)[PAD] = s->skin + 9;

    for (int lane = 0, i = g * GROUP; lane < GROUP; lane++, i++) {
        lt_real x[3], dx[3] = { 0 };
        for (int b = 0; b < 3; b++)
            x[b] = posed[b][lane];
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) {
                dx[b] += s->skin[3 * a + b][i] * dv[a][i];
                s->skin[3 * a + b][i] = dv[a][i] * x[b];
            }
        for (int b = 0; b < 3; b++)
            posed[b][lane] = dx[b];
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

static void give_coefficients(const lt_real *d_coef, lt_real *d_R, lt_real *d_beta)
{
    for (int k = 0; d_beta && k < B; k++)
        d_beta[k] += d_coef[1 + k];
    for (int k = 0; d_R && k < POSE; k++)
        d_R[9 + k] += d_coef[1 + B + k];
}

static void unrest(const lt_hand_layer *layer, double d_rest[J][3], lt_real *d_beta)
{
    for (int k = 0; k < B; k++) {
        double sum = 0;
        for (int j = 0; j < J; j++)
            for (int a = 0; a < 3; a++)
                sum += layer->rest_beta[k][j][a] * d_rest[j][a];
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

    widen(j->R + i * 9 * J, R_wide);
    spread_gradients(j->layer, j->d_vertices ? j->d_vertices + i * 3 * V : NULL,
                     j->d_keypoints ? j->d_keypoints + i * 3 * LT_HAND_KEYPOINTS : NULL, s->skin + 9, &g);
    lt_k->skin(NULL, s->skin[0], PAD, s->posed.group[0][0], j->layer->skin, V, s->frame);
    for (int group = 0; group < GROUPS; group++)
        unskin_group(s, group);
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
    lt_gemm(LT_NO_TRANS, LT_TRANS, n, BLENDS, 3 * PAD, scratch->posed.group[0][0], SAMPLE,
            layer->blend[0].group[0][0], 3 * PAD, false, scratch->coef, SAMPLE, NULL);
    for (int64_t i = 0; i < n; i++)
        give_coefficients(scratch[i].coef, d_R ? d_R + i * 9 * J : NULL, d_beta ? d_beta + i * B : NULL);
}
