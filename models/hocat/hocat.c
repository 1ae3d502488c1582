/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hocat/hocat.h"

#include "libtensor/nn/init.h"
#include "models/backbones/imagenet.h"

#include <string.h>

/* ---- configuration ------------------------------------------------------------------------------------ */

static const char *const variants[] = { "full", "dual", "base", NULL };
static const char *const se_places[] = { "lateral+out", "out", "lateral", "none", NULL };
static const char *const base_feats[] = { "c2", "c5up", NULL };
static const char *const head_inits[] = { "hfl", "default", NULL };
static const char *const blocks[] = {
    "trunk", "c5up", "hand_fpn", "object_fpn", "hocat", "hand_head", "hand_encoder", "mano", "object_head", NULL,
};

#define KEY(field) #field, .offset = offsetof(hocat_config, field)

static const lt_config_key keys[] = {
    { KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"full\"", .choices = variants,
      .doc = "row of Table 5: base, dual (without cross-attention), full" },
    { KEY(image_size), .type = LT_CONFIG_INT, .fallback = "256", .lo = 64, .hi = 1024,
      .doc = "side of the crop in pixels, a multiple of 32" },
    { KEY(width), .type = LT_CONFIG_INT, .fallback = "64", .lo = 8, .hi = 256,
      .doc = "planes of the trunk's first stage; all features have four times as many channels" },
    { KEY(blocks), .type = LT_CONFIG_INTS, .fallback = "[3, 4, 6, 3]", .lo = 1, .hi = RESNET_MAX_BLOCKS,
      .doc = "bottlenecks of the trunk's four stages" },
    { KEY(roi), .type = LT_CONFIG_INT, .fallback = "32", .lo = 8, .hi = 64,
      .doc = "side of the pooled features in cells: 8, 16, 32 or 64" },
    { KEY(depth), .type = LT_CONFIG_INT, .fallback = "4", .lo = 1, .hi = HOCAT_MAX_DEPTH,
      .doc = "blocks of cross-attention" },
    { KEY(heads), .type = LT_CONFIG_INT, .fallback = "4", .lo = 1, .hi = 64, .doc = "attention heads" },
    { KEY(mlp_ratio), .type = LT_CONFIG_INT, .fallback = "4", .lo = 1, .hi = 16,
      .doc = "hidden width of the feed-forward part over its input's" },
    { KEY(fused), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "HFL-Net's attention instead: one block of self-attention over both features side by side, "
             "whatever depth says" },
    { KEY(base_feat), .type = LT_CONFIG_CHOICE, .fallback = "\"c2\"", .choices = base_feats,
      .doc = "what the baseline pools from: c2, or c5up, the last stage behind a 1 x 1 convolution, 8 times as large" },
    { KEY(se_place), .type = LT_CONFIG_CHOICE, .fallback = "\"lateral+out\"", .choices = se_places,
      .doc = "where squeeze-and-excitation gates stand in the feature pyramids" },
    { KEY(detach_minor), .type = LT_CONFIG_BOOL, .fallback = "true",
      .doc = "no gradient of the hand's loss into the object's pyramid" },
    { KEY(imagenet_norm), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "normalise the image by ImageNet's mean and deviation" },
    { KEY(identity_pose), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "start from the flat hand instead of HFL-Net's random rotations: learns in fewer steps" },
    { KEY(head_init), .type = LT_CONFIG_CHOICE, .fallback = "\"hfl\"", .choices = head_inits,
      .doc = "first weights of heads and attention: hfl, near zero, for a trunk that has learnt; default, for a "
             "start from nothing at a high rate" },
    { KEY(depth_fit), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "lay the object's pose on the measured depth by iterated closest points; the paper has colour alone" },
    HAND_OBJECT_KEYS(hocat_config),
    { .name = NULL },
};

static lt_status check(const char *where, const void *config)
{
    const hocat_config *c = config;

    if (c->image_size % 32)
        return lt_error(LT_EINVAL, "%s.image_size: %d is no multiple of 32", where, c->image_size);
    if (c->roi & (c->roi - 1))
        return lt_error(LT_EINVAL, "%s.roi: %d is no power of two", where, c->roi);
    if (4 * c->width % c->heads)
        return lt_error(LT_EINVAL, "%s.heads: %d do not divide %d channels", where, c->heads, 4 * c->width);
    if (c->fused && c->variant != HOCAT_FULL)
        return lt_error(LT_EINVAL, "%s.fused: variant %s has no attention", where, variants[c->variant]);
    if (c->base_feat != HOCAT_C2 && c->variant != HOCAT_BASE)
        return lt_error(LT_EINVAL, "%s.base_feat: variant %s pools from its pyramids", where, variants[c->variant]);
    return LT_OK;
}

/* ---- building ----------------------------------------------------------------------------------------- */

/* Halvings from side to 2: the depth of the hourglass and the levels of the encoder. */
static int levels_of(int side)
{
    int n = 0;

    for (; side > 2; side /= 2)
        n++;
    return n;
}

static void build(model *self, const lt_hand_layer *hand)
{
    hocat *m = self->self;
    lt_params *set = self->params;
    const hocat_config *c = &m->config;
    const int channels = 4 * c->width, levels = levels_of(c->roi);
    resnet_opts trunk = { .width = c->width, .slope = 0.01 };

    self->variant = variants[c->variant], self->image_size = c->image_size, self->cells = c->roi;
    self->depth_fit = c->depth_fit;
    self->hand_alone = c->w.p2d <= 0;
    memcpy(trunk.blocks, c->blocks, sizeof(trunk.blocks));
    resnet_new(&m->trunk, set, "trunk", &trunk);
    if (c->base_feat == HOCAT_C5UP)
        m->c5up = lt_conv_layer_new(set, "c5up", m->trunk.channels[RESNET_STAGES - 1], channels, 1, true, NULL);
    if (c->variant != HOCAT_BASE) {
        hocat_fpn_new(&m->hand_fpn, set, "hand_fpn", m->trunk.channels, channels, c->se_place);
        hocat_fpn_new(&m->object_fpn, set, "object_fpn", m->trunk.channels, channels, c->se_place);
    }
    if (c->variant == HOCAT_FULL && c->fused)
        hocat_attention_new(&m->attention, set, "hocat", 2 * channels, 1, c->heads, c->mlp_ratio);
    else if (c->variant == HOCAT_FULL)
        hocat_attention_new(&m->attention, set, "hocat", channels, c->depth, c->heads, c->mlp_ratio);
    heatmap_head_new(&m->hand_head, set, "hand_head", channels, LT_HAND_KEYPOINTS, levels);
    fusion_encoder_new(&m->encoder, set, "hand_encoder", channels, LT_HAND_KEYPOINTS, levels);
    mano_regressor_new(&m->mano, set, "mano", 4 * channels, 4 * channels, 2 * channels, hand);
    object_head_new(&m->object, set, "object_head", channels);
}

/* Heads and attention start near zero, so that at first every confidence is 0.5, every place its cell's
 * centre and every heat map flat; the pyramids keep the default.                       [HFL model.py] */
static void init_head(lt_param *p, uint64_t seed)
{
    const char *part = strrchr(p->name, '.') + 1;

    if (strcmp(part, "bias") == 0)
        lt_init_constant(p, 0);
    else if (strcmp(part, "weight") == 0 && p->shape.rank == 4)
        lt_init_normal(p, seed, 0.001);
    else if (strcmp(part, "weight") == 0 && p->shape.rank == 2)
        lt_init_normal(p, seed, 0.01);
}

/* A heat map's cells sum to 1, and features do not: times its side it weighs, from the first step on, about as much as
 * what it is added to. */
static void scale_heatmaps(lt_param *weight, int side)
{
    for (int64_t i = 0; i < lt_param_numel(weight); i++)
        weight->data[i] *= (lt_real)side;
}

static void init(const model *self, uint64_t seed)
{
    static const char *const heads[] = { "hocat.", "hand_head.", "hand_encoder.", "mano.", "object_head." };
    const hocat *m = self->self;

    lt_init_default(self->params, seed);
    resnet_init(&m->trunk, seed);
    lt_init_constant(m->hand_head.temperature, 1);
    for (lt_param *p = lt_params_first(self->params); p; p = p->next)
        for (size_t i = 0; m->config.head_init == HOCAT_HFL_INIT && i < LT_COUNT(heads); i++)
            if (strncmp(p->name, heads[i], strlen(heads[i])) == 0)
                init_head(p, seed);
    if (m->config.head_init == HOCAT_DEFAULT_INIT)
        scale_heatmaps(m->encoder.heatmap_conv.weight, m->config.roi);
    if (m->config.identity_pose)
        identity_pose_init(m->mano.pose.bias);
}

/* ---- the data flow of the paper, top to bottom ---------------------------------------------------------- */

/* What RoIAlign reads: the two maps, or the baseline's twice. */
typedef struct {
    lt_tensor *hand, *object;
} feature_maps;

static feature_maps base_features(const hocat *m, lt_tensor *image)
{
    const bool c5up = m->config.base_feat == HOCAT_C5UP;
    const resnet_out c = resnet_forward(&m->trunk, image, c5up ? RESNET_STAGES : 1);
    const int64_t side = m->config.image_size / 4;
    lt_tensor *map = c.c[0];

    if (c5up)
        map = lt_resize_bilinear(lt_conv_layer_forward(&m->c5up, c.c[RESNET_STAGES - 1]), side, side);
    return (feature_maps){ map, map };
}

/* Undefined where no box reads them, unless whole */
static feature_maps pyramids(const hocat *m, lt_tensor *image, lt_tensor *hand_rois, lt_tensor *object_rois,
                             bool whole)
{
    const bool minor = m->config.variant == HOCAT_FULL;
    const resnet_out c = resnet_forward(&m->trunk, image, RESNET_STAGES);
    lt_tensor *const read[] = { object_rois, hand_rois };

    return (feature_maps){ hocat_fpn_forward(&m->hand_fpn, &c, &hand_rois, whole ? 0 : 1),
                           hocat_fpn_forward(&m->object_fpn, &c, read, whole ? 0 : minor ? 2 : 1) };
}

/* (B, 4) -> (B, 5): one box per image, its index in front */
static lt_tensor *number_boxes(lt_tensor *boxes)
{
    return lt_concat((lt_tensor *[]){ lt_sample_index(boxes), boxes }, 2, 1);
}

/* F_h of F_hm and F_on */
static lt_tensor *attend(const hocat *m, lt_tensor *hand, lt_tensor *minor)
{
    if (m->config.detach_minor)
        minor = lt_detach(minor);
    return (m->config.fused ? hocat_fused_forward : hocat_attention_forward)(&m->attention, hand, minor);
}

static hand_object_out forward(const hocat *m, lt_tensor *image, lt_tensor *hand_box, lt_tensor *object_box,
                               bool whole)
{
    const int roi = m->config.roi;
    lt_tensor *hand_rois = number_boxes(hand_box), *object_rois = number_boxes(object_box);
    lt_tensor *normal = m->config.imagenet_norm ? imagenet_normalise(image) : image;
    const feature_maps p2 = m->config.variant == HOCAT_BASE ? base_features(m, normal)
                                                            : pyramids(m, normal, hand_rois, object_rois, whole);
    lt_tensor *hand_main = lt_roi_align(p2.hand, hand_rois, roi, roi, 0.25);            /* F_hm */
    lt_tensor *object_main = lt_roi_align(p2.object, object_rois, roi, roi, 0.25);      /* F_om */
    hand_object_out out = { 0 };

    if (m->config.variant == HOCAT_FULL)
        hand_main = attend(m, hand_main, lt_roi_align(p2.object, hand_rois, roi, roi, 0.25));   /* F_h of F_hm, F_on */
    out.heat = heatmap_head_forward(&m->hand_head, hand_main);
    out.mano = mano_regressor_forward(&m->mano, fusion_encoder_forward(&m->encoder, out.heat.heatmaps,
                                                                       out.heat.encoding));
    out.object = object_head_forward(&m->object, object_main);
    return out;
}

static void record(const model *self, bool losses, model_record *r)
{
    const hocat *m = self->self;
    const int64_t B = r->batch, S = m->config.image_size;
    lt_tensor *image = model_input(r, "image", LT_SHAPE(B, 3, S, S));
    lt_tensor *hand_box = model_input(r, "hand_box", LT_SHAPE(B, 4));
    lt_tensor *object_box = model_input(r, "object_box", LT_SHAPE(B, 4));
    const hand_object_out o = forward(m, image, hand_box, object_box, r->whole_maps);

    hand_object_record(&o, m->mano.hand, &m->config.w, losses, r);
}

const model_class hocat_class = {
    .name = "hocat", .size = sizeof(hocat), .task = "hand-object",
    .paper = "Cai et al. 2025, Electronics 14(5), 1029",
    .variants = variants, .keys = keys, .blocks = blocks,
    .check = check, .build = build, .init = init, .record = record,
};
