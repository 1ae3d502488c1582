/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Windows of clips, and which of them are trained on.
 *
 * Source: as action.h; 25 windows a clip make its 5,000 a class out of 200 clips.
 */
#ifndef DATA_ACTION_WINDOWS_H
#define DATA_ACTION_WINDOWS_H

#include "data/action/action.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    ACTION_BY_SUBJECT,              /* who is scored was never trained on */
    ACTION_AT_RANDOM,               /* windows of one clip are on both sides: it leaks */
} action_split;

typedef struct {
    int frames, per_clip;           /* T; windows of a clip, their starts spread evenly over it */
    action_split split;
    int held_out;                   /* the subject that is scored; -1: the last one. At random: the draw's seed */
    bool evaluation;                /* of the scored side; else of the other */
} action_window_options;

typedef struct { int clip, start; } action_window;

/* action_windows - in the clips' order, into the arena. Errors: LT_EINVAL: no window is on that side; LT_ENOMEM */
lt_status action_windows(lt_arena *arena, const action_set *set, const action_window_options *how,
                         const action_window **out, int64_t *n);

/**
 * action_window_read - T frames, of a shorter clip the last one again and again
 *
 *   body          (3, T, 65)   less the pelvis of the first frame
 *   hand_object   (3, T, 30)   less the wrist of the first valid frame; zeros where not valid
 *   valid         (T)          1 or 0
 *
 * Returns how many frames are valid.
 */
int action_window_read(const action_set *set, const action_window *w, int T, float *body, float *hand_object,
                       float *valid);

#ifdef __cplusplus
}
#endif
#endif
