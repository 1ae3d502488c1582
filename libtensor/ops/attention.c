/* SPDX-License-Identifier: Apache-2.0 */
/* attention: y = softmax(q k^T / sqrt(d)) v, head by head                [Vaswani et al. 2017, section 3.2]
 *   q (B, T, C)   k, v (B, S, C)   ->   y (B, T, C), d = C / heads
 *
 * With P = softmax(z), z = q k^T / sqrt(d), and R = dy v^T:
 *   dv += P^T dy      dz = P * (R - sum(R * P))      dq += dz k / sqrt(d)      dk += dz^T q / sqrt(d)
 *
 * P exists for ROWS rows at a time; backward makes it again from q and k. One task owns a head of an
 * image in backward, so that dk and dv have one owner and the row blocks are added in their order.
 */
#include "libtensor/kernels/gemm.h"
#include "libtensor/ops/common.h"

enum { Q, K, V };
enum { ROWS = 64, FORWARD_CUTS = 4 };

typedef struct {
    int heads;
} attention_attr;

typedef struct {
    int64_t B, T, S, C, d;
    int heads;
    lt_real scale;
} sizes;

static sizes sizes_of(const lt_call *c)
{
    const attention_attr *a = c->attr;
    sizes s = {
        .B = lt_dim(c->in[Q], 0), .T = lt_dim(c->in[Q], 1), .S = lt_dim(c->in[K], 1),
        .C = lt_dim(c->in[Q], 2), .heads = a->heads,
    };

    s.d = s.C / s.heads;
    s.scale = (lt_real)(1 / sqrt((double)s.d));
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

static size_t block_bytes(const sizes *s)
{
    return (size_t)(ROWS * s->S) * sizeof(lt_real);
}

static void plan(lt_call *c)
{
    const sizes s = sizes_of(c);
    const size_t per_head = block_bytes(&s) * (c->train ? 2 : 1);
    const size_t forward_tasks = FORWARD_CUTS * block_bytes(&s);

    c->work_bytes = (size_t)(s.B * s.heads) * (per_head > forward_tasks ? per_head : forward_tasks);
}

/* What one task works on: one head of one image. */
typedef struct {
    sizes s;
    int64_t q_at, k_at;             /* of its first element in q and in k */
} head;

static head head_of(const lt_call *c, int64_t i)
{
    const sizes s = sizes_of(c);
    const int64_t b = i / s.heads, h = i % s.heads;

    return (head){ s, b * s.T * s.C + h * s.d, b * s.S * s.C + h * s.d };
}

static const lt_real *at(const lt_call *c, int i, int64_t offset)
{
    return (const lt_real *)c->in[i]->data + offset;
}

/* P for rows t .. t + n - 1 */
static void attend(const lt_call *c, const head *h, int64_t t, int64_t n, lt_real *p)
{
    const sizes *s = &h->s;

    lt_gemm(LT_NO_TRANS, LT_TRANS, n, s->S, s->d, at(c, Q, h->q_at + t * s->C), s->C, at(c, K, h->k_at), s->C,
            false, p, s->S, NULL);
    lt_k->scale(p, p, s->scale, (size_t)(n * s->S));
    for (int64_t i = 0; i < n; i++)
        lt_k->softmax(p + i * s->S, p + i * s->S, (size_t)s->S);
}

static void forward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const head h = head_of(c, task / FORWARD_CUTS);
    const sizes *s = &h.s;
    const int64_t cut = lt_ceil_div(lt_ceil_div(s->T, FORWARD_CUTS), ROWS) * ROWS;
    const int64_t first = task % FORWARD_CUTS * cut, end = lt_min_i64(s->T, first + cut);
    lt_real *p = (lt_real *)c->work + task * ROWS * s->S;

    for (int64_t t = first; t < end; t += ROWS) {
        const int64_t n = lt_min_i64(ROWS, end - t);

        attend(c, &h, t, n, p);
        lt_gemm(LT_NO_TRANS, LT_NO_TRANS, n, s->d, s->S, p, s->S, at(c, V, h.k_at), s->C, false,
                (lt_real *)c->out->data + h.q_at + t * s->C, s->C, NULL);
    }
}

static void forward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    lt_parallel_for(s.B * s.heads * FORWARD_CUTS, forward_task, (void *)c);
}

/* dz in the place of R = dy v^T, scaled for the products with k and q */
static void score_gradient(const lt_call *c, const head *h, int64_t t, int64_t n, const lt_real *p, lt_real *r)
{
    const sizes *s = &h->s;

    lt_gemm(LT_NO_TRANS, LT_TRANS, n, s->S, s->d, c->dout + h->q_at + t * s->C, s->C, at(c, V, h->k_at), s->C,
            false, r, s->S, NULL);
    for (int64_t i = 0; i < n; i++) {
        const lt_real sum = (lt_real)lt_k->dot(r + i * s->S, p + i * s->S, (size_t)s->S);

        for (int64_t j = 0; j < s->S; j++)
            r[i * s->S + j] = p[i * s->S + j] * (r[i * s->S + j] - sum) * s->scale;
    }
}

static void backward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const head h = head_of(c, task);
    const sizes *s = &h.s;
    lt_real *p = (lt_real *)c->work + task * 2 * ROWS * s->S, *dz = p + ROWS * s->S;

    for (int64_t t = 0; t < s->T; t += ROWS) {
        const int64_t n = lt_min_i64(ROWS, s->T - t), q_at = h.q_at + t * s->C;

        attend(c, &h, t, n, p);
        if (c->din[V])
            lt_gemm(LT_TRANS, LT_NO_TRANS, s->S, s->d, n, p, s->S, c->dout + q_at, s->C, true,
                    c->din[V] + h.k_at, s->C, NULL);
        score_gradient(c, &h, t, n, p, dz);
        if (c->din[Q])
            lt_gemm(LT_NO_TRANS, LT_NO_TRANS, n, s->d, s->S, dz, s->S, at(c, K, h.k_at), s->C, true,
                    c->din[Q] + q_at, s->C, NULL);
        if (c->din[K])
            lt_gemm(LT_TRANS, LT_NO_TRANS, s->S, s->d, n, dz, s->S, at(c, Q, q_at), s->C, true,
                    c->din[K] + h.k_at, s->C, NULL);
    }
}

static void backward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    lt_parallel_for(s.B * s.heads, backward_task, (void *)c);
}

static int64_t macs(const lt_call *c)
{
    const sizes s = sizes_of(c);

    return 2 * s.B * s.T * s.S * s.C;
}

static const lt_op attention_op = {
    .name = "attention", .keeps = LT_KEEP_IN(Q) | LT_KEEP_IN(K) | LT_KEEP_IN(V), .infer = infer,
    .plan = plan, .forward = forward, .backward = backward, .macs = macs,
};

lt_tensor *(lt_attention)(lt_tensor *q, lt_tensor *k, lt_tensor *v, int heads)
{
    const attention_attr a = { .heads = heads };

    return lt_apply(&attention_op, &a, sizeof(a), (lt_tensor *[]){ q, k, v }, 3);
}
