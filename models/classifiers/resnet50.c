/* SPDX-License-Identifier: Apache-2.0 */
/* ResNet-50 as torchvision has it: 25,557,032 parameters at full size. */
#include "libtensor/nn/init.h"
#include "models/backbones/resnet.h"
#include "models/classifiers/classifier.h"

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

static lt_status create(const char *where, const struct cJSON *config, const lt_hand_layer *hand,
                        lt_params *set, model *out)
{
    resnet50 *m = lt_arena_alloc(lt_params_arena(set), sizeof(*m));
    resnet_opts trunk = { .slope = 0 };
    lt_status st;

    (void)hand;
    if (!m)
        return lt_error(LT_ENOMEM, "no memory for the model");
    st = lt_config_read(lt_params_arena(set), where, config, keys, &m->config);
    if (st)
        return st;
    trunk.width = m->config.width;
    for (int i = 0; i < RESNET_STAGES; i++)
        trunk.blocks[i] = m->config.blocks[i];
    resnet_new(&m->trunk, set, "", &trunk);
    m->fc = lt_linear_layer_new(set, "fc", m->trunk.channels[RESNET_STAGES - 1], m->config.classes, true);
    *out = (model){
        .cls = &resnet50_class, .params = set, .self = m, .config = &m->config,
        .variant = classifier_variants[0], .image_size = m->config.image_size,
    };
    return lt_params_status(set);
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
    .name = "resnet50",
    .paper = "He et al. 2016, CVPR, pages 770-778",
    .task = MODEL_CLASSIFIER,
    .variants = classifier_variants, .keys = keys, .blocks = blocks,
    .mean = classifier_mean, .deviation = classifier_deviation,
    .create = create, .init = init, .record = record,
};
