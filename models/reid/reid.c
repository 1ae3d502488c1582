/* SPDX-License-Identifier: Apache-2.0 */
#include "models/reid/reid.h"

#include "libtensor/nn/init.h"
#include "models/reid/unit.h"

enum { UNITS = 6, LAST_CHANNELS = 128, CELLS = 16 * 8 };

static const double FIRST_KAPPA = 16;           /* which is its own softplus, nearly */

typedef enum { COMPAT_NONE, COMPAT_TF } reid_compat;

typedef struct {
    int variant, compat, identities;
    double dropout;
} reid_config;

typedef struct {
    reid_config config;
    reid_conv conv1, conv2;
    reid_unit unit[UNITS];
    lt_linear_layer fc;
    lt_batch_norm_layer fc_bn, ball;
    lt_param *identity;             /* (identities, 128) a direction each; NULL without */
    lt_param *scale;                /* (1, 1) of which the softplus is kappa */
} reid;

/* Names, and channels, as in the reference's layers */
static const struct { const char *name; int in, out; } units[UNITS] = {
    { "conv2_1", 32, 32 }, { "conv2_3", 32, 32 }, { "conv3_1", 32, 64 }, { "conv3_3", 64, 64 }, { "conv4_1", 64, 128 },
    { "conv4_3", 128, LAST_CHANNELS },
};

static const char *const variants[] = { "cosine", NULL };
static const char *const compats[] = { "none", "tf", NULL };
static const char *const blocks[] = { "conv1_1", "conv1_2", "conv2_1", "conv2_3", "conv3_1", "conv3_3", "conv4_1",
                                      "conv4_3", "fc1", "ball", "softmax", NULL };
static const char *const fresh[] = { "softmax.", NULL };

#define KEY(field) #field, .offset = offsetof(reid_config, field)

static const lt_config_key keys[] = {
    { KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"cosine\"", .choices = variants,
      .doc = "trained by a softmax over cosines" },
    { .name = "reid_compat", .offset = offsetof(reid_config, compat), .type = LT_CONFIG_CHOICE, .fallback = "\"none\"",
      .choices = compats, .doc = "tf: pads and normalises as the graph of DeepSORT's published arrays does" },
    { KEY(identities), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 1000000,
      .doc = "identities to learn; 0: none, but as many as a training set has where one is trained" },
    { KEY(dropout), .type = LT_CONFIG_NUMBER, .fallback = "0.4", .lo = 0, .hi = 0.95,
      .doc = "share of what is dropped" },
    { .name = NULL },
};

int reid_identities(const model *m)
{
    return ((const reid *)m->self)->config.identities;
}

static void build(model *self, const lt_hand_layer *hand)
{
    reid *m = self->self;
    const bool tf = m->config.compat == COMPAT_TF;
    lt_params *set = self->params;

    (void)hand;
    self->variant = variants[m->config.variant];
    self->image_size = REID_HEIGHT;
    m->conv1 = reid_conv_new(set, "conv1_1", 3, 32, 1, tf);
    m->conv2 = reid_conv_new(set, "conv1_2", 32, 32, 1, tf);
    for (int i = 0; i < UNITS; i++)
        m->unit[i] = reid_unit_new(set, units[i].name, units[i].in, units[i].out, i == 0, m->config.dropout, tf);
    m->fc = lt_linear_layer_new(set, "fc1", LAST_CHANNELS * CELLS, REID_EMBEDDING, false);
    m->fc_bn = reid_norm_new(set, "fc1.bn", REID_EMBEDDING, tf);
    m->ball = reid_norm_new(set, "ball", REID_EMBEDDING, tf);
    if (!m->config.identities)
        return;
    m->identity = lt_params_add(set, "softmax", "weight", LT_WEIGHT, LT_SHAPE(m->config.identities, REID_EMBEDDING));
    m->scale = lt_params_add(set, "softmax", "scale", LT_WEIGHT, LT_SHAPE(1, 1));
}

static void init(const model *self, uint64_t seed)
{
    lt_init_default(self->params, seed);
    if (lt_params_find(self->params, "softmax.scale"))
        lt_init_constant(lt_params_find(self->params, "softmax.scale"), FIRST_KAPPA);
}

/* (B, 16 8 128): rows of the map, their cells, the channels of each, as the arrays of the reference have them */
static lt_tensor *flatten(const reid *m, lt_tensor *x)
{
    const int64_t B = lt_dim(x, 0);

    if (m->config.compat == COMPAT_TF)
        x = lt_permute(x, (int[]){ 0, 2, 3, 1 });
    return lt_reshape(x, LT_SHAPE(B, LAST_CHANNELS * CELLS));
}

static lt_tensor *embed(const reid *m, lt_tensor *image)
{
    const double dropout = m->config.dropout;
    lt_tensor *x = reid_conv_forward(&m->conv1, lt_scale(image, 255));

    x = reid_conv_forward(&m->conv2, x);                                    /* (B, 32, 128, 64) */
    x = lt_max_pool2d(x, 3, 2, m->config.compat == COMPAT_TF ? 0 : 1, false);     /* 64 x 32, or 63 x 31 */
    for (int i = 0; i < UNITS; i++)
        x = reid_unit_forward(&m->unit[i], x);                              /* (B, 128, 16, 8) in the end */
    x = flatten(m, x);
    if (dropout > 0)
        x = lt_dropout(x, dropout);
    x = lt_elu(lt_batch_norm_layer_forward(&m->fc_bn, lt_linear_layer_forward(&m->fc, x)));
    return lt_l2_normalise(lt_batch_norm_layer_forward(&m->ball, x), 1e-8);
}

/* softplus(k) = log(exp k + exp 0): the cross-entropy of the logits k, 0 with the second */
static lt_tensor *kappa(const reid *m, lt_graph *g)
{
    const lt_real zero = 0, second[] = { 0, 1 };
    lt_tensor *logits = lt_concat((lt_tensor *[]){ lt_use(g, m->scale),
                                                   lt_constant(g, LT_F32, LT_SHAPE(1, 1), &zero) }, 2, 1);

    return lt_cross_entropy(logits, lt_constant(g, LT_F32, LT_SHAPE(1, 2), second), NULL);
}

static void record(const model *self, bool losses, model_record *r)
{
    const reid *m = self->self;
    const int64_t B = r->batch, n = m->config.identities;
    lt_tensor *embedding = embed(m, model_input(r, "image", LT_SHAPE(B, 3, REID_HEIGHT, REID_WIDTH))), *logits;

    model_port_add(&r->outputs, "embedding", lt_output(embedding, "embedding"));
    if (!losses || !n)
        return;
    logits = lt_linear(embedding, lt_l2_normalise(lt_use(r->g, m->identity), 1e-8), NULL);
    logits = lt_mul(logits, kappa(m, r->g));
    r->loss = lt_cross_entropy(logits, model_input(r, "identity", LT_SHAPE(B, n)),
                               model_input(r, "weight", LT_SHAPE(B)));
    lt_output(r->loss, "loss");
    model_port_add(&r->losses, "identity", r->loss);
}

const model_class reid_class = {
    .name = "reid", .size = sizeof(reid), .paper = "Wojke and Bewley 2018", .task = "reid", .variants = variants,
    .keys = keys, .blocks = blocks, .fresh = fresh, .build = build, .init = init, .record = record,
};
