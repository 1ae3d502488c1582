/* SPDX-License-Identifier: Apache-2.0 */
/* G-PM by itself, to measure it: whole, as the paper and as a CPU has it, and the paper's encoder on tokens. */
#include "models/hogs/gpm_model.h"

#include "models/hogs/gpm_loss.h"
#include "models/hogs/sizes.h"

typedef enum { FULL, CPU, ENCODER } gpm_variant;

typedef struct {
    gpm_variant variant;
    int points;
    double dropout;
} gpm_config;

typedef struct {
    gpm_config config;
    const hogs_sizes *sizes;
    gpm gpm;
} gpm_model;

static const char *const variants[] = { "full", "cpu", "encoder", NULL };
static const char *const blocks[] = {
    "embed1", "embed2", "sa1", "project", "encoder", "norm", "translation", "rotation", NULL,
};

#define KEY(field) #field, .offset = offsetof(gpm_config, field)

static const lt_config_key keys[] = {
    { KEY(variant), .type = LT_CONFIG_CHOICE, .fallback = "\"full\"", .choices = variants,
      .doc = "the paper's sizes, those for a CPU, or of the former only the encoder with its heads" },
    { KEY(points), .type = LT_CONFIG_INT, .fallback = "0", .lo = 0, .hi = 1000000,
      .doc = "Gaussians of the object; 0 for as many as training draws" },
    { KEY(dropout), .type = LT_CONFIG_NUMBER, .fallback = "0.1", .lo = 0, .hi = 0.99,
      .doc = "chance to zero a value behind attention and in the feed-forward parts in training" },
    { .name = NULL },
};

static void build(model *self, const lt_hand_layer *hand)
{
    gpm_model *m = self->self;
    gpm_opts opts;

    (void)hand;
    self->variant = variants[m->config.variant];
    m->sizes = m->config.variant == CPU ? &hogs_cpu : &hogs_full;
    opts = m->sizes->gpm;
    opts.dropout = m->config.dropout;
    gpm_new(&m->gpm, self->params, "", &opts);
}

static void init(const model *self, uint64_t seed)
{
    gpm_init(&((const gpm_model *)self->self)->gpm, seed);
}

static gpm_out forward(const gpm_model *m, model_record *r)
{
    const gpm_opts *o = &m->gpm.opts;
    const int64_t B = r->batch, P = m->config.points ? m->config.points : m->sizes->gpm_points, side = m->sizes->map;
    vpm_condition condition = { .h = (int)side, .w = (int)side };
    gpm_in in = { .condition = &condition };

    if (m->config.variant == ENCODER)
        return gpm_encode(&m->gpm, model_input(r, "tokens", LT_SHAPE(B, o->level.points, gpm_token(o))));
    in.points = model_input(r, "points", LT_SHAPE(B, P, 3));
    in.encoding = model_input(r, "encoding", LT_SHAPE(B, P, o->encoding));
    in.covariance = model_input(r, "covariance", LT_SHAPE(B, P, 6));
    in.colour = model_input(r, "colour", LT_SHAPE(B, P, 3));
    in.opacity = model_input(r, "opacity", LT_SHAPE(B, P, 1));
    in.place = model_input(r, "place", LT_SHAPE(B, P, 2));
    in.rgb = model_input(r, "rgb", LT_SHAPE(B, P, 3));
    in.root = model_input(r, "root", LT_SHAPE(B, 3));
    condition.base = model_input(r, "condition", LT_SHAPE(B, o->condition));
    condition.map = model_input(r, "condition_map", LT_SHAPE(B, side * side, o->condition));
    return gpm_forward(&m->gpm, &in);
}

static void record(const model *self, bool losses, model_record *r)
{
    const gpm_out out = forward(self->self, r);
    const lt_shape R = LT_SHAPE(r->batch, 3, 3), t = LT_SHAPE(r->batch, 3);
    gpm_truth truth;

    model_port_add(&r->outputs, "delta_T", lt_output(out.delta_T, "delta_T"));
    model_port_add(&r->outputs, "delta_R", lt_output(out.delta_R, "delta_R"));
    if (!losses)
        return;
    truth = (gpm_truth){
        .initial = { model_input(r, "rotation", R), model_input(r, "origin", t) },
        .truth = { model_input(r, "true_rotation", R), model_input(r, "true_origin", t) },
        .translation = model_input(r, "translation", t),
        .corners = model_input(r, "corners", LT_SHAPE(r->batch, 8, 3)),
    };
    r->loss = lt_output(gpm_pose_losses(&out, &truth).pose, "loss");
    model_port_add(&r->losses, "loss", r->loss);
}

const model_class gpm_class = {
    .name = "gpm", .size = sizeof(gpm_model),
    .paper = "HOGS, its pose refinement", .variants = variants, .keys = keys, .blocks = blocks,
    .build = build, .init = init, .record = record,
};
