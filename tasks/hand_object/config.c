/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hand_object/config.h"

#include "data/dexycb/dexycb.h"
#include "train/task.h"

#define DATA(field) #field, .offset = offsetof(hand_object_config, field)

const lt_config_key hand_object_keys[] = {
    TRAIN_DIR_KEY(hand_object_config),
    { DATA(kind), .type = LT_CONFIG_CHOICE, .fallback = "\"folder\"",
      .choices = (const char *const[]){ "folder", "stream", NULL },
      .doc = "train on data.dir, or on synthetic pictures that are made meanwhile, by train.seed; data.dir is then "
             "only what validation looks at, where it is given" },
    { DATA(pictures), .type = LT_CONFIG_INT, .fallback = "100000", .lo = 1, .hi = 100000000,
      .doc = "stream: pictures in an epoch" },
    { DATA(shrink), .type = LT_CONFIG_INT, .fallback = "2", .lo = 1, .hi = 4, .doc = "stream: they are 640 x 480 over "
      "this" },
    { DATA(near), .type = LT_CONFIG_NUMBER, .fallback = "0", .lo = 0, .hi = 1,
      .doc = "stream: share of pictures of hands from near by, most of them bare" },
    { DATA(keep_mb), .type = LT_CONFIG_INT, .fallback = "1000", .lo = 0, .hi = 1000000,
      .doc = "stream: MB of memory in which pictures stay for the next epochs, 30 to 40 a MB, 12 with depth; "
      "others are drawn anew" },
    { DATA(objects), .type = LT_CONFIG_TEXT, .fallback = "\"\"",
      .doc = "folder of the object models; empty: models/ in the dataset, or beside it" },
    { DATA(hand), .type = LT_CONFIG_TEXT, .fallback = "\"\"",
      .doc = "hand model: MANO's .pkl, a .npz, the folder of MANO's, or embedded; empty: $PALMAR_HAND, else embedded" },
    { DATA(hand_left), .type = LT_CONFIG_TEXT, .fallback = "\"\"",
      .doc = "DexYCB: left hand model, whose components left hands' poses are in; empty: the file beside the right "
             "one's, or that one's mirror image" },
    { DATA(setup), .type = LT_CONFIG_CHOICE, .fallback = "\"s0\"", .choices = dexycb_setups,
      .doc = "DexYCB: all seen, or unseen subjects, views, objects" },
    { DATA(filter), .type = LT_CONFIG_CHOICE, .fallback = "\"valid\"", .choices = dexycb_filters,
      .doc = "DexYCB: with a hand; every frame; as HFL-Net; as HOISDF: right hands in contact" },
    TRAIN_LOADER_KEYS(hand_object_config),
    { DATA(augment), .type = LT_CONFIG_BOOL, .fallback = "true", .doc = "jitter, turn and recolour the crops" },
    { DATA(bilinear), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "sample HOCAT's crops between pixels, not at the nearest" },
    { DATA(contact_mm), .type = LT_CONFIG_NUMBER, .fallback = "0", .lo = 0, .hi = 1000,
      .doc = "train on samples whose hand comes this close to the object; 0: on all" },
    { DATA(centre_jitter), .type = LT_CONFIG_NUMBER, .fallback = "0.1", .lo = 0, .hi = 1,
      .doc = "HOCAT: the crop's centre moves by up to this share of its side" },
    { DATA(scale_jitter), .type = LT_CONFIG_NUMBER, .fallback = "0.2", .lo = 0, .hi = 0.9,
      .doc = "HOCAT: deviation of the crop's scale, and its limit" },
    { DATA(rotation_deg), .type = LT_CONFIG_NUMBER, .fallback = "180", .lo = 0, .hi = 180,
      .doc = "the crop turns by up to this, degrees" },
    { DATA(rotation_chance), .type = LT_CONFIG_NUMBER, .fallback = "1", .lo = 0, .hi = 1,
      .doc = "below 1: with this chance it turns by rotation_deg times a normal draw, cut at 2" },
    { DATA(blur), .type = LT_CONFIG_NUMBER, .fallback = "0.5", .lo = 0, .hi = 1,
      .doc = "deviation of the blur at most, pixels" },
    { DATA(brightness), .type = LT_CONFIG_NUMBER, .fallback = "0.5", .lo = 0, .hi = 1, .doc = "factor 1 +- this" },
    { DATA(contrast), .type = LT_CONFIG_NUMBER, .fallback = "0.5", .lo = 0, .hi = 1, .doc = "factor 1 +- this" },
    { DATA(saturation), .type = LT_CONFIG_NUMBER, .fallback = "0.5", .lo = 0, .hi = 1, .doc = "factor 1 +- this" },
    { DATA(hue), .type = LT_CONFIG_NUMBER, .fallback = "0.15", .lo = 0, .hi = 0.5,
      .doc = "hue turns by up to this, in turns" },
    { DATA(background), .type = LT_CONFIG_NUMBER, .fallback = "0", .lo = 0, .hi = 1,
      .doc = "chance of another background behind hand and object; needs their masks (HO3D: seg/, DexYCB: seg)" },
    { .name = NULL },
};

const hand_object_config *hand_object_config_of(const train_config *c)
{
    return (const hand_object_config *)c->data;
}

const char *hand_object_setup(const hand_object_config *d)
{
    return dexycb_setups[d->setup];
}

const char *hand_object_filter(const hand_object_config *d)
{
    return dexycb_filters[d->filter];
}
