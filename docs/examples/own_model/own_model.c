/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A hand-object model of one's own, outside of palmar's tree: a plain trunk, a head and a loss of its own, and the
 * heads and losses that palmar has. It trains, resumes and is scored as those that come with palmar.
 *
 *     own_model data/tiny runs/own
 */
#include "libtensor/nn/init.h"
#include "models/heads/hand_object.h"
#include "tasks/hand_object/task.h"
#include "train/trainer.h"

#include <stdio.h>

enum { STAGES = 3 };                    /* each halves the map */

/* Group "model" of a config: what `palmar train --keys` would list. */
typedef struct {
    int image_size, width;
    double w_small;
    hand_object_weights w;
} plain_config;

typedef struct {
    plain_config config;                /* first: model_create reads it by the keys */
    lt_conv_layer conv[STAGES];
    lt_batch_norm_layer bn[STAGES];
    lt_conv_layer score;
    lt_param *temperature;
    mano_regressor mano;
    object_head object;
} plain;

#define KEY(field) #field, .offset = offsetof(plain_config, field)

static const lt_config_key keys[] = {
    { KEY(image_size), .type = LT_CONFIG_INT, .fallback = "64", .lo = 32, .hi = 512, .doc = "side of the crop" },
    { KEY(width), .type = LT_CONFIG_INT, .fallback = "32", .lo = 8, .hi = 512, .doc = "channels" },
    { KEY(w_small), .type = LT_CONFIG_NUMBER, .fallback = "0.01", .doc = "weight of the loss on large shapes" },
    HAND_OBJECT_KEYS(plain_config),
    { .name = NULL },
};

static const char *const variants[] = { "full", NULL };
static const char *const blocks[] = { "trunk", "hand", "mano", "object", NULL };

/* Parameters, by names that a checkpoint has. Values come later: from init, or from a file. */
static void build(model *self, const lt_hand_layer *hand)
{
    plain *m = self->self;
    lt_params *set = self->params;
    const int width = m->config.width;

    self->variant = variants[0];
    self->image_size = m->config.image_size;
    self->cells = m->config.image_size >> STAGES;
    for (int i = 0; i < STAGES; i++) {
        m->conv[i] = lt_conv_layer_new(set, lt_name(set, "trunk.%d.conv", i), i ? width : 3, width, 3, false,
                                       &(lt_conv_opts){ .stride = 2, .pad = 1 });
        m->bn[i] = lt_batch_norm_layer_new(set, lt_name(set, "trunk.%d.bn", i), width);
    }
    m->score = lt_conv_layer_new(set, "hand.score", width, LT_HAND_KEYPOINTS, 1, true, NULL);
    m->temperature = lt_params_add(set, "hand", "temperature", LT_WEIGHT, LT_SHAPE(LT_HAND_KEYPOINTS));
    mano_regressor_new(&m->mano, set, "mano", width, 2 * width, width, hand);
    object_head_new(&m->object, set, "object", width);
}

static void init(const model *self, uint64_t seed)
{
    const plain *m = self->self;

    lt_init_default(self->params, seed);
    lt_init_constant(m->temperature, 1);
    identity_pose_init(m->mano.pose.bias);
}

/* A head: a score for each cell and joint, and where its softmax has its middle. */
static heatmap_out locate(const plain *m, lt_tensor *x)
{
    heatmap_out out = { .encoding = x };

    heatmap_softmax(lt_conv_layer_forward(&m->score, x), m->temperature, &out);
    out.joints2d = lt_soft_argmax2d(out.heatmaps);
    return out;
}

/* A loss: the ten numbers of the hand's shape are small where the picture does not tell. */
static void add_small(const plain *m, lt_tensor *beta, model_record *r)
{
    lt_tensor *loss = lt_scale(lt_sum(lt_mul(beta, beta)), m->config.w_small / r->batch);

    model_port_add(&r->losses, "small", lt_output(loss, "small"));
    r->loss = lt_output(lt_add(r->loss, loss), "loss");
}

/* The graph. A mistake in it is kept, and told once, by lt_compile. */
static void record(const model *self, bool losses, model_record *r)
{
    const plain *m = self->self;
    lt_tensor *x = model_input(r, "image", LT_SHAPE(r->batch, 3, m->config.image_size, m->config.image_size));
    hand_object_out out;

    for (int i = 0; i < STAGES; i++)
        x = lt_relu(lt_batch_norm_layer_forward(&m->bn[i], lt_conv_layer_forward(&m->conv[i], x)));
    out = (hand_object_out){
        .heat = locate(m, x),
        .mano = mano_regressor_forward(&m->mano, lt_global_avg_pool(x)),
        .object = object_head_forward(&m->object, x),
    };
    hand_object_record(&out, self->hand, &m->config.w, losses, r);
    if (losses)
        add_small(m, out.mano.beta, r);
}

static const model_class plain_class = {
    .name = "plain", .size = sizeof(plain), .paper = "none", .task = "hand-object", .variants = variants, .keys = keys,
    .blocks = blocks, .build = build, .init = init, .record = record,
};

/* ---- training it ----------------------------------------------------------------------------------------------- */

int main(int argc, char **argv)
{
    const model_class *const mine[] = { &plain_class, NULL };
    task hand_object = hand_object_task;
    const task *const tasks[] = { &hand_object, NULL };
    const char *set[] = { NULL };
    train_options o = { .tasks = tasks, .config = "own_model.json", .set = set, .n_set = 1 };
    char data[4096];
    train_result r;

    if (argc != 3) {
        fprintf(stderr, "usage: own_model DATA OUT\n");
        return 2;
    }
    snprintf(data, sizeof(data), "data.dir=%s", argv[1]);
    set[0] = data;
    o.out = argv[2];
    hand_object.models = mine;
    if (train_run(&o, &r)) {
        fprintf(stderr, "own_model: %s\n", lt_last_error());
        return 1;
    }
    printf("PA-MPJPE %.1f mm\n", r.best);
    return 0;
}
