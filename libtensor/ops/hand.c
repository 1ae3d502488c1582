/* SPDX-License-Identifier: Apache-2.0 */
/* hand: the hand layer.                                           [Romero et al. 2017, "Embodied Hands"]
 *   rotations (B, 16, 3, 3)   betas (B, 10)   ->   vertices (B, 778, 3), key points (B, 21, 3)
 *
 * The formula and its gradient are libtensor/geometry/hand/layer.c; here is what it is in ONNX.
 */
#include "libtensor/ops/common.h"

enum { ROTATIONS, BETAS };
enum { VERTICES, KEYPOINTS };

typedef struct {
    const lt_hand_layer *layer;
} hand_attr;

static lt_status infer(lt_call *c)
{
    int64_t B;

    if (lt_want_rank(c, ROTATIONS, "rotations", 4))
        return LT_ESHAPE;
    B = lt_dim(c->in[ROTATIONS], 0);
    if (lt_want_shape(c, ROTATIONS, "rotations", LT_SHAPE(B, LT_HAND_JOINTS, 3, 3))
        || lt_want_shape(c, BETAS, "betas", LT_SHAPE(B, LT_HAND_BETAS)))
        return LT_ESHAPE;
    c->outs[VERTICES]->shape = LT_SHAPE(B, LT_HAND_VERTICES, 3);
    c->outs[KEYPOINTS]->shape = LT_SHAPE(B, LT_HAND_KEYPOINTS, 3);
    return LT_OK;
}

static void plan(lt_call *c)
{
    const size_t bytes = (size_t)lt_dim(c->in[BETAS], 0) * sizeof(lt_hand_scratch);

    if (c->train)
        c->saved_bytes[0] = bytes;
    else
        c->work_bytes = bytes;
}

static lt_hand_scratch *scratch(const lt_call *c)
{
    return c->train ? c->saved[0] : c->work;
}

static void forward(const lt_call *c)
{
    const hand_attr *a = c->attr;

    lt_hand_layer_forward(a->layer, lt_dim(c->in[BETAS], 0), c->in[ROTATIONS]->data, c->in[BETAS]->data,
                          c->outs[VERTICES]->data, c->outs[KEYPOINTS]->data, scratch(c));
}

static void backward(const lt_call *c)
{
    const hand_attr *a = c->attr;

    lt_hand_layer_backward(a->layer, lt_dim(c->in[BETAS], 0), c->in[ROTATIONS]->data, c->douts[VERTICES],
                           c->douts[KEYPOINTS], c->din[ROTATIONS], c->din[BETAS], scratch(c));
}

/* ---- in ONNX: the formula again, in the words of hand/layer.c --------------------------------------------- */

enum {
    V = LT_HAND_VERTICES, J = LT_HAND_JOINTS, DIRECTIONS = LT_HAND_BETAS + LT_HAND_POSE_FEATURES,
    LEVELS = 4,
};

/* Joints by their distance from the wrist: those of a level have their parents in the one before. */
typedef struct {
    int joint[J], place[J];             /* place[joint[i]] = i */
    int first[LEVELS + 1];              /* of each level */
} levels;

static levels joint_levels(void)
{
    levels l;
    int n = 0;

    for (int depth = 0; depth < LEVELS; depth++) {
        l.first[depth] = n;
        for (int j = 0; j < J; j++) {
            int steps = 0;

            for (int k = lt_hand_parent[j]; k >= 0; k = lt_hand_parent[k])
                steps++;
            if (steps != depth)
                continue;
            l.place[j] = n;
            l.joint[n++] = j;
        }
    }
    l.first[LEVELS] = n;
    return l;
}

/* A constant of n numbers, laid out by fill */
static const char *table(lt_onnx *w, const lt_hand_layer *layer, lt_shape shape,
                         void (*fill)(const lt_hand_tables *t, lt_real *y))
{
    const lt_hand_tables t = lt_hand_layer_tables(layer);
    lt_real *y = lt_alloc((size_t)lt_shape_numel(&shape) * sizeof(*y));
    const char *value;

    if (!y) {
        lt_onnx_refuse(w, "no memory");
        return "";
    }
    fill(&t, y);
    value = lt_onnx_numbers(w, shape, y);
    lt_release(y);
    return value;
}

static void fill_directions(const lt_hand_vertices *blend, int n, lt_real *y)
{
    for (int k = 0; k < n; k++)
        for (int a = 0; a < 3; a++)
            for (int i = 0; i < V; i++)
                *y++ = blend[k].group[i / LT_HAND_GROUP][a][i % LT_HAND_GROUP];
}

static void fill_blend(const lt_hand_tables *t, lt_real *y)         /* (145, 3 V) */
{
    fill_directions(t->blend + 1, DIRECTIONS, y);
}

static void fill_mean(const lt_hand_tables *t, lt_real *y)          /* (3 V) */
{
    fill_directions(t->blend, 1, y);
}

static void fill_weight(const lt_hand_tables *t, lt_real *y)        /* (16, V), joints by level */
{
    const levels l = joint_levels();

    for (int i = 0; i < J; i++)
        memcpy(y + i * V, t->weight[l.joint[i]], V * sizeof(*y));
}

static void fill_rest(const lt_hand_tables *t, lt_real *y)          /* (48) */
{
    for (int i = 0; i < 3 * J; i++)
        y[i] = (lt_real)t->rest[i / 3][i % 3];
}

static void fill_rest_beta(const lt_hand_tables *t, lt_real *y)     /* (10, 48) */
{
    for (int k = 0; k < LT_HAND_BETAS; k++)
        for (int i = 0; i < 3 * J; i++)
            y[3 * J * k + i] = (lt_real)t->rest_beta[k][i / 3][i % 3];
}

/* posed_i = mean_i + sum of c_k blend_k,i, c = beta, then R_k - I: (B, 1, 3, V) */
static const char *posed_vertices(lt_onnx *w, const lt_hand_layer *layer, const char *R, const char *beta)
{
    lt_real eye[LT_HAND_POSE_FEATURES];
    const char *c, *y;

    for (int i = 0; i < LT_HAND_POSE_FEATURES; i++)
        eye[i] = i % 9 % 4 == 0;
    c = lt_onnx_reshape(w, lt_onnx_slice(w, R, 1, 1, J - 1), LT_SHAPE(-1, LT_HAND_POSE_FEATURES));
    c = LT_ONNX(w, "Sub", c, lt_onnx_numbers(w, LT_SHAPE(LT_HAND_POSE_FEATURES), eye));
    c = LT_ONNX(w, "Concat", beta, c);
    lt_onnx_int(w, "axis", 1);
    y = LT_ONNX(w, "MatMul", c, table(w, layer, LT_SHAPE(DIRECTIONS, 3 * V), fill_blend));
    y = LT_ONNX(w, "Add", y, table(w, layer, LT_SHAPE(3 * V), fill_mean));
    return lt_onnx_reshape(w, y, LT_SHAPE(-1, 1, 3, V));
}

/* Joints before posing (B, 16, 3, 1) */
static const char *rest_joints(lt_onnx *w, const lt_hand_layer *layer, const char *beta)
{
    const char *y = LT_ONNX(w, "MatMul", beta, table(w, layer, LT_SHAPE(LT_HAND_BETAS, 3 * J), fill_rest_beta));

    y = LT_ONNX(w, "Add", y, table(w, layer, LT_SHAPE(3 * J), fill_rest));
    return lt_onnx_reshape(w, y, LT_SHAPE(-1, J, 3, 1));
}

/* Frames of the joints: A (B, n, 3, 3), p (B, n, 3, 1) */
typedef struct {
    const char *A, *p;
} frames;

/* A_k = A_parent R_k, p_k = p_parent + A_parent (rest_k - rest_parent), for all joints of a level */
static frames next_level(lt_onnx *w, const levels *l, int depth, frames above, const char *R, const char *rest)
{
    const int first = l->first[depth], n = l->first[depth + 1] - first, *joint = l->joint + first;
    int parent[J], place[J];
    const char *A, *bone;
    frames f;

    for (int i = 0; i < n; i++) {
        parent[i] = lt_hand_parent[joint[i]];
        place[i] = l->place[parent[i]] - l->first[depth - 1];
    }
    A = lt_onnx_gather(w, above.A, 1, place, n);
    bone = LT_ONNX(w, "Sub", lt_onnx_gather(w, rest, 1, joint, n), lt_onnx_gather(w, rest, 1, parent, n));
    f.A = LT_ONNX(w, "MatMul", A, lt_onnx_gather(w, R, 1, joint, n));
    f.p = LT_ONNX(w, "Add", lt_onnx_gather(w, above.p, 1, place, n), LT_ONNX(w, "MatMul", A, bone));
    return f;
}

/* From the wrist, which stands at the origin, to the tips: all 16, by level */
static frames joint_frames(lt_onnx *w, const levels *l, const char *R, const char *rest)
{
    frames f = { .A = lt_onnx_slice(w, R, 1, 0, 1) };
    const char *A[LEVELS], *p[LEVELS];

    f.p = LT_ONNX(w, "Mul", lt_onnx_slice(w, rest, 1, 0, 1), lt_onnx_number(w, 0));
    A[0] = f.A;
    p[0] = f.p;
    for (int depth = 1; depth < LEVELS; depth++) {
        f = next_level(w, l, depth, f, R, rest);
        A[depth] = f.A;
        p[depth] = f.p;
    }
    f.A = lt_onnx_put(w, "Concat", A, LEVELS);
    lt_onnx_int(w, "axis", 1);
    f.p = lt_onnx_put(w, "Concat", p, LEVELS);
    lt_onnx_int(w, "axis", 1);
    return f;
}

/* v_i = sum of w_ik (A_k posed_i + s_k), s_k = p_k - A_k rest_k: (B, V, 3) */
static const char *skinned(lt_onnx *w, const lt_hand_layer *layer, const levels *l, frames f, const char *rest,
                           const char *posed)
{
    const char *s, *M, *v;

    s = LT_ONNX(w, "MatMul", f.A, lt_onnx_gather(w, rest, 1, l->joint, J));
    M = LT_ONNX(w, "Concat", f.A, LT_ONNX(w, "Sub", f.p, s));
    lt_onnx_int(w, "axis", 3);
    M = lt_onnx_transpose(w, lt_onnx_reshape(w, M, LT_SHAPE(-1, J, 12)), (int[]){ 0, 2, 1 }, 3);
    M = LT_ONNX(w, "MatMul", M, table(w, layer, LT_SHAPE(J, V), fill_weight));
    M = lt_onnx_reshape(w, M, LT_SHAPE(-1, 3, 4, V));
    v = lt_onnx_sum(w, LT_ONNX(w, "Mul", lt_onnx_slice(w, M, 2, 0, 3), posed), 2, true);
    v = LT_ONNX(w, "Add", v, lt_onnx_slice(w, M, 2, 3, 1));
    return lt_onnx_transpose(w, lt_onnx_reshape(w, v, LT_SHAPE(-1, 3, V)), (int[]){ 0, 2, 1 }, 3);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const lt_hand_layer *layer = ((const hand_attr *)n->attr)->layer;
    const char *R = lt_onnx_of(w, n->in[ROTATIONS]), *beta = lt_onnx_of(w, n->in[BETAS]);
    const levels l = joint_levels();
    const char *rest = rest_joints(w, layer, beta), *posed = posed_vertices(w, layer, R, beta), *v, *points;
    const frames f = joint_frames(w, &l, R, rest);
    int index[LT_HAND_KEYPOINTS];

    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        index[i] = lt_mano_to_simple[i] < J ? l.place[lt_mano_to_simple[i]] : lt_mano_to_simple[i];
    v = lt_onnx_is(w, n->outs[VERTICES], skinned(w, layer, &l, f, rest, posed));
    points = lt_onnx_gather(w, v, 1, lt_hand_layer_tables(layer).tips, LT_HAND_KEYPOINTS - J);
    points = LT_ONNX(w, "Concat", lt_onnx_reshape(w, f.p, LT_SHAPE(-1, J, 3)), points);
    lt_onnx_int(w, "axis", 1);
    lt_onnx_is(w, n->outs[KEYPOINTS], lt_onnx_gather(w, points, 1, index, LT_HAND_KEYPOINTS));
}

static const lt_op hand_op = {
    .name = "hand", .n_out = 2, .keeps = LT_KEEP_IN(ROTATIONS), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_hand)(const lt_hand_layer *layer, lt_tensor *R, lt_tensor *betas)
{
    const hand_attr a = { .layer = layer };

    return lt_apply(&hand_op, &a, sizeof(a), (lt_tensor *[]){ R, betas }, 2);
}
