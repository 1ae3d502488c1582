/* SPDX-License-Identifier: Apache-2.0 */
/* EfficientNet-B0 as torchvision has it: 5,288,548 parameters at full size. */
#include "libtensor/nn/init.h"
#include "models/backbones/efficientnet.h"
#include "models/backbones/imagenet.h"
#include "models/classifiers/classifier.h"

#include <math.h>

typedef struct {
    int image_size, classes;
    double dropout, stochastic_depth;
} efficientnet_b0_config;

typedef struct {
    efficientnet_b0_config config;
    efficientnet trunk;
    lt_linear_layer fc;
} efficientnet_b0;

static const char *const blocks[] = {
    "features.0", "features.1", "features.2", "features.3", "features.4", "features.5", "features.6",
    "features.7", "features.8", "classifier", NULL,
};

#define KEY(field) #field, .offset = offsetof(efficientnet_b0_config, field)

static const lt_config_key keys[] = {
    { KEY(image_size), .type = LT_CONFIG_INT, .fallback = "224", .lo = 32, .hi = 1024,
      .doc = "side of the image in pixels" },
    { KEY(classes), .type = LT_CONFIG_INT, .fallback = "1000", .lo = 1, .hi = 100000, .doc = "classes" },
    { KEY(dropout), .type = LT_CONFIG_NUMBER, .fallback = "0.2", .lo = 0, .hi = 0.99,
      .doc = "chance to zero a feature before the last layer in training" },
    { KEY(stochastic_depth), .type = LT_CONFIG_NUMBER, .fallback = "0.2", .lo = 0, .hi = 0.99,
      .doc = "chance to leave the last block out in training; earlier blocks' is in proportion" },
    { .name = NULL },
};

static void build(model *self, const lt_hand_layer *hand)
{
    efficientnet_b0 *m = self->self;
    const efficientnet_opts trunk = {
        .in = 3, .stages = EFFICIENTNET_STAGES, .has_head = true, .stochastic_depth = m->config.stochastic_depth,
    };

    (void)hand;
    self->variant = classifier_variants[0], self->image_size = m->config.image_size;
    efficientnet_new(&m->trunk, self->params, "", &trunk);
    m->fc = lt_linear_layer_new(self->params, "classifier.1", m->trunk.channels, m->config.classes, true);
}

static void init(const model *self, uint64_t seed)
{
    const efficientnet_b0 *m = self->self;

    lt_init_default(self->params, seed);
    efficientnet_init(&m->trunk, seed);
    lt_init_uniform(m->fc.weight, seed, 1 / sqrt(m->config.classes));
    lt_init_constant(m->fc.bias, 0);
}

static void record(const model *self, bool losses, model_record *r)
{
    const efficientnet_b0 *m = self->self;
    lt_tensor *features = efficientnet_forward(&m->trunk, classifier_image(r, m->config.image_size));

    classifier_record(&m->fc, m->config.dropout, features, losses, r);
}

const model_class efficientnet_b0_class = {
    .name = "efficientnet_b0", .size = sizeof(efficientnet_b0),
    .paper = "Tan and Le 2019, ICML, pages 6105-6114",
    .variants = classifier_variants, .keys = keys, .blocks = blocks,
    .mean = imagenet_mean, .deviation = imagenet_deviation,
    .build = build, .init = init, .record = record,
};
