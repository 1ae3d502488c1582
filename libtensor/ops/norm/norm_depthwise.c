/* SPDX-License-Identifier: Apache-2.0 */
/* norm_depthwise: y = depthwise(act(batch_norm(x)), w), what plans with gradients make of the two
 *   x (B, C, H, W)   weight, bias, running mean, running var (C)   w (C, 1, kh, kw)   ->   y (B, C, H', W')
 *
 * The map between, the widest of an inverted bottleneck, exists one image and channel at a time, in a thread's scratch;
 * its gradient begins where that of x will be. y is as conv2d and batch_norm have it, bit by bit; of the gradients the
 * sums over a channel, in double, have another order.
 */
#include "libtensor/ops/norm/norm_depthwise.h"

#include "libtensor/kernels/conv/depthwise.h"
#include "libtensor/kernels/gemm/product.h"
#include "libtensor/ops/norm/batch_norm.h"

enum { X, KERNEL = NORM_INPUTS, INPUTS };

typedef struct {
    norm_attr norm;                     /* first, as batch_norm.h wants it */
    lt_depthwise_maps maps;
} norm_depthwise_attr;

/* A channel, and the scratch of whoever works on it: the map between, and its gradient where x has none to begin */
typedef struct {
    const lt_call *c;
    const norm_depthwise_attr *a;
    int64_t ch;
    const lt_real *w;
    lt_real *map, *dmap;
} channel;

static size_t map_size(const channel *s)
{
    return (size_t)(s->a->maps.p.h * s->a->maps.p.w);
}

/* Where channel ch of image b is in x, and in y */
static int64_t x_at(const channel *s, int64_t b)
{
    return (b * s->a->maps.p.c + s->ch) * (int64_t)map_size(s);
}

static int64_t y_at(const channel *s, int64_t b)
{
    return (b * s->a->maps.p.c + s->ch) * s->a->maps.forward.out_h * s->a->maps.forward.out_w;
}

static const lt_real *x_of(const channel *s, int64_t b)
{
    return (const lt_real *)s->c->in[X]->data + x_at(s, b);
}

static const lt_real *dy_of(const channel *s, int64_t b)
{
    return s->c->dout + y_at(s, b);
}

static void make_map(const channel *s, int64_t b, const norm_measure *m)
{
    const norm_line l = norm_line_of(s->c, s->ch, m);

    lt_k->affine(s->map, x_of(s, b), l.scale, l.shift, NULL, s->a->norm.act, map_size(s));
}

typedef void (*channel_fn)(channel *s);
typedef struct { channel s; channel_fn fn; } channel_job;

static void in_scratch(void *ctx, lt_real *a, lt_real *b)
{
    channel_job *j = ctx;

    j->s.map = a, j->s.dmap = b;
    j->fn(&j->s);
}

static void with_channel(const lt_call *c, int64_t ch, channel_fn fn)
{
    const norm_depthwise_attr *a = c->attr;
    const lt_real *w = c->in[KERNEL]->data;
    channel_job j = { { .c = c, .a = a, .ch = ch, .w = w + ch * a->maps.p.kh * a->maps.p.kw }, fn };

    lt_with_scratch(in_scratch, &j);
}

/* ---- forward ---- */

static void forward_maps(channel *s)
{
    const norm_measure m = norm_measure_of(s->c, s->ch);

    for (int64_t b = 0; b < s->a->maps.p.n; b++) {
        make_map(s, b, &m);
        lt_depthwise_map(&s->a->maps, s->map, s->w, (lt_real *)s->c->out->data + y_at(s, b));
    }
}

static void finish_channel(const lt_call *c, int64_t ch)
{
    with_channel(c, ch, forward_maps);
}

static void forward_channel(const lt_call *c, int64_t ch)
{
    if (c->train)
        norm_sum(c, ch);
    finish_channel(c, ch);
}

static void by_channel(const lt_call *c, op_row_fn fn)
{
    if (lt_numel(c->in[X]))
        op_by_row(c, lt_dim(c->in[X], 1), lt_numel(c->in[X]) / lt_dim(c->in[X], 1), fn);
}

static void forward_share(const lt_call *c)
{
    by_channel(c, norm_sum);
}

static void forward(const lt_call *c)
{
    by_channel(c, c->part ? finish_channel : forward_channel);
}

/* ---- backward ---- */

/* What came through the activation to image b's map, in dz, and the map itself; the sums of dz are added. */
static void come_through(const channel *s, int64_t b, lt_real *dz, double sum[2])
{
    const lt_act_kind act = s->a->norm.act.kind;
    const lt_behind behind = norm_behind(s->c, s->ch);
    const lt_through to = { .dz = dz, .silu = s->map };
    double more[2];

    lt_depthwise_map_data(&s->a->maps, dy_of(s, b), s->w, dz);
    lt_k->grad_moments(more, &to, dz, act == LT_ACT_NONE ? NULL : &behind, x_of(s, b), norm_saved(s->c, s->ch)->mean, 0,
                       1, map_size(s));
    sum[0] += more[0], sum[1] += more[1];
    if (act != LT_ACT_SILU)
        make_map(s, b, norm_saved(s->c, s->ch));
}

/* Image b's part of the window's gradient, of its map */
static void add_to_window(const channel *s, int64_t b, double *window)
{
    const int64_t next = lt_min_i64(b + 1, s->a->maps.p.n - 1);

    if (s->c->din[KERNEL])
        lt_depthwise_map_weights(&s->a->maps, window, s->map, dy_of(s, b), x_of(s, next), dy_of(s, next));
}

/* Where dx begins, it holds what came through until the sums are known; else that is made twice. */
static bool keeps_what_comes_through(const lt_call *c)
{
    return c->din[X] && c->fresh[X];
}

static void sum_maps(channel *s)
{
    const lt_call *c = s->c;
    double sum[2] = { 0 }, window[LT_DEPTHWISE_SUMS] = { 0 };

    for (int64_t b = 0; b < s->a->maps.p.n; b++) {
        come_through(s, b, keeps_what_comes_through(c) ? c->din[X] + x_at(s, b) : s->dmap, sum);
        add_to_window(s, b, window);
    }
    norm_save_gradient(c, s->ch, sum);
    if (c->din[KERNEL])
        lt_depthwise_sum_weights(&s->a->maps, window, c->din[KERNEL] + s->ch * s->a->maps.p.kh * s->a->maps.p.kw);
}

static void finish_maps(channel *s)
{
    const lt_call *c = s->c;
    const bool kept = keeps_what_comes_through(c);
    const norm_gradient g = norm_gradient_of(c, s->ch);
    double again[2] = { 0 };

    for (int64_t b = 0; c->din[X] && b < s->a->maps.p.n; b++) {
        lt_real *dx = c->din[X] + x_at(s, b);

        if (!kept)
            come_through(s, b, s->dmap, again);
        lt_k->affine_grad(dx, kept ? dx : s->dmap, NULL, x_of(s, b), (lt_real)g.s, (lt_real)g.t, (lt_real)g.u, !kept,
                          map_size(s));
    }
    norm_collect(c, s->ch);
}

static void backward_maps(channel *s)
{
    sum_maps(s);
    finish_maps(s);
}

static void sum_gradient(const lt_call *c, int64_t ch)
{
    with_channel(c, ch, sum_maps);
}

static void finish_gradient(const lt_call *c, int64_t ch)
{
    with_channel(c, ch, finish_maps);
}

static void backward_channel(const lt_call *c, int64_t ch)
{
    with_channel(c, ch, backward_maps);
}

static void start_kernel(const lt_call *c)
{
    op_start(c, KERNEL, 0, lt_numel(c->in[KERNEL]));
}

static void backward_share(const lt_call *c)
{
    start_kernel(c);
    by_channel(c, sum_gradient);
}

static void backward(const lt_call *c)
{
    for (int i = NORM_WEIGHT; i <= NORM_VAR; i++)
        op_start(c, i, 0, lt_dim(c->in[X], 1));
    if (!c->part)
        start_kernel(c);
    by_channel(c, c->part ? finish_gradient : backward_channel);
}

static int64_t macs(const lt_call *c)
{
    return lt_numel(c->out) * lt_dim(c->in[KERNEL], 2) * lt_dim(c->in[KERNEL], 3);
}

static const lt_op norm_depthwise_op = {
    .name = "norm_depthwise", .flags = LT_OP_ASSIGNS,
    .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(NORM_WEIGHT) | LT_KEEP_IN(NORM_BIAS) | LT_KEEP_IN(KERNEL),
    .plan = norm_plan, .forward = forward, .backward = backward, .forward_share = forward_share,
    .backward_share = backward_share, .macs = macs,
};

bool op_norm_depthwise(lt_node *node, const lt_node *before, lt_tensor *w, const lt_conv2d_params *p)
{
    const norm_attr *norm = norm_before(before);
    norm_depthwise_attr a;
    lt_tensor *in[INPUTS];

    if (!norm || !lt_depthwise_by_maps(&a.maps, p))
        return false;
    a.norm = *norm;
    memcpy(in, before->in, NORM_INPUTS * sizeof(in[0]));
    in[KERNEL] = w;
    return lt_become(node, &norm_depthwise_op, &a, sizeof(a), in, INPUTS);
}
