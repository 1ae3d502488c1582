/* SPDX-License-Identifier: Apache-2.0 */
#include "data/action/windows.h"

#include "libtensor/base/rng.h"

#include <math.h>
#include <string.h>

enum { SPLIT = 0x53504c54 };

/* At random as large a share is scored as one subject of all would be. */
static bool on_side(const action_set *set, const action_window_options *how, int clip, int k)
{
    lt_rng r;

    if (set->whole)
        return how->evaluation;
    if (how->split == ACTION_BY_SUBJECT) {
        const int held_out = how->held_out < 0 ? set->subjects - 1 : how->held_out;

        return (set->clip[clip].subject == held_out) == how->evaluation;
    }
    r = lt_rng_make((uint64_t)how->held_out, lt_rng_mix(SPLIT, (uint64_t)clip * (uint64_t)how->per_clip + (uint64_t)k));
    return (lt_rng_below(&r, (uint32_t)set->subjects) == 0) == how->evaluation;
}

static int start_of(const action_clip *c, int T, int per_clip, int k)
{
    const int last = c->frames > T ? c->frames - T : 0;

    return per_clip > 1 ? (int)lround((double)k * last / (per_clip - 1)) : last / 2;
}

lt_status action_windows(lt_arena *arena, const action_set *set, const action_window_options *how,
                         const action_window **out, int64_t *n)
{
    action_window *w = lt_arena_array(arena, (size_t)set->n * (size_t)how->per_clip, sizeof(*w));
    int64_t count = 0;

    if (!w)
        return lt_error(LT_ENOMEM, "%s: no memory for windows", set->root);
    for (int64_t i = 0; i < set->n; i++)
        for (int k = 0; k < how->per_clip; k++)
            if (on_side(set, how, (int)i, k))
                w[count++] = (action_window){ (int)i, start_of(&set->clip[i], how->frames, how->per_clip, k) };
    if (!count && set->whole)
        return lt_error(LT_EINVAL, "%s: what persons did before cameras is scored, and not trained on", set->root);
    if (!count && how->split == ACTION_BY_SUBJECT)
        return lt_error(LT_EINVAL, "%s: no clip to %s: subject %d is held out, and %d are there", set->root,
                        how->evaluation ? "score" : "train on", how->held_out < 0 ? set->subjects - 1 : how->held_out,
                        set->subjects);
    if (!count)
        return lt_error(LT_EINVAL, "%s: no window to %s", set->root, how->evaluation ? "score" : "train on");
    *out = w;
    *n = count;
    return LT_OK;
}

/* Frames from start on of (3, length, points), less what `origin` has at its first point */
static void copy_points(const float *x, int length, int points, const int *frame, int T, int origin, float *out)
{
    for (int64_t c = 0; c < 3; c++) {
        const float less = x[(c * length + origin) * points];

        for (int k = 0; k < T; k++)
            for (int i = 0; i < points; i++)
                out[(c * T + k) * points + i] = x[(c * length + frame[k]) * points + i] - less;
    }
}

static int read_hand_object(const action_set *set, int clip, const int *frame, int T, float *out, float *valid)
{
    const uint8_t *known = set->valid ? set->valid + (int64_t)clip * set->length : NULL;
    int n = 0, first = -1;

    for (int k = 0; k < T; k++) {
        valid[k] = known && known[frame[k]];
        n += valid[k] > 0;
        first = first < 0 && valid[k] > 0 ? frame[k] : first;
    }
    memset(out, 0, (size_t)T * 3 * ACTION_HAND_OBJECT * sizeof(*out));
    if (!n)
        return 0;
    copy_points(set->hand_object + (int64_t)clip * 3 * set->length * ACTION_HAND_OBJECT, set->length,
                ACTION_HAND_OBJECT, frame, T, first, out);
    for (int k = 0; k < T; k++)
        for (int64_t c = 0; c < 3 && !(valid[k] > 0); c++)
            memset(out + (c * T + k) * ACTION_HAND_OBJECT, 0, ACTION_HAND_OBJECT * sizeof(*out));
    return n;
}

int action_window_read(const action_set *set, const action_window *w, int T, float *body, float *hand_object,
                       float *valid)
{
    const action_clip *c = &set->clip[w->clip];
    int frame[ACTION_MOST_FRAMES];

    for (int k = 0; k < T; k++)
        frame[k] = w->start + k < c->frames ? w->start + k : c->frames - 1;
    copy_points(set->body + (int64_t)w->clip * 3 * set->length * ACTION_BODY, set->length, ACTION_BODY, frame, T,
                frame[0], body);
    return read_hand_object(set, w->clip, frame, T, hand_object, valid);
}
