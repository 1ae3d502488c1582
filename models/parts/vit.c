/* SPDX-License-Identifier: Apache-2.0 */
/* CLIP's image tower: 87,456,000 parameters as b32. */
#include "models/backbones/vit.h"

#include "libtensor/nn/init.h"
#include "models/parts/parts.h"

typedef struct {
    int variant;
} vit_config;

typedef struct {
    vit_config config;
    vit tower;
} vit_model;

static const char *const blocks[] = { "embed", "norm_pre", "blocks", "norm", NULL };

static const lt_config_key keys[] = {
    { "variant", .offset = offsetof(vit_config, variant), .type = LT_CONFIG_CHOICE, .fallback = "\"b32\"",
      .choices = vit_variants, .doc = "b32 and s16, on 224 x 224 pixels; tiny, on 112 x 112" },
    { .name = NULL },
};

static void build(model *self, const lt_hand_layer *hand)
{
    vit_model *m = self->self;
    const vit_opts *size = &vit_sizes[m->config.variant];

    (void)hand;
    self->variant = vit_variants[m->config.variant], self->image_size = size->image_size;
    vit_new(&m->tower, self->params, "", size);
}

static void init(const model *self, uint64_t seed)
{
    const vit_model *m = self->self;

    lt_init_default(self->params, seed);
    vit_init(&m->tower, seed);
}

/* With losses "loss", the mean squared distance of the feature to the input "target" (B, C) */
static void record(const model *self, bool losses, model_record *r)
{
    const vit_model *m = self->self;
    const int size = m->tower.opts.image_size;
    const vit_out y = vit_forward(&m->tower, model_input(r, "image", LT_SHAPE(r->batch, 3, size, size)));

    model_port_add(&r->outputs, "feature", lt_output(y.feature, "feature"));
    model_port_add(&r->outputs, "patches", lt_output(y.patches, "patches"));
    if (!losses)
        return;
    r->loss = lt_output(lt_mse_loss(y.feature, model_input(r, "target", y.feature->shape), NULL), "loss");
    model_port_add(&r->losses, "loss", r->loss);
}

const model_class vit_class = {
    .name = "vit", .size = sizeof(vit_model),
    .paper = "Radford et al. 2021, ICML, pages 8748-8763",
    .variants = vit_variants, .keys = keys, .blocks = blocks, .mean = vit_mean, .deviation = vit_deviation,
    .build = build, .init = init, .record = record,
};
