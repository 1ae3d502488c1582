/* SPDX-License-Identifier: Apache-2.0 */
/* attention: y = softmax(q k^T / sqrt(d)) v, head by head                [Vaswani et al. 2017, section 3.2]
 *   q (B, T, C)   k, v (B, S, C)   ->   y (B, T, C), d = C / heads
 *
 * With P = softmax(z), z = q k^T / sqrt(d), and R = dy v^T:
 *   dv += P^T dy      dz = P * (R - sum(R * P))      dq += dz k / sqrt(d)      dk += dz^T q / sqrt(d)
 * where a row's sum(R * P) is sum(dy * y).
 *
 * P never exists whole: a panel of queries meets a strip of keys at a time, and backward makes P again from
 * each row's largest score and sum. One task owns a head of an image in backward, so that dq, dk and dv
 * have one owner, which takes keys and queries in their order.
 */
#include "libtensor/ops/common.h"

enum { Q, K, V };

typedef struct {
    int heads;
} attention_attr;

typedef struct {
    int64_t B, T, S, C, d;
    int heads;
    double scale;
} sizes;

static sizes sizes_of(const lt_call *c)
{
    const attention_attr *a = c->attr;
    sizes s = {
        .B = lt_dim(c->in[Q], 0), .T = lt_dim(c->in[Q], 1), .S = lt_dim(c->in[K], 1),
        .C = lt_dim(c->in[Q], 2), .heads = a->heads,
    };

    s.d = s.C / s.heads;
    s.scale = 1 / sqrt((double)s.d);
    return s;
}

static lt_status infer(lt_call *c)
{
    const attention_attr *a = c->attr;
    lt_shape kv;

    if (lt_want_rank(c, Q, "query", 3) || lt_want_rank(c, K, "key", 3))
        return LT_ESHAPE;
    kv = LT_SHAPE(lt_dim(c->in[Q], 0), lt_dim(c->in[K], 1), lt_dim(c->in[Q], 2));
    if (lt_want_shape(c, K, "key", kv) || lt_want_shape(c, V, "value", kv))
        return LT_ESHAPE;
    if (a->heads < 1 || lt_dim(c->in[Q], 2) % a->heads)
        return lt_fail(c, "%d heads do not divide %lld channels", a->heads, (long long)lt_dim(c->in[Q], 2));
    if (kv.dim[1] < 1)
        return lt_fail(c, "there are no keys");
    return op_same_shape(c);
}

static const lt_attention_kernels *kernels_of(const sizes *s)
{
    return lt_attention_of(lt_k, s->d);
}

/* Elements of n packed rows of a head: for results, and for gradients */
static int64_t packed(const sizes *s, lt_attend_part part, int64_t n)
{
    return kernels_of(s)->packing.packed(part, n, s->d);
}

static int64_t grad_packed(const sizes *s, lt_attend_part part, int64_t n)
{
    return kernels_of(s)->grad_packing.packed(part, n, s->d);
}

/* What one task works on: one head of one image. */
typedef struct {
    sizes s;
    int64_t number, q_at, k_at;     /* of all heads; of its first element in q and in k */
} head;

static head head_of(const lt_call *c, int64_t i)
{
    const sizes s = sizes_of(c);
    const int64_t b = i / s.heads, h = i % s.heads;

    return (head){ s, i, b * s.T * s.C + h * s.d, b * s.S * s.C + h * s.d };
}

static const lt_real *at(const lt_call *c, int i, int64_t offset)
{
    return (const lt_real *)c->in[i]->data + offset;
}

/* Largest score and 1 / sum of each of a head's rows; NULL when no backward will come */
static lt_real *stats_of(const lt_call *c, const head *h)
{
    return c->train ? (lt_real *)c->saved[0] + 2 * h->number * h->s.T : NULL;
}

/* What queries are multiplied with: scores are powers of two. */
static lt_real scale_of(const sizes *s)
{
    const double log2e = 1.4426950408889634;

    return (lt_real)(s->scale * log2e);
}

/* Those of n rows from x on that lie in [from, from + LT_ATTEND_UNIT), to their place in out */
static void pack_unit(const sizes *s, lt_attend_part part, lt_real *out, const lt_real *x, int64_t from, int64_t n,
                      lt_real factor)
{
    if (from < n)
        kernels_of(s)->packing.pack(part, out + packed(s, part, from), x + from * s->C, s->C,
                                    lt_min_i64(LT_ATTEND_UNIT, n - from), s->d, factor);
}

/* ---- forward ------------------------------------------------------------------------------------------ */

static int64_t tasks_of(const sizes *s)
{
    return lt_ceil_div(s->T, kernels_of(s)->packing.queries);
}

static int64_t units_of(const sizes *s)
{
    return lt_ceil_div(lt_max_i64(s->T, s->S), LT_ATTEND_UNIT);
}

static int64_t forward_elements(const sizes *s)
{
    return packed(s, LT_ATTEND_Q, s->T) + packed(s, LT_ATTEND_K, s->S) + packed(s, LT_ATTEND_V, s->S);
}

typedef struct {
    lt_real *q, *k, *v;
} packed_head;

static packed_head packed_of(const lt_call *c, const head *h)
{
    packed_head p = { .q = (lt_real *)c->work + h->number * forward_elements(&h->s) };

    p.k = p.q + packed(&h->s, LT_ATTEND_Q, h->s.T);
    p.v = p.k + packed(&h->s, LT_ATTEND_K, h->s.S);
    return p;
}

static void pack_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const sizes s = sizes_of(c);
    const head h = head_of(c, task / units_of(&s));
    const int64_t from = task % units_of(&s) * LT_ATTEND_UNIT;
    const packed_head p = packed_of(c, &h);

    pack_unit(&s, LT_ATTEND_Q, p.q, at(c, Q, h.q_at), from, s.T, scale_of(&s));
    pack_unit(&s, LT_ATTEND_K, p.k, at(c, K, h.k_at), from, s.S, 1);
    pack_unit(&s, LT_ATTEND_V, p.v, at(c, V, h.k_at), from, s.S, 1);
}

static void forward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const sizes s = sizes_of(c);
    const head h = head_of(c, task / tasks_of(&s));
    const packed_head p = packed_of(c, &h);
    const int64_t at_once = kernels_of(&s)->packing.queries, t = task % tasks_of(&s) * at_once;
    lt_real *stats = stats_of(c, &h);

    kernels_of(&s)->attend((lt_real *)c->out->data + h.q_at + t * s.C, s.C, stats ? stats + 2 * t : NULL,
                           p.q + packed(&s, LT_ATTEND_Q, t), p.k, p.v, lt_min_i64(at_once, s.T - t), s.S, s.d);
}

static void forward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    if (s.T == 0)
        return;
    lt_parallel_for(s.B * s.heads * units_of(&s), pack_task, (void *)c);
    lt_parallel_for(s.B * s.heads * tasks_of(&s), forward_task, (void *)c);
}

/* ---- backward ----------------------------------------------------------------------------------------- */

/* A task's scratch: packed queries and gradients of results, sum(dy * y) of each row, some keys and their values. */
typedef struct {
    lt_real *q, *dy, *mean, *k, *v;
} gradient_scratch;

enum { VECTOR = LT_ALIGN / sizeof(lt_real) };           /* so that each task's scratch is aligned */

static int64_t backward_elements(const sizes *s)
{
    const int keys = kernels_of(s)->grad_packing.keys;

    return grad_packed(s, LT_ATTEND_Q, s->T) + grad_packed(s, LT_ATTEND_DY, s->T) + lt_ceil_div(s->T, VECTOR) * VECTOR
           + grad_packed(s, LT_ATTEND_K, keys) + grad_packed(s, LT_ATTEND_V, keys);
}

static gradient_scratch scratch_of(const lt_call *c, const head *h)
{
    const int keys = kernels_of(&h->s)->grad_packing.keys;
    gradient_scratch g = { .q = (lt_real *)c->work + h->number * backward_elements(&h->s) };

    g.dy = g.q + grad_packed(&h->s, LT_ATTEND_Q, h->s.T);
    g.k = g.dy + grad_packed(&h->s, LT_ATTEND_DY, h->s.T);
    g.v = g.k + grad_packed(&h->s, LT_ATTEND_K, keys);
    g.mean = g.v + grad_packed(&h->s, LT_ATTEND_V, keys);
    return g;
}

static void pack_queries(const lt_call *c, const head *h, const gradient_scratch *g)
{
    const sizes *s = &h->s;
    const lt_attend_packing *packing = &kernels_of(s)->grad_packing;
    const lt_real *y = (const lt_real *)c->out->data + h->q_at, *dy = c->dout + h->q_at;

    packing->pack(LT_ATTEND_Q, g->q, at(c, Q, h->q_at), s->C, s->T, s->d, scale_of(s));
    packing->pack(LT_ATTEND_DY, g->dy, dy, s->C, s->T, s->d, 1);
    for (int64_t t = 0; t < s->T; t++)
        g->mean[t] = (lt_real)lt_k->dot(dy + t * s->C, y + t * s->C, (size_t)s->d);
}

/* A head's rows of din[i] from `offset`, before the first addition */
static void start(const lt_call *c, int i, const sizes *s, int64_t offset, int64_t rows)
{
    for (int64_t t = 0; t < rows; t++)
        op_start(c, i, offset + t * s->C, s->d);
}

static lt_real *din(const lt_call *c, int i, int64_t offset)
{
    return c->din[i] ? c->din[i] + offset : NULL;
}

/* n keys from j on, which g has packed, against all queries */
static void backward_keys(const lt_call *c, const head *h, int64_t j, int64_t n, const gradient_scratch *g)
{
    const sizes *s = &h->s;
    const int64_t k_at = h->k_at + j * s->C, at_once = kernels_of(s)->grad_packing.queries;

    for (int64_t t = 0; t < s->T; t += at_once) {
        const int64_t q_at = h->q_at + t * s->C;
        const lt_attend_grad a = {
            .d = s->d, .ld = s->C, .rows = lt_min_i64(at_once, s->T - t), .keys = n,
            .packed_q = g->q + grad_packed(s, LT_ATTEND_Q, t), .packed_k = g->k, .packed_v = g->v,
            .packed_dy = g->dy + grad_packed(s, LT_ATTEND_DY, t),
            .q = at(c, Q, q_at), .k = at(c, K, k_at), .dy = c->dout + q_at,
            .stats = stats_of(c, h) + 2 * t, .mean = g->mean + t, .scale = (lt_real)s->scale,
            .dq = din(c, Q, q_at), .dk = din(c, K, k_at), .dv = din(c, V, k_at),
        };

        kernels_of(s)->attend_grad(&a);
    }
}

static void backward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const head h = head_of(c, task);
    const sizes *s = &h.s;
    const lt_attend_packing *packing = &kernels_of(s)->grad_packing;
    const gradient_scratch g = scratch_of(c, &h);

    pack_queries(c, &h, &g);
    start(c, Q, s, h.q_at, s->T);
    start(c, K, s, h.k_at, s->S);
    start(c, V, s, h.k_at, s->S);
    for (int64_t j = 0; j < s->S; j += packing->keys) {
        const int64_t n = lt_min_i64(packing->keys, s->S - j), k_at = h.k_at + j * s->C;

        packing->pack(LT_ATTEND_K, g.k, at(c, K, k_at), s->C, n, s->d, 1);
        packing->pack(LT_ATTEND_V, g.v, at(c, V, k_at), s->C, n, s->d, 1);
        backward_keys(c, &h, j, n, &g);
    }
}

static void backward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    lt_parallel_for(s.B * s.heads, backward_task, (void *)c);
}

static void plan(lt_call *c)
{
    const sizes s = sizes_of(c);
    const int64_t elements = lt_max_i64(forward_elements(&s), c->train ? backward_elements(&s) : 0);

    c->work_bytes = (size_t)(s.B * s.heads * elements) * sizeof(lt_real);
    if (c->train)
        c->saved_bytes[0] = (size_t)(s.B * s.heads * 2 * s.T) * sizeof(lt_real);
}

static int64_t macs(const lt_call *c)
{
    const sizes s = sizes_of(c);

    return 2 * s.B * s.T * s.S * s.C;
}

/* (B, T, C) -> (B, T, heads, d), in this order */
static const char *heads_of(lt_onnx *w, const lt_node *n, int i, const int *order)
{
    const int64_t heads = ((const attention_attr *)n->attr)->heads, B = lt_onnx_dim(w, n->in[i], 0);
    const lt_shape split = LT_SHAPE(B, lt_onnx_dim(w, n->in[i], 1), heads, lt_dim(n->in[i], 2) / heads);

    return lt_onnx_transpose(w, lt_onnx_reshape(w, lt_onnx_of(w, n->in[i]), split), order, 4);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const int heads = ((const attention_attr *)n->attr)->heads;
    const int64_t d = lt_dim(n->in[Q], 2) / heads;
    const char *q = heads_of(w, n, Q, (int[]){ 0, 2, 1, 3 }), *k = heads_of(w, n, K, (int[]){ 0, 2, 3, 1 });
    const char *v = heads_of(w, n, V, (int[]){ 0, 2, 1, 3 }), *y;
    lt_shape shape = n->outs[0]->shape;

    y = LT_ONNX(w, "Mul", LT_ONNX(w, "MatMul", q, k), lt_onnx_number(w, 1 / sqrt((double)d)));
    y = LT_ONNX(w, "Softmax", y);
    lt_onnx_int(w, "axis", -1);
    y = lt_onnx_transpose(w, LT_ONNX(w, "MatMul", y, v), (int[]){ 0, 2, 1, 3 }, 4);
    shape.dim[0] = lt_onnx_dim(w, n->outs[0], 0);
    lt_onnx_is(w, n->outs[0], lt_onnx_reshape(w, y, shape));
}

static const lt_op attention_op = {
    .name = "attention", .flags = LT_OP_ASSIGNS,
    .keeps = LT_KEEP_IN(Q) | LT_KEEP_IN(K) | LT_KEEP_IN(V) | LT_KEEP_OUT(0), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward, .macs = macs, .onnx = onnx,
};

lt_tensor *(lt_attention)(lt_tensor *q, lt_tensor *k, lt_tensor *v, int heads)
{
    const attention_attr a = { .heads = heads };

    return lt_apply(&attention_op, &a, sizeof(a), (lt_tensor *[]){ q, k, v }, 3);
}
