/* SPDX-License-Identifier: Apache-2.0 */
#include "models/action/action.h"

#include "libtensor/nn/init.h"
#include "models/action/skeleton.h"

typedef struct {
    int variant, frames, kernel;
    double dropout;
} action_config;

typedef struct {
    action_config config;
    stgcn body;
    object_stream object;
    action_head head;
} action;

static const char *const variants[] = { [STGCN_SMALL] = "small", [STGCN_FULL] = "full", NULL };
static const char *const blocks[] = { "body", "hand_object", "head", NULL };

#define KEY(field) #field, .offset = offsetof(action_config, field)

static const lt_config_key keys[] = {
    { KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"small\"", .choices = variants,
      .doc = "of ST-GCN: 6 units of 32 to 128 channels, or 10 of 64 to 256" },
    { KEY(frames), .type = LT_CONFIG_INT, .fallback = "30", .lo = 8, .hi = 1000,
      .doc = "of a window, at 30 a second" },
    { KEY(kernel), .type = LT_CONFIG_INT, .fallback = "9", .lo = 3, .hi = 31,
      .doc = "moments that a unit of ST-GCN looks at: an odd number" },
    { KEY(dropout), .type = LT_CONFIG_NUMBER, .fallback = "1", .lo = 0, .hi = 1.5,
      .doc = "factor on the shares that are dropped: 0.3 (full: 0.5) of units, 0.1 of stream 2, 0.3 before the end" },
    { .name = NULL },
};

static lt_status check(const char *where, const void *config)
{
    const action_config *c = config;

    return c->kernel % 2 ? LT_OK : lt_error(LT_EINVAL, "%s.kernel: %d, expected an odd number", where, c->kernel);
}

static void build(model *self, const lt_hand_layer *hand)
{
    action *m = self->self;
    lt_params *set = self->params;

    (void)hand;
    self->variant = variants[m->config.variant];
    stgcn_new(&m->body, set, "body", (stgcn_size)m->config.variant, m->config.kernel, m->config.dropout);
    object_stream_new(&m->object, set, "hand_object", m->config.frames, 0.1 * m->config.dropout);
    m->head.fc1 = lt_linear_layer_new(set, "head.fc1", m->body.features + OBJECT_STREAM_TOKEN, 256, true);
    m->head.norm1 = lt_layer_norm_layer_new(set, "head.norm1", 256);
    m->head.fc2 = lt_linear_layer_new(set, "head.fc2", 256, 128, true);
    m->head.norm2 = lt_layer_norm_layer_new(set, "head.norm2", 128);
    m->head.fc3 = lt_linear_layer_new(set, "head.fc3", 128, ACTION_OUTPUTS, true);
}

static void init(const model *self, uint64_t seed)
{
    const action *m = self->self;

    lt_init_default(self->params, seed);
    stgcn_init(&m->body, seed);
    object_stream_init(&m->object, seed);
}

const stgcn *action_stgcn(const model *m)
{
    return &((const action *)m->self)->body;
}

int action_frames(const model *m)
{
    return ((const action *)m->self)->config.frames;
}

lt_tensor *action_hand_object(const model *m, lt_tensor *x, lt_tensor *valid)
{
    return object_stream_forward(&((const action *)m->self)->object, x, valid);
}

lt_tensor *action_classify(const model *m, lt_tensor *body, lt_tensor *hand_object, lt_tensor *on)
{
    const action *a = m->self;
    const action_head *h = &a->head;
    const double dropout = 0.3 * a->config.dropout;
    lt_tensor *x = lt_mul(hand_object, lt_reshape(on, LT_SHAPE(lt_dim(on, 0), 1)));

    x = lt_linear_layer_forward(&h->fc1, lt_concat((lt_tensor *[]){ body, x }, 2, 1));
    x = lt_dropout(lt_relu(lt_layer_norm_layer_forward(&h->norm1, x)), dropout);
    x = lt_linear_layer_forward(&h->fc2, x);
    x = lt_dropout(lt_relu(lt_layer_norm_layer_forward(&h->norm2, x)), dropout);
    return lt_linear_layer_forward(&h->fc3, x);
}

static void record(const model *self, bool losses, model_record *r)
{
    const action *m = self->self;
    const int64_t B = r->batch, T = m->config.frames;
    lt_tensor *body = model_input(r, "body", LT_SHAPE(B, 3, T, SKELETON_BODY));
    lt_tensor *with = model_input(r, "hand_object", LT_SHAPE(B, 3, T, SKELETON_HAND_OBJECT));
    lt_tensor *valid = model_input(r, "valid", LT_SHAPE(B, T)), *on = model_input(r, "on", LT_SHAPE(B));
    lt_tensor *logits = action_classify(self, stgcn_forward(&m->body, body), action_hand_object(self, with, valid), on);

    model_port_add(&r->outputs, "logits", lt_output(logits, "logits"));
    if (!losses)
        return;
    r->loss = lt_cross_entropy(logits, model_input(r, "class", LT_SHAPE(B, ACTION_OUTPUTS)),
                               model_input(r, "weight", LT_SHAPE(B)));
    lt_output(r->loss, "loss");
    model_port_add(&r->losses, "class", r->loss);
}

const model_class action_class = {
    .name = "action", .size = sizeof(action), .paper = "Bandi and Thomas 2025", .task = "action", .variants = variants,
    .keys = keys, .blocks = blocks, .check = check, .build = build, .init = init, .record = record,
};
