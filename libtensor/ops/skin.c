/* SPDX-License-Identifier: Apache-2.0 */
/* skin: linear blend skinning.                                    [Loper et al. 2015, "SMPL", equations 2 to 10]
 *   rotations (B, J, 3, 3)   shape (B, S)   ->   vertices (B, V, 3), points (B, n_points, 3)
 *
 * The formula and its gradient are in libtensor/geometry/skin; here is what it is in ONNX.
 */
#include "libtensor/ops/common.h"

enum { ROTATIONS, SHAPE };
enum { VERTICES, POINTS };

typedef struct {
    const lt_skin_layer *layer;
} skin_attr;

static const lt_skin_layer *layer_of(const lt_call *c)
{
    return ((const skin_attr *)c->attr)->layer;
}

static lt_status infer(lt_call *c)
{
    const lt_skin_tables t = lt_skin_layer_tables(layer_of(c));
    int64_t B;

    if (lt_want_rank(c, ROTATIONS, "rotations", 4))
        return LT_ESHAPE;
    B = lt_dim(c->in[ROTATIONS], 0);
    if (lt_want_shape(c, ROTATIONS, "rotations", LT_SHAPE(B, t.J, 3, 3))
        || lt_want_shape(c, SHAPE, "shape", LT_SHAPE(B, t.S)))
        return LT_ESHAPE;
    c->outs[VERTICES]->shape = LT_SHAPE(B, t.V, 3);
    c->outs[POINTS]->shape = LT_SHAPE(B, t.n_points, 3);
    return LT_OK;
}

static void plan(lt_call *c)
{
    const size_t bytes = lt_skin_scratch_bytes(layer_of(c), lt_dim(c->in[SHAPE], 0));

    if (c->train)
        c->saved_bytes[0] = bytes;
    else
        c->work_bytes = bytes;
}

static void *scratch(const lt_call *c)
{
    return c->train ? c->saved[0] : c->work;
}

static void forward(const lt_call *c)
{
    lt_skin_forward(layer_of(c), lt_dim(c->in[SHAPE], 0), c->in[ROTATIONS]->data, c->in[SHAPE]->data,
                    c->outs[VERTICES]->data, c->outs[POINTS]->data, scratch(c));
}

static void backward(const lt_call *c)
{
    lt_skin_backward(layer_of(c), lt_dim(c->in[SHAPE], 0), c->in[ROTATIONS]->data, c->douts[VERTICES],
                     c->douts[POINTS], c->din[ROTATIONS], c->din[SHAPE], scratch(c));
}

/* ---- in ONNX: the formula again, in the words of geometry/skin/internal.h ---------------------------------- */

/* Joints by their distance from the root: those of a level have their parents in the one before. */
typedef struct {
    int count;
    int joint[LT_RIG_JOINTS], place[LT_RIG_JOINTS];     /* place[joint[i]] = i */
    int first[LT_RIG_JOINTS + 1];                       /* of each level */
} levels;

static int steps_to_root(const int *parents, int j)
{
    int steps = 0;

    for (int k = parents[j]; k >= 0; k = parents[k])
        steps++;
    return steps;
}

static levels joint_levels(const lt_skin_tables *t)
{
    levels l = { .count = 0 };

    for (int n = 0; n < t->J; l.count++) {
        l.first[l.count] = n;
        for (int j = 0; j < t->J; j++) {
            if (steps_to_root(t->parents, j) != l.count)
                continue;
            l.place[j] = n;
            l.joint[n++] = j;
        }
    }
    l.first[l.count] = t->J;
    return l;
}

/* A constant of n numbers, laid out by fill */
static const char *table(lt_onnx *w, const lt_skin_tables *t, lt_shape shape,
                         void (*fill)(const lt_skin_tables *t, lt_real *y))
{
    lt_real *y = lt_alloc((size_t)lt_shape_numel(&shape) * sizeof(*y));
    const char *value;

    if (!y) {
        lt_onnx_refuse(w, "no memory");
        return "";
    }
    fill(t, y);
    value = lt_onnx_numbers(w, shape, y);
    lt_release(y);
    return value;
}

static void fill_directions(const lt_skin_tables *t, int first, int n, lt_real *y)
{
    for (int64_t k = first; k < first + n; k++)
        for (int a = 0; a < 3; a++)
            for (int64_t i = 0; i < t->V; i++)
                *y++ = t->blend[((k * t->groups + i / LT_SKIN_GROUP) * 3 + a) * LT_SKIN_GROUP + i % LT_SKIN_GROUP];
}

static void fill_blend(const lt_skin_tables *t, lt_real *y)         /* (S + P, 3 V) */
{
    fill_directions(t, 1, t->S + t->P, y);
}

static void fill_mean(const lt_skin_tables *t, lt_real *y)          /* (3 V) */
{
    fill_directions(t, 0, 1, y);
}

static void fill_weight(const lt_skin_tables *t, lt_real *y)        /* (J, V), joints by level */
{
    const levels l = joint_levels(t);

    for (int i = 0; i < t->J; i++)
        memcpy(y + (int64_t)i * t->V, t->weight + l.joint[i] * t->padded, (size_t)t->V * sizeof(*y));
}

static void fill_rest(const lt_skin_tables *t, lt_real *y)          /* (3 J) */
{
    for (int i = 0; i < 3 * t->J; i++)
        y[i] = (lt_real)t->rest[i / 3][i % 3];
}

static void fill_rest_shape(const lt_skin_tables *t, lt_real *y)    /* (S, 3 J) */
{
    for (int i = 0; i < 3 * t->S * t->J; i++)
        y[i] = (lt_real)t->rest_shape[i / 3][i % 3];
}

/* R_k - I of the joints behind the root: (B, P) */
static const char *pose_coefficients(lt_onnx *w, const lt_skin_tables *t, const char *R)
{
    lt_real eye[9 * LT_RIG_JOINTS];
    const char *c;

    for (int i = 0; i < t->P; i++)
        eye[i] = i % 9 % 4 == 0;
    c = lt_onnx_reshape(w, lt_onnx_slice(w, R, 1, 1, t->J - 1), LT_SHAPE(-1, t->P));
    return LT_ONNX(w, "Sub", c, lt_onnx_numbers(w, LT_SHAPE(t->P), eye));
}

/* posed_i = mean_i + sum of c_k blend_k,i, c = shape, then R_k - I: (B, 1, 3, V) */
static const char *posed_vertices(lt_onnx *w, const lt_skin_tables *t, const char *R, const char *shape)
{
    const char *c = shape, *y;

    if (t->P) {
        c = LT_ONNX(w, "Concat", shape, pose_coefficients(w, t, R));
        lt_onnx_int(w, "axis", 1);
    }
    y = LT_ONNX(w, "MatMul", c, table(w, t, LT_SHAPE(t->S + t->P, 3 * t->V), fill_blend));
    y = LT_ONNX(w, "Add", y, table(w, t, LT_SHAPE(3 * t->V), fill_mean));
    return lt_onnx_reshape(w, y, LT_SHAPE(-1, 1, 3, t->V));
}

/* Joints before posing (B, J, 3, 1) */
static const char *rest_joints(lt_onnx *w, const lt_skin_tables *t, const char *shape)
{
    const char *y = LT_ONNX(w, "MatMul", shape, table(w, t, LT_SHAPE(t->S, 3 * t->J), fill_rest_shape));

    y = LT_ONNX(w, "Add", y, table(w, t, LT_SHAPE(3 * t->J), fill_rest));
    return lt_onnx_reshape(w, y, LT_SHAPE(-1, t->J, 3, 1));
}

/* Frames of the joints: A (B, n, 3, 3), p (B, n, 3, 1) */
typedef struct {
    const char *A, *p;
} frames;

/* A_k = A_parent R_k, p_k = p_parent + A_parent (rest_k - rest_parent), for all joints of a level */
static frames next_level(lt_onnx *w, const int *parents, const levels *l, int depth, frames above, const char *R,
                         const char *rest)
{
    const int first = l->first[depth], n = l->first[depth + 1] - first, *joint = l->joint + first;
    int parent[LT_RIG_JOINTS], place[LT_RIG_JOINTS];
    const char *A, *bone;
    frames f;

    for (int i = 0; i < n; i++) {
        parent[i] = parents[joint[i]];
        place[i] = l->place[parent[i]] - l->first[depth - 1];
    }
    A = lt_onnx_gather(w, above.A, 1, place, n);
    bone = LT_ONNX(w, "Sub", lt_onnx_gather(w, rest, 1, joint, n), lt_onnx_gather(w, rest, 1, parent, n));
    f.A = LT_ONNX(w, "MatMul", A, lt_onnx_gather(w, R, 1, joint, n));
    f.p = LT_ONNX(w, "Add", lt_onnx_gather(w, above.p, 1, place, n), LT_ONNX(w, "MatMul", A, bone));
    return f;
}

/* From the root, which stands at the origin, to the tips: all J, by level */
static frames joint_frames(lt_onnx *w, const int *parents, const levels *l, const char *R, const char *rest)
{
    frames f = { .A = lt_onnx_slice(w, R, 1, 0, 1) };
    const char *A[LT_RIG_JOINTS], *p[LT_RIG_JOINTS];

    f.p = LT_ONNX(w, "Mul", lt_onnx_slice(w, rest, 1, 0, 1), lt_onnx_number(w, 0));
    A[0] = f.A;
    p[0] = f.p;
    for (int depth = 1; depth < l->count; depth++) {
        f = next_level(w, parents, l, depth, f, R, rest);
        A[depth] = f.A;
        p[depth] = f.p;
    }
    f.A = lt_onnx_put(w, "Concat", A, l->count);
    lt_onnx_int(w, "axis", 1);
    f.p = lt_onnx_put(w, "Concat", p, l->count);
    lt_onnx_int(w, "axis", 1);
    return f;
}

/* v_i = sum of w_ik (A_k posed_i + s_k), s_k = p_k - A_k rest_k: (B, V, 3) */
static const char *skinned(lt_onnx *w, const lt_skin_tables *t, const levels *l, frames f, const char *rest,
                           const char *posed)
{
    const char *s, *M, *v;

    s = LT_ONNX(w, "MatMul", f.A, lt_onnx_gather(w, rest, 1, l->joint, t->J));
    M = LT_ONNX(w, "Concat", f.A, LT_ONNX(w, "Sub", f.p, s));
    lt_onnx_int(w, "axis", 3);
    M = lt_onnx_transpose(w, lt_onnx_reshape(w, M, LT_SHAPE(-1, t->J, 12)), (int[]){ 0, 2, 1 }, 3);
    M = LT_ONNX(w, "MatMul", M, table(w, t, LT_SHAPE(t->J, t->V), fill_weight));
    M = lt_onnx_reshape(w, M, LT_SHAPE(-1, 3, 4, t->V));
    v = lt_onnx_sum(w, LT_ONNX(w, "Mul", lt_onnx_slice(w, M, 2, 0, 3), posed), 2, true);
    v = LT_ONNX(w, "Add", v, lt_onnx_slice(w, M, 2, 3, 1));
    return lt_onnx_transpose(w, lt_onnx_reshape(w, v, LT_SHAPE(-1, 3, t->V)), (int[]){ 0, 2, 1 }, 3);
}

/* Joints p (B, J, 3, 1), by level, and vertices v (B, V, 3) that are points */
static const char *points_of(lt_onnx *w, const lt_skin_tables *t, const levels *l, const char *p, const char *v,
                             int *index)
{
    int *vertex = index + t->n_points, n = 0;
    const char *joints = lt_onnx_reshape(w, p, LT_SHAPE(-1, t->J, 3)), *all = joints;

    for (int i = 0; i < t->n_points; i++) {
        const int point = t->points[i];

        index[i] = point < t->J ? l->place[point] : t->J + n;
        if (point >= t->J)
            vertex[n++] = point - t->J;
    }
    if (n) {
        all = LT_ONNX(w, "Concat", joints, lt_onnx_gather(w, v, 1, vertex, n));
        lt_onnx_int(w, "axis", 1);
    }
    return lt_onnx_gather(w, all, 1, index, t->n_points);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const lt_skin_tables t = lt_skin_layer_tables(((const skin_attr *)n->attr)->layer);
    const char *R = lt_onnx_of(w, n->in[ROTATIONS]), *shape = lt_onnx_of(w, n->in[SHAPE]);
    const levels l = joint_levels(&t);
    const char *rest = rest_joints(w, &t, shape), *posed = posed_vertices(w, &t, R, shape), *v;
    const frames f = joint_frames(w, t.parents, &l, R, rest);
    int *index = lt_alloc(2 * (size_t)t.n_points * sizeof(*index));

    v = lt_onnx_is(w, n->outs[VERTICES], skinned(w, &t, &l, f, rest, posed));
    if (index)
        lt_onnx_is(w, n->outs[POINTS], points_of(w, &t, &l, f.p, v, index));
    else
        lt_onnx_refuse(w, "no memory");
    lt_release(index);
}

static const lt_op skin_op = {
    .name = "skin", .n_out = 2, .keeps = LT_KEEP_IN(ROTATIONS), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_skin)(const lt_skin_layer *layer, lt_tensor *R, lt_tensor *shape)
{
    const skin_attr a = { .layer = layer };

    return lt_apply(&skin_op, &a, sizeof(a), (lt_tensor *[]){ R, shape }, 2);
}
