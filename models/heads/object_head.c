/* SPDX-License-Identifier: Apache-2.0 */
#include "models/heads/object_head.h"

#include "libtensor/base/parallel.h"
#include "libtensor/graph/op.h"

#include <math.h>

static const double SLOPE = 0.1;

void object_head_new(object_head *m, lt_params *set, const char *prefix, int channels)
{
    const int half = channels / 2;
    const lt_conv_opts pad = { .pad = 1 };

    for (int i = 0; i < OBJECT_LAYERS; i++) {
        m->conv1[i] = lt_conv_layer_new(set, lt_name(set, "%s.%d.conv1", prefix, i), channels, half, 1, true, NULL);
        m->bn1[i] = lt_batch_norm_layer_new(set, lt_name(set, "%s.%d.bn1", prefix, i), half);
        m->conv2[i] = lt_conv_layer_new(set, lt_name(set, "%s.%d.conv2", prefix, i), half, channels, 3, true, &pad);
        m->bn2[i] = lt_batch_norm_layer_new(set, lt_name(set, "%s.%d.bn2", prefix, i), channels);
    }
    m->head = lt_conv_layer_new(set, lt_name(set, "%s.head", prefix), channels, 3 * OBJECT_POINTS, 1, true, NULL);
}

static lt_tensor *conv_bn_act(const lt_conv_layer *conv, const lt_batch_norm_layer *bn, lt_tensor *x)
{
    return lt_leaky_relu(lt_batch_norm_layer_forward(bn, lt_conv_layer_forward(conv, x)), SLOPE);
}

/* The centres of R cells in [0, 1], along the last dimension or the one before. */
static lt_tensor *cell_centres(lt_graph *g, int64_t R, bool columns)
{
    lt_tensor *t;
    lt_real *centre = lt_constant_reals(g, columns ? LT_SHAPE(1, R) : LT_SHAPE(R, 1), &t);

    for (int64_t i = 0; centre && i < R; i++)
        centre[i] = (lt_real)(((double)i + 0.5) / (double)R);
    return t;
}

object_out object_head_forward(const object_head *m, lt_tensor *features)
{
    lt_tensor *x = features, *raw;
    object_out out;

    for (int i = 0; i < OBJECT_LAYERS; i++) {
        x = conv_bn_act(&m->conv1[i], &m->bn1[i], x);
        x = conv_bn_act(&m->conv2[i], &m->bn2[i], x);
    }
    raw = lt_conv_layer_forward(&m->head, x);           /* confidence 0-20, x 21-41, y 42-62 */
    out.conf = lt_sigmoid(lt_slice(raw, 1, 0, OBJECT_POINTS));
    out.x = lt_add(lt_scale(lt_slice(raw, 1, OBJECT_POINTS, OBJECT_POINTS), 0.1),
                   cell_centres(raw->graph, lt_dim(raw, 3), true));
    out.y = lt_add(lt_scale(lt_slice(raw, 1, 2 * OBJECT_POINTS, OBJECT_POINTS), 0.1),
                   cell_centres(raw->graph, lt_dim(raw, 2), false));
    return out;
}

/* ---- the confidence's target: C = exp(-|p - g|) M, no gradient ------------------------------------------ */

enum { PX, PY, POINTS, MASK };

static lt_status target_infer(lt_call *c)
{
    const lt_tensor *px = c->in[PX];
    const int64_t B = lt_dim(px, 0);

    if (lt_want_rank(c, PX, "places", 4) || lt_want_shape(c, PY, "places", px->shape)
        || lt_want_shape(c, POINTS, "points", LT_SHAPE(B, lt_dim(px, 1), 2))
        || lt_want_shape(c, MASK, "mask", LT_SHAPE(B, lt_dim(px, 2), lt_dim(px, 3))))
        return LT_ESHAPE;
    c->out->shape = px->shape;
    return LT_OK;
}

/* One point's map in one image */
static void target_map(void *ctx, int64_t map)
{
    const lt_call *c = ctx;
    const int64_t cells = lt_dim(c->out, 2) * lt_dim(c->out, 3);
    const lt_real *px = (const lt_real *)c->in[PX]->data + map * cells;
    const lt_real *py = (const lt_real *)c->in[PY]->data + map * cells;
    const lt_real *g = (const lt_real *)c->in[POINTS]->data + 2 * map;
    const lt_real *mask = (const lt_real *)c->in[MASK]->data + map / lt_dim(c->out, 1) * cells;
    lt_real *target = (lt_real *)c->out->data + map * cells;

    for (int64_t i = 0; i < cells; i++) {
        const lt_real dx = px[i] - g[0], dy = py[i] - g[1];

        target[i] = -(lt_real)sqrt(dx * dx + dy * dy);
    }
    lt_k->exp(target, target, (size_t)cells);
    lt_k->mul(target, target, mask, (size_t)cells);
}

static void target_forward(const lt_call *c)
{
    lt_parallel_for(lt_dim(c->out, 0) * lt_dim(c->out, 1), target_map, (void *)c);
}

static const lt_op confidence_target_op = {
    .name = "confidence_target", .flags = LT_OP_DETACH, .infer = target_infer, .forward = target_forward,
};

object_losses object_head_losses(const object_out *o, lt_tensor *points, lt_tensor *mask, lt_tensor *weight)
{
    const int64_t B = lt_dim(o->x, 0), R = lt_dim(o->x, 2);
    lt_tensor *m = lt_reshape(mask, LT_SHAPE(B, 1, R, R));
    lt_tensor *gx = lt_reshape(lt_slice(points, 2, 0, 1), LT_SHAPE(B, OBJECT_POINTS, 1, 1));
    lt_tensor *gy = lt_reshape(lt_slice(points, 2, 1, 1), LT_SHAPE(B, OBJECT_POINTS, 1, 1));
    lt_tensor *in[] = { o->x, o->y, points, mask };
    lt_tensor *target = lt_apply(&confidence_target_op, NULL, 0, in, 4);
    object_losses l;

    l.p2d = lt_add(lt_l1_loss(lt_mul(o->x, m), lt_mul(gx, m), weight),
                   lt_l1_loss(lt_mul(o->y, m), lt_mul(gy, m), weight));
    l.conf = lt_l1_loss(o->conf, target, weight);
    return l;
}
