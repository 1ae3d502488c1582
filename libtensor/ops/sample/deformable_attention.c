/* SPDX-License-Identifier: Apache-2.0 */
/* deformable_attention: each query looks at a few places of its own on a map   [Zhu et al. 2021, equation 2]
 *   value (B, h w, C)   offset (B, T, heads, points, 2)   logit (B, T, heads, points)   reference (T, 2)
 *   y (B, T, C):   y[t, m] = sum over k of A_mk v_m(p_t + o_mk),   A_m = softmax over k of logit
 * where v_m(x, y) is the bilinear sample of head m's channels of the value map, 0 outside.
 *
 * With g_mk = dy_m . v_m(p_t + o_mk):
 *   dlogit += A (g - sum over k of A g)     doffset += A dg/do     dvalue += A times each corner's weight, dy
 *
 * A task has some queries of one head: the places' corners and weights become a table, and then the head's
 * channels, which lie side by side, are summed by it. In backward a task owns a whole head of an image.
 */
#include "libtensor/ops/common.h"

enum { VALUE, OFFSET, LOGIT, REFERENCE };
enum { QUERIES = 64, MAX_POINTS = 16, CORNERS = 4 };

typedef struct {
    int heads, h, w;
} deformable_attr;

typedef struct {
    int64_t B, T, S, C, d, points;
    int64_t h, w, heads, blocks;        /* blocks of queries */
} sizes;

static sizes sizes_of(const lt_call *c)
{
    const deformable_attr *a = c->attr;
    sizes s = {
        .B = lt_dim(c->in[VALUE], 0), .T = lt_dim(c->in[LOGIT], 1), .S = lt_dim(c->in[VALUE], 1),
        .C = lt_dim(c->in[VALUE], 2), .h = a->h, .w = a->w, .heads = a->heads,
    };

    s.d = s.C / s.heads;
    s.points = lt_dim(c->in[LOGIT], 2) / s.heads;
    s.blocks = lt_ceil_div(s.T, QUERIES);
    return s;
}

static lt_status check_heads(lt_call *c)
{
    const deformable_attr *a = c->attr;
    const long long C = lt_dim(c->in[VALUE], 2), places = lt_dim(c->in[LOGIT], 2);

    if (a->heads < 1 || C % a->heads || places % a->heads)
        return lt_fail(c, "%d heads do not divide %lld channels and %lld weights", a->heads, C, places);
    if (places < a->heads || places > (long long)a->heads * MAX_POINTS)
        return lt_fail(c, "%lld weights for %d heads, want 1 to %d for each", places, a->heads, MAX_POINTS);
    return LT_OK;
}

static lt_status infer(lt_call *c)
{
    const deformable_attr *a = c->attr;
    const lt_tensor *logit = c->in[LOGIT];
    int64_t B, T;

    if (lt_want_rank(c, VALUE, "value", 3) || lt_want_rank(c, LOGIT, "weights", 3))
        return LT_ESHAPE;
    B = lt_dim(c->in[VALUE], 0);
    T = lt_dim(logit, 1);
    if (a->h < 1 || a->w < 1 || (int64_t)a->h * a->w != lt_dim(c->in[VALUE], 1))
        return lt_fail(c, "value has %lld cells, want those of a %d x %d map", (long long)lt_dim(c->in[VALUE], 1),
                       a->h, a->w);
    if (check_heads(c) || lt_want_shape(c, LOGIT, "weights", LT_SHAPE(B, T, lt_dim(logit, 2)))
        || lt_want_shape(c, OFFSET, "offsets", LT_SHAPE(B, T, 2 * lt_dim(logit, 2)))
        || lt_want_shape(c, REFERENCE, "reference", LT_SHAPE(T, 2)))
        return LT_ESHAPE;
    c->out->shape = LT_SHAPE(B, T, lt_dim(c->in[VALUE], 2));
    return LT_OK;
}

/* ---- some queries of one head ------------------------------------------------------------------------- */

/* By point, then by query: what A is, where samples are, which cells they read and what those weigh. */
typedef struct {
    sizes s;
    int64_t value_at, query_at, place_at;   /* elements before: in value, in y, in logit; twice in offset */
    int64_t rows;
    const lt_real *reference;
    lt_real share[MAX_POINTS][QUERIES], place[2 * MAX_POINTS][QUERIES];
    int32_t at[CORNERS * MAX_POINTS][QUERIES];
    lt_real weight[CORNERS * MAX_POINTS][QUERIES];
} queries;

static void add_reference(queries *q)
{
    for (int64_t r = 0; r < q->rows; r++)
        for (int64_t k = 0; k < 2 * q->s.points; k++)
            q->place[k][r] += q->reference[2 * r + k % 2];
}

/* Block `block` of head `head` of image b. */
static void look(const lt_call *c, int64_t b, int64_t head, int64_t block, queries *q)
{
    const sizes s = sizes_of(c);
    const int64_t t = block * QUERIES, all = s.heads * s.points;

    q->s = s;
    q->rows = lt_min_i64(QUERIES, s.T - t);
    q->value_at = b * s.S * s.C + head * s.d;
    q->query_at = (b * s.T + t) * s.C + head * s.d;
    q->place_at = (b * s.T + t) * all + head * s.points;
    q->reference = (const lt_real *)c->in[REFERENCE]->data + 2 * t;
    lt_k->turn(q->share[0], QUERIES, (const lt_real *)c->in[LOGIT]->data + q->place_at, all, q->rows, s.points,
               false);
    lt_k->softmax_down(q->share[0], QUERIES, s.points, (size_t)q->rows);
    lt_k->turn(q->place[0], QUERIES, (const lt_real *)c->in[OFFSET]->data + 2 * q->place_at, 2 * all, q->rows,
               2 * s.points, false);
    add_reference(q);
    for (int64_t k = 0; k < s.points; k++)
        lt_k->corners(q->at[CORNERS * k], q->weight[CORNERS * k], QUERIES, q->place[2 * k], q->place[2 * k + 1],
                      s.h, s.w, (size_t)q->rows);
}

/* Corner weights become those of the sum over points too. */
static void share_out(queries *q)
{
    for (int64_t k = 0; k < q->s.points; k++)
        for (int i = 0; i < CORNERS; i++)
            lt_k->mul(q->weight[CORNERS * k + i], q->weight[CORNERS * k + i], q->share[k], (size_t)q->rows);
}

static lt_samples samples_of(const lt_call *c, const queries *q)
{
    return (lt_samples){
        .x = (const lt_real *)c->in[VALUE]->data + q->value_at, .ldx = q->s.C, .d = q->s.d, .rows = q->rows,
        .taps = CORNERS * q->s.points, .stride = QUERIES, .at = q->at[0], .weight = q->weight[0],
    };
}

/* ---- forward ------------------------------------------------------------------------------------------ */

/* A thread's tasks have all heads of its queries: linear layers, by rows as well, write and read the same ones. */
static void forward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const sizes s = sizes_of(c);
    lt_samples samples;
    queries q;

    look(c, task / s.heads / s.blocks, task % s.heads, task / s.heads % s.blocks, &q);
    share_out(&q);
    samples = samples_of(c, &q);
    lt_k->sample((lt_real *)c->out->data + q.query_at, s.C, &samples);
}

static void forward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    lt_parallel_for(s.B * s.heads * s.blocks, forward_task, (void *)c);
}

/* ---- backward ----------------------------------------------------------------------------------------- */

/* By point, then by query: gradients of A and of places. */
typedef struct {
    lt_real dot[CORNERS * MAX_POINTS][QUERIES];
    lt_real share[MAX_POINTS][QUERIES], place[2 * MAX_POINTS][QUERIES];
} slopes;

static void measure(const lt_call *c, const queries *q, slopes *g)
{
    const lt_samples samples = samples_of(c, q);
    const sizes *s = &q->s;

    memset(g->dot, 0, (size_t)(CORNERS * s->points) * sizeof(g->dot[0]));
    lt_k->sample_dots(g->dot[0], c->dout + q->query_at, s->C, &samples);
    for (int64_t k = 0; k < s->points; k++) {
        lt_k->corners_grad(g->place[2 * k], g->place[2 * k + 1], g->share[k], QUERIES, g->dot[CORNERS * k],
                           q->place[2 * k], q->place[2 * k + 1], s->h, s->w, (size_t)q->rows);
        for (int i = 0; i < 2; i++)
            lt_k->mul(g->place[2 * k + i], g->place[2 * k + i], q->share[k], (size_t)q->rows);
    }
}

/* The softmax's gradient, in place. */
static void through_softmax(const queries *q, slopes *g)
{
    lt_real mean[QUERIES] = { 0 };

    for (int64_t k = 0; k < q->s.points; k++)
        lt_k->mul_to(mean, q->share[k], g->share[k], (size_t)q->rows);
    for (int64_t k = 0; k < q->s.points; k++) {
        lt_k->sub(g->share[k], g->share[k], mean, (size_t)q->rows);
        lt_k->mul(g->share[k], g->share[k], q->share[k], (size_t)q->rows);
    }
}

static void give(const lt_call *c, const queries *q, slopes *g)
{
    const int64_t all = q->s.heads * q->s.points;

    if (c->din[OFFSET])
        lt_k->turn(c->din[OFFSET] + 2 * q->place_at, 2 * all, g->place[0], QUERIES, 2 * q->s.points, q->rows,
                   !c->fresh[OFFSET]);
    if (!c->din[LOGIT])
        return;
    through_softmax(q, g);
    lt_k->turn(c->din[LOGIT] + q->place_at, all, g->share[0], QUERIES, q->s.points, q->rows, !c->fresh[LOGIT]);
}

static void backward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const sizes s = sizes_of(c);
    const int64_t b = task / s.heads, head = task % s.heads, value_at = b * s.S * s.C + head * s.d;

    for (int64_t i = 0; i < s.S; i++)
        op_start(c, VALUE, value_at + i * s.C, s.d);
    for (int64_t block = 0; block < s.blocks; block++) {
        lt_samples samples;
        queries q;
        slopes g;

        look(c, b, head, block, &q);
        if (c->din[OFFSET] || c->din[LOGIT]) {
            measure(c, &q, &g);
            give(c, &q, &g);
        }
        share_out(&q);
        samples = samples_of(c, &q);
        if (c->din[VALUE])
            lt_k->sample_spread(c->din[VALUE] + value_at, c->dout + q.query_at, s.C, &samples);
    }
}

static void backward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    lt_parallel_for(s.B * s.heads, backward_task, (void *)c);
}

/* Four corners of each point, and the weighing of points. */
static int64_t macs(const lt_call *c)
{
    const sizes s = sizes_of(c);

    return s.B * s.T * s.C * s.points * CORNERS;
}

/* (B heads, T, points, 2) from -1 to 1 between the outer edges of the map, as GridSample has it */
static const char *sample_places(lt_onnx *w, const lt_node *n, int64_t points)
{
    const deformable_attr *a = n->attr;
    const int64_t T = lt_dim(n->in[LOGIT], 1);
    const lt_real scale[2] = { (lt_real)(2.0 / a->w), (lt_real)(2.0 / a->h) };
    const lt_real shift[2] = { (lt_real)(1.0 / a->w - 1), (lt_real)(1.0 / a->h - 1) };
    const char *place = lt_onnx_reshape(w, lt_onnx_of(w, n->in[OFFSET]), LT_SHAPE(-1, T, a->heads, points, 2));
    const char *from = lt_onnx_reshape(w, lt_onnx_of(w, n->in[REFERENCE]), LT_SHAPE(T, 1, 2));

    place = LT_ONNX(w, "Add", lt_onnx_transpose(w, place, (int[]){ 0, 2, 1, 3, 4 }, 5), from);
    place = LT_ONNX(w, "Mul", place, lt_onnx_numbers(w, LT_SHAPE(2), scale));
    place = LT_ONNX(w, "Add", place, lt_onnx_numbers(w, LT_SHAPE(2), shift));
    return lt_onnx_reshape(w, place, LT_SHAPE(-1, T, points, 2));
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const deformable_attr *a = n->attr;
    const int64_t T = lt_dim(n->in[LOGIT], 1), C = lt_dim(n->in[VALUE], 2), heads = a->heads;
    const int64_t points = lt_dim(n->in[LOGIT], 2) / heads;
    const char *maps, *share, *y;

    maps = lt_onnx_reshape(w, lt_onnx_of(w, n->in[VALUE]), LT_SHAPE(-1, lt_dim(n->in[VALUE], 1), C));
    maps = lt_onnx_transpose(w, maps, (int[]){ 0, 2, 1 }, 3);
    maps = lt_onnx_reshape(w, maps, LT_SHAPE(-1, C / heads, a->h, a->w));
    y = LT_ONNX(w, "GridSample", maps, sample_places(w, n, points));             /* (B heads, d, T, points) */
    lt_onnx_text_of(w, "mode", "bilinear");
    lt_onnx_text_of(w, "padding_mode", "zeros");
    lt_onnx_int(w, "align_corners", 0);
    share = LT_ONNX(w, "Softmax", lt_onnx_reshape(w, lt_onnx_of(w, n->in[LOGIT]), LT_SHAPE(-1, T, heads, points)));
    lt_onnx_int(w, "axis", -1);
    share = lt_onnx_transpose(w, share, (int[]){ 0, 2, 1, 3 }, 4);
    share = lt_onnx_reshape(w, share, LT_SHAPE(-1, 1, T, points));
    y = lt_onnx_sum(w, LT_ONNX(w, "Mul", y, share), 3, false);
    y = lt_onnx_transpose(w, lt_onnx_reshape(w, y, LT_SHAPE(-1, C, T)), (int[]){ 0, 2, 1 }, 3);
    lt_onnx_is(w, n->outs[0], y);
}

static const lt_op deformable_attention_op = {
    .name = "deformable_attention", .flags = LT_OP_ASSIGNS,
    .keeps = LT_KEEP_IN(VALUE) | LT_KEEP_IN(OFFSET) | LT_KEEP_IN(LOGIT) | LT_KEEP_IN(REFERENCE),
    .infer = infer, .forward = forward, .backward = backward, .macs = macs, .onnx = onnx,
};

lt_tensor *(lt_deformable_attention)(lt_tensor *value, lt_tensor *offset, lt_tensor *logit, lt_tensor *reference,
                                     int heads, int h, int w)
{
    const deformable_attr a = { heads, h, w };

    return lt_apply(&deformable_attention_op, &a, sizeof(a),
                    (lt_tensor *[]){ value, offset, logit, reference }, 4);
}

lt_tensor *lt_cell_places(lt_graph *g, int h, int w)
{
    const int64_t n = (int64_t)h * w;
    lt_tensor *t;
    lt_real *at = lt_constant_reals(g, LT_SHAPE(n, 2), &t);

    for (int64_t i = 0; at && i < n; i++) {
        at[2 * i] = (lt_real)(i % w);
        at[2 * i + 1] = (lt_real)(i / w);
    }
    return t;
}
