/* SPDX-License-Identifier: Apache-2.0 */
#include "models/points/points.h"

#include "libtensor/nn/init.h"
#include "models/backbones/pointnet2.h"
#include "models/hogs/sizes.h"

typedef enum { FULL, CPU } points_variant;

typedef struct {
    points_variant variant;
    double temperature;
} points_config;

typedef struct {
    points_config config;
    const hogs_sizes *sizes;
    pointnet2_level level[POINTNET2_LEVELS];
    lt_linear_layer projection;
} points_model;

/* Above G-PM's first level: ULIP's, and for a CPU, where they would take twenty times what that level takes, others. */
static const pointnet2_level_opts small_levels[POINTNET2_LEVELS] = {
    [1] = { .points = 32, .samples = 32, .radius = 0.4, .width = { 64, 64, 128 } },
    [2] = { .width = { 128, 256, 512 } },
};

static const char *const variants[] = { "full", "cpu", NULL };
static const char *const blocks[] = { "sa1", "sa2", "sa3", "projection", NULL };

#define KEY(field) #field, .offset = offsetof(points_config, field)

static const lt_config_key keys[] = {
    { KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"full\"", .choices = variants,
      .doc = "whose first level it is: that of HOGS's full sizes, or of those for a CPU" },
    { KEY(temperature), .type = LT_CONFIG_NUMBER, .fallback = "0.07", .lo = 1e-3, .hi = 10,
      .doc = "what similarities are divided by" },
    { .name = NULL },
};

int points_view(const model *m)
{
    return ((const points_model *)m->self)->sizes->gpm_points;
}

static void build(model *self, const lt_hand_layer *hand)
{
    points_model *m = self->self;
    const bool small = m->config.variant == CPU;
    int features = 0;

    (void)hand;
    self->variant = variants[m->config.variant];
    m->sizes = small ? &hogs_cpu : &hogs_full;
    for (int i = 0; i < POINTNET2_LEVELS; i++) {
        const pointnet2_level_opts *o = i == 0 ? &m->sizes->gpm.level : small ? &small_levels[i] : &ulip_levels[i];

        pointnet2_level_new(&m->level[i], self->params, lt_name(self->params, "sa%d", i + 1), "mlp_convs.0", features,
                            o);
        features = o->width[POINTNET2_CONVS - 1];
    }
    m->projection = lt_linear_layer_new(self->params, "projection", features, POINTS_EMBEDDING, true);
}

static void init(const model *self, uint64_t seed)
{
    lt_init_default(self->params, seed);
}

/* (n, n): 1 for view i and its twin, 2 k and 2 k + 1. */
static lt_tensor *twins(lt_graph *g, int64_t n)
{
    lt_tensor *t;
    lt_real *x = lt_constant_reals(g, LT_SHAPE(n, n), &t);

    for (int64_t i = 0; x && i < n; i++)
        x[i * n + (i ^ 1)] = 1;
    return t;
}

static void record(const model *self, bool losses, model_record *r)
{
    const points_model *m = self->self;
    const int64_t n = 2 * r->batch;
    pointnet2_out o = { .points = model_input(r, "points", LT_SHAPE(n, points_view(self), 3)) };
    lt_tensor *z, *similar;

    for (int i = 0; i < POINTNET2_LEVELS; i++)
        o = pointnet2_level_forward(&m->level[i], o.points, o.features, NULL);
    z = lt_reshape(o.features, LT_SHAPE(n, lt_dim(o.features, 2)));
    z = lt_output(lt_l2_normalise(lt_linear_layer_forward(&m->projection, z), 1e-12), "embedding");
    model_port_add(&r->outputs, "embedding", z);
    if (!losses)
        return;
    similar = lt_scale(lt_matmul(z, lt_permute(z, (int[]){ 1, 0 })), 1 / m->config.temperature);
    similar = lt_add(similar, model_input(r, "others", LT_SHAPE(n, n)));
    r->loss = lt_output(lt_cross_entropy(similar, twins(r->g, n), model_input(r, "weight", LT_SHAPE(n))), "loss");
    model_port_add(&r->losses, "contrast", r->loss);
}

const model_class points_class = {
    .name = "points", .size = sizeof(points_model), .paper = "none; Chen et al. 2020, on PointNet++",
    .task = "point-pairs", .variants = variants, .keys = keys, .blocks = blocks, .build = build, .init = init,
    .record = record,
};
