/* SPDX-License-Identifier: Apache-2.0 */
#include "models/unified/unified.h"

#include "libtensor/nn/init.h"
#include "models/backbones/imagenet.h"

enum { STAGES = 4, STRIDE = 8, FFN_RATIO = 4 };

/* ---- configuration ------------------------------------------------------------------------------------ */

static const char *const variants[] = { "full", "no_cross_attention", "no_aaf", "no_depth", NULL };
static const char *const blocks[] = {
    "rgb", "depth", "aaf", "hand_encoder", "object_encoder", "cross", "hourglass", "mesh_encoder", "mano",
    "object_head", NULL,
};
static const char *const twins[] = { "rgb", "depth" };

#define KEY(field) #field, .offset = offsetof(unified_config, field)

static const lt_config_key keys[] = {
    { KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"full\"", .choices = variants,
      .doc = "row of Table 8: full, or without cross-attention, adaptive fusion, depth" },
    { KEY(image_size), .type = LT_CONFIG_INT, .fallback = "224", .lo = 64, .hi = 1024,
      .doc = "side of the crop in pixels, a multiple of 32" },
    { KEY(width), .type = LT_CONFIG_INT, .fallback = "64", .lo = 8, .hi = 256,
      .doc = "channels of hand and object features behind the encoders, whose tokens have twice as many" },
    { KEY(layers), .type = LT_CONFIG_INT, .fallback = "3", .lo = 1, .hi = ENCODER_MAX_LAYERS,
      .doc = "layers of a deformable encoder" },
    { KEY(heads), .type = LT_CONFIG_INT, .fallback = "8", .lo = 1, .hi = 64, .doc = "attention heads" },
    { KEY(points), .type = LT_CONFIG_INT, .fallback = "4", .lo = 1, .hi = 16, .doc = "places a head looks at" },
    { KEY(dropout), .type = LT_CONFIG_NUMBER, .fallback = "0.1", .lo = 0, .hi = 0.99,
      .doc = "chance to zero a value behind attention and in the feed-forward parts in training" },
    { KEY(stochastic_depth), .type = LT_CONFIG_NUMBER, .fallback = "0.2", .lo = 0, .hi = 0.99,
      .doc = "of whole EfficientNet-B0's last block; the blocks that are there have their share" },
    { KEY(stage5_dilation), .type = LT_CONFIG_INT, .fallback = "1", .lo = 1, .hi = 2,
      .doc = "of the last stage's windows; 2 keeps what ImageNet's weights have learnt to see" },
    { KEY(aaf_spatial_sigmoid), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "a sigmoid over the spatial attention of the fusion" },
    { KEY(up3_relu), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "the printed ReLU between the hourglass's last transposed convolution and the heat maps' softmax" },
    { KEY(depth_fit), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "lay the object's pose on the measured depth by iterated closest points; the paper has the control points "
             "alone" },
    HAND_OBJECT_KEYS(unified_config),
    { .name = NULL },
};

static lt_status check(const char *where, const void *config)
{
    const unified_config *c = config;

    if (c->image_size % 32)
        return lt_error(LT_EINVAL, "%s.image_size: %d is no multiple of 32", where, c->image_size);
    if (2 * c->width % c->heads)
        return lt_error(LT_EINVAL, "%s.heads: %d do not divide %d channels", where, c->heads, 2 * c->width);
    return LT_OK;
}

/* ---- building ----------------------------------------------------------------------------------------- */

static void build_streams(unified *m, lt_params *set)
{
    const unified_config *c = &m->config;
    efficientnet_opts stream = {
        .in = 3, .stages = STAGES, .last_stride = 1, .last_dilation = c->stage5_dilation,
        .stochastic_depth = c->stochastic_depth,
    };

    efficientnet_new(&m->rgb, set, "rgb", &stream);
    if (c->variant == UNIFIED_NO_DEPTH)
        return;
    stream.in = 1;
    efficientnet_new(&m->depth, set, "depth", &stream);
    if (c->variant == UNIFIED_NO_AAF)
        return;
    adaptive_attention_new(&m->rgb_attention, set, "aaf.rgb", m->rgb.channels, c->aaf_spatial_sigmoid);
    adaptive_attention_new(&m->depth_attention, set, "aaf.depth", m->rgb.channels, c->aaf_spatial_sigmoid);
}

static void build(model *self, const lt_hand_layer *hand)
{
    unified *m = self->self;
    lt_params *set = self->params;
    const unified_config *c = &m->config;
    const int width = c->width, cells = c->image_size / STRIDE;
    encoder_opts encoder = {
        .width = 2 * width, .out = width, .layers = c->layers, .heads = c->heads, .points = c->points,
        .ffn = 2 * width * FFN_RATIO, .dropout = c->dropout, .cells = cells,
    };

    self->variant = variants[c->variant], self->image_size = c->image_size, self->cells = m->cells = cells;
    self->depth = c->variant != UNIFIED_NO_DEPTH;
    self->depth_fit = c->depth_fit && self->depth;
    self->hand_alone = c->w.p2d <= 0;
    build_streams(m, set);
    encoder.in = m->rgb.channels;
    deformable_encoder_new(&m->hand_encoder, set, "hand_encoder", &encoder);
    deformable_encoder_new(&m->object_encoder, set, "object_encoder", &encoder);
    if (c->variant != UNIFIED_NO_CROSS_ATTENTION)
        cross_attention_new(&m->cross, set, "cross", width);
    unified_hourglass_new(&m->hourglass, set, "hourglass", cells, width, LT_HAND_KEYPOINTS, c->up3_relu);
    mesh_encoder_new(&m->mesh, set, "mesh_encoder", cells, width, LT_HAND_KEYPOINTS);
    mano_regressor_new(&m->mano, set, "mano", 16 * width, 16 * width, 8 * width, hand);
    object_head_new(&m->object, set, "object_head", width);
}

static void init(const model *self, uint64_t seed)
{
    const unified *m = self->self;
    const unified_config *c = &m->config;

    lt_init_default(self->params, seed);
    efficientnet_init(&m->rgb, seed);
    if (c->variant != UNIFIED_NO_DEPTH)
        efficientnet_init(&m->depth, seed);
    if (c->variant != UNIFIED_NO_DEPTH && c->variant != UNIFIED_NO_AAF) {
        adaptive_attention_init(&m->rgb_attention, seed);
        adaptive_attention_init(&m->depth_attention, seed);
    }
    deformable_encoder_init(&m->hand_encoder, seed);
    deformable_encoder_init(&m->object_encoder, seed);
    lt_init_constant(m->hourglass.temperature, 1);
    lt_init_xavier(m->mano.pose.weight, seed, 0.01);
    identity_pose_init(m->mano.pose.bias);
}

/* ---- the data flow of the paper, top to bottom ---------------------------------------------------------- */

/* F_rgb A_rgb + F_depth A_depth, or what the variant leaves of it */
static lt_tensor *features(const unified *m, lt_tensor *image, lt_tensor *depth)
{
    lt_tensor *f = efficientnet_forward(&m->rgb, imagenet_normalise(image)), *d;

    if (!depth)
        return f;
    d = efficientnet_forward(&m->depth, depth);
    if (m->config.variant == UNIFIED_NO_AAF)
        return lt_add(f, d);
    return lt_add(adaptive_attention_forward(&m->rgb_attention, f),
                  adaptive_attention_forward(&m->depth_attention, d));
}

static hand_object_out forward(const unified *m, lt_tensor *image, lt_tensor *depth)
{
    lt_tensor *tokens = lt_map_to_tokens(features(m, image, depth));                    /* (B, 784, 80) */
    lt_tensor *places = lt_cell_places(image->graph, m->cells, m->cells);
    lt_tensor *hand = deformable_encoder_forward(&m->hand_encoder, tokens, places);     /* (B, 784, 64) */
    lt_tensor *object = deformable_encoder_forward(&m->object_encoder, tokens, places);
    hand_object_out out = { 0 };

    if (m->config.variant != UNIFIED_NO_CROSS_ATTENTION)
        cross_attention_forward(&m->cross, &hand, &object);
    out.heat = unified_hourglass_forward(&m->hourglass, lt_tokens_to_map(hand, m->cells, m->cells));
    out.mano = mano_regressor_forward(&m->mano, mesh_encoder_forward(&m->mesh, &out.heat));
    out.object = object_head_forward(&m->object, lt_tokens_to_map(object, m->cells, m->cells));
    return out;
}

static void record(const model *self, bool losses, model_record *r)
{
    const unified *m = self->self;
    const int64_t B = r->batch, S = m->config.image_size;
    lt_tensor *image = model_input(r, "image", LT_SHAPE(B, 3, S, S));
    lt_tensor *depth = m->config.variant == UNIFIED_NO_DEPTH ? NULL : model_input(r, "depth", LT_SHAPE(B, 1, S, S));
    const hand_object_out out = forward(m, image, depth);

    hand_object_record(&out, m->mano.hand, &m->config.w, losses, r);
}

const model_class unified_class = {
    .name = "unified", .size = sizeof(unified), .task = "hand-object",
    .paper = "Bandi and Thomas 2025, Robotics 14(4), 53",
    .variants = variants, .keys = keys, .blocks = blocks, .twins = twins,
    .check = check, .build = build, .init = init, .record = record,
};
