/* SPDX-License-Identifier: Apache-2.0 */
#include "models/body/osx_encoder.h"

#include "libtensor/nn/init.h"

enum { PATCH = 16, PAD = 2 };

static const double NORM_EPS = 1e-6;

void osx_encoder_new(osx_encoder *m, lt_params *set, const char *prefix, int width, int layers, int heads,
                     double stochastic_depth)
{
    m->width = width;
    m->layers = layers;
    m->patch = lt_conv_layer_new(set, lt_name(set, "%s.patch_embed.proj", prefix), 3, width, PATCH, true,
                                 &(lt_conv_opts){ .stride = PATCH, .pad = PAD });
    m->position = lt_params_add(set, prefix, "pos_embed", LT_WEIGHT, LT_SHAPE(1 + OSX_CELLS, width));
    m->token = lt_params_add(set, prefix, "task_tokens", LT_WEIGHT, LT_SHAPE(OSX_TOKENS, width));
    for (int i = 0; i < layers; i++) {
        vit_block *b = &m->block[i];

        *b = vit_block_new(set, lt_name(set, "%s.blocks.%d", prefix, i), width, heads);
        b->norm1.eps = b->norm2.eps = NORM_EPS;
        b->exact_gelu = true;
        b->stochastic_depth = layers > 1 ? stochastic_depth * i / (layers - 1) : 0;
    }
    m->norm = lt_layer_norm_layer_new(set, lt_name(set, "%s.last_norm", prefix), width);
    m->norm.eps = NORM_EPS;
}

void osx_encoder_init(const osx_encoder *m, uint64_t seed)
{
    lt_init_normal(m->position, seed, 0.02);
    lt_init_normal(m->token, seed, 0.02);
    for (int i = 0; i < m->layers; i++)
        vit_block_init(&m->block[i], seed);
}

/* (B, OSX_TOKENS + OSX_CELLS, C) */
static lt_tensor *embed(const osx_encoder *m, lt_tensor *image)
{
    lt_graph *g = image->graph;
    lt_tensor *position = lt_use(g, m->position), *first = lt_slice(position, 0, 0, 1);
    lt_tensor *cells = lt_map_to_tokens(lt_conv_layer_forward(&m->patch, image));
    lt_tensor *zero = lt_reshape(lt_scale(lt_sample_index(image), 0), LT_SHAPE(lt_dim(image, 0), 1, 1));
    lt_tensor *asked = lt_add(zero, lt_use(g, m->token));           /* of any number of samples */

    cells = lt_add(cells, lt_add(lt_slice(position, 0, 1, OSX_CELLS), first));
    return lt_concat((lt_tensor *[]){ asked, cells }, 2, 1);
}

osx_features osx_encoder_forward(const osx_encoder *m, lt_tensor *image)
{
    lt_tensor *x = embed(m, image);

    for (int i = 0; i < m->layers; i++)
        x = vit_block_forward(&m->block[i], x);
    x = lt_layer_norm_layer_forward(&m->norm, x);
    return (osx_features){
        .map = lt_tokens_to_map(lt_slice(x, 1, OSX_TOKENS, OSX_CELLS), OSX_ROWS, OSX_COLUMNS),
        .tokens = lt_slice(x, 1, 0, OSX_TOKENS),
    };
}
