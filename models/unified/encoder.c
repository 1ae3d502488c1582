/* SPDX-License-Identifier: Apache-2.0 */
#include "models/unified/encoder.h"

#include "libtensor/nn/init.h"

#include <math.h>

static const double OFFSET_RATE = 0.1;      /* of the learning rate                    [Deformable-DETR main.py] */

static encoder_layer layer_new(lt_params *set, const char *prefix, const encoder_opts *o)
{
    const int places = o->heads * o->points;
    const encoder_layer l = {
        .offsets = lt_linear_layer_new(set, lt_name(set, "%s.offsets", prefix), o->width, 2 * places, true),
        .weights = lt_linear_layer_new(set, lt_name(set, "%s.weights", prefix), o->width, places, true),
        .value = lt_linear_layer_new(set, lt_name(set, "%s.value", prefix), o->width, o->width, true),
        .output = lt_linear_layer_new(set, lt_name(set, "%s.output", prefix), o->width, o->width, true),
        .norm1 = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm1", prefix), o->width),
        .linear1 = lt_linear_layer_new(set, lt_name(set, "%s.linear1", prefix), o->width, o->ffn, true),
        .linear2 = lt_linear_layer_new(set, lt_name(set, "%s.linear2", prefix), o->ffn, o->width, true),
        .norm2 = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm2", prefix), o->width),
    };

    l.offsets.weight->rate = l.offsets.bias->rate = OFFSET_RATE;
    return l;
}

void deformable_encoder_new(deformable_encoder *m, lt_params *set, const char *prefix, const encoder_opts *o)
{
    m->opts = *o;
    m->position = lt_params_add(set, prefix, "position", LT_WEIGHT, LT_SHAPE((int64_t)o->cells * o->cells, o->in));
    m->embed = lt_linear_layer_new(set, lt_name(set, "%s.embed", prefix), o->in, o->width, true);
    for (int i = 0; i < o->layers; i++)
        m->layer[i] = layer_new(set, lt_name(set, "%s.layers.%d", prefix, i), o);
    m->head1 = lt_linear_layer_new(set, lt_name(set, "%s.head1", prefix), o->width, o->width, true);
    m->head2 = lt_linear_layer_new(set, lt_name(set, "%s.head2", prefix), o->width, o->out, true);
    m->norm = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm", prefix), o->out);
}

/* ---- initial values ----------------------------------------------------------------------------------- */

static void init_xavier(const lt_linear_layer *l, uint64_t seed)
{
    lt_init_xavier(l->weight, seed, 1);
    lt_init_constant(l->bias, 0);
}

/* Head m looks along the angle 2 pi m / heads, its point k at the (k + 1)-th ring of cells. */
static void init_star(lt_param *bias, int heads, int points)
{
    for (int i = 0; i < heads * points; i++) {
        const double angle = 2 * M_PI * (i / points) / heads;
        const double ring = (i % points + 1) / fmax(fabs(cos(angle)), fabs(sin(angle)));

        bias->data[2 * i] = (lt_real)(ring * cos(angle));
        bias->data[2 * i + 1] = (lt_real)(ring * sin(angle));
    }
}

static void init_layer(const encoder_layer *l, const encoder_opts *o, uint64_t seed)
{
    lt_init_constant(l->offsets.weight, 0);
    init_star(l->offsets.bias, o->heads, o->points);
    lt_init_constant(l->weights.weight, 0);
    lt_init_constant(l->weights.bias, 0);
    init_xavier(&l->value, seed);
    init_xavier(&l->output, seed);
    init_xavier(&l->linear1, seed);
    init_xavier(&l->linear2, seed);
}

void deformable_encoder_init(const deformable_encoder *m, uint64_t seed)
{
    lt_init_normal(m->position, seed, 0.02);
    init_xavier(&m->embed, seed);
    for (int i = 0; i < m->opts.layers; i++)
        init_layer(&m->layer[i], &m->opts, seed);
    init_xavier(&m->head1, seed);
    init_xavier(&m->head2, seed);
}

/* ---- forward ------------------------------------------------------------------------------------------ */

static lt_tensor *drop(const encoder_opts *o, lt_tensor *x)
{
    return o->dropout > 0 ? lt_dropout(x, o->dropout) : x;
}

static lt_tensor *look(const encoder_layer *l, const encoder_opts *o, lt_tensor *x, lt_tensor *places)
{
    lt_tensor *value = lt_linear_layer_forward(&l->value, x);
    lt_tensor *offsets = lt_linear_layer_forward(&l->offsets, x);
    lt_tensor *weights = lt_linear_layer_forward(&l->weights, x);

    return lt_linear_layer_forward(&l->output, lt_deformable_attention(value, offsets, weights, places, o->heads,
                                                                       o->cells, o->cells));
}

/* x = LN(x + DMHA(x));  x = LN(x + W2 relu(W1 x)) */
static lt_tensor *layer_forward(const encoder_layer *l, const encoder_opts *o, lt_tensor *x, lt_tensor *places)
{
    lt_tensor *hidden;

    x = lt_layer_norm_layer_forward(&l->norm1, lt_add(drop(o, look(l, o, x, places)), x));
    hidden = drop(o, lt_relu(lt_linear_layer_forward(&l->linear1, x)));
    return lt_layer_norm_layer_forward(&l->norm2, lt_add(drop(o, lt_linear_layer_forward(&l->linear2, hidden)), x));
}

lt_tensor *deformable_encoder_forward(const deformable_encoder *m, lt_tensor *tokens, lt_tensor *places)
{
    lt_tensor *x = lt_linear_layer_forward(&m->embed, lt_add(tokens, lt_use(tokens->graph, m->position)));

    for (int i = 0; i < m->opts.layers; i++)
        x = layer_forward(&m->layer[i], &m->opts, x, places);
    x = lt_linear_layer_forward(&m->head2, lt_relu(lt_linear_layer_forward(&m->head1, x)));
    return lt_layer_norm_layer_forward(&m->norm, x);
}
