/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/track/events.h"

static const double MEET = 0.3, HIDDEN = 0.2, SHORT = 1, LONG = 4, AWAY = 0.5;

static double iou(const synth_pixels *a, const synth_pixels *b)
{
    const int64_t w = lt_min_i64(a->x1, b->x1) - lt_max_i64(a->x0, b->x0);
    const int64_t h = lt_min_i64(a->y1, b->y1) - lt_max_i64(a->y0, b->y0);
    const int64_t in = w > 0 && h > 0 ? w * h : 0;
    const int64_t all = (int64_t)(a->x1 - a->x0) * (a->y1 - a->y0) + (int64_t)(b->x1 - b->x0) * (b->y1 - b->y0) - in;

    return all > 0 ? (double)in / (double)all : 0;
}

static const synth_mot_truth *find(const synth_mot_truth *truth, int n, int id)
{
    for (int i = 0; i < n; i++)
        if (truth[i].id == id)
            return &truth[i];
    return NULL;
}

static void follow(track_events *e, track_state *s, const synth_mot_truth *t, double time)
{
    const bool hidden = t && t->visible < HIDDEN, was_here = s->here;

    if (s->here && s->hidden && !hidden)
        e->occlusions += t && time - s->since >= SHORT && time - s->since <= LONG;
    if (!was_here && t)
        e->returns += time - s->since >= AWAY;
    if (was_here != (t != NULL) || hidden != s->hidden)
        s->since = time;
    s->here = t;
    s->hidden = hidden;
    if (t)
        s->box = t->box;
}

void track_events_add(track_events *e, track_watch *w, const synth_mot_truth *truth, int n, double time)
{
    for (int i = 0; i < w->n; i++)
        follow(e, &w->state[i], find(truth, n, w->state[i].id), time);
    for (int i = 0; i < n; i++) {
        bool known = false;
        for (int j = 0; j < w->n; j++)
            known = known || w->state[j].id == truth[i].id;
        if (!known && w->n < SYNTH_THINGS)
            w->state[w->n++] = (track_state){ truth[i].id, true, truth[i].visible < HIDDEN, time, truth[i].box };
    }
    for (int i = 0; i < w->n; i++)
        for (int j = 0; j < i; j++) {
            const bool both = w->state[i].here && w->state[j].here;
            const bool meet = both && iou(&w->state[i].box, &w->state[j].box) >= MEET;
            e->crossings += meet && !w->met[i][j];
            w->met[i][j] = meet;
        }
}
