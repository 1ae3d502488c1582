/* SPDX-License-Identifier: Apache-2.0 */
/* aggregate: what each node of a graph is told by those it is linked with   [Yan et al. 2018, "ST-GCN", equation 10]
 *   x (B, K C, T, V)   mask (K, V, V)   ->   y (B, C, T, V)
 *   y[b, c, t, w] = act(scale[c] sum over links (k, v, w, a) of a mask[k, v, w] x[b, k C + c, t, v] + shift[c])
 *   dx[b, k C + c, t, v] += a mask[k, v, w] dy[b, c, t, w]
 *   dmask[k, v, w] += sum a dy[b, c, t, w] x[b, k C + c, t, v]
 *
 * Links to one node that stand together are summed in registers.
 * scale, shift and act, none or relu, are there only where an inference plan fused them. Plain maps are turned, so that
 * moments of time are in the lanes; of maps in blocks it is the channels.
 */
#include "libtensor/kernels/blocks/blocks.h"
#include "libtensor/ops/common.h"

enum { X, MASK, SCALE, SHIFT, INPUTS };
enum { LANES = 16, MOST_NODES = 128, MOST_SUBSETS = 4, PARTS = 64 };

typedef struct {
    const lt_adjacency *of;
    lt_act act;
} aggregate_attr;

static const lt_adjacency *links(const lt_call *c)
{
    return ((const aggregate_attr *)c->attr)->of;
}

static lt_status infer(lt_call *c)
{
    const lt_adjacency *a = links(c);

    if (a->nodes < 1 || a->nodes > MOST_NODES || a->subsets < 1 || a->subsets > MOST_SUBSETS)
        return lt_fail(c, "%d nodes in %d subsets: want 1 to %d in 1 to %d", a->nodes, a->subsets, MOST_NODES,
                       MOST_SUBSETS);
    if (lt_want_rank(c, X, "input", 4) || lt_want_shape(c, MASK, "mask", LT_SHAPE(a->subsets, a->nodes, a->nodes)))
        return LT_ESHAPE;
    if (lt_dim(c->in[X], 3) != a->nodes)
        return lt_fail(c, "input has %lld nodes, the graph %d", (long long)lt_dim(c->in[X], 3), a->nodes);
    if (lt_dim(c->in[X], 1) % a->subsets)
        return lt_fail(c, "%d subsets do not divide %lld channels", a->subsets, (long long)lt_dim(c->in[X], 1));
    c->out->shape = c->in[X]->shape;
    c->out->shape.dim[1] /= a->subsets;
    return LT_OK;
}

static int64_t parts(const lt_call *c)
{
    return lt_min_i64(PARTS, op_outer(c->out, 2));
}

/* work: a link's weight each; in training, of each part of the batch and channels each link's gradient */
static void plan(lt_call *c)
{
    c->work_bytes = (size_t)op_aligned(links(c)->n * (int64_t)sizeof(lt_real));
    if (c->train)
        c->work_bytes += (size_t)(parts(c) * links(c)->n) * sizeof(double);
}

static int64_t mask_at(const lt_adjacency *a, const lt_link *l)
{
    return ((int64_t)l->subset * a->nodes + l->from) * a->nodes + l->to;
}

static void weigh_links(const lt_call *c)
{
    const lt_adjacency *a = links(c);
    const lt_real *mask = c->in[MASK]->data;

    for (int i = 0; i < a->n; i++)
        ((lt_real *)c->work)[i] = (lt_real)a->link[i].value * mask[mask_at(a, &a->link[i])];
}

/* ---- plain maps ---- */

/* A few moments of one channel: of each subset's map and of the result, (V, LANES) each */
typedef struct {
    _Alignas(LT_ALIGN) lt_real x[MOST_SUBSETS][MOST_NODES][LANES];
    _Alignas(LT_ALIGN) lt_real y[MOST_NODES][LANES];
} moments;

/* Where the map of subset k is that belongs to map `plane` of the result */
static int64_t x_at(const lt_call *c, int64_t plane, int k, int64_t t)
{
    const lt_adjacency *a = links(c);
    const int64_t C = lt_dim(c->out, 1), b = plane / C, channel = plane % C, T = lt_dim(c->out, 2);

    return (((b * a->subsets + k) * C + channel) * T + t) * a->nodes;
}

static void turn_in(const lt_call *c, moments *m, int64_t plane, int64_t t, int64_t n)
{
    const lt_adjacency *a = links(c);

    for (int k = 0; k < a->subsets; k++) {
        if (n < LANES)
            memset(m->x[k], 0, (size_t)a->nodes * sizeof(m->x[k][0]));
        lt_k->turn(m->x[k][0], LANES, (const lt_real *)c->in[X]->data + x_at(c, plane, k, t), a->nodes, n, a->nodes,
                   false);
    }
}

static void add_links(const lt_call *c, moments *m)
{
    const lt_adjacency *a = links(c);

    memset(m->y, 0, (size_t)a->nodes * sizeof(m->y[0]));
    for (int i = 0; i < a->n;) {
        const int to = a->link[i].to;
        lt_real sum[LANES] = { 0 };

        for (; i < a->n && a->link[i].to == to; i++) {
            const lt_real weight = ((const lt_real *)c->work)[i], *x = m->x[a->link[i].subset][a->link[i].from];

            for (int j = 0; j < LANES; j++)
                sum[j] += weight * x[j];
        }
        for (int j = 0; j < LANES; j++)
            m->y[to][j] += sum[j];
    }
}

static void forward_plane(const lt_call *c, int64_t plane)
{
    const int64_t T = lt_dim(c->out, 2), V = links(c)->nodes, channel = plane % lt_dim(c->out, 1);
    lt_real *y = (lt_real *)c->out->data + plane * T * V;
    moments m;

    for (int64_t t = 0; t < T; t += LANES) {
        const int64_t n = lt_min_i64(LANES, T - t);

        turn_in(c, &m, plane, t, n);
        add_links(c, &m);
        lt_k->turn(y + t * V, V, m.y[0], LANES, V, n, false);
    }
    if (c->in[SCALE])
        lt_k->affine(y, y, ((const lt_real *)c->in[SCALE]->data)[channel],
                     ((const lt_real *)c->in[SHIFT]->data)[channel], NULL, ((const aggregate_attr *)c->attr)->act,
                     (size_t)(T * V));
}

/* ---- maps in blocks of channels ---- */

static void finish_block(const lt_call *c, int64_t block, lt_real *y)
{
    const lt_real *scale = (const lt_real *)c->in[SCALE]->data + block * LT_BLOCK;
    const lt_real *shift = (const lt_real *)c->in[SHIFT]->data + block * LT_BLOCK;
    const bool relu = ((const aggregate_attr *)c->attr)->act.kind == LT_ACT_RELU;

    for (int64_t w = 0; w < links(c)->nodes; w++, y += LT_BLOCK)
        for (int j = 0; j < LT_BLOCK; j++) {
            y[j] = scale[j] * y[j] + shift[j];
            y[j] = relu && !(y[j] > 0) ? 0 : y[j];
        }
}

/* One moment of a block of channels */
static void forward_moment(const lt_call *c, int64_t i)
{
    const lt_adjacency *a = links(c);
    const int64_t T = lt_dim(c->out, 2), V = a->nodes, blocks = lt_dim(c->out, 1), row = V * LT_BLOCK;
    const int64_t t = i % T, block = i / T % blocks, b = i / T / blocks;
    lt_real *y = (lt_real *)c->out->data + i * row;

    memset(y, 0, (size_t)row * sizeof(*y));
    for (int k = 0; k < a->n;) {
        const int to = a->link[k].to;
        lt_real sum[LT_BLOCK] = { 0 };

        for (; k < a->n && a->link[k].to == to; k++) {
            const lt_real weight = ((const lt_real *)c->work)[k];
            const lt_real *x = (const lt_real *)c->in[X]->data
                + (((b * a->subsets + a->link[k].subset) * blocks + block) * T + t) * row + a->link[k].from * LT_BLOCK;

            for (int j = 0; j < LT_BLOCK; j++)
                sum[j] += weight * x[j];
        }
        for (int j = 0; j < LT_BLOCK; j++)
            y[to * LT_BLOCK + j] += sum[j];
    }
    if (c->in[SCALE])
        finish_block(c, block, y);
}

static void forward(const lt_call *c)
{
    weigh_links(c);
    if (lt_in_blocks(c->out))
        op_by_row(c, op_outer(c->out, 3), (int64_t)links(c)->n * LT_BLOCK, forward_moment);
    else
        op_by_row(c, op_outer(c->out, 2), lt_dim(c->out, 2) * links(c)->n, forward_plane);
}

/* ---- gradients ---- */

static void mask_gradient(const lt_call *c, const moments *m, double *sum)
{
    const lt_adjacency *a = links(c);

    for (int i = 0; i < a->n; i++) {
        const lt_link *l = &a->link[i];
        const lt_real *x = m->x[l->subset][l->from], *dy = m->y[l->to];
        lt_real part = 0;

        for (int j = 0; j < LANES; j++)
            part += x[j] * dy[j];
        sum[i] += (double)part * l->value;
    }
}

static void data_gradient(const lt_call *c, moments *m)
{
    const lt_adjacency *a = links(c);

    memset(m->x, 0, sizeof(m->x));
    for (int i = 0; i < a->n; i++) {
        const lt_link *l = &a->link[i];
        const lt_real weight = ((const lt_real *)c->work)[i], *dy = m->y[l->to];
        lt_real *dx = m->x[l->subset][l->from];

        for (int j = 0; j < LANES; j++)
            dx[j] += weight * dy[j];
    }
}

static void backward_plane(const lt_call *c, int64_t plane, double *sum)
{
    const lt_adjacency *a = links(c);
    const int64_t T = lt_dim(c->out, 2), V = a->nodes;
    moments m;

    for (int k = 0; k < a->subsets && c->din[X]; k++)
        op_start(c, X, x_at(c, plane, k, 0), T * V);
    for (int64_t t = 0; t < T; t += LANES) {
        const int64_t n = lt_min_i64(LANES, T - t);

        memset(m.y, 0, sizeof(m.y));
        lt_k->turn(m.y[0], LANES, c->dout + (plane * T + t) * V, V, n, V, false);
        if (sum) {
            turn_in(c, &m, plane, t, n);
            mask_gradient(c, &m, sum);
        }
        if (!c->din[X])
            continue;
        data_gradient(c, &m);
        for (int k = 0; k < a->subsets; k++)
            lt_k->turn(c->din[X] + x_at(c, plane, k, t), V, m.x[k][0], LANES, V, n, true);
    }
}

static double *sums_of(const lt_call *c, int64_t part)
{
    return (double *)((char *)c->work + op_aligned(links(c)->n * (int64_t)sizeof(lt_real))) + part * links(c)->n;
}

static void backward_part(void *ctx, int64_t part)
{
    const lt_call *c = ctx;
    const int64_t planes = op_outer(c->out, 2), first = part * planes / parts(c), end = (part + 1) * planes / parts(c);
    double *sum = c->din[MASK] ? sums_of(c, part) : NULL;

    if (sum)
        memset(sum, 0, (size_t)links(c)->n * sizeof(*sum));
    for (int64_t plane = first; plane < end; plane++)
        backward_plane(c, plane, sum);
}

static void backward(const lt_call *c)
{
    const lt_adjacency *a = links(c);

    weigh_links(c);
    op_start(c, MASK, 0, lt_numel(c->in[MASK]));
    lt_parallel_for(parts(c), backward_part, (void *)c);
    for (int i = 0; c->din[MASK] && i < a->n; i++) {
        double sum = 0;

        for (int64_t part = 0; part < parts(c); part++)
            sum += sums_of(c, part)[i];
        c->din[MASK][mask_at(a, &a->link[i])] += (lt_real)sum;
    }
}

/* ---- what passes ask ---- */

static int64_t macs(const lt_call *c)
{
    const int64_t lanes = lt_in_blocks(c->out) ? LT_BLOCK : 1;

    return op_outer(c->out, 3) * lanes * links(c)->n;
}

static bool absorb(lt_node *node, const lt_tail *tail)
{
    aggregate_attr *a = node->attr;
    const bool relu = tail->act.kind == LT_ACT_RELU, none = tail->act.kind == LT_ACT_NONE;

    if (tail->addend || !(relu || none) || a->act.kind != LT_ACT_NONE || (tail->scale && node->in[SCALE])
        || (!tail->scale && !node->in[SCALE]))
        return false;
    if (tail->scale) {
        node->in[SCALE] = tail->scale;
        node->in[SHIFT] = tail->shift;
    }
    a->act = tail->act;
    return true;
}

static unsigned takes_blocks(const lt_node *node)
{
    return lt_dim(node->outs[0], 1) % LT_BLOCK ? 0 : LT_BLOCKS_IN(X) | LT_BLOCKS_OUT;
}

/* A product with a whole matrix for each subset */
static void onnx(lt_onnx *w, const lt_node *n)
{
    const lt_adjacency *a = ((const aggregate_attr *)n->attr)->of;
    lt_real matrix[MOST_NODES * MOST_NODES];
    const char *x = lt_onnx_of(w, n->in[X]), *mask = lt_onnx_of(w, n->in[MASK]), *y = NULL;
    const int64_t C = lt_dim(n->outs[0], 1);

    for (int k = 0; k < a->subsets; k++) {
        const char *part = lt_onnx_slice(w, x, 1, k * C, C), *weight;

        memset(matrix, 0, sizeof(matrix));
        for (int i = 0; i < a->n; i++)
            if (a->link[i].subset == k)
                matrix[a->link[i].from * a->nodes + a->link[i].to] = (lt_real)a->link[i].value;
        weight = LT_ONNX(w, "Mul", lt_onnx_slice(w, mask, 0, k, 1),
                         lt_onnx_numbers(w, LT_SHAPE(1, a->nodes, a->nodes), matrix));
        part = LT_ONNX(w, "MatMul", part, lt_onnx_reshape(w, weight, LT_SHAPE(a->nodes, a->nodes)));
        y = y ? LT_ONNX(w, "Add", y, part) : part;
    }
    lt_onnx_is(w, n->outs[0], y);
}

static const lt_op aggregate_op = {
    .name = "aggregate", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(MASK),
    .optional = LT_OPTIONAL_IN(SCALE) | LT_OPTIONAL_IN(SHIFT), .infer = infer, .plan = plan, .forward = forward,
    .backward = backward, .macs = macs, .absorb = absorb, .takes_blocks = takes_blocks, .onnx = onnx,
};

lt_tensor *(lt_aggregate)(lt_tensor *x, lt_tensor *mask, const lt_adjacency *of)
{
    const aggregate_attr a = { .of = of, .act = { .kind = LT_ACT_NONE } };

    return lt_apply(&aggregate_op, &a, sizeof(a), (lt_tensor *[INPUTS]){ x, mask }, INPUTS);
}
