/* SPDX-License-Identifier: Apache-2.0 */
#include "models/body/osx.h"

#include "libtensor/nn/init.h"
#include "models/body/osx_parts.h"
#include "models/body/volume_loss.h"

static const double HAND_TIMES = 2;             /* a hand's box is made so much larger */

typedef struct {
    int variant;
    double stochastic_depth, w_rotation, w_nodes, w_volumes;
} osx_config;

typedef struct {
    osx_config config;
    osx_encoder encoder;
    osx_position position;
    osx_body body;
    osx_box_net boxes;
    osx_hands hands;
    lt_linear_layer expression, jaw;
} osx;

static const char *const variants[] = { "tiny", "s", "b", "l", NULL };

static const struct {
    osx_sizes size;
    int layers, heads;
} sizes[] = {
    { { 192, 64, 128 }, 12, 3 }, { { 384, 128, 256 }, 12, 6 }, { { 768, 256, 512 }, 12, 12 },
    { { 1024, 256, 512 }, 24, 16 },
};

static const char *const blocks[] = { "encoder", "body_position_net", "body_regressor", "box_net", "hand_roi_net",
                                      "hand_position_net", "hand_regressor", "face_regressor", NULL };

#define KEY(field) #field, .offset = offsetof(osx_config, field)

static const lt_config_key keys[] = {
    { KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"tiny\"", .choices = variants,
      .doc = "b and l are OSX's ViT-B and ViT-L; s and tiny are for a CPU" },
    { KEY(stochastic_depth), .type = LT_CONFIG_NUMBER, .fallback = "0", .lo = 0, .hi = 0.99,
      .doc = "chance that training leaves out the last block; of others in proportion" },
    { KEY(w_rotation), .type = LT_CONFIG_NUMBER, .fallback = "1", .lo = 0, .hi = 1e30,
      .doc = "weight of the rotations' loss" },
    { KEY(w_nodes), .type = LT_CONFIG_NUMBER, .fallback = "1", .lo = 0, .hi = 1e30,
      .doc = "weight of the loss of the 65 nodes in space" },
    { KEY(w_volumes), .type = LT_CONFIG_NUMBER, .fallback = "0", .lo = 0, .hi = 1e30,
      .doc = "weight of the cross-entropy of the volumes in which the body's joints are found; the paper has none" },
    { .name = NULL },
};

static void build(model *self, const lt_hand_layer *hand)
{
    osx *m = self->self;
    lt_params *set = self->params;
    const osx_sizes size = sizes[m->config.variant].size;

    (void)hand;
    self->variant = variants[m->config.variant];
    self->image_size = OSX_HEIGHT;
    osx_encoder_new(&m->encoder, set, "encoder", size.width, sizes[m->config.variant].layers,
                    sizes[m->config.variant].heads, m->config.stochastic_depth);
    m->position = osx_position_new(set, "body_position_net", size.width, OSX_BODY_JOINTS, OSX_DEPTHS);
    m->body = osx_body_new(set, "body_regressor", size);
    m->boxes = osx_box_net_new(set, "box_net", size);
    m->hands = osx_hands_new(set, size);
    m->expression = lt_linear_layer_new(set, "face_regressor.expr_out.0", size.width, OSX_EXPRESSIONS, true);
    m->jaw = lt_linear_layer_new(set, "face_regressor.jaw_pose_out.0", size.width, 6, true);
}

/* A body's y points up, the camera's down: at rest in the camera's axes somebody would hang head down, away from it. */
enum { SECOND_OF_Y = 3 };           /* of the six numbers: y of the second column */

/* Somebody at rest who stands before the camera and looks into it, nearly */
static void init(const model *self, uint64_t seed)
{
    const osx *m = self->self;

    lt_init_default(self->params, seed);
    osx_encoder_init(&m->encoder, seed);
    osx_rotations_init(&m->body.root, seed);
    m->body.root.bias->data[SECOND_OF_Y] = -1;
    osx_rotations_init(&m->body.pose, seed);
    osx_rotations_init(&m->hands.pose, seed);
    osx_rotations_init(&m->jaw, seed);
}

static void give(model_record *r, const char *name, lt_tensor *t)
{
    model_port_add(&r->outputs, name, lt_output(t, name));
}

/* Of an output to the input of its name; known: that of what there is, or NULL */
static void add_loss(model_record *r, const char *name, lt_tensor *a, const char *known, double weight)
{
    lt_tensor *seen = known ? model_input(r, known, LT_SHAPE(r->batch, lt_dim(a, 1))) : NULL;

    osx_loss_add(r, name, osx_l1(r, a, model_input(r, name, a->shape), seen), weight);
}

static void add_volume_loss(model_record *r, lt_tensor *logits, double weight)
{
    const volume_size size = { .depth = OSX_DEPTHS, .rows = OSX_ROWS, .columns = OSX_COLUMNS };

    osx_loss_add(r, "volumes", volume_loss(logits, model_port_find(&r->inputs, "body_place"),
                                           model_port_find(&r->inputs, "body_known"), size,
                                           model_port_find(&r->inputs, "weight")), weight);
}

static void add_losses(model_record *r, const osx_weights *w, lt_tensor *volumes, lt_tensor *const box[2],
                       const osx_hands_out *hands)
{
    lt_tensor *place[2];

    model_input(r, "weight", LT_SHAPE(r->batch));
    for (int i = 0; i < 2; i++)
        place[i] = osx_hand_in_picture(hands->place[i], box[i]);
    add_loss(r, "rotation", model_port_find(&r->outputs, "rotation"), NULL, w->rotation);
    add_loss(r, "shape", model_port_find(&r->outputs, "shape"), NULL, 1);
    add_loss(r, "expression", model_port_find(&r->outputs, "expression"), NULL, 1);
    add_loss(r, "body_place", model_port_find(&r->outputs, "body_place"), "body_known", 1);
    add_loss(r, "hand_place", lt_concat(place, 2, 1), "hand_known", 1);
    add_loss(r, "box_centre", model_port_find(&r->outputs, "box_centre"), "box_known", 1);
    add_loss(r, "box_size", model_port_find(&r->outputs, "box_size"), NULL, 1);
    if (w->volumes > 0)
        add_volume_loss(r, volumes, w->volumes);
    lt_output(r->loss, "loss");
}

osx_weights osx_weights_of(const model *self)
{
    const osx_config *c = &((const osx *)self->self)->config;

    return (osx_weights){ .rotation = c->w_rotation, .nodes = c->w_nodes, .volumes = c->w_volumes };
}

/* Figure 2 of the paper, from left to right */
static void record(const model *self, bool losses, model_record *r)
{
    const osx *m = self->self;
    const osx_weights weights = osx_weights_of(self);
    const osx_features f = osx_encoder_forward(&m->encoder,
                                               model_input(r, "image", LT_SHAPE(r->batch, 3, OSX_HEIGHT, OSX_WIDTH)));
    const osx_places joints = osx_position_forward(&m->position, f.map);
    const osx_body_out body = osx_body_forward(&m->body, f.tokens, joints.place);
    const osx_boxes boxes = osx_box_net_forward(&m->boxes, f.map, joints.heat);
    lt_tensor *const box[2] = { osx_box_pixels(&boxes, 0, HAND_TIMES), osx_box_pixels(&boxes, 1, HAND_TIMES) };
    const osx_hands_out hands = osx_hands_forward(&m->hands, f.map, box);
    lt_tensor *jaw = osx_rotations(osx_of_token(&m->jaw, f.tokens, OSX_JAW_TOKEN));

    give(r, "rotation", lt_concat((lt_tensor *[]){ body.rotation, hands.rotation[0], hands.rotation[1], jaw }, 4, 1));
    give(r, "shape", body.shape);
    give(r, "expression", osx_of_token(&m->expression, f.tokens, OSX_EXPRESSION_TOKEN));
    give(r, "camera", body.camera);
    give(r, "body_place", joints.place);
    give(r, "hand_place", lt_concat((lt_tensor *[]){ hands.place[0], hands.place[1] }, 2, 1));
    give(r, "box_centre", boxes.centre);
    give(r, "box_size", boxes.size);
    r->loss = NULL;
    if (losses)
        add_losses(r, &weights, joints.logits, box, &hands);
}

const model_class osx_class = {
    .name = "osx", .size = sizeof(osx), .paper = "Lin et al. 2023, CVPR, pages 21159-21168", .task = "body",
    .variants = variants, .keys = keys, .blocks = blocks, .build = build, .init = init, .record = record,
};
