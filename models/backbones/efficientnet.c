/* SPDX-License-Identifier: Apache-2.0 */
#include "models/backbones/efficientnet.h"

#include "libtensor/nn/init.h"

#include <math.h>

/* The rows of table 1 behind the stem. */
typedef struct {
    int expand, k, stride, out, blocks;
} stage_shape;

static const stage_shape shape[EFFICIENTNET_STAGES] = {
    { 1, 3, 1, 16, 1 }, { 6, 3, 2, 24, 2 }, { 6, 5, 2, 40, 2 }, { 6, 3, 2, 80, 3 },
    { 6, 5, 1, 112, 3 }, { 6, 5, 2, 192, 4 }, { 6, 3, 1, 320, 1 },
};
enum { STEM = 32, SE_REDUCTION = 4, ALL_BLOCKS = 16 };

/* ---- building ----------------------------------------------------------------------------------------- */

/* Convolution and norm PREFIX.0 and PREFIX.1 */
static void conv_bn_new(lt_params *set, const char *prefix, int in, int out, int k, lt_conv_opts opts,
                        lt_conv_layer *conv, lt_batch_norm_layer *bn)
{
    opts.pad = (k - 1) / 2 * (opts.dilation ? opts.dilation : 1);
    *conv = lt_conv_layer_new(set, lt_name(set, "%s.0", prefix), in, out, k, false, &opts);
    *bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.1", prefix), out);
}

static efficientnet_block block_new(lt_params *set, const char *prefix, const stage_shape *s, int in,
                                    int stride, int dilation)
{
    const int hidden = s->expand * in, narrow = in / SE_REDUCTION;
    const lt_conv_opts spatial = { .stride = stride, .dilation = dilation, .groups = hidden };
    efficientnet_block b = { .has_expand = s->expand > 1, .residual = stride == 1 && in == s->out };
    int n = 0;                                          /* torchvision numbers what there is */

    if (b.has_expand)
        conv_bn_new(set, lt_name(set, "%s.block.%d", prefix, n++), in, hidden, 1, (lt_conv_opts){ 0 },
                    &b.expand, &b.expand_bn);
    conv_bn_new(set, lt_name(set, "%s.block.%d", prefix, n++), hidden, hidden, s->k, spatial, &b.depthwise,
                &b.depthwise_bn);
    b.squeeze = lt_conv_layer_new(set, lt_name(set, "%s.block.%d.fc1", prefix, n), hidden, narrow, 1, true, NULL);
    b.excite = lt_conv_layer_new(set, lt_name(set, "%s.block.%d.fc2", prefix, n++), narrow, hidden, 1, true, NULL);
    conv_bn_new(set, lt_name(set, "%s.block.%d", prefix, n), hidden, s->out, 1, (lt_conv_opts){ 0 }, &b.project,
                &b.project_bn);
    return b;
}

/* Stage s on in channels, whose first block is number first of the whole network's. */
static void stage_new(efficientnet *m, lt_params *set, const char *features, int s, int in, int first,
                      const efficientnet_opts *opts)
{
    const bool last = s + 1 == opts->stages;
    const int stride = last && opts->last_stride ? opts->last_stride : shape[s].stride;

    for (int i = 0; i < shape[s].blocks; i++) {
        const char *name = lt_name(set, "%s.%d.%d", features, s + 1, i);

        m->block[s][i] = block_new(set, name, &shape[s], i ? shape[s].out : in, i ? 1 : stride,
                                   last && i ? opts->last_dilation : 0);
        m->block[s][i].drop = opts->stochastic_depth * (first + i) / ALL_BLOCKS;
    }
}

void efficientnet_new(efficientnet *m, lt_params *set, const char *prefix, const efficientnet_opts *opts)
{
    const char *features = lt_name(set, "%s%sfeatures", prefix, *prefix ? "." : "");
    int first = 0;

    *m = (efficientnet){ .stages = opts->stages, .channels = STEM, .has_head = opts->has_head };
    conv_bn_new(set, lt_name(set, "%s.0", features), opts->in, STEM, 3, (lt_conv_opts){ .stride = 2 }, &m->stem,
                &m->stem_bn);
    for (int s = 0; s < opts->stages; s++) {
        stage_new(m, set, features, s, m->channels, first, opts);
        first += shape[s].blocks;
        m->channels = shape[s].out;
    }
    if (!opts->has_head)
        return;
    conv_bn_new(set, lt_name(set, "%s.%d", features, opts->stages + 1), m->channels, EFFICIENTNET_FEATURES, 1,
                (lt_conv_opts){ 0 }, &m->head, &m->head_bn);
    m->channels = EFFICIENTNET_FEATURES;
}

/* ---- forward ------------------------------------------------------------------------------------------ */

static lt_tensor *conv_bn(const lt_conv_layer *conv, const lt_batch_norm_layer *bn, lt_tensor *x)
{
    return lt_batch_norm_layer_forward(bn, lt_conv_layer_forward(conv, x));
}

/* x sigmoid(excite silu(squeeze mean(x))) */
static lt_tensor *gated(const efficientnet_block *b, lt_tensor *x)
{
    lt_tensor *gate = lt_conv_layer_on_rows(&b->squeeze, lt_global_avg_pool(x));        /* (B, narrow) */

    gate = lt_sigmoid(lt_conv_layer_on_rows(&b->excite, lt_silu(gate)));                /* (B, hidden) */
    return lt_mul(x, lt_reshape(gate, LT_SHAPE(lt_dim(gate, 0), lt_dim(gate, 1), 1, 1)));
}

static lt_tensor *block_forward(const efficientnet_block *b, lt_tensor *x)
{
    lt_tensor *y = b->has_expand ? lt_silu(conv_bn(&b->expand, &b->expand_bn, x)) : x;

    y = lt_silu(conv_bn(&b->depthwise, &b->depthwise_bn, y));
    y = conv_bn(&b->project, &b->project_bn, gated(b, y));
    if (!b->residual)
        return y;
    return lt_add(b->drop > 0 ? lt_stochastic_depth(y, b->drop) : y, x);
}

lt_tensor *efficientnet_forward(const efficientnet *m, lt_tensor *image)
{
    lt_tensor *x = lt_silu(conv_bn(&m->stem, &m->stem_bn, image));

    for (int s = 0; s < m->stages; s++)
        for (int i = 0; i < shape[s].blocks; i++)
            x = block_forward(&m->block[s][i], x);
    return m->has_head ? lt_silu(conv_bn(&m->head, &m->head_bn, x)) : x;
}

/* ---- initial values ----------------------------------------------------------------------------------- */

static void init_conv(const lt_conv_layer *conv, uint64_t seed)
{
    lt_init_normal(conv->weight, seed, sqrt(2 / lt_fan_out(conv->weight)));
    if (conv->bias)
        lt_init_constant(conv->bias, 0);
}

static void init_block(const efficientnet_block *b, uint64_t seed)
{
    if (b->has_expand)
        init_conv(&b->expand, seed);
    init_conv(&b->depthwise, seed);
    init_conv(&b->squeeze, seed);
    init_conv(&b->excite, seed);
    init_conv(&b->project, seed);
}

void efficientnet_init(const efficientnet *m, uint64_t seed)
{
    init_conv(&m->stem, seed);
    for (int s = 0; s < m->stages; s++)
        for (int i = 0; i < shape[s].blocks; i++)
            init_block(&m->block[s][i], seed);
    if (m->has_head)
        init_conv(&m->head, seed);
}
