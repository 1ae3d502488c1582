/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The hand layer that networks learn through. The wrist stands at the origin:
 *
 *   posed_i = template_i + sum of c_k blend_k,i         c = beta (10), then R_k - I (135)
 *   A_k, p_k                                            frames of the joints, p_0 = 0
 *   v_i = sum of w_ik (A_k posed_i + s_k)               s_k = p_k - A_k rest_k
 *
 * Everything over vertices is one row per coordinate, so that the loops run along contiguous memory; what
 * is over joints is small, and in double.
 */
#include "libtensor/geometry/hand_layer.h"

#include "libtensor/geometry/hand_chain.h"
#include "libtensor/geometry/mat3.h"

enum {
    V = LT_HAND_VERTICES, PAD = LT_HAND_PADDED, J = LT_HAND_JOINTS, B = LT_HAND_BETAS,
    BLENDS = LT_HAND_BETAS + LT_HAND_POSE_FEATURES,
};

struct lt_hand_layer {
    lt_real blend[BLENDS][3][PAD];      /* shape directions, then pose directions */
    lt_real template[3][PAD];
    lt_real weight[J][PAD];
    double rest[J][3], rest_beta[J][3][B];      /* rest joints, and how they follow beta */
    int tips[5];
};

/* ---- rows ---------------------------------------------------------------------------------------- */

/* out += sum of coef_k row_k, for n rows of PAD numbers that are `stride` apart */
static void add_rows(int n, const lt_real *coef, const lt_real *restrict row, size_t stride,
                     lt_real *restrict out)
{
    int k = 0;

    for (; k + 4 <= n; k += 4, row += 4 * stride) {     /* out is loaded and stored once for four */
        const lt_real *r1 = row + stride, *r2 = r1 + stride, *r3 = r2 + stride;
        const lt_real c0 = coef[k], c1 = coef[k + 1], c2 = coef[k + 2], c3 = coef[k + 3];
        for (int i = 0; i < PAD; i++)
            out[i] += c0 * row[i] + c1 * r1[i] + (c2 * r2[i] + c3 * r3[i]);
    }
    for (; k < n; k++, row += stride)
        for (int i = 0; i < PAD; i++)
            out[i] += coef[k] * row[i];
}

/* out_k += row_k . x: the transpose of add_rows. Four sums at a time hide the latency of each; the order
 * within one is the compiler's, the same in every run of a build. */
static void dot_rows(int n, const lt_real *restrict row, size_t stride, const lt_real *restrict x,
                     lt_real *restrict out)
{
    int k = 0;

    for (; k + 4 <= n; k += 4, row += 4 * stride) {
        const lt_real *r1 = row + stride, *r2 = r1 + stride, *r3 = r2 + stride;
        lt_real s0 = 0, s1 = 0, s2 = 0, s3 = 0;
        #pragma omp simd reduction(+ : s0, s1, s2, s3)
        for (int i = 0; i < PAD; i++) {
            s0 += row[i] * x[i];
            s1 += r1[i] * x[i];
            s2 += r2[i] * x[i];
            s3 += r3[i] * x[i];
        }
        out[k] += s0;
        out[k + 1] += s1;
        out[k + 2] += s2;
        out[k + 3] += s3;
    }
    for (; k < n; k++, row += stride) {
        lt_real sum = 0;
        #pragma omp simd reduction(+ : sum)
        for (int i = 0; i < PAD; i++)
            sum += row[i] * x[i];
        out[k] += sum;
    }
}

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

lt_status lt_hand_layer_new(lt_arena *arena, const lt_hand_model *model, const int tips[5],
                            lt_hand_layer **out)
{
    lt_hand_layer *layer;

    for (int i = 0; i < 5; i++)
        if (tips[i] < 0 || tips[i] >= V)
            return lt_error(LT_EINVAL, "hand layer: finger tip %d is vertex %d, want 0 to %d", i, tips[i],
                            V - 1);
    layer = lt_arena_alloc(arena, sizeof(*layer));
    if (!layer)
        return lt_error(LT_ENOMEM, "hand layer: no memory for %zu bytes", sizeof(*layer));
    for (int i = 0; i < V; i++)
        lay_vertex(layer, model, i);
    for (int j = 0; j < J; j++)
        lay_joint(layer, model, j);
    memcpy(layer->tips, tips, sizeof(layer->tips));
    *out = layer;
    return LT_OK;
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

static void pose_vertices(const lt_hand_layer *layer, const lt_real *R, const lt_real *beta,
                          lt_real posed[3][PAD])
{
    lt_real coef[BLENDS];

    memcpy(coef, beta, B * sizeof(*coef));
    for (int k = 0; k < LT_HAND_POSE_FEATURES; k++)
        coef[B + k] = R[9 + k] - (k % 9 % 4 == 0);
    memcpy(posed, layer->template, sizeof(layer->template));
    for (int a = 0; a < 3; a++)
        add_rows(BLENDS, coef, layer->blend[0][a], 3 * PAD, posed[a]);
}

/* The twelve numbers of each vertex's transformation: joints' frames, weighted */
static void blend_frames(const lt_hand_layer *layer, lt_hand_scratch *s)
{
    lt_real coef[12][J];

    for (int k = 0; k < J; k++) {
        double turned[3];
        lt_mat3_mulvec(s->world_R[k], s->rest[k], turned);
        for (int r = 0; r < 9; r++)
            coef[r][k] = (lt_real)s->world_R[k][r];
        for (int a = 0; a < 3; a++)
            coef[9 + a][k] = (lt_real)(s->world_t[k][a] - turned[a]);
    }
    memset(s->skin, 0, sizeof(s->skin));
    for (int r = 0; r < 12; r++)
        add_rows(J, coef[r], layer->weight[0], PAD, s->skin[r]);
}

static void skin_vertices(const lt_hand_scratch *s, lt_real *vertices)
{
    for (int i = 0; i < V; i++) {
        const lt_real x = s->posed[0][i], y = s->posed[1][i], z = s->posed[2][i];
        for (int a = 0; a < 3; a++)
            vertices[3 * i + a] = s->skin[3 * a][i] * x + s->skin[3 * a + 1][i] * y
                                + s->skin[3 * a + 2][i] * z + s->skin[9 + a][i];
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

void lt_hand_layer_forward(const lt_hand_layer *layer, const lt_real *R, const lt_real *beta,
                           lt_real *vertices, lt_real *keypoints, lt_hand_scratch *scratch)
{
    const double origin[3] = { 0 };
    double R_wide[9 * J];

    widen(R, 9 * J, R_wide);
    rest_joints(layer, beta, scratch->rest);
    lt_hand_chain(scratch->rest, R_wide, origin, scratch->world_R, scratch->world_t);
    pose_vertices(layer, R, beta, scratch->posed);
    blend_frames(layer, scratch);
    skin_vertices(scratch, vertices);
    gather_keypoints(layer, scratch, vertices, keypoints);
}

/* ---- backward ------------------------------------------------------------------------------------- */

/* Gradients of the joints' frames and rest places. */
typedef struct {
    double A[J][9], p[J][3], rest[J][3];
} joint_grads;

/* Keypoints are joints or vertices: their gradients join those of what they are. dv goes where the
 * translations of skin were, which backward does not ask for. */
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
    lt_real sum[12][J] = { { 0 } };     /* as in blend_frames */

    for (int r = 0; r < 12; r++)
        dot_rows(J, layer->weight[0], PAD, s->skin[r], sum[r]);
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

/* Through the blended offsets: coefficients below 10 are beta, the others R_k - I */
static void unblend_offsets(const lt_hand_layer *layer, lt_real d_posed[3][PAD], lt_real *d_R,
                            lt_real *d_beta)
{
    lt_real d_coef[BLENDS] = { 0 };

    for (int a = 0; a < 3; a++)
        dot_rows(BLENDS, layer->blend[0][a], 3 * PAD, d_posed[a], d_coef);
    for (int k = 0; k < B; k++)
        d_beta[k] += d_coef[k];
    for (int k = B; k < BLENDS; k++)
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

void lt_hand_layer_backward(const lt_hand_layer *layer, const lt_real *R, const lt_real *d_vertices,
                            const lt_real *d_keypoints, lt_real *d_R, lt_real *d_beta,
                            lt_hand_scratch *scratch)
{
    joint_grads g = { .p = { { 0 } } };
    double R_wide[9 * J], dR[9 * J];

    widen(R, 9 * J, R_wide);
    spread_gradients(layer, d_vertices, d_keypoints, scratch->skin + 9, &g);
    unskin_vertices(scratch);
    unblend_frames(layer, scratch, &g);
    unchain(R_wide, scratch, &g, dR);
    for (int i = 0; i < 9 * J; i++)
        d_R[i] += (lt_real)dR[i];
    unblend_offsets(layer, scratch->posed, d_R, d_beta);
    unrest(layer, g.rest, d_beta);
}
