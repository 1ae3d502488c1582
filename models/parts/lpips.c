/* SPDX-License-Identifier: Apache-2.0 */
/* LPIPS of whole images: 2,469,696 frozen weights of AlexNet's convolutions and 1,152 of channels. */
#include "models/backbones/lpips.h"

#include "models/parts/parts.h"

typedef struct {
    int image_size;
} lpips_config;

typedef struct {
    lpips_config config;
    lpips network;
} lpips_model;

static const char *const variants[] = { "alex", NULL };
static const char *const blocks[] = { "features", "lin0", "lin1", "lin2", "lin3", "lin4", NULL };

static const lt_config_key keys[] = {
    { "image_size", .offset = offsetof(lpips_config, image_size), .type = LT_CONFIG_INT, .fallback = "150",
      .lo = ALEXNET_LEAST, .hi = 1024, .doc = "side of the images in pixels" },
    { .name = NULL },
};

static void build(model *self, const lt_hand_layer *hand)
{
    lpips_model *m = self->self;

    (void)hand;
    self->variant = variants[0], self->image_size = m->config.image_size;
    lpips_new(&m->network, self->params, "");
}

static void init(const model *self, uint64_t seed)
{
    lpips_model *m = self->self;

    (void)seed;
    lpips_init(&m->network);
}

/* With losses "loss", the sum of the distances, and a gradient of the image */
static void record(const model *self, bool losses, model_record *r)
{
    const lpips_model *m = self->self;
    const lt_shape shape = LT_SHAPE(r->batch, 3, m->config.image_size, m->config.image_size);
    lt_tensor *image = model_input(r, "image", shape), *distance;

    if (losses)
        lt_want_grad(image);
    distance = lpips_distance(&m->network, LPIPS_SYM, image, model_input(r, "truth", shape), NULL);
    model_port_add(&r->outputs, "distance", lt_output(distance, "distance"));
    if (!losses)
        return;
    r->loss = lt_output(lt_sum(distance), "loss");
    model_port_add(&r->losses, "loss", r->loss);
}

const model_class lpips_class = {
    .name = "lpips", .size = sizeof(lpips_model),
    .paper = "Zhang et al. 2018, CVPR, pages 586-595",
    .variants = variants, .keys = keys, .blocks = blocks, .build = build, .init = init, .record = record,
};
