/* SPDX-License-Identifier: Apache-2.0 */
/* PointNet++ by itself: its first level as HOGS has it, and ULIP's whole point encoder. */
#include "models/backbones/pointnet2.h"

#include "libtensor/nn/init.h"
#include "models/classifiers/classifier.h"

typedef enum { FIRST_LEVEL, WHOLE } pointnet2_variant;

typedef struct {
    pointnet2_variant variant;
    int points, features;
    double dropout;
} pointnet2_config;

typedef struct {
    pointnet2_config config;
    pointnet2 whole;                /* of the first level alone only that */
} pointnet2_model;

static const char *const variants[] = { "sa1", "ulip", NULL };
static const char *const blocks[] = { "sa1", "sa2", "sa3", "fc1", "fc2", NULL };

#define KEY(field) #field, .offset = offsetof(pointnet2_config, field)

static const lt_config_key keys[] = {
    { KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"sa1\"", .choices = variants,
      .doc = "the first level alone, or ULIP's three with its head, which look at places alone" },
    { KEY(points), .type = LT_CONFIG_INT, .fallback = "2048", .lo = 1, .hi = 1000000, .doc = "points of a set" },
    { KEY(features), .type = LT_CONFIG_INT, .fallback = "87", .lo = 1, .hi = 1024,
      .doc = "numbers of a point beside its place, of the first level alone" },
    { KEY(dropout), .type = LT_CONFIG_NUMBER, .fallback = "0.4", .lo = 0, .hi = 0.99,
      .doc = "chance to zero a feature of the head in training" },
    { .name = NULL },
};

static void build(model *self, const lt_hand_layer *hand)
{
    pointnet2_model *m = self->self;
    const pointnet2_config *c = &m->config;

    (void)hand;
    self->variant = variants[c->variant];
    if (c->variant == WHOLE)
        pointnet2_new(&m->whole, self->params, "", NULL, c->dropout);
    else
        pointnet2_level_new(&m->whole.level[0], self->params, "sa1", "input", c->features, &ulip_levels[0]);
}

static void init(const model *self, uint64_t seed)
{
    lt_init_default(self->params, seed);
}

/* Centres begin with the first point: another only where a task draws it. */
static void record(const model *self, bool losses, model_record *r)
{
    const pointnet2_model *m = self->self;
    const pointnet2_config *c = &m->config;
    lt_tensor *points = model_input(r, "points", LT_SHAPE(r->batch, c->points, 3)), *out;

    if (c->variant == WHOLE)
        out = pointnet2_forward(&m->whole, points, NULL);
    else
        out = pointnet2_level_forward(&m->whole.level[0], points,
                                      model_input(r, "features", LT_SHAPE(r->batch, c->points, c->features)),
                                      NULL).features;
    model_port_add(&r->outputs, "embedding", lt_output(out, "embedding"));
    if (!losses)
        return;
    r->loss = lt_output(lt_mse_loss(out, model_input(r, "target", out->shape), NULL), "loss");
    model_port_add(&r->losses, "loss", r->loss);
}

const model_class pointnet2_class = {
    .name = "pointnet2", .size = sizeof(pointnet2_model),
    .paper = "Qi et al. 2017, NIPS, pages 5099-5108",
    .variants = variants, .keys = keys, .blocks = blocks, .build = build, .init = init, .record = record,
};
