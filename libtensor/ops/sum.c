/* SPDX-License-Identifier: Apache-2.0 */
/* sum: y = the sum of all elements.
 *   dx += dy
 */
#include "libtensor/ops/common.h"

static lt_status infer(lt_call *c)
{
    c->out->shape = (lt_shape){ 0 };
    return LT_OK;
}

static void forward(const lt_call *c)
{
    *(lt_real *)c->out->data = (lt_real)lt_k->sum(c->in[0]->data, (size_t)lt_numel(c->in[0]));
}

static void backward(const lt_call *c)
{
    for (int64_t i = 0; c->din[0] && i < lt_numel(c->in[0]); i++)
        c->din[0][i] += *c->dout;
}

static const lt_op sum_op = {
    .name = "sum", .keeps = LT_KEEP_NOTHING, .infer = infer, .forward = forward, .backward = backward,
};

lt_tensor *(lt_sum)(lt_tensor *x)
{
    return lt_apply(&sum_op, NULL, 0, &x, 1);
}
