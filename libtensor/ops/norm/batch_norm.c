/* SPDX-License-Identifier: Apache-2.0 */
/* batch_norm: y = (x - mean) / sqrt(var + eps) * weight + bias, per channel
 *                                                             [Ioffe and Szegedy 2015, algorithm 1]
 *   x (B, C, ...)   weight, bias, running mean, running var (C)   ->   y (B, C, ...)
 *   with n = (x - mean) rstd, N elements a channel:
 *   dbias = sum dy      dweight = sum dy n      dx = weight rstd (dy - dbias / N - n dweight / N)
 *
 * With gradients the mean and biased variance are the batch's, and backward puts the mean and the unbiased
 * variance where the running statistics collect them. Without, the running statistics make it a scale
 * and a shift (lower), which a convolution before it takes into its weights.
 *
 * Of a batch in parts it measures the whole: each part shares its sums, here and in backward.
 *
 * A plan with gradients lets it do what follows as well: y = act(batch_norm(x) + residual), with a leaky relu whose
 * result tells where its gradient passes, or, without a residual, silu.
 */
#include "libtensor/ops/norm/batch_norm.h"

enum { X, WEIGHT, BIAS, MEAN, VAR, RESIDUAL, INPUTS };

static lt_status infer(lt_call *c)
{
    static const char *const what[] = { "input", "weight", "bias", "running mean", "running var" };
    const norm_attr *a = c->attr;

    if (c->in[X]->shape.rank < 2)
        return lt_fail(c, "its input has no dimension 1 for channels");
    for (int i = WEIGHT; i <= VAR; i++)
        if (lt_want_shape(c, i, what[i], LT_SHAPE(lt_dim(c->in[X], 1))))
            return LT_ESHAPE;
    if (!(a->eps > 0))
        return lt_fail(c, "eps is %g, want a number above 0", a->eps);
    return op_same_shape(c);
}

/* What is saved of a channel: what the batch measured, and this part's sums. Forward's and backward's have places of
 * their own: between the two no part waits for another, which may still read the former when the latter are made. */
enum { MEASURE, SUMS, GRADIENT_SUMS };

typedef struct { double sum[2]; } sums;

void norm_plan(lt_call *c)
{
    if (!c->train)
        return;
    c->saved_bytes[MEASURE] = (size_t)lt_dim(c->in[X], 1) * sizeof(norm_measure);
    c->saved_bytes[SUMS] = c->saved_bytes[GRADIENT_SUMS] = (size_t)lt_dim(c->in[X], 1) * sizeof(sums);
}

static const lt_real *value(const lt_call *c, int i)
{
    return c->in[i]->data;
}

static int64_t plane_at(const lt_call *c, int64_t b, int64_t ch)
{
    return (b * lt_dim(c->in[X], 1) + ch) * op_inner(c->in[X], 1);
}

/* From a channel's plane of one image to that of the next */
static int64_t image_step(const lt_call *c)
{
    return lt_dim(c->in[X], 1) * op_inner(c->in[X], 1);
}

static int64_t count(const lt_call *c)
{
    return lt_dim(c->in[X], 0) * op_inner(c->in[X], 1);
}

double norm_count(const lt_call *c)
{
    return (double)count(c) * (c->part ? c->n_parts : 1);
}

static sums *sums_of(const lt_call *c, int which, int64_t ch)
{
    return (sums *)c->saved[which] + ch;
}

/* Over all parts, in their order */
static sums total(const lt_call *c, int which, int64_t ch)
{
    sums all = *sums_of(c->part ? c->part[0] : c, which, ch);

    for (int k = 1; c->part && k < c->n_parts; k++)
        for (int i = 0; i < 2; i++)
            all.sum[i] += sums_of(c->part[k], which, ch)->sum[i];
    return all;
}

void norm_sum(const lt_call *c, int64_t ch)
{
    lt_k->moments(sums_of(c, SUMS, ch)->sum, value(c, X) + plane_at(c, 0, ch), image_step(c), lt_dim(c->in[X], 0),
                  (size_t)op_inner(c->in[X], 1));
}

/* Sums in double of floats: x^2 - mean^2 loses nothing that a float could show. */
static norm_measure batch(const lt_call *c, int64_t ch)
{
    const norm_attr *a = c->attr;
    const double n = norm_count(c);
    const sums all = total(c, SUMS, ch);
    norm_measure m;

    m.mean = all.sum[0] / n;
    m.var = fmax(0, all.sum[1] / n - m.mean * m.mean);
    m.rstd = 1 / sqrt(m.var + a->eps);
    return m;
}

static norm_measure running(const lt_call *c, int64_t ch)
{
    const norm_attr *a = c->attr;
    const double var = value(c, VAR)[ch];

    return (norm_measure){ value(c, MEAN)[ch], var, 1 / sqrt(var + a->eps) };
}

norm_measure norm_measure_of(const lt_call *c, int64_t ch)
{
    norm_measure *m = (norm_measure *)c->saved[MEASURE] + ch;

    if (!c->train)
        return running(c, ch);
    *m = batch(c, ch);
    return *m;
}

const norm_measure *norm_saved(const lt_call *c, int64_t ch)
{
    return (const norm_measure *)c->saved[MEASURE] + ch;
}

norm_line norm_line_of(const lt_call *c, int64_t ch, const norm_measure *m)
{
    const double scale = value(c, WEIGHT)[ch] * m->rstd;

    return (norm_line){ (lt_real)scale, (lt_real)(value(c, BIAS)[ch] - m->mean * scale) };
}

static void normalise(const lt_call *c, int64_t ch, const norm_measure *m)
{
    const norm_attr *a = c->attr;
    const norm_line l = norm_line_of(c, ch, m);

    for (int64_t b = 0; b < lt_dim(c->out, 0); b++) {
        const int64_t at = plane_at(c, b, ch);

        lt_k->affine((lt_real *)c->out->data + at, value(c, X) + at, l.scale, l.shift,
                     c->in[RESIDUAL] ? value(c, RESIDUAL) + at : NULL, a->act, (size_t)op_inner(c->out, 1));
    }
}

static void finish_channel(const lt_call *c, int64_t ch)
{
    const norm_measure m = norm_measure_of(c, ch);

    normalise(c, ch, &m);
}

/* A channel at a time while it is in the cache, where there is no other part to wait for */
static void forward_channel(const lt_call *c, int64_t ch)
{
    if (c->train)
        norm_sum(c, ch);
    finish_channel(c, ch);
}

static void recompute_channel(const lt_call *c, int64_t ch)
{
    const norm_measure m = c->train ? *norm_saved(c, ch) : running(c, ch);

    normalise(c, ch, &m);
}

static void by_channel(const lt_call *c, op_row_fn fn)
{
    op_by_row(c, lt_dim(c->out, 1), count(c), fn);
}

static void forward_share(const lt_call *c)
{
    by_channel(c, norm_sum);
}

static void forward(const lt_call *c)
{
    by_channel(c, c->part ? finish_channel : forward_channel);
}

static void recompute(const lt_call *c)
{
    by_channel(c, recompute_channel);
}

/* All parts add the same statistics, a share each. */
void norm_collect(const lt_call *c, int64_t ch)
{
    const norm_measure *m = norm_saved(c, ch);
    const double *sum = sums_of(c, GRADIENT_SUMS, ch)->sum;
    const double n = norm_count(c), share = 1.0 / (c->part ? c->n_parts : 1);
    const bool some = n > 1;                            /* one value says nothing of others: running ones stay */
    const double add[] = { [WEIGHT] = sum[1] * m->rstd, [BIAS] = sum[0],
                           [MEAN] = share * (some ? m->mean : (double)value(c, MEAN)[ch]),
                           [VAR] = share * (some ? m->var * n / (n - 1) : (double)value(c, VAR)[ch]) };

    for (int i = WEIGHT; i <= VAR; i++)
        if (c->din[i])
            c->din[i][ch] += (lt_real)add[i];
}

void norm_save_gradient(const lt_call *c, int64_t ch, const double sum[2])
{
    memcpy(sums_of(c, GRADIENT_SUMS, ch)->sum, sum, sizeof(sums));
}

norm_gradient norm_gradient_of(const lt_call *c, int64_t ch)
{
    const norm_measure *m = norm_saved(c, ch);
    const sums all = total(c, GRADIENT_SUMS, ch);
    norm_gradient g = { .s = value(c, WEIGHT)[ch] * m->rstd };

    g.t = -g.s * m->rstd * (all.sum[1] * m->rstd) / norm_count(c);
    g.u = -g.s * all.sum[0] / norm_count(c) - g.t * m->mean;
    return g;
}

lt_behind norm_behind(const lt_call *c, int64_t ch)
{
    const lt_act act = ((const norm_attr *)c->attr)->act;
    const norm_line l = norm_line_of(c, ch, norm_saved(c, ch));

    return (lt_behind){ .slope = act.param, .a = l.scale, .b = l.shift, .silu = act.kind == LT_ACT_SILU };
}

/* The activation at the first plane of a channel; NULL where there is none. The result is read where a residual went
 * into it; else x says what went in, and x is read anyway. */
static const lt_behind *behind_of(const lt_call *c, int64_t ch, lt_behind *behind)
{
    *behind = norm_behind(c, ch);
    if (c->in[RESIDUAL])
        behind->y = (const lt_real *)c->out->data + plane_at(c, 0, ch);
    return ((const norm_attr *)c->attr)->act.kind == LT_ACT_NONE ? NULL : behind;
}

static void backward_residual(const lt_call *c, int64_t at, size_t n, const lt_real *dy, const lt_behind *behind)
{
    op_start(c, RESIDUAL, at, (int64_t)n);
    if (behind)
        lt_k->leaky_relu_grad(c->din[RESIDUAL] + at, dy + at, behind->y, behind->slope, n);
    else
        lt_k->add_to(c->din[RESIDUAL] + at, dy + at, n);
}

/* dx may be dy: of the two, the residual's gradient comes first. */
static void backward_plane(const lt_call *c, int64_t at, size_t n, const lt_real *dy, const lt_behind *behind,
                           const norm_gradient *g)
{
    if (c->in[RESIDUAL] && c->din[RESIDUAL])
        backward_residual(c, at, n, dy, behind);
    if (c->din[X])
        lt_k->affine_grad(c->din[X] + at, dy + at, behind, value(c, X) + at, (lt_real)g->s, (lt_real)g->t,
                          (lt_real)g->u, !c->fresh[X], n);
}

/* Whether what comes through the activation is kept where dx will be */
static bool comes_through(const lt_call *c)
{
    return ((const norm_attr *)c->attr)->act.kind != LT_ACT_NONE && c->din[X] && c->fresh[X];
}

static void sum_gradient(const lt_call *c, int64_t ch)
{
    const int64_t first = plane_at(c, 0, ch);
    const lt_through to = { .dz = comes_through(c) ? c->din[X] + first : NULL };
    lt_behind store;
    double sum[2];

    lt_k->grad_moments(sum, to.dz ? &to : NULL, c->dout + first, behind_of(c, ch, &store), value(c, X) + first,
                       norm_saved(c, ch)->mean, image_step(c), lt_dim(c->out, 0), (size_t)op_inner(c->out, 1));
    norm_save_gradient(c, ch, sum);
}

static void finish_gradient(const lt_call *c, int64_t ch)
{
    const int64_t first = plane_at(c, 0, ch), step = image_step(c);
    const bool through = comes_through(c);
    const norm_gradient g = norm_gradient_of(c, ch);
    lt_behind store;
    const lt_behind *behind = behind_of(c, ch, &store);

    for (int64_t b = 0; b < lt_dim(c->out, 0); b++) {
        backward_plane(c, first + b * step, (size_t)op_inner(c->out, 1), through ? c->din[X] : c->dout,
                       through ? NULL : behind, &g);
        store.y = store.y ? store.y + step : NULL;
    }
    norm_collect(c, ch);
}

static void backward_channel(const lt_call *c, int64_t ch)
{
    sum_gradient(c, ch);
    finish_gradient(c, ch);
}

static void backward_share(const lt_call *c)
{
    by_channel(c, sum_gradient);
}

static void backward(const lt_call *c)
{
    for (int i = WEIGHT; i <= VAR; i++)
        op_start(c, i, 0, lt_dim(c->out, 1));
    by_channel(c, c->part ? finish_gradient : backward_channel);
}

/* ---- without gradients: scale = weight / sqrt(var + eps), shift = bias - mean scale -------------------- */

static lt_status fold_infer(lt_call *c)
{
    c->outs[0]->shape = c->outs[1]->shape = c->in[0]->shape;
    return LT_OK;
}

static void fold_forward(const lt_call *c)
{
    const norm_attr *a = c->attr;
    lt_real *scale = c->outs[0]->data, *shift = c->outs[1]->data;

    for (int64_t i = 0; i < lt_numel(c->out); i++) {
        const double s = value(c, 0)[i] / sqrt(value(c, 3)[i] + a->eps);

        scale[i] = (lt_real)s;
        shift[i] = (lt_real)(value(c, 1)[i] - value(c, 2)[i] * s);
    }
}

static const lt_op fold_op = {
    .name = "batch_norm_fold", .n_out = 2, .infer = fold_infer, .forward = fold_forward,
};

static lt_tensor *lower(const lt_node *node, lt_tensor *const *in)
{
    lt_tensor *scale = lt_apply(&fold_op, node->attr, sizeof(norm_attr), in + WEIGHT, 4);

    return lt_channel_affine(in[X], scale, lt_result(scale, 1));
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "BatchNormalization");
    lt_onnx_float(w, "epsilon", ((const norm_attr *)n->attr)->eps);
}

static bool absorb_for_training(lt_node *node, const lt_tail *tail);

#define BATCH_NORM(cheap, kept) {                                                                   \
    .name = "batch_norm", .flags = LT_OP_ASSIGNS | LT_OP_INPLACE_GRAD | (cheap), \
    .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(WEIGHT) | (kept), \
    .optional = LT_OPTIONAL_IN(RESIDUAL), .infer = infer, .plan = norm_plan, .forward = forward, .backward = backward, \
    .forward_share = forward_share, .backward_share = backward_share, .recompute = recompute, .lower = lower, \
    .absorb_for_training = absorb_for_training, .onnx = onnx, \
}

/* With an activation the gradient reads the bias as well, or, behind a residual, the result. Then making it again is
 * not cheap any more. */
static const lt_op batch_norm_op = BATCH_NORM(LT_OP_CHEAP, 0);
static const lt_op with_act_op = BATCH_NORM(LT_OP_CHEAP, LT_KEEP_IN(BIAS));
static const lt_op with_residual_op = BATCH_NORM(0, LT_KEEP_IN(BIAS) | LT_KEEP_OUT(0));

/* Silu's wants what went into it, which a residual hides. */
static bool has_gradient(const lt_node *node, const lt_tail *tail)
{
    const lt_act_kind kind = tail->act.kind;

    return kind == LT_ACT_NONE || kind == LT_ACT_RELU || kind == LT_ACT_LEAKY_RELU
           || (kind == LT_ACT_SILU && !tail->addend && !node->in[RESIDUAL]);
}

static bool absorb_for_training(lt_node *node, const lt_tail *tail)
{
    norm_attr *a = node->attr;

    if (tail->scale || a->act.kind != LT_ACT_NONE || (tail->addend && node->in[RESIDUAL]) || !has_gradient(node, tail))
        return false;
    if (tail->addend)
        node->in[RESIDUAL] = tail->addend;
    a->act = tail->act;
    node->op = node->in[RESIDUAL] ? &with_residual_op : &with_act_op;
    return true;
}

/* With weights that learn it is the batch that it measures, whoever does its work. */
const norm_attr *norm_before(const lt_node *node)
{
    const lt_tensor *weight = node->in[WEIGHT];

    if (node->op->forward != forward || node->in[RESIDUAL]
        || !(weight->param ? !weight->param->frozen : weight->wants_grad))
        return NULL;
    return node->attr;
}

lt_tensor *(lt_batch_norm)(lt_tensor *x, lt_tensor *weight, lt_tensor *bias, lt_tensor *running_mean,
                           lt_tensor *running_var, double eps)
{
    const norm_attr a = { .eps = eps };
    lt_tensor *const in[INPUTS] = { x, weight, bias, running_mean, running_var };

    return lt_apply(&batch_norm_op, &a, sizeof(a), in, INPUTS);
}
