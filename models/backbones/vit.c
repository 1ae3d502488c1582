/* SPDX-License-Identifier: Apache-2.0 */
#include "models/backbones/vit.h"

#include "libtensor/nn/init.h"
#include "models/backbones/imagenet.h"

const double vit_mean[3] = { 0.48145466, 0.4578275, 0.40821073 };
const double vit_deviation[3] = { 0.26862954, 0.26130258, 0.27577711 };

const char *const vit_variants[] = { [VIT_B32] = "b32", [VIT_S16] = "s16", [VIT_TINY] = "tiny", NULL };

const vit_opts vit_sizes[] = {
    [VIT_B32] = { .image_size = 224, .patch = 32, .width = 768, .layers = 12, .heads = 12 },
    [VIT_S16] = { .image_size = 224, .patch = 16, .width = 384, .layers = 12, .heads = 6 },
    [VIT_TINY] = { .image_size = 112, .patch = 16, .width = 192, .layers = 6, .heads = 3 },
};

lt_tensor *vit_normalise(lt_tensor *image)
{
    return image_normalise(image, vit_mean, vit_deviation);
}

vit_block vit_block_new(lt_params *set, const char *prefix, int width, int heads)
{
    vit_block b = { .exact_gelu = false };

    b.norm1 = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm1", prefix), width);
    b.attention = lt_attention_layer_new(set, lt_name(set, "%s.attn", prefix), width, heads);
    b.norm2 = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm2", prefix), width);
    b.fc1 = lt_linear_layer_new(set, lt_name(set, "%s.mlp.fc1", prefix), width, 4 * width, true);
    b.fc2 = lt_linear_layer_new(set, lt_name(set, "%s.mlp.fc2", prefix), 4 * width, width, true);
    return b;
}

void vit_new(vit *m, lt_params *set, const char *prefix, const vit_opts *opts)
{
    const char *dot = *prefix ? "." : "", *embed = lt_name(set, "%s%sembed", prefix, dot);
    const int cells = opts->image_size / opts->patch;

    m->opts = *opts;
    m->patch = lt_conv_layer_new(set, lt_name(set, "%s.patch", embed), 3, opts->width, opts->patch, false,
                                 &(lt_conv_opts){ .stride = opts->patch });
    m->class_token = lt_params_add(set, embed, "class_token", LT_WEIGHT, LT_SHAPE(opts->width));
    m->position = lt_params_add(set, embed, "position", LT_WEIGHT, LT_SHAPE(1 + cells * cells, opts->width));
    m->norm_pre = lt_layer_norm_layer_new(set, lt_name(set, "%s%snorm_pre", prefix, dot), opts->width);
    for (int i = 0; i < opts->layers; i++)
        m->block[i] = vit_block_new(set, lt_name(set, "%s%sblocks.%d", prefix, dot, i), opts->width, opts->heads);
    m->norm = lt_layer_norm_layer_new(set, lt_name(set, "%s%snorm", prefix, dot), opts->width);
}

static void init_linear(const lt_linear_layer *l, uint64_t seed)
{
    lt_init_normal(l->weight, seed, 0.02);
    lt_init_constant(l->bias, 0);
}

void vit_block_init(const vit_block *b, uint64_t seed)
{
    init_linear(&b->attention.q, seed);
    init_linear(&b->attention.k, seed);
    init_linear(&b->attention.v, seed);
    init_linear(&b->attention.out, seed);
    init_linear(&b->fc1, seed);
    init_linear(&b->fc2, seed);
}

void vit_init(const vit *m, uint64_t seed)
{
    lt_init_normal(m->patch.weight, seed, 0.02);
    lt_init_normal(m->class_token, seed, 0.02);
    lt_init_normal(m->position, seed, 0.02);
    for (int i = 0; i < m->opts.layers; i++)
        vit_block_init(&m->block[i], seed);
}

/* The class token before the patches' rows, and each one's position: (B, 1 + cells^2, C) */
static lt_tensor *embed(const vit *m, lt_tensor *image)
{
    lt_graph *g = image->graph;
    lt_tensor *patches = lt_map_to_tokens(lt_conv_layer_forward(&m->patch, image));
    lt_tensor *zero = lt_reshape(lt_scale(lt_sample_index(image), 0), LT_SHAPE(lt_dim(image, 0), 1, 1));
    lt_tensor *tokens = lt_add(zero, lt_use(g, m->class_token));        /* one a sample, of any number of them */

    return lt_add(lt_concat((lt_tensor *[]){ tokens, patches }, 2, 1), lt_use(g, m->position));
}

/* x and what is added to it */
static lt_tensor *beside(const vit_block *b, lt_tensor *added, lt_tensor *x)
{
    return lt_add(b->stochastic_depth > 0 ? lt_stochastic_depth(added, b->stochastic_depth) : added, x);
}

lt_tensor *vit_block_forward(const vit_block *b, lt_tensor *x)
{
    lt_tensor *y = lt_attention_layer_forward(&b->attention, lt_layer_norm_layer_forward(&b->norm1, x), NULL), *hidden;

    y = beside(b, y, x);
    hidden = lt_linear_layer_forward(&b->fc1, lt_layer_norm_layer_forward(&b->norm2, y));
    hidden = b->exact_gelu ? lt_gelu(hidden) : lt_quick_gelu(hidden);
    return beside(b, lt_linear_layer_forward(&b->fc2, hidden), y);
}

vit_out vit_forward(const vit *m, lt_tensor *image)
{
    const int64_t B = lt_dim(image, 0), C = m->opts.width;
    lt_tensor *x = lt_layer_norm_layer_forward(&m->norm_pre, embed(m, image)), *token;

    for (int i = 0; i < m->opts.layers; i++)
        x = vit_block_forward(&m->block[i], x);
    token = lt_reshape(lt_slice(x, 1, 0, 1), LT_SHAPE(B, C));
    return (vit_out){
        .feature = lt_layer_norm_layer_forward(&m->norm, token), .patches = lt_slice(x, 1, 1, lt_dim(x, 1) - 1),
    };
}
