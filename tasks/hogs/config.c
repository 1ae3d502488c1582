/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/config.h"

#include "data/dexycb/dexycb.h"

#define DATA(field) #field, .offset = offsetof(hogs_data_config, field)

static const char *const masks[] = { "data", "initial", NULL };

const lt_config_key hogs_data_keys[] = {
    TRAIN_DIR_KEY(hogs_data_config),
    { DATA(objects), .type = LT_CONFIG_TEXT, .fallback = "\"\"",
      .doc = "folder of the object models; empty: models/ in the dataset, or beside it" },
    { DATA(hand), .type = LT_CONFIG_TEXT, .fallback = "\"\"",
      .doc = "hand model: MANO's .pkl, a .npz, or embedded; empty: $PALMAR_HAND, else embedded" },
    { DATA(poses), .type = LT_CONFIG_TEXT, .fallback = "\"\"",
      .doc = "file of poses to begin from, or truth, truth+independent, truth+correlated; empty: "
             "poses/independent.json of the dataset, or truth+independent where it has none" },
    { DATA(setup), .type = LT_CONFIG_CHOICE, .fallback = "\"s0\"", .choices = dexycb_setups,
      .doc = "DexYCB: all seen, or unseen subjects, views, objects" },
    { DATA(filter), .type = LT_CONFIG_CHOICE, .fallback = "\"hoisdf\"", .choices = dexycb_filters,
      .doc = "DexYCB: as HOISDF: right hands in contact; with a hand; every frame; as HFL-Net" },
    { DATA(masks), .type = LT_CONFIG_CHOICE, .fallback = "\"data\"", .choices = masks,
      .doc = "where masks come from: the dataset's, or the silhouettes of hand and object under the initial poses" },
    { DATA(jitter), .type = LT_CONFIG_BOOL, .fallback = "false",
      .doc = "multiply each channel of an image by 0.7 to 1.3, in training and in scoring" },
    { DATA(iterations), .type = LT_CONFIG_INT, .fallback = "20000", .lo = 20, .hi = 100000000,
      .doc = "of stage 1, one frame each; densification, opacity resets and G-PM's start go by them" },
    { DATA(pose_epochs), .type = LT_CONFIG_INT, .fallback = "2", .lo = 0, .hi = 1000,
      .doc = "of stage 2, in which G-PM alone learns from eight frames a step" },
    { DATA(cache_mb), .type = LT_CONFIG_INT, .fallback = "1000", .lo = 0, .hi = 1000000,
      .doc = "megabytes in which models of the paper's size keep what their ViT, which does not learn, sees of frames: "
             "0.15 a frame, and the same results with any; with data.jitter nothing is kept" },
    TRAIN_LOADER_KEYS(hogs_data_config),
    { .name = NULL },
};

const hogs_data_config *hogs_data_of(const train_config *c)
{
    return (const hogs_data_config *)c->data;
}
