/* SPDX-License-Identifier: Apache-2.0 */
#include "models/body/osx_encoder.h"

#include "libtensor/nn/init.h"

#include <math.h>

enum { PATCH = 16, PAD = 2 };

static const double NORM_EPS = 1e-6, PATCH_SIZE = 0.5, POSITION_SIZE = 0.5;

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

/* How far a patch's cosine of so many half periods down and across is from 0 as a rule: the less, the finer it is. Fitted
 * to the synthetic pictures, to a third. */
static double usual_size(int down, int across)
{
    return 3.5 / (1 + 3.2 * (down + across) + 2.2 * down * across);
}

/* A filter's weights: one cosine in one mixture of the colours, as large as makes its output's deviation PATCH_SIZE */
static void cosine(lt_real *w, int colour, int down, int across)
{
    static const double mix[3][3] = { { 1 / 3.0, 1 / 3.0, 1 / 3.0 }, { 0.5, 0, -0.5 }, { -0.25, 0.5, -0.25 } };
    static const double share[3] = { 1, 0.28, 0.12 };       /* of brightness's size */
    const double size = (down ? sqrt(2) : 1) * (across ? sqrt(2) : 1) / PATCH;
    const double gain = PATCH_SIZE * size / (share[colour] * usual_size(down, across));

    for (int i = 0; i < 3 * PATCH * PATCH; i++)
        w[i] = (lt_real)(gain * mix[colour][i / (PATCH * PATCH)] * cos(M_PI * (i / PATCH % PATCH + 0.5) * down / PATCH)
                         * cos(M_PI * (i % PATCH + 0.5) * across / PATCH));
}

/* The first layer sees brightness and two differences of colours, each by its cosines from the coarsest on, all of one
 * size: random filters see little but how bright a patch is, which drowns what is in it. Filters of which there are more
 * than cosines stay random. */
static void init_patch(const osx_encoder *m)
{
    int filter = 0;

    lt_init_constant(m->patch.bias, 0);
    for (int sum = 0; sum <= 2 * (PATCH - 1); sum++)
        for (int down = 0; down <= sum; down++)
            for (int colour = 0; colour < 3 && down < PATCH && sum - down < PATCH && filter < m->width; colour++)
                cosine(m->patch.weight->data + (int64_t)filter++ * 3 * PATCH * PATCH, colour, down, sum - down);
    m->patch.bias->data[0] = (lt_real)(-0.5 * PATCH * PATCH_SIZE / usual_size(0, 0));       /* a grey picture is 0 */
}

/* Sines and cosines of column and row, a quarter of the width each: random numbers would take long to say which cells
 * are neighbours. Source: Chen et al. 2021, "An empirical study of training self-supervised vision transformers". */
static void init_position(const osx_encoder *m)
{
    const int quarter = m->width / 4;

    for (int i = 0; i < OSX_CELLS; i++) {
        lt_real *p = m->position->data + (1 + i) * m->width;

        for (int k = 0; k < quarter; k++) {
            const double f = pow(10000, -(double)k / quarter), x = f * (i % OSX_COLUMNS), y = f * (i / OSX_COLUMNS);

            p[k] = (lt_real)(POSITION_SIZE * sin(x));
            p[quarter + k] = (lt_real)(POSITION_SIZE * cos(x));
            p[2 * quarter + k] = (lt_real)(POSITION_SIZE * sin(y));
            p[3 * quarter + k] = (lt_real)(POSITION_SIZE * cos(y));
        }
    }
}

/* Linear layers that keep the size of what goes through them; the last one of a branch adds the less, the more branches
 * there are: else what attention mixes, nearly the same for all tokens at first, drowns what tells them apart. Source:
 * Radford et al. 2019, "Language models are unsupervised multitask learners", section 2.3. */
static void init_block(const vit_block *b, int layers, uint64_t seed)
{
    const double last = 1 / sqrt(2 * layers);
    const struct { const lt_linear_layer *layer; double gain; } part[] = {
        { &b->attention.q, 1 }, { &b->attention.k, 1 }, { &b->attention.v, 1 }, { &b->attention.out, last },
        { &b->fc1, 1 }, { &b->fc2, last },
    };

    for (size_t i = 0; i < LT_COUNT(part); i++) {
        lt_init_xavier(part[i].layer->weight, seed, part[i].gain);
        lt_init_constant(part[i].layer->bias, 0);
    }
}

void osx_encoder_init(const osx_encoder *m, uint64_t seed)
{
    init_patch(m);
    lt_init_constant(m->position, 0);
    init_position(m);
    lt_init_normal(m->token, seed, 0.02);
    for (int i = 0; i < m->layers; i++)
        init_block(&m->block[i], m->layers, seed);
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
