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
enum { AT_ONCE = LT_ATTEND_PANELS * LT_ATTEND_QUERIES };    /* queries */

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

/* Elements of n rows of a head, packed in panels */
static int64_t packed(const sizes *s, int64_t n, int width)
{
    return lt_ceil_div(n, width) * width * s->d;
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

/* Queries from `from` on, at most n of them. Scores are powers of two: q is scaled by log2(e) too. */
static void pack_queries(const lt_call *c, const head *h, int64_t from, int64_t n, lt_real *out)
{
    const double log2e = 1.4426950408889634;

    lt_k->attend_pack(out, at(c, Q, h->q_at + from * h->s.C), h->s.C, lt_min_i64(n, h->s.T - from), h->s.d,
                      LT_ATTEND_QUERIES, (lt_real)(h->s.scale * log2e));
}

/* ---- forward ------------------------------------------------------------------------------------------ */

static int64_t tasks_of(const sizes *s)
{
    return lt_ceil_div(s->T, AT_ONCE);
}

/* A head as attend wants it: panels of queries, panels of keys, rows of values. These are copied where there are
 * several heads: of one they already lie without gaps. */
typedef struct {
    lt_real *q, *k, *v;
} packed_head;

static int64_t forward_elements(const sizes *s)
{
    return packed(s, s->T, LT_ATTEND_QUERIES) + packed(s, s->S, LT_ATTEND_KEYS) + (s->heads > 1 ? s->S * s->d : 0);
}

static packed_head packed_of(const lt_call *c, const head *h)
{
    packed_head p = { .q = (lt_real *)c->work + h->number * forward_elements(&h->s) };

    p.k = p.q + packed(&h->s, h->s.T, LT_ATTEND_QUERIES);
    p.v = p.k + packed(&h->s, h->s.S, LT_ATTEND_KEYS);
    return p;
}

/* Rows of q, k and v that a task packs: whole panels of both */
enum { PACK_ROWS = LT_ATTEND_QUERIES * LT_ATTEND_KEYS / 4 };

static int64_t parts_of(const sizes *s)
{
    return lt_ceil_div(lt_max_i64(s->T, s->S), PACK_ROWS);
}

static void pack_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const sizes s = sizes_of(c);
    const head h = head_of(c, task / parts_of(&s));
    const int64_t from = task % parts_of(&s) * PACK_ROWS, row = from * s.C;
    const packed_head p = packed_of(c, &h);

    pack_queries(c, &h, from, PACK_ROWS, p.q + from * s.d);
    lt_k->attend_pack(p.k + from * s.d, at(c, K, h.k_at + row), s.C, lt_min_i64(PACK_ROWS, s.S - from), s.d,
                      LT_ATTEND_KEYS, 1);
    for (int64_t j = from; s.heads > 1 && j < lt_min_i64(from + PACK_ROWS, s.S); j++)
        memcpy(p.v + j * s.d, at(c, V, h.k_at + j * s.C), (size_t)s.d * sizeof(*p.v));
}

static void forward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const sizes s = sizes_of(c);
    const head h = head_of(c, task / tasks_of(&s));
    const packed_head p = packed_of(c, &h);
    const int64_t t = task % tasks_of(&s) * AT_ONCE;
    lt_real *stats = stats_of(c, &h);

    lt_k->attend((lt_real *)c->out->data + h.q_at + t * s.C, s.C, stats ? stats + 2 * t : NULL, p.q + t * s.d, p.k,
                 s.heads > 1 ? p.v : at(c, V, h.k_at), lt_min_i64(AT_ONCE, s.T - t), s.S, s.d);
}

static void forward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    if (s.T == 0)
        return;
    lt_parallel_for(s.B * s.heads * parts_of(&s), pack_task, (void *)c);
    lt_parallel_for(s.B * s.heads * tasks_of(&s), forward_task, (void *)c);
}

/* ---- backward ----------------------------------------------------------------------------------------- */

/* A task's scratch: panels of q and dy, sum(dy * y) of each row, panels of some keys and their values. */
static int64_t backward_elements(const sizes *s)
{
    return 2 * packed(s, s->T, LT_ATTEND_QUERIES) + s->T + 2 * LT_ATTEND_GRAD_KEYS * s->d;
}

static void pack_gradients(const lt_call *c, const head *h, lt_real *dy, lt_real *mean)
{
    const sizes *s = &h->s;
    const lt_real *y = (const lt_real *)c->out->data + h->q_at;

    lt_k->attend_pack(dy, c->dout + h->q_at, s->C, s->T, s->d, LT_ATTEND_QUERIES, 1);
    for (int64_t t = 0; t < s->T; t++)
        mean[t] = (lt_real)lt_k->dot(c->dout + h->q_at + t * s->C, y + t * s->C, (size_t)s->d);
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

/* Keys [j, j + g->keys), whose panels g has, against all queries. */
static void backward_keys(const lt_call *c, const head *h, int64_t j, lt_attend_grad g)
{
    const sizes *s = &h->s;
    const lt_real *q_panels = g.q_panel, *dy_panels = g.dy_panel, *mean = g.mean;
    const int64_t k_at = h->k_at + j * s->C;

    g.k = at(c, K, k_at), g.dk = din(c, K, k_at), g.dv = din(c, V, k_at);
    for (int64_t t = 0; t < s->T; t += AT_ONCE) {
        const int64_t q_at = h->q_at + t * s->C;

        g.rows = lt_min_i64(AT_ONCE, s->T - t);
        g.q_panel = q_panels + t * s->d, g.dy_panel = dy_panels + t * s->d;
        g.q = at(c, Q, q_at), g.dy = c->dout + q_at, g.dq = din(c, Q, q_at);
        g.stats = stats_of(c, h) + 2 * t, g.mean = mean + t;
        lt_k->attend_grad(&g);
    }
}

static void backward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const head h = head_of(c, task);
    const sizes *s = &h.s;
    lt_real *q = (lt_real *)c->work + task * backward_elements(s);
    lt_real *dy = q + packed(s, s->T, LT_ATTEND_QUERIES), *mean = dy + packed(s, s->T, LT_ATTEND_QUERIES);
    lt_real *k = mean + s->T, *v = k + LT_ATTEND_GRAD_KEYS * s->d;

    pack_queries(c, &h, 0, s->T, q);
    pack_gradients(c, &h, dy, mean);
    start(c, Q, s, h.q_at, s->T);
    start(c, K, s, h.k_at, s->S);
    start(c, V, s, h.k_at, s->S);
    for (int64_t j = 0; j < s->S; j += LT_ATTEND_GRAD_KEYS) {
        const int64_t n = lt_min_i64(LT_ATTEND_GRAD_KEYS, s->S - j), k_at = h.k_at + j * s->C;

        lt_k->attend_pack(k, at(c, K, k_at), s->C, n, s->d, LT_ATTEND_KEYS, 1);
        lt_k->attend_pack(v, at(c, V, k_at), s->C, n, s->d, LT_ATTEND_KEYS, 1);
        backward_keys(c, &h, j, (lt_attend_grad){
            .d = s->d, .ld = s->C, .keys = n, .q_panel = q, .dy_panel = dy, .k_panels = k, .v_panels = v,
            .mean = mean, .scale = (lt_real)s->scale });
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
