/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hogs/gpm.h"

#include "libtensor/nn/init.h"

#include <assert.h>
#include <math.h>

enum { EMBED_HIDDEN = 64, COVARIANCE = 6, OPACITY = 1 };

static const double SLOPE = 0.01, CM2 = 1e4;    /* of leaky relu; covariances go in as square centimetres */

/* ---- parameters ----------------------------------------------------------------------------------------- */

static int level_width(const gpm_opts *o)
{
    return o->level.width[POINTNET2_CONVS - 1];
}

int gpm_token(const gpm_opts *o)
{
    return 3 + level_width(o) + o->condition + GPM_COLOUR;
}

static int encoder_width(const gpm_opts *o)
{
    return o->width ? o->width : gpm_token(o);
}

static gpm_layer layer_new(lt_params *set, const char *prefix, int width, int ffn)
{
    return (gpm_layer){
        .q = lt_linear_layer_new(set, lt_name(set, "%s.self_attn.q", prefix), width, width, true),
        .k = lt_linear_layer_new(set, lt_name(set, "%s.self_attn.k", prefix), width, width, true),
        .v = lt_linear_layer_new(set, lt_name(set, "%s.self_attn.v", prefix), width, width, true),
        .out = lt_linear_layer_new(set, lt_name(set, "%s.self_attn.out", prefix), width, width, true),
        .linear1 = lt_linear_layer_new(set, lt_name(set, "%s.linear1", prefix), width, ffn, true),
        .linear2 = lt_linear_layer_new(set, lt_name(set, "%s.linear2", prefix), ffn, width, true),
        .norm1 = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm1", prefix), width),
        .norm2 = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm2", prefix), width),
    };
}

static void head_new(lt_linear_layer head[GPM_HEAD], lt_params *set, const char *prefix, int width, int out)
{
    for (int i = 0; i < GPM_HEAD; i++)
        head[i] = lt_linear_layer_new(set, lt_name(set, "%s.%d", prefix, i), width, i < GPM_HEAD - 1 ? width : out,
                                      true);
}

void gpm_new(gpm *m, lt_params *set, const char *prefix, const gpm_opts *opts)
{
    const char *p = *prefix ? lt_name(set, "%s.", prefix) : "";
    const int width = encoder_width(opts);

    assert(opts->layers <= GPM_LAYERS);
    *m = (gpm){ .opts = *opts };
    m->embed1 = lt_linear_layer_new(set, lt_name(set, "%sembed1", p), 3, EMBED_HIDDEN, true);
    m->embed2 = lt_linear_layer_new(set, lt_name(set, "%sembed2", p), EMBED_HIDDEN, GPM_COLOUR, true);
    pointnet2_level_new(&m->level, set, lt_name(set, "%ssa1", p), "input",
                        opts->encoding + COVARIANCE + GPM_COLOUR + OPACITY, &opts->level);
    if (opts->width)
        m->project = lt_linear_layer_new(set, lt_name(set, "%sproject", p), gpm_token(opts), width, true);
    for (int i = 0; i < opts->layers; i++)
        m->layer[i] = layer_new(set, lt_name(set, "%sencoder.%d", p, i), width, opts->ffn);
    m->norm = lt_layer_norm_layer_new(set, lt_name(set, "%snorm", p), width);
    head_new(m->translation, set, lt_name(set, "%stranslation", p), width, 3);
    head_new(m->rotation, set, lt_name(set, "%srotation", p), width, 9);
}

/* ---- initial values ------------------------------------------------------------------------------------- */

static void init_default(const lt_linear_layer *l, uint64_t seed)
{
    const double bound = l->weight ? lt_fan_in(l->weight) : 1;

    if (!l->weight)
        return;
    lt_init_uniform(l->weight, seed, 1 / sqrt(bound));
    lt_init_uniform(l->bias, seed, 1 / sqrt(bound));
}

static void init_xavier(const lt_linear_layer *l, uint64_t seed)
{
    lt_init_xavier(l->weight, seed, 1);
    lt_init_constant(l->bias, 0);
}

static void init_level(const pointnet2_level *l, uint64_t seed)
{
    for (int i = 0; i < POINTNET2_CONVS; i++) {
        const double bound = 1 / sqrt(lt_fan_in(l->conv[i].weight));

        lt_init_uniform(l->conv[i].weight, seed, bound);
        lt_init_uniform(l->conv[i].bias, seed, bound);
        lt_init_constant(l->norm[i].weight, 1);
        lt_init_constant(l->norm[i].running_var, 1);
    }
}

static void init_norm(const lt_layer_norm_layer *n)
{
    lt_init_constant(n->weight, 1);
}

static void init_encoder(const gpm_layer *l, uint64_t seed)
{
    const lt_linear_layer *const linear[] = { &l->q, &l->k, &l->v, &l->out, &l->linear1, &l->linear2 };

    for (size_t i = 0; i < LT_COUNT(linear); i++)
        init_xavier(linear[i], seed);
    init_norm(&l->norm1);
    init_norm(&l->norm2);
}

static void init_head(const lt_linear_layer head[GPM_HEAD], uint64_t seed)
{
    for (int i = 0; i < GPM_HEAD; i++)
        init_default(&head[i], seed);
    lt_init_normal(head[GPM_HEAD - 1].weight, seed, 1e-5);
    lt_init_constant(head[GPM_HEAD - 1].bias, 0);
}

void gpm_init(const gpm *m, uint64_t seed)
{
    init_default(&m->embed1, seed);
    init_default(&m->embed2, seed);
    init_level(&m->level, seed);
    init_default(&m->project, seed);
    for (int i = 0; i < m->opts.layers; i++)
        init_encoder(&m->layer[i], seed);
    init_norm(&m->norm);
    init_head(m->translation, seed);
    init_head(m->rotation, seed);
}

/* ---- tokens --------------------------------------------------------------------------------------------- */

static lt_tensor *embed(const gpm *m, lt_tensor *colour)
{
    lt_tensor *hidden = lt_leaky_relu(lt_linear_layer_forward(&m->embed1, lt_detach(colour)), SLOPE);

    return lt_linear_layer_forward(&m->embed2, hidden);
}

/* What the level reads of a Gaussian beside its place: enc(p), covariance, colour, opacity */
static lt_tensor *features_of(const gpm *m, const gpm_in *in)
{
    lt_tensor *const part[] = { lt_detach(in->encoding), lt_scale(lt_detach(in->covariance), CM2),
                                embed(m, in->colour), lt_detach(in->opacity) };

    return lt_concat(part, (int)LT_COUNT(part), 2);
}

/* (B, M, 3) from the hand's root, features, what the image shows there, its colour embedded */
lt_tensor *gpm_tokens(const gpm *m, const gpm_in *in)
{
    lt_tensor *points = lt_detach(in->points);
    lt_tensor *grouped = m->opts.metric_radius ? points : lt_unit_sphere(points, in->count);
    const pointnet2_out o = pointnet2_level_forward(&m->level, grouped, features_of(m, in), in->start);
    lt_tensor *root = lt_reshape(lt_detach(in->root), LT_SHAPE(lt_dim(points, 0), 1, 3));
    lt_tensor *place = lt_gather(lt_detach(in->place), o.index);
    lt_tensor *const part[] = { lt_sub(lt_gather(points, o.index), root), o.features,
                                lt_detach(vpm_condition_at(in->condition, place)),
                                embed(m, lt_gather(in->rgb, o.index)) };

    return lt_concat(part, (int)LT_COUNT(part), 2);
}

/* ---- encoder and heads ---------------------------------------------------------------------------------- */

static lt_tensor *drop(const gpm_opts *o, lt_tensor *x)
{
    return o->dropout > 0 ? lt_dropout(x, o->dropout) : x;
}

static lt_tensor *layer_forward(const gpm_layer *l, const gpm_opts *o, lt_tensor *x)
{
    lt_tensor *q = lt_linear_layer_forward(&l->q, x), *k = lt_linear_layer_forward(&l->k, x);
    lt_tensor *v = lt_linear_layer_forward(&l->v, x), *y;

    y = lt_linear_layer_forward(&l->out, lt_attention(q, k, v, o->heads));
    x = lt_layer_norm_layer_forward(&l->norm1, lt_add(x, drop(o, y)));
    y = drop(o, lt_relu(lt_linear_layer_forward(&l->linear1, x)));
    y = lt_linear_layer_forward(&l->linear2, y);
    return lt_layer_norm_layer_forward(&l->norm2, lt_add(x, drop(o, y)));
}

static lt_tensor *head_forward(const lt_linear_layer head[GPM_HEAD], lt_tensor *x)
{
    for (int i = 0; i < GPM_HEAD; i++)
        x = lt_linear_layer_forward(&head[i], i ? lt_relu(x) : x);
    return x;
}

/* (B, M, C) -> (B, C) */
static lt_tensor *mean_of_tokens(lt_tensor *x)
{
    lt_tensor *map = lt_permute(x, (int[]){ 0, 2, 1 });

    return lt_global_avg_pool(lt_reshape(map, LT_SHAPE(lt_dim(map, 0), lt_dim(map, 1), 1, lt_dim(map, 2))));
}

gpm_out gpm_encode(const gpm *m, lt_tensor *tokens)
{
    const int last = m->opts.layers - 1;
    lt_tensor *x = m->opts.width ? lt_linear_layer_forward(&m->project, tokens) : tokens;
    gpm_out out = { .layers = m->opts.layers };

    for (int i = 0; i <= last; i++) {
        lt_tensor *normed;

        x = layer_forward(&m->layer[i], &m->opts, x);
        normed = lt_layer_norm_layer_forward(&m->norm, x);
        out.translation[i] = head_forward(m->translation, normed);
        out.rotation[i] = head_forward(m->rotation, normed);
    }
    out.delta_T = mean_of_tokens(out.translation[last]);
    out.delta_R = lt_reshape(mean_of_tokens(out.rotation[last]), LT_SHAPE(lt_dim(tokens, 0), 3, 3));
    return out;
}

gpm_out gpm_forward(const gpm *m, const gpm_in *in)
{
    return gpm_encode(m, gpm_tokens(m, in));
}
