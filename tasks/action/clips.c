/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/action/clips.h"

#include "assets/hands.h"
#include "data/action/takes.h"
#include "data/recording/clips.h"

lt_status action_clips_open(lt_arena *arena, const train_config *c, action_set *out)
{
    const char *root = c->data->dir;
    hands both;
    lt_status st;

    if (recording_clips_probe(root))
        return recording_clips_open(arena, root, action_data_of(c)->seen, out);
    if (*action_data_of(c)->seen)
        return lt_error(LT_EUSAGE, "data.seen: goes with a world of palmar synth --preset world, and %s is none", root);
    if (!action_is_takes(root))
        return action_open(arena, root, out);
    if (action_data_of(c)->streams != STREAMS_HAND_OBJECT)
        return lt_error(LT_EUSAGE,
                        "%s: DexYCB has no skeletons; --set data.streams=hand_object learns from hands and objects "
                        "alone", root);
    st = hands_open(arena, NULL, &both);
    return st ? st : action_open_takes(arena, root, both.right, out);
}
