/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/detect/config.h"

#include <math.h>

static const char *const optimizers[] = { "auto", "given", NULL };

#define DATA(field) #field, .offset = offsetof(detect_config, field)

const lt_config_key detect_keys[] = {
    TRAIN_DIR_KEY(detect_config),
    TRAIN_LOADER_KEYS(detect_config),
    { DATA(names), .type = LT_CONFIG_TEXT, .fallback = "\"\"",
      .doc = "what the classes are called, with commas between; a run takes the dataset's names, whatever stands "
             "here" },
    { DATA(optimizer), .type = LT_CONFIG_CHOICE, .fallback = "\"auto\"", .choices = optimizers,
      .doc = "auto: AdamW, or SGD for runs of more than 10,000 steps, with rates to suit; given: what optim says" },
    { DATA(augment), .type = LT_CONFIG_BOOL, .fallback = "true", .doc = "mosaics, other sizes, places and colours" },
    { DATA(mosaic), .type = LT_CONFIG_NUMBER, .fallback = "1", .lo = 0, .hi = 1,
      .doc = "chance of a picture put together of four" },
    { DATA(close_mosaic), .type = LT_CONFIG_INT, .fallback = "10", .lo = 0, .hi = 1e9,
      .doc = "epochs at the end without mosaics" },
    { DATA(scale), .type = LT_CONFIG_NUMBER, .fallback = "0.5", .lo = 0, .hi = 0.95, .doc = "size times 1 +- this" },
    { DATA(translate), .type = LT_CONFIG_NUMBER, .fallback = "0.1", .lo = 0, .hi = 1,
      .doc = "moved by up to this share of the picture" },
    { DATA(flip), .type = LT_CONFIG_NUMBER, .fallback = "0.5", .lo = 0, .hi = 1, .doc = "chance of left for right" },
    { DATA(hue), .type = LT_CONFIG_NUMBER, .fallback = "0.015", .lo = 0, .hi = 1, .doc = "hue times 1 +- this" },
    { DATA(saturation), .type = LT_CONFIG_NUMBER, .fallback = "0.7", .lo = 0, .hi = 1,
      .doc = "saturation times 1 +- this" },
    { DATA(value), .type = LT_CONFIG_NUMBER, .fallback = "0.4", .lo = 0, .hi = 1, .doc = "value times 1 +- this" },
    { .name = NULL },
};

enum { NOMINAL = 64, LONG_RUN = 10000 };

/* What the rule, or the configuration, says of any weight */
static lt_optim_group base_of(const train_config *c, int64_t images, int classes)
{
    const train_optim_config *o = &c->optim;
    const int nominal = o->batch > NOMINAL ? o->batch : NOMINAL;
    lt_optim_group g = train_optim_group(c);

    g.weight_decay *= (double)o->batch / NOMINAL;
    if (o->schedule == LT_LINEAR_LR)
        g.schedule.every = 1;
    if (detect_config_of(c)->optimizer == DETECT_OPTIM_AUTO) {
        const bool is_long = lt_ceil_div(images, nominal) * o->epochs > LONG_RUN;

        g.kind = is_long ? LT_SGD : LT_ADAMW;
        g.nesterov = is_long;
        g.momentum = 0.9;
        g.schedule.kind = LT_LINEAR_LR;
        g.schedule.every = 1;
        g.schedule.lr = is_long ? 0.01 : 0.002 * 5 / (4 + classes);
        g.schedule.min_lr = 0.01 * g.schedule.lr;
    }
    if (g.kind == LT_SGD)
        g.warmup_momentum = 0.8;
    return g;
}

void detect_groups(const train_config *c, int64_t images, int classes, lt_optim_group out[DETECT_GROUPS])
{
    static const char *const biases[] = { ".bias", NULL };
    const lt_optim_group base = base_of(c, images, classes);

    out[0] = out[1] = base;
    out[0].name = "biases";
    out[0].suffix = biases;
    out[0].weight_decay = 0;
    if (base.kind == LT_SGD && detect_config_of(c)->optimizer == DETECT_OPTIM_GIVEN)
        out[0].schedule.warmup_lr = 0.1;
    out[1].name = "weights";
    out[1].decay_rank = 2;
}
