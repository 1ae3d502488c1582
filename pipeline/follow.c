/* SPDX-License-Identifier: Apache-2.0 */
/* Which hand of a film's frame is which of the frames before. */
#include "pipeline/internal.h"

#include <math.h>

enum { NOBODY = -1, REACH = 2 };        /* a hand moves by less than so many sides of its box from frame to frame */

static int64_t track_of(const predict_view *v)
{
    return v->hand_seen ? v->hand_seen->track : 0;
}

/* How far a box has moved, in its longer sides; infinity for a hand of the other side, where somebody says it, or of
 * another track. */
static float distance(const predict_smoother *s, const predict_view *v)
{
    const crop_box a = s->box, b = v->hand_box;
    const float side = fmaxf(b.x1 - b.x0, b.y1 - b.y0);

    if ((s->left != v->left && !v->any_side) || (s->track && track_of(v) && s->track != track_of(v)))
        return INFINITY;
    return hypotf((a.x0 + a.x1 - b.x0 - b.x1) / 2, (a.y0 + a.y1 - b.y0 - b.y1) / 2) / side;
}

/* The nearest pair of those that are left; false where none is near. */
static bool next_pair(const predict_followed *f, const predict_view *v, int n, const int *who, const bool *taken,
                      int *view, int *smoother)
{
    float best = REACH;

    for (int i = 0; i < n; i++)
        for (size_t k = 0; k < f->n && who[i] == NOBODY; k++)
            if (!taken[k] && distance(&f->smoother[k], &v[i]) < best) {
                best = distance(&f->smoother[k], &v[i]);
                *view = i;
                *smoother = (int)k;
            }
    return best < REACH;
}

static void match_tracks(const predict_followed *f, const predict_view *v, int n, int *who, bool *taken)
{
    for (int i = 0; i < n; i++)
        for (size_t k = 0; k < f->n; k++)
            if (track_of(&v[i]) && f->smoother[k].track == track_of(&v[i])) {
                who[i] = (int)k;
                taken[k] = true;
            }
}

/* Whose each of n views is, and which of the film's hands are among them */
typedef struct { int *who; bool *taken; } matches;

/* A film of one hand that nobody looks for has that one, wherever it goes. LT_ENOMEM */
static lt_status match(const predict_followed *f, lt_arena *scratch, const predict_view *v, int n, matches *out)
{
    int *who = lt_arena_array(scratch, (size_t)n, sizeof(*who)), i, k;
    bool *taken = lt_arena_array(scratch, f->n, sizeof(*taken));

    if (!who || !taken)
        return lt_error(LT_ENOMEM, "%s: no memory for its hands", v->path);
    *out = (matches){ who, taken };
    for (i = 0; i < n; i++)
        who[i] = NOBODY;
    if (n == 1 && f->n == 1 && !v->hand_seen) {
        who[0] = 0;
        taken[0] = true;
        return LT_OK;
    }
    match_tracks(f, v, n, who, taken);
    while (next_pair(f, v, n, who, taken, &i, &k)) {
        who[i] = k;
        taken[k] = true;
    }
    return LT_OK;
}

lt_status predict_follow_sides(const predict_followed *f, lt_arena *scratch, predict_view *v, int n, bool *known)
{
    matches m;
    lt_status st = match(f, scratch, v, n, &m);

    for (int i = 0; i < n && !st; i++) {
        known[i] = m.who[i] != NOBODY;
        if (known[i] && v[i].any_side)
            v[i].left = f->smoother[m.who[i]].left;
    }
    return st;
}

static lt_status add_smoother(predict_followed *f, const predict_view *v, int *who)
{
    predict_smoother *longer = lt_arena_grow(f->arena, f->smoother, f->n, &f->room, sizeof(*longer));

    if (!longer)
        return lt_error(LT_ENOMEM, "%s: no memory for its hands", v->path);
    f->smoother = longer;
    *who = (int)f->n;
    f->smoother[f->n++] = (predict_smoother){ .dt = f->dt, .left = v->left };
    return LT_OK;
}

static void forget_lost(predict_followed *f)
{
    size_t kept = 0;

    for (size_t k = 0; k < f->n; k++)
        if (f->smoother[k].unseen <= PREDICT_COAST)
            f->smoother[kept++] = f->smoother[k];
    f->n = kept;
}

lt_status predict_follow(predict_followed *f, lt_arena *scratch, const predict_view *v, predict_result *r, int n)
{
    matches m;
    lt_status st = match(f, scratch, v, n, &m);

    for (size_t k = 0; k < f->n && !st; k++)
        if (!m.taken[k]) {
            f->smoother[k].unseen++;
            predict_smooth_missed(&f->smoother[k]);
        }
    for (int i = 0; i < n && !st; i++) {
        predict_smoother *s;

        if (m.who[i] == NOBODY)
            st = add_smoother(f, &v[i], &m.who[i]);
        if (st)
            break;
        s = &f->smoother[m.who[i]];
        s->box = v[i].hand_box;
        s->track = track_of(&v[i]) ? track_of(&v[i]) : s->track;
        s->unseen = 0;
        predict_smooth(s, &v[i], v[i].object, &r[i]);
    }
    forget_lost(f);
    return st;
}

void predict_follow_missed(predict_followed *f)
{
    for (size_t k = 0; k < f->n; k++) {
        f->smoother[k].unseen++;
        predict_smooth_missed(&f->smoother[k]);
    }
    forget_lost(f);
}
