/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/scorers/mot.h"

#include "vision/assignment.h"

#include <string.h>

enum { ON_VEHICLE = 2, VEHICLE = 6, STATIC = 7, DISTRACTOR = 8, REFLECTION = 12 };

static const double MATCHED = 0.5;

static bool is_distractor(const char *name, int cls)
{
    return cls == ON_VEHICLE || cls == STATIC || cls == DISTRACTOR || cls == REFLECTION ||
        (cls == VEHICLE && strncmp(name, "MOT20", 5) == 0);
}

typedef struct {
    const char *name;
    const mot_looks *looks;
    lt_arena *arena, *scratch;      /* of the sequence, of a frame */
} sequence;

/* Which results of a frame belong to distractors; each result goes with the box of the truth that it fits best in
 * all. */
static lt_status find_distractors(const sequence *s, const mot_frame *truth, const mot_frame *results, bool *drop)
{
    double *cost = lt_arena_array(s->scratch, (size_t)truth->n * (size_t)results->n + 1, sizeof(*cost));
    int *column = lt_arena_array(s->scratch, (size_t)truth->n + 1, sizeof(*column));
    lt_status st;

    if (!cost || !column)
        return lt_error(LT_ENOMEM, "%s: no memory to score it", s->name);
    for (int i = 0; i < truth->n; i++)
        for (int j = 0; j < results->n; j++) {
            const double iou = track_iou(truth->box[i].box, results->box[j].box);

            cost[i * results->n + j] = iou < MATCHED ? 0 : -iou;
        }
    st = assignment_solve(s->scratch, cost, truth->n, results->n, column);
    for (int i = 0; !st && i < truth->n; i++)
        if (column[i] >= 0 && cost[i * results->n + column[i]] < 0 && is_distractor(s->name, truth->box[i].cls))
            drop[column[i]] = true;
    return st;
}

static lt_status take_frame(const sequence *s, const mot_frame *truth, const mot_frame *results,
                            track_scored_frame *out)
{
    track_scored *of_truth = lt_arena_array(s->arena, (size_t)truth->n + 1, sizeof(*of_truth));
    track_scored *found = lt_arena_array(s->arena, (size_t)results->n + 1, sizeof(*found));
    bool *drop = (lt_arena_reset(s->scratch), lt_arena_array(s->scratch, (size_t)results->n + 1, sizeof(*drop)));
    lt_status st;

    if (!of_truth || !found || !drop)
        return lt_error(LT_ENOMEM, "%s: no memory to score it", s->name);
    *out = (track_scored_frame){ .truth = of_truth, .found = found };
    st = find_distractors(s, truth, results, drop);
    for (int i = 0; i < truth->n; i++)
        if (truth->box[i].cls == MOT_PEDESTRIAN && truth->box[i].scored) {
            of_truth[out->n_truth].id = truth->box[i].id;
            of_truth[out->n_truth].look = mot_look(s->looks, s->name, truth->box[i].id);
            memcpy(of_truth[out->n_truth++].box, truth->box[i].box, sizeof(truth->box[i].box));
        }
    for (int j = 0; j < results->n; j++)
        if (!drop[j]) {
            found[out->n_found].id = results->box[j].id;
            memcpy(found[out->n_found++].box, results->box[j].box, sizeof(results->box[j].box));
        }
    return st;
}

lt_status mot_count(const char *name, const mot_looks *looks, const mot_frame *truth, const mot_frame *results,
                    int64_t frames, track_counts *out)
{
    const sequence s = { name, looks, lt_arena_new(), lt_arena_new() };
    const bool room = s.arena && s.scratch;
    track_scored_frame *frame = room ? lt_arena_array(s.arena, (size_t)frames + 1, sizeof(*frame)) : NULL;
    lt_status st = frame ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory to score it", name);

    for (int64_t k = 0; !st && k < frames; k++)
        st = take_frame(&s, &truth[k], &results[k], &frame[k]);
    if (!st) {
        st = track_count(frame, frames, out);
        st = st ? lt_error_prefix(st, "%s", name) : st;
    }
    lt_arena_free(s.scratch);
    lt_arena_free(s.arena);
    return st;
}
