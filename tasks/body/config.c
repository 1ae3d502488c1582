/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/body/config.h"

#define DATA(field) #field, .offset = offsetof(body_data_config, field)

const lt_config_key body_data_keys[] = {
    TRAIN_DIR_KEY(body_data_config),
    TRAIN_LOADER_KEYS(body_data_config),
    { DATA(body), .type = LT_CONFIG_TEXT, .fallback = "\"\"",
      .doc = "body model: SMPLX_NEUTRAL.npz or .pkl, or embedded; the one that the dataset was made with" },
    { DATA(scale), .type = LT_CONFIG_NUMBER, .fallback = "0.15", .lo = 0, .hi = 0.5,
      .doc = "pictures to train on are made larger or smaller by up to this share" },
    { DATA(shift), .type = LT_CONFIG_NUMBER, .fallback = "0.05", .lo = 0, .hi = 0.5,
      .doc = "and moved by up to this share of their width" },
    { DATA(rotation_deg), .type = LT_CONFIG_NUMBER, .fallback = "30", .lo = 0, .hi = 90,
      .doc = "three fifths of them turned by a normal draw of this deviation, degrees, at most twice that" },
    { DATA(flip), .type = LT_CONFIG_NUMBER, .fallback = "0.5", .lo = 0, .hi = 1,
      .doc = "share of them that is mirrored" },
    { DATA(colour), .type = LT_CONFIG_NUMBER, .fallback = "0.2", .lo = 0, .hi = 1,
      .doc = "and changed in brightness, contrast and saturation by up to this share" },
    { DATA(heads_rate), .type = LT_CONFIG_NUMBER, .fallback = "1", .lo = 0, .hi = 1,
      .doc = "factor on the learning rate of the layers that turn all joints at once: each of their numbers is a sum "
             "over thousands, which as many small steps of Adam throw far" },
    { DATA(matrices_rate), .type = LT_CONFIG_NUMBER, .fallback = "1", .lo = 0, .hi = 1000,
      .doc = "and on that of the transformer's matrices, which optim.kind muon moves in a way of its own" },
    { .name = NULL },
};

static lt_optim_group group(const lt_optim_group *like, const char *name, const char *const *prefix,
                            const char *const *suffix, double rate)
{
    lt_optim_group g = *like;

    g.name = name;
    g.prefix = prefix;
    g.suffix = suffix;
    g.schedule.lr *= rate;
    g.schedule.min_lr *= rate;
    return g;
}

void body_groups(const train_config *c, lt_optim_group out[BODY_GROUPS])
{
    static const char *const heads[] = { "body_regressor.root_pose_out.", "body_regressor.body_pose_out.",
                                         "hand_regressor.hand_pose_out.", NULL };
    static const char *const blocks[] = { "encoder.blocks.", NULL };
    static const char *const matrices[] = { ".q.weight", ".k.weight", ".v.weight", ".out.weight", ".fc1.weight",
                                            ".fc2.weight", NULL };
    const lt_optim_group all = train_optim_group(c);
    lt_optim_group rest = all;

    if (all.kind == LT_MUON)
        rest.kind = LT_ADAMW;
    out[0] = group(&rest, "heads", heads, NULL, body_data_of(c)->heads_rate);
    out[1] = group(&all, "transformer", blocks, matrices, body_data_of(c)->matrices_rate);
    out[2] = group(&rest, "others", NULL, NULL, 1);
}
