/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hogs/vpm.h"

#include "libtensor/nn/init.h"

#include <math.h>

enum { FEATURES = 2, BINS = 16, ALPHA_HIDDEN = 64 };    /* of an entry of the hash grid; of OneBlob; of psi_1 */
enum { COVARIANCE = 6, SH = 48, OPACITY = 1 };
enum { PLACE = 3, SCALE = 3, ROTATION = 4, DELTAS = PLACE + SCALE + ROTATION };
enum { TRUNK_LAYERS = 4 };

static const double CM2 = 1e4;      /* covariances in square centimetres: in metres they are about 1e-6 */

int vpm_encoding(const vpm_opts *o)
{
    return o->one_blob ? 3 * BINS : FEATURES * o->grid.levels;
}

/* Columns of the trunk's first layer for G; the condition's follow. */
static int gaussian_columns(const vpm_opts *o)
{
    return o->gaussian ? vpm_encoding(o) + COVARIANCE + SH + OPACITY : 0;
}

static bool has_condition(const vpm_opts *o)
{
    return o->global || o->pixel;
}

void vpm_new(vpm *m, lt_params *set, const char *prefix, int sets, const vpm_opts *opts)
{
    const int seen = opts->vit * (opts->global + opts->pixel), Z = opts->appearance;
    const int in = gaussian_columns(opts) + (has_condition(opts) ? opts->condition : 0);

    *m = (vpm){ .opts = *opts };
    if (!opts->one_blob)
        m->table = lt_params_add(set, lt_name(set, "%s.hash", prefix), "table", LT_WEIGHT,
                                 LT_SHAPE(lt_hash_grid_entries(&opts->grid), FEATURES));
    if (has_condition(opts))
        m->reduce = lt_linear_layer_new(set, lt_name(set, "%s.reduce", prefix), seen, opts->condition, true);
    set_mlp_new(&m->trunk, set, lt_name(set, "%s.trunk", prefix), sets,
                (int[]){ in, opts->trunk, opts->trunk, opts->trunk, DELTAS + Z }, TRUNK_LAYERS);
    m->alpha1 = lt_linear_layer_new(set, lt_name(set, "%s.alpha1", prefix), 3 + Z, ALPHA_HIDDEN, true);
    m->alpha2 = lt_linear_layer_new(set, lt_name(set, "%s.alpha2", prefix), ALPHA_HIDDEN, opts->alpha3 ? 3 : 1, true);
    m->colour = lt_linear_layer_new(set, lt_name(set, "%s.colour", prefix), Z, 3, true);
}

static void init_linear(const lt_linear_layer *l, uint64_t seed)
{
    const double bound = l->weight ? 1 / sqrt(lt_fan_in(l->weight)) : 0;

    if (!l->weight)
        return;
    lt_init_uniform(l->weight, seed, bound);
    lt_init_uniform(l->bias, seed, bound);
}

void vpm_init(const vpm *m, uint64_t seed)
{
    if (m->table)
        lt_init_uniform(m->table, seed, 1e-4);
    init_linear(&m->reduce, seed);
    set_mlp_init(&m->trunk, seed);
    lt_init_normal(m->trunk.weight[TRUNK_LAYERS - 1], seed, 1e-5);
    lt_init_constant(m->trunk.bias[TRUNK_LAYERS - 1], 0);
    init_linear(&m->alpha1, seed);
    init_linear(&m->alpha2, seed);
    init_linear(&m->colour, seed);
}

/* -1 to 1 as 0 to 1 */
static lt_tensor *unit(lt_tensor *places)
{
    return lt_add(lt_scale(lt_detach(places), 0.5), lt_scalar(places->graph, 0.5));
}

lt_tensor *vpm_encode_by(lt_param *table, const lt_hash_grid_opts *grid, lt_tensor *places)
{
    return lt_hash_grid(unit(places), lt_use(places->graph, table), grid);
}

lt_tensor *vpm_encode(const vpm *m, lt_tensor *places)
{
    return m->table ? vpm_encode_by(m->table, &m->opts.grid, places) : lt_one_blob(unit(places), BINS);
}

/* ---- the visual condition ------------------------------------------------------------------------------ */

/*
 * cond = W_r [F; F(pi)] + b_r, and behind it the trunk's first layer. A bilinear sample and a linear map commute, and
 * nothing between the two is not linear: so W_r = [W_F | W_P] and the layer's columns L_c go over the map's cells, and
 * the result is sampled at the Gaussians. The same numbers but for rounding, for a sixth of the work.
 */
vpm_condition vpm_condition_of(const vpm *m, lt_tensor *F, lt_tensor *map, int h, int w)
{
    const vpm_opts *o = &m->opts;
    vpm_condition c = { .h = h, .w = w };
    lt_tensor *W, *b;

    if (!has_condition(o))
        return c;
    W = lt_use(F->graph, m->reduce.weight), b = lt_use(F->graph, m->reduce.bias);
    if (o->global)
        c.base = lt_linear(F, lt_slice(W, 1, 0, o->vit), b);
    else
        c.base = lt_reshape(b, LT_SHAPE(1, o->condition));
    if (o->pixel)
        c.map = lt_linear(map, lt_slice(W, 1, o->global ? o->vit : 0, o->vit), NULL);
    return c;
}

lt_tensor *vpm_condition_at(const vpm_condition *c, lt_tensor *place)
{
    lt_tensor *base = lt_reshape(c->base, LT_SHAPE(lt_dim(c->base, 0), 1, lt_dim(c->base, 1)));

    if (!c->map) {
        lt_tensor *zeros;

        lt_constant_reals(place->graph, LT_SHAPE(1, lt_dim(place, 1), 1), &zeros);
        return lt_add(base, zeros);
    }
    return lt_add(lt_sample_rows(c->map, place, c->h, c->w), base);
}

/* ---- the trunk ------------------------------------------------------------------------------------------ */

/* G: enc(p), covariance, SH, opacity */
static lt_tensor *gaussian_part(const vpm_gaussians *g)
{
    lt_tensor *const part[] = { g->encoding, lt_scale(lt_detach(g->covariance), CM2), lt_detach(g->sh),
                                lt_detach(g->opacity) };

    return lt_concat(part, (int)LT_COUNT(part), 1);
}

/* What comes out of the trunk's first layer, before its activation: L_G G + (L_c base + b) + sample of L_c map */
static lt_tensor *first_layer(const vpm *m, const vpm_condition *c, const vpm_gaussians *g, lt_tensor *place,
                              lt_tensor *which)
{
    const vpm_opts *o = &m->opts;
    const int columns = gaussian_columns(o);
    const set_layer l = set_mlp_layer(&m->trunk, 0, which);
    lt_tensor *bias = l.bias, *of_condition = NULL, *x = NULL;

    if (has_condition(o)) {
        of_condition = lt_slice(l.weight, 1, columns, o->condition);
        bias = lt_reshape(lt_linear(c->base, of_condition, bias), LT_SHAPE(o->trunk));
    }
    if (o->gaussian)
        x = lt_linear(gaussian_part(g), lt_slice(l.weight, 1, 0, columns), bias);
    if (o->pixel) {
        lt_tensor *V = lt_linear(c->map, of_condition, NULL);          /* (1, h w, trunk) */
        lt_tensor *sample = lt_sample_rows(V, place, c->h, c->w);

        sample = lt_reshape(sample, LT_SHAPE(lt_dim(place, 1), o->trunk));
        x = lt_add(sample, x ? x : bias);
    }
    return x;
}

vpm_out vpm_forward(const vpm *m, const vpm_condition *c, const vpm_gaussians *g, lt_tensor *place, lt_tensor *which)
{
    lt_tensor *out = set_mlp_rest(&m->trunk, 0, first_layer(m, c, g, place, which), which);

    return (vpm_out){
        .place = lt_slice(out, 1, 0, PLACE), .scale = lt_slice(out, 1, PLACE, SCALE),
        .rotation = lt_slice(out, 1, PLACE + SCALE, ROTATION),
        .appearance = lt_slice(out, 1, DELTAS, m->opts.appearance),
    };
}

static lt_tensor *mean_sum_of_sizes(lt_tensor *x, lt_tensor *weight)
{
    lt_tensor *zeros;

    lt_constant_reals(x->graph, x->shape, &zeros);
    return lt_scale(lt_l1_loss(x, zeros, weight), (double)lt_dim(x, 1));
}

/* Lengths are distances from the origin. */
vpm_penalties vpm_penalties_of(const vpm_out *out, lt_tensor *weight)
{
    const int64_t N = lt_dim(out->place, 0);
    lt_tensor *origin, *length;

    lt_constant_reals(out->place->graph, LT_SHAPE(1, 1, 3), &origin);
    length = lt_reshape(lt_nearest(lt_reshape(out->place, LT_SHAPE(1, N, 3)), origin), LT_SHAPE(N, 1));
    return (vpm_penalties){
        .place = mean_sum_of_sizes(length, weight), .scale = mean_sum_of_sizes(out->scale, weight),
        .rotation = mean_sum_of_sizes(lt_slice(out->rotation, 1, 1, ROTATION - 1), weight),
    };
}

lt_tensor *vpm_colour(const vpm *m, lt_tensor *c_sh, lt_tensor *appearance)
{
    lt_tensor *both = lt_concat((lt_tensor *[]){ c_sh, appearance }, 2, 1);
    lt_tensor *hidden = lt_relu(lt_linear_layer_forward(&m->alpha1, both));
    lt_tensor *alpha = lt_sigmoid(lt_linear_layer_forward(&m->alpha2, hidden));
    lt_tensor *v = lt_sigmoid(lt_linear_layer_forward(&m->colour, appearance));

    return lt_add(c_sh, lt_mul(alpha, lt_sub(v, c_sh)));
}
