/* SPDX-License-Identifier: Apache-2.0 */
/* mse_loss: y = mean of (a - b)^2; l1_loss: y = mean of |a - b|; each sample of dimension 0 weighed.
 *   y = sum_s w_s f_s / (E sum_s w_s), f_s the sum over the E elements of sample s
 *   mse  da += dy 2 (a - b) w_s / (E sum w)         db the negative
 *   l1   da += dy sign(a - b) w_s / (E sum w)       db the negative; 0 where a = b
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

/* Each sample's sum waits here to be added in order. */
static void plan(lt_call *c)
{
    c->work_bytes = (size_t)samples_of(c) * sizeof(double);
}

static double weight_of(const lt_call *c, int64_t s)
{
    return c->in[WEIGHT] ? ((const lt_real *)c->in[WEIGHT]->data)[s] : 1;
}

static double total_weight(const lt_call *c)
{
    double sum = 0;

    for (int64_t s = 0; s < samples_of(c); s++)
        sum += weight_of(c, s);
    return sum * (double)elements_of(c);
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

/* A sample of weight 0 stays out, whatever it holds. */
static void run_forward(const lt_call *c, op_row_fn fn)
{
    const double total = total_weight(c);
    double sum = 0;

    op_by_row(c, samples_of(c), elements_of(c), fn);
    for (int64_t s = 0; s < samples_of(c); s++)
        if (weight_of(c, s) != 0)
            sum += weight_of(c, s) * ((const double *)c->work)[s];
    *(lt_real *)c->out->data = (lt_real)(total > 0 ? sum / total : 0);
}

static void mse_forward(const lt_call *c) { run_forward(c, mse_sample); }
static void l1_forward(const lt_call *c) { run_forward(c, l1_sample); }

/* What one element's difference is multiplied with; 0 for a sample that stays out. */
static lt_real factor(const lt_call *c, int64_t s)
{
    const double total = total_weight(c);

    return total > 0 ? (lt_real)(*c->dout * weight_of(c, s) / total) : 0;
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

static void mse_backward(const lt_call *c)
{
    op_by_row(c, samples_of(c), elements_of(c), mse_grad_sample);
}

static void l1_backward(const lt_call *c)
{
    op_by_row(c, samples_of(c), elements_of(c), l1_grad_sample);
}

static const lt_op mse_loss_op = {
    .name = "mse_loss", .optional = LT_OPTIONAL_IN(WEIGHT), .infer = infer, .plan = plan,
    .forward = mse_forward, .backward = mse_backward,
};

static const lt_op l1_loss_op = {
    .name = "l1_loss", .optional = LT_OPTIONAL_IN(WEIGHT), .infer = infer, .plan = plan,
    .forward = l1_forward, .backward = l1_backward,
};

lt_tensor *(lt_mse_loss)(lt_tensor *a, lt_tensor *b, lt_tensor *weight)
{
    return lt_apply(&mse_loss_op, NULL, 0, (lt_tensor *[]){ a, b, weight }, 3);
}

lt_tensor *(lt_l1_loss)(lt_tensor *a, lt_tensor *b, lt_tensor *weight)
{
    return lt_apply(&l1_loss_op, NULL, 0, (lt_tensor *[]){ a, b, weight }, 3);
}
