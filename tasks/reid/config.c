/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/reid/config.h"

#define DATA(field) #field, .offset = offsetof(reid_data_config, field)

const lt_config_key reid_data_keys[] = {
    TRAIN_DIR_KEY(reid_data_config),
    TRAIN_LOADER_KEYS(reid_data_config),
    { DATA(every), .type = LT_CONFIG_INT, .fallback = "3", .lo = 1, .hi = 1000000,
      .doc = "frames from one that is learnt from to the next, as neighbours look alike" },
    { DATA(visible), .type = LT_CONFIG_NUMBER, .fallback = "0.3", .lo = 0, .hi = 1,
      .doc = "least share of a box that is seen" },
    { DATA(noise), .type = LT_CONFIG_NUMBER, .fallback = "0.03", .lo = 0, .hi = 0.5,
      .doc = "what a box's corners are off by, as a share of its sides (deviation)" },
    { DATA(flip), .type = LT_CONFIG_NUMBER, .fallback = "0.5", .lo = 0, .hi = 1,
      .doc = "chance of left for right, of persons alone" },
    { DATA(min_conf), .type = LT_CONFIG_NUMBER, .fallback = "0.3", .lo = 0, .hi = 1,
      .doc = "trackers: least score of a detection that begins a track" },
    { DATA(low_conf), .type = LT_CONFIG_NUMBER, .fallback = "0.1", .lo = 0, .hi = 1,
      .doc = "byte: least score of a detection that continues a track" },
    { DATA(look_conf), .type = LT_CONFIG_NUMBER, .fallback = "0.6", .lo = 0, .hi = 1,
      .doc = "deepsort, byte: least score of a detection whose look counts; 0: any, as DeepSORT was published" },
    { DATA(max_cosine), .type = LT_CONFIG_NUMBER, .fallback = "0.2", .lo = 0, .hi = 2,
      .doc = "deepsort, byte: largest cosine distance of a look from a track's" },
    { DATA(max_iou), .type = LT_CONFIG_NUMBER, .fallback = "0.7", .lo = 0, .hi = 1,
      .doc = "trackers: largest 1 - IoU of a box from a track's" },
    { DATA(overlap_cosine), .type = LT_CONFIG_NUMBER, .fallback = "0.5", .lo = 0, .hi = 2,
      .doc = "deepsort, byte: largest cosine distance of a look from a track's where overlap makes the pair; 2: any, "
             "as DeepSORT was published" },
    { DATA(unsure_iou), .type = LT_CONFIG_NUMBER, .fallback = "0.4", .lo = 0, .hi = 1,
      .doc = "deepsort, byte: max_iou of a detection below look_conf; 1: as DeepSORT was published" },
    { DATA(max_age), .type = LT_CONFIG_INT, .fallback = "30", .lo = 1, .hi = 1000000,
      .doc = "trackers: frames of the camera's rate that a track may be missed for" },
    { DATA(n_init), .type = LT_CONFIG_INT, .fallback = "3", .lo = 1, .hi = 1000,
      .doc = "trackers: the detection that confirms a track" },
    { DATA(budget), .type = LT_CONFIG_INT, .fallback = "100", .lo = 1, .hi = 100000,
      .doc = "deepsort, byte: looks that a track remembers" },
    { .name = NULL },
};

tracker_options reid_tracker(const train_config *c, track_method method, double fps)
{
    const reid_data_config *d = reid_data_of(c);
    tracker_options o = tracker_defaults;

    o.method = method;
    o.fps = fps;
    o.min_conf = d->min_conf;
    o.low_conf = d->low_conf;
    o.look_conf = d->look_conf;
    o.max_cosine = d->max_cosine;
    o.max_iou = d->max_iou;
    o.overlap_cosine = d->overlap_cosine;
    o.unsure_iou = d->unsure_iou;
    o.max_age = d->max_age;
    o.n_init = d->n_init;
    o.budget = d->budget;
    return o;
}
