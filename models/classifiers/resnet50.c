/* SPDX-License-Identifier: Apache-2.0 */
/* ResNet-50 as torchvision has it: 25,557,032 parameters at full size. */
#include "libtensor/nn/init.h"
#include "models/backbones/imagenet.h"
#include "models/backbones/resnet.h"
#include "models/classifiers/classifier.h"

#include <string.h>

typedef struct {
    int image_size, width, classes;
    int blocks[RESNET_STAGES];
} resnet50_config;

typedef struct {
    resnet50_config config;
    resnet trunk;
    lt_linear_layer fc;
} resnet50;

static const char *const blocks[] = { "conv1", "bn1", "layer1", "layer2", "layer3", "layer4", "fc", NULL };

#define KEY(field) #field, .offset = offsetof(resnet50_config, field)

static const lt_config_key keys[] = {
    { KEY(image_size), .type = LT_CONFIG_INT, .fallback = "256", .lo = 32, .hi = 1024,
      .doc = "side of the image in pixels" },
    { KEY(width), .type = LT_CONFIG_INT, .fallback = "64", .lo = 8, .hi = 256,
      .doc = "planes of the first stage" },
    { KEY(blocks), .type = LT_CONFIG_INTS, .fallback = "[3, 4, 6, 3]", .lo = 1, .hi = RESNET_MAX_BLOCKS,
      .doc = "bottlenecks of the four stages" },
    { KEY(classes), .type = LT_CONFIG_INT, .fallback = "1000", .lo = 1, .hi = 100000, .doc = "classes" },
    { .name = NULL },
};

static void build(model *self, const lt_hand_layer *hand)
{
    resnet50 *m = self->self;
    resnet_opts trunk = { .width = m->config.width, .slope = 0 };

    (void)hand;
    self->variant = classifier_variants[0], self->image_size = m->config.image_size;
    memcpy(trunk.blocks, m->config.blocks, sizeof(trunk.blocks));
    resnet_new(&m->trunk, self->params, "", &trunk);
    m->fc = lt_linear_layer_new(self->params, "fc", m->trunk.channels[RESNET_STAGES - 1], m->config.classes, true);
}

static void init(const model *self, uint64_t seed)
{
    const resnet50 *m = self->self;

    lt_init_default(self->params, seed);
    resnet_init(&m->trunk, seed);
}

static void record(const model *self, bool losses, model_record *r)
{
    const resnet50 *m = self->self;
    const resnet_out c = resnet_forward(&m->trunk, classifier_image(r, m->config.image_size), RESNET_STAGES);

    classifier_record(&m->fc, 0, c.c[RESNET_STAGES - 1], losses, r);
}

const model_class resnet50_class = {
    .name = "resnet50", .size = sizeof(resnet50),
    .paper = "He et al. 2016, CVPR, pages 770-778",
    .variants = classifier_variants, .keys = keys, .blocks = blocks,
    .mean = imagenet_mean, .deviation = imagenet_deviation,
    .build = build, .init = init, .record = record,
};
