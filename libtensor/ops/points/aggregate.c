/* SPDX-License-Identifier: Apache-2.0 */
/* aggregate: what each node of a graph is told by those it is linked with   [Yan et al. 2018, "ST-GCN", equation 10]
 *   x (B, K C, T, V)   mask (K, V, V)   ->   y (B, C, T, V)
 *   y[b, c, t, w] = act(scale[c] sum over links (k, v, w, a) of a mask[k, v, w] x[b, k C + c, t, v] + shift[c])
 *   dx[b, k C + c, t, v] += a mask[k, v, w] dy[b, c, t, w]
 *   dmask[k, v, w] += sum a dy[b, c, t, w] x[b, k C + c, t, v]
 *
 * scale, shift and act, none or relu, are there only where an inference plan fused them. A row of a kernel is a node:
 * of maps in blocks the channels are in its lanes; plain maps are turned, so that moments of time are.
 */
#include "libtensor/kernels/blocks/blocks.h"
#include "libtensor/ops/common.h"

#include <string.h>

enum { X, MASK, SCALE, SHIFT, INPUTS };
enum { LANES = LT_BLOCK, MOST_NODES = 128, MOST_SUBSETS = 4, PARTS = 64 };

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

/* ---- links, sorted by the row that they tell ---- */

/* In work: its first element of each kind, the first three of a link each, and how many bytes in all */
typedef struct {
    int64_t from, weight, sorted, first, sums, bytes;
} layout;

/* sums: in training, of each part of the batch and its channels what each link's gradient is the sum of */
static layout layout_of(const lt_adjacency *a, int64_t parts)
{
    layout l = { .from = 0 };

    l.weight = l.from + op_aligned(a->n * (int64_t)sizeof(int64_t));
    l.sorted = l.weight + op_aligned(a->n * (int64_t)sizeof(lt_real));
    l.first = l.sorted + op_aligned(a->n * (int64_t)sizeof(int32_t));
    l.sums = l.first + op_aligned((a->subsets * a->nodes + 1) * (int64_t)sizeof(int32_t));
    l.bytes = l.sums + parts * a->n * LANES * (int64_t)sizeof(lt_real);
    return l;
}

static void plan(lt_call *c)
{
    c->work_bytes = (size_t)layout_of(links(c), c->train ? parts(c) : 0).bytes;
}

static void *in_work(const lt_call *c, int64_t at)
{
    return (char *)c->work + at;
}

static int64_t mask_at(const lt_adjacency *a, const lt_link *l)
{
    return ((int64_t)l->subset * a->nodes + l->from) * a->nodes + l->to;
}

static lt_links links_in(const lt_call *c)
{
    const layout at = layout_of(links(c), 0);

    return (lt_links){ .first = in_work(c, at.first), .from = in_work(c, at.from), .weight = in_work(c, at.weight) };
}

/* The row that a link tells: forward a node, backward a subset's node, which learns what its node has told */
static int row_of(const lt_adjacency *a, const lt_link *l, bool forward)
{
    return forward ? l->to : l->subset * a->nodes + l->from;
}

/* subset: forward, so many elements are between the first rows of two subsets */
static void sort_links(const lt_call *c, bool forward, int64_t subset)
{
    const lt_adjacency *a = links(c);
    const layout at = layout_of(a, 0);
    const lt_real *mask = c->in[MASK]->data;
    const int rows = forward ? a->nodes : a->subsets * a->nodes;
    int64_t *from = in_work(c, at.from);
    lt_real *weight = in_work(c, at.weight);
    int32_t *sorted = in_work(c, at.sorted), *first = in_work(c, at.first);

    memset(first, 0, (size_t)(rows + 1) * sizeof(*first));
    for (int i = 0; i < a->n; i++)
        first[row_of(a, &a->link[i], forward) + 1]++;
    for (int r = 0; r < rows; r++)
        first[r + 1] += first[r];
    for (int i = 0; i < a->n; i++) {
        const lt_link *l = &a->link[i];
        const int32_t k = first[row_of(a, l, forward)]++;

        from[k] = forward ? l->subset * subset + (int64_t)l->from * LANES : (int64_t)l->to * LANES;
        weight[k] = (lt_real)l->value * mask[mask_at(a, l)];
        sorted[k] = i;
    }
    memmove(first + 1, first, (size_t)rows * sizeof(*first));       /* each is at the next row's now */
    first[0] = 0;
}

/* ---- plain maps ---- */

/* A few moments of one channel: of each subset's map and of the result, (V, LANES) each */
typedef struct {
    _Alignas(LT_ALIGN) lt_real x[MOST_SUBSETS * MOST_NODES][LANES];
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

    if (n < LANES)
        memset(m->x, 0, (size_t)(a->subsets * a->nodes) * sizeof(m->x[0]));
    for (int k = 0; k < a->subsets; k++)
        lt_k->turn(m->x[k * a->nodes], LANES, (const lt_real *)c->in[X]->data + x_at(c, plane, k, t), a->nodes, n,
                   a->nodes, false);
}

static void forward_plane(const lt_call *c, int64_t plane)
{
    const int64_t T = lt_dim(c->out, 2), V = links(c)->nodes, channel = plane % lt_dim(c->out, 1);
    const lt_links l = links_in(c);
    lt_real *y = (lt_real *)c->out->data + plane * T * V;
    moments m;

    for (int64_t t = 0; t < T; t += LANES) {
        const int64_t n = lt_min_i64(LANES, T - t);

        turn_in(c, &m, plane, t, n);
        lt_k->link_rows(m.y[0], m.x[0], &l, V);
        lt_k->turn(y + t * V, V, m.y[0], LANES, V, n, false);
    }
    if (c->in[SCALE])
        lt_k->affine(y, y, ((const lt_real *)c->in[SCALE]->data)[channel],
                     ((const lt_real *)c->in[SHIFT]->data)[channel], NULL, ((const aggregate_attr *)c->attr)->act,
                     (size_t)(T * V));
}

/* ---- maps in blocks of channels ---- */

/* One moment of a block of channels */
static void forward_moment(const lt_call *c, int64_t i)
{
    const int64_t T = lt_dim(c->out, 2), V = links(c)->nodes, blocks = lt_dim(c->out, 1), row = V * LT_BLOCK;
    const int64_t t = i % T, block = i / T % blocks, b = i / T / blocks;
    const lt_real *x = (const lt_real *)c->in[X]->data + ((b * links(c)->subsets * blocks + block) * T + t) * row;
    lt_links l = links_in(c);

    if (c->in[SCALE]) {
        l.scale = (const lt_real *)c->in[SCALE]->data + block * LT_BLOCK;
        l.shift = (const lt_real *)c->in[SHIFT]->data + block * LT_BLOCK;
        l.relu = ((const aggregate_attr *)c->attr)->act.kind == LT_ACT_RELU;
    }
    lt_k->link_rows((lt_real *)c->out->data + i * row, x, &l, V);
}

static void forward(const lt_call *c)
{
    const int64_t row = lt_dim(c->out, 3) * LANES;

    if (lt_in_blocks(c->out)) {
        sort_links(c, true, lt_dim(c->out, 1) * lt_dim(c->out, 2) * row);
        op_by_row(c, op_outer(c->out, 3), (int64_t)links(c)->n * LANES, forward_moment);
    } else {
        sort_links(c, true, row);
        op_by_row(c, op_outer(c->out, 2), lt_dim(c->out, 2) * links(c)->n, forward_plane);
    }
}

/* ---- gradients ---- */

static void backward_plane(const lt_call *c, int64_t plane, lt_real *sums)
{
    const int64_t T = lt_dim(c->out, 2), V = links(c)->nodes, rows = links(c)->subsets * V;
    const lt_links l = links_in(c);
    moments m;

    for (int k = 0; k < links(c)->subsets && c->din[X]; k++)
        op_start(c, X, x_at(c, plane, k, 0), T * V);
    for (int64_t t = 0; t < T; t += LANES) {
        const int64_t n = lt_min_i64(LANES, T - t);

        if (n < LANES)
            memset(m.y, 0, (size_t)V * sizeof(m.y[0]));
        lt_k->turn(m.y[0], LANES, c->dout + (plane * T + t) * V, V, n, V, false);
        if (sums) {
            turn_in(c, &m, plane, t, n);
            lt_k->link_products(sums, m.y[0], m.x[0], &l, rows);
        }
        if (!c->din[X])
            continue;
        lt_k->link_rows(m.x[0], m.y[0], &l, rows);
        for (int k = 0; k < links(c)->subsets; k++)
            lt_k->turn(c->din[X] + x_at(c, plane, k, t), V, m.x[k * V], LANES, V, n, true);
    }
}

static lt_real *sums_of(const lt_call *c, int64_t part)
{
    return (lt_real *)in_work(c, layout_of(links(c), 0).sums) + part * links(c)->n * LANES;
}

static void backward_part(void *ctx, int64_t part)
{
    const lt_call *c = ctx;
    const int64_t planes = op_outer(c->out, 2), first = part * planes / parts(c), end = (part + 1) * planes / parts(c);
    lt_real *sums = c->din[MASK] ? sums_of(c, part) : NULL;

    if (sums)
        memset(sums, 0, (size_t)(links(c)->n * LANES) * sizeof(*sums));
    for (int64_t plane = first; plane < end; plane++)
        backward_plane(c, plane, sums);
}

static void mask_gradient(const lt_call *c)
{
    const lt_adjacency *a = links(c);
    const int32_t *sorted = in_work(c, layout_of(a, 0).sorted);

    op_start(c, MASK, 0, lt_numel(c->in[MASK]));
    for (int k = 0; k < a->n; k++) {
        const lt_link *l = &a->link[sorted[k]];
        double sum = 0;

        for (int64_t part = 0; part < parts(c); part++)
            for (int lane = 0; lane < LANES; lane++)
                sum += (double)sums_of(c, part)[k * LANES + lane];
        c->din[MASK][mask_at(a, l)] += (lt_real)(l->value * sum);
    }
}

static void backward(const lt_call *c)
{
    sort_links(c, false, 0);
    lt_parallel_for(parts(c), backward_part, (void *)c);
    if (c->din[MASK])
        mask_gradient(c);
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
