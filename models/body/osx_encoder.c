/* SPDX-License-Identifier: Apache-2.0 */
#include "models/body/osx_encoder.h"

#include "libtensor/nn/init.h"

#include <math.h>
#include <string.h>

enum { PATCH = 16, FILTER = 3 * PATCH * PATCH, PAD = 2, WAVES = 16, PLACE_CHANNELS = 4 * WAVES };

static const double NORM_EPS = 1e-6, PATCH_SIZE = 0.5;

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

    for (int i = 0; i < FILTER; i++)
        w[i] = (lt_real)(gain * mix[colour][i / (PATCH * PATCH)] * cos(M_PI * (i / PATCH % PATCH + 0.5) * down / PATCH)
                         * cos(M_PI * (i % PATCH + 0.5) * across / PATCH));
}

/* The first layer sees brightness and two differences of colours, each by its cosines from the coarsest on, all of one
 * size: random filters see little but how bright a patch is, which drowns what is in it. Filters of which there are more
 * than cosines stay random; the last ones, whose channels say where a cell is, see nothing. */
static void init_patch(const osx_encoder *m)
{
    const int filters = m->width - PLACE_CHANNELS;
    int filter = 0;

    memset(m->patch.weight->data + (int64_t)filters * FILTER, 0, (size_t)PLACE_CHANNELS * FILTER * sizeof(lt_real));
    lt_init_constant(m->patch.bias, 0);
    for (int sum = 0; sum <= 2 * (PATCH - 1); sum++)
        for (int down = 0; down <= sum; down++)
            for (int colour = 0; colour < 3 && down < PATCH && sum - down < PATCH && filter < filters; colour++)
                cosine(m->patch.weight->data + (int64_t)filter++ * FILTER, colour, down, sum - down);
    m->patch.bias->data[0] = (lt_real)(-0.5 * PATCH * PATCH_SIZE / usual_size(0, 0));       /* a grey picture is 0 */
}

/* Of a wave, in radians a cell: from a period of three cells to one of nearly thirty */
static double frequency(int wave)
{
    return 2 * pow(0.1, (double)wave / WAVES);
}

/* Sines and cosines of column and row, in channels of their own, the last ones: random numbers would take long to say
 * which cells are neighbours. After Chen et al. 2021, "An empirical study of training self-supervised vision
 * transformers", whose waves are up to ten thousand cells long and in all channels. */
static void init_position(const osx_encoder *m)
{
    for (int i = 0; i < OSX_CELLS; i++) {
        lt_real *p = m->position->data + (int64_t)(1 + i + 1) * m->width - PLACE_CHANNELS;
        const int place[2] = { i % OSX_COLUMNS, i / OSX_COLUMNS };

        for (int k = 0; k < 2 * WAVES; k++) {
            const double x = frequency(k % WAVES) * place[k / WAVES];

            p[2 * k] = (lt_real)sin(x);
            p[2 * k + 1] = (lt_real)cos(x);
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

/* A head of an attention layer looks at the cell that is so many columns and rows further: keys are the waves that say
 * where a cell is, queries those of that place. That cell has some 70 to 80 % of the attention, by the width; any other
 * less than a tenth of it. Source: Zheng et al. 2024, "Structured initialization for attention in vision transformers". */
static void look_at(const osx_encoder *m, const vit_block *b, int head, const int further[2])
{
    const int64_t width = m->width, first = head * width / b->attention.heads * width;
    lt_real *key = b->attention.k.weight->data + first, *query = b->attention.q.weight->data + first;

    memset(key, 0, (size_t)(PLACE_CHANNELS * width) * sizeof(lt_real));
    memset(query, 0, (size_t)(PLACE_CHANNELS * width) * sizeof(lt_real));
    for (int k = 0; k < 2 * WAVES; k++) {
        const double turn = frequency(k % WAVES) * further[k / WAVES];
        const int64_t sine = width - PLACE_CHANNELS + 2 * k;
        lt_real *const key_of[2] = { key + 2 * k * width + sine, key + (2 * k + 1) * width + sine };
        lt_real *const query_of[2] = { query + 2 * k * width + sine, query + (2 * k + 1) * width + sine };

        key_of[0][0] = key_of[1][1] = 1;
        query_of[0][0] = query_of[1][1] = (lt_real)cos(turn);
        query_of[0][1] = (lt_real)sin(turn);
        query_of[1][0] = (lt_real)-sin(turn);
    }
}

void osx_encoder_init(const osx_encoder *m, uint64_t seed)
{
    static const int beside[2][2][2] = { { { -1, 0 }, { 1, 0 } }, { { 0, -1 }, { 0, 1 } } };

    init_patch(m);
    lt_init_constant(m->position, 0);
    init_position(m);
    lt_init_normal(m->token, seed, 0.02);
    for (int i = 0; i < m->layers; i++) {
        init_block(&m->block[i], m->layers, seed);
        for (int head = 0; head < 2; head++)
            look_at(m, &m->block[i], head, beside[i % 2][head]);
    }
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
