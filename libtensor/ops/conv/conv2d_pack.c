/* SPDX-License-Identifier: Apache-2.0 */
/* conv2d_pack: w (O, ...), times scale (O) if that is there, in the order in which conv2d's forward reads it */
#include "libtensor/ops/conv/conv2d_pack.h"

#include "libtensor/kernels/blocks/conv.h"

enum { W, SCALE };

static lt_status infer(lt_call *c)
{
    const conv2d_packing *a = c->attr;

    c->out->shape = LT_SHAPE(a->blocks ? lt_conv_blocks_packed(&a->p)
                             : a->range.scale > 0 ? lt_conv2d_int8_packed(&a->p) : lt_conv2d_packed(&a->p));
    return LT_OK;
}

static size_t scaled_bytes(const lt_call *c)
{
    return c->in[SCALE] ? (size_t)op_aligned(lt_numel(c->in[W])) * sizeof(lt_real) : 0;
}

static void plan(lt_call *c)
{
    const conv2d_packing *a = c->attr;

    c->work_bytes = scaled_bytes(c) + (a->range.scale > 0 ? lt_conv2d_int8_pack_work(&a->p) : 0);
}

static void scale_channel(void *ctx, int64_t o)
{
    const lt_call *c = ctx;
    const int64_t n = lt_numel(c->in[W]) / lt_dim(c->in[W], 0);
    const lt_real *w = c->in[W]->data, *scale = c->in[SCALE]->data;

    lt_k->scale((lt_real *)c->work + o * n, w + o * n, scale[o], (size_t)n);
}

static void forward(const lt_call *c)
{
    const conv2d_packing *a = c->attr;
    const lt_real *w = c->in[SCALE] ? c->work : c->in[W]->data;

    if (c->in[SCALE])
        lt_parallel_for(lt_dim(c->in[W], 0), scale_channel, (void *)c);
    if (a->blocks)
        lt_conv_blocks_pack(&a->p, w, c->out->data);
    else if (a->range.scale > 0)
        lt_conv2d_int8_pack(&a->p, &a->range, w, c->out->data, (char *)c->work + scaled_bytes(c));
    else
        lt_conv2d_pack(&a->p, w, c->out->data);
}

static const lt_op conv2d_pack_op = {
    .name = "conv2d_pack", .optional = LT_OPTIONAL_IN(SCALE), .infer = infer, .plan = plan, .forward = forward,
};

lt_tensor *op_conv2d_pack(lt_tensor *w, lt_tensor *scale, const conv2d_packing *how)
{
    return lt_apply(&conv2d_pack_op, how, sizeof(*how), (lt_tensor *[]){ w, scale }, 2);
}
