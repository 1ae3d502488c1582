/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/action/config.h"

#define DATA(field) #field, .offset = offsetof(action_data_config, field)

static const char *const splits[] = { [ACTION_BY_SUBJECT] = "subject", [ACTION_AT_RANDOM] = "random", NULL };
static const char *const streams[] = { [STREAMS_BOTH] = "both", [STREAMS_BODY] = "body",
                                       [STREAMS_HAND_OBJECT] = "hand_object", NULL };

const lt_config_key action_data_keys[] = {
    TRAIN_DIR_KEY(action_data_config),
    TRAIN_LOADER_KEYS(action_data_config),
    { DATA(windows), .type = LT_CONFIG_INT, .fallback = "25", .lo = 1, .hi = 10000,
      .doc = "of a clip, their starts spread evenly over it" },
    { DATA(split), .type = LT_CONFIG_CHOICE, .fallback = "\"subject\"", .choices = splits,
      .doc = "who is scored was never trained on; random: windows of a clip on both sides, which leaks" },
    { DATA(held_out), .type = LT_CONFIG_INT, .fallback = "-1", .lo = -1, .hi = ACTION_MOST_SUBJECTS,
      .doc = "subject that is scored, from 0 on; -1: the last one. Of a random split the seed" },
    { DATA(streams), .type = LT_CONFIG_CHOICE, .fallback = "\"both\"", .choices = streams,
      .doc = "what is looked at; the other stream's input is zeros, in training and validation" },
    { DATA(min_valid), .type = LT_CONFIG_INT, .fallback = "8", .lo = 1, .hi = 10000,
      .doc = "stream 2 is off in a window with fewer frames in which hand and object are known" },
    { DATA(hide), .type = LT_CONFIG_NUMBER, .fallback = "0.2", .lo = 0, .hi = 1,
      .doc = "chance that stream 2 is off in training, of classes with an object, so that zeros alone tell nothing" },
    { DATA(seen), .type = LT_CONFIG_TEXT, .fallback = "\"\"",
      .doc = "of a drawn world: a file of lines of palmar watch --json, whose skeletons are scored in place of the "
             "true ones" },
    { .name = NULL },
};

action_window_options action_windows_of(const train_config *c, int T, bool evaluation)
{
    const action_data_config *d = action_data_of(c);

    return (action_window_options){ .frames = T, .per_clip = d->windows, .split = (action_split)d->split,
                                    .held_out = d->held_out, .evaluation = evaluation };
}
