/* SPDX-License-Identifier: Apache-2.0 */
/* mse_loss: y = mean of (a - b)^2; l1_loss: y = mean of |a - b|; smooth_l1_loss: y = mean of (a - b)^2 / 2 where
 * |a - b| < 1, |a - b| - 1/2 elsewhere; cross_entropy: y = mean over rows of
 * -sum_c b_c log softmax(a)_c; each sample of dimension 0 weighed.
 *   y = sum_s w_s f_s / (E sum_s w_s), f_s the sum over the E elements (cross_entropy: rows) of sample s
 *   mse            da += dy 2 (a - b) w_s / (E sum w)         db the negative
 *   l1             da += dy sign(a - b) w_s / (E sum w)       db the negative; 0 where a = b
 *   smooth_l1      da += dy (a - b cut off at -1 and 1) w_s / (E sum w)         db the negative
 *   cross_entropy  da += dy (softmax(a) sum_c b_c - b) w_s / (E sum w)
 *                  db -= dy log softmax(a) w_s / (E sum w)
 *
 * Without weights all are 1. When they sum to 0, so does y.
 */
#include "libtensor/ops/common.h"

enum { A, B, WEIGHT };

static int64_t samples_of(const lt_call *c)
{
    return c->in[A]->shape.rank ? lt_dim(c->in[A], 0) : 1;
}

static int64_t elements_of(const lt_call *c)
{
    return c->in[A]->shape.rank ? op_inner(c->in[A], 0) : 1;
}

static lt_status infer(lt_call *c)
{
    if (lt_want_shape(c, B, "second operand", c->in[A]->shape))
        return LT_ESHAPE;
    if (c->in[WEIGHT] && lt_want_shape(c, WEIGHT, "weight", LT_SHAPE(samples_of(c))))
        return LT_ESHAPE;
    c->out->shape = (lt_shape){ 0 };
    return LT_OK;
}

/* Each sample's sum waits here to be added in order; on the way back, the total weight. */
static void plan(lt_call *c)
{
    c->work_bytes = (size_t)lt_max_i64(1, samples_of(c)) * sizeof(double);
}

static double weight_of(const lt_call *c, int64_t s)
{
    return c->in[WEIGHT] ? ((const lt_real *)c->in[WEIGHT]->data)[s] : 1;
}

/* terms: how many a sample's sum has */
static double total_weight(const lt_call *c, int64_t terms)
{
    double sum = 0;

    for (int64_t s = 0; s < samples_of(c); s++)
        sum += weight_of(c, s);
    return sum * (double)terms;
}

static const lt_real *sample(const lt_call *c, int i, int64_t s)
{
    return (const lt_real *)c->in[i]->data + s * elements_of(c);
}

static void mse_sample(const lt_call *c, int64_t s)
{
    const lt_real *a = sample(c, A, s), *b = sample(c, B, s);
    double sum = 0;

    for (int64_t i = 0; i < elements_of(c); i++) {
        const double d = (double)a[i] - b[i];

        sum += d * d;
    }
    ((double *)c->work)[s] = sum;
}

static void l1_sample(const lt_call *c, int64_t s)
{
    const lt_real *a = sample(c, A, s), *b = sample(c, B, s);
    double sum = 0;

    for (int64_t i = 0; i < elements_of(c); i++)
        sum += fabs((double)a[i] - b[i]);
    ((double *)c->work)[s] = sum;
}

static void smooth_l1_sample(const lt_call *c, int64_t s)
{
    const lt_real *a = sample(c, A, s), *b = sample(c, B, s);
    double sum = 0;

    for (int64_t i = 0; i < elements_of(c); i++) {
        const double d = fabs((double)a[i] - b[i]);

        sum += d < 1 ? d * d / 2 : d - 0.5;
    }
    ((double *)c->work)[s] = sum;
}

/* A sample of weight 0 stays out, whatever it holds. */
static void run_forward(const lt_call *c, int64_t terms, op_row_fn fn)
{
    const double total = total_weight(c, terms);
    double sum = 0;

    op_by_row(c, samples_of(c), elements_of(c), fn);
    for (int64_t s = 0; s < samples_of(c); s++)
        if (weight_of(c, s) != 0)
            sum += weight_of(c, s) * ((const double *)c->work)[s];
    *(lt_real *)c->out->data = (lt_real)(total <= 0 ? 0 : sum / total);
}

static void mse_forward(const lt_call *c) { run_forward(c, elements_of(c), mse_sample); }
static void l1_forward(const lt_call *c) { run_forward(c, elements_of(c), l1_sample); }
static void smooth_l1_forward(const lt_call *c) { run_forward(c, elements_of(c), smooth_l1_sample); }

/* What one term's gradient is multiplied with; 0 for a sample that stays out. */
static lt_real factor(const lt_call *c, int64_t s)
{
    const double total = *(const double *)c->work;

    return total <= 0 ? 0 : (lt_real)(*c->dout * weight_of(c, s) / total);
}

static void give(const lt_call *c, int64_t i, lt_real g)
{
    if (c->din[A])
        c->din[A][i] += g;
    if (c->din[B])
        c->din[B][i] -= g;
}

static void mse_grad_sample(const lt_call *c, int64_t s)
{
    const lt_real *a = sample(c, A, s), *b = sample(c, B, s), f = 2 * factor(c, s);

    for (int64_t i = 0; f != 0 && i < elements_of(c); i++)
        give(c, s * elements_of(c) + i, f * (a[i] - b[i]));
}

static void l1_grad_sample(const lt_call *c, int64_t s)
{
    const lt_real *a = sample(c, A, s), *b = sample(c, B, s), f = factor(c, s);

    for (int64_t i = 0; f != 0 && i < elements_of(c); i++)
        give(c, s * elements_of(c) + i, f * (lt_real)((a[i] > b[i]) - (a[i] < b[i])));
}

static void smooth_l1_grad_sample(const lt_call *c, int64_t s)
{
    const lt_real *a = sample(c, A, s), *b = sample(c, B, s), f = factor(c, s);

    for (int64_t i = 0; f != 0 && i < elements_of(c); i++) {
        const lt_real d = a[i] - b[i];

        give(c, s * elements_of(c) + i, f * (d > 1 ? 1 : d < -1 ? -1 : d));
    }
}

static void run_backward(const lt_call *c, int64_t terms, int64_t rows, int64_t row_cost, op_row_fn fn)
{
    *(double *)c->work = total_weight(c, terms);
    op_by_row(c, rows, row_cost, fn);
}

static void mse_backward(const lt_call *c)
{
    run_backward(c, elements_of(c), samples_of(c), elements_of(c), mse_grad_sample);
}

static void l1_backward(const lt_call *c)
{
    run_backward(c, elements_of(c), samples_of(c), elements_of(c), l1_grad_sample);
}

static void smooth_l1_backward(const lt_call *c)
{
    run_backward(c, elements_of(c), samples_of(c), elements_of(c), smooth_l1_grad_sample);
}

/* ---- cross entropy: a are logits, b what their softmax should be ---- */

static int64_t classes_of(const lt_call *c)
{
    return lt_dim(c->in[A], -1);
}

static int64_t rows_of(const lt_call *c)
{
    return elements_of(c) / classes_of(c);
}

static lt_status entropy_infer(lt_call *c)
{
    char text[LT_SHAPE_TEXT];

    if (c->in[A]->shape.rank < 2 || !classes_of(c))
        return lt_fail(c, "logits is %s, want samples and at least one class", lt_shape_text(&c->in[A]->shape, text));
    return infer(c);
}

/* softmax(a): saved, or behind the sums in the scratch where nothing goes back */
static void entropy_plan(lt_call *c)
{
    const size_t bytes = (size_t)lt_numel(c->in[A]) * sizeof(lt_real);

    plan(c);
    if (c->train)
        c->saved_bytes[0] = bytes;
    else
        c->work_bytes += bytes;
}

static lt_real *softmax_of(const lt_call *c)
{
    return c->train ? c->saved[0] : (void *)((double *)c->work + samples_of(c));
}

/* log sum_c exp(a_c) of a row whose softmax is q: by the largest, whose q is no less than 1 / n */
static double log_sum_exp(const lt_real *a, const lt_real *q, int64_t n)
{
    int64_t largest = 0;

    for (int64_t i = 1; i < n; i++)
        if (a[i] > a[largest])
            largest = i;
    return (double)a[largest] - log((double)q[largest]);
}

static void entropy_sample(const lt_call *c, int64_t s)
{
    const int64_t n = classes_of(c);
    const lt_real *a = sample(c, A, s), *b = sample(c, B, s);
    lt_real *q = softmax_of(c) + s * elements_of(c);
    double sum = 0;

    for (int64_t row = 0; row < rows_of(c); row++, a += n, b += n, q += n) {
        double log_sum;
        lt_k->softmax(q, a, (size_t)n);
        log_sum = log_sum_exp(a, q, n);
        for (int64_t i = 0; i < n; i++)
            sum += b[i] != 0 ? b[i] * (log_sum - a[i]) : 0;
    }
    ((double *)c->work)[s] = sum;
}

static void entropy_forward(const lt_call *c)
{
    run_forward(c, rows_of(c), entropy_sample);
}

static void entropy_grad_row(const lt_call *c, int64_t row)
{
    const int64_t n = classes_of(c), at = row * n;
    const lt_real f = factor(c, at / elements_of(c));
    const lt_real *a = (const lt_real *)c->in[A]->data + at, *b = (const lt_real *)c->in[B]->data + at;
    const lt_real *q = (const lt_real *)c->saved[0] + at;
    lt_real sum = 0;

    if (f == 0)
        return;
    for (int64_t i = 0; i < n; i++)
        sum += b[i];
    for (int64_t i = 0; c->din[A] && i < n; i++)
        c->din[A][at + i] += f * (q[i] * sum - b[i]);
    if (!c->din[B])
        return;
    for (int64_t i = 0; i < n; i++)
        c->din[B][at + i] += f * (lt_real)(log_sum_exp(a, q, n) - a[i]);
}

static void entropy_backward(const lt_call *c)
{
    if (elements_of(c))
        run_backward(c, rows_of(c), samples_of(c) * rows_of(c), classes_of(c), entropy_grad_row);
}

static const lt_op mse_loss_op = {
    .name = "mse_loss", .optional = LT_OPTIONAL_IN(WEIGHT), .infer = infer, .plan = plan,
    .forward = mse_forward, .backward = mse_backward,
};

static const lt_op l1_loss_op = {
    .name = "l1_loss", .optional = LT_OPTIONAL_IN(WEIGHT), .infer = infer, .plan = plan,
    .forward = l1_forward, .backward = l1_backward,
};

static const lt_op smooth_l1_loss_op = {
    .name = "smooth_l1_loss", .optional = LT_OPTIONAL_IN(WEIGHT), .infer = infer, .plan = plan,
    .forward = smooth_l1_forward, .backward = smooth_l1_backward,
};

static const lt_op cross_entropy_op = {
    .name = "cross_entropy", .optional = LT_OPTIONAL_IN(WEIGHT), .infer = entropy_infer, .plan = entropy_plan,
    .forward = entropy_forward, .backward = entropy_backward,
};

lt_tensor *(lt_mse_loss)(lt_tensor *a, lt_tensor *b, lt_tensor *weight)
{
    return lt_apply(&mse_loss_op, NULL, 0, (lt_tensor *[]){ a, b, weight }, 3);
}

lt_tensor *(lt_l1_loss)(lt_tensor *a, lt_tensor *b, lt_tensor *weight)
{
    return lt_apply(&l1_loss_op, NULL, 0, (lt_tensor *[]){ a, b, weight }, 3);
}

lt_tensor *(lt_smooth_l1_loss)(lt_tensor *a, lt_tensor *b, lt_tensor *weight)
{
    return lt_apply(&smooth_l1_loss_op, NULL, 0, (lt_tensor *[]){ a, b, weight }, 3);
}

lt_tensor *(lt_cross_entropy)(lt_tensor *logits, lt_tensor *target, lt_tensor *weight)
{
    return lt_apply(&cross_entropy_op, NULL, 0, (lt_tensor *[]){ logits, target, weight }, 3);
}
