/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which detection belongs to which track. Each step matches some of the tracks and detections that are left, and one
 * assignment serves all classes: a pair of two classes costs as much as no pair, so none is made.
 */
#include "vision/assignment.h"
#include "vision/track/internal.h"

#include <math.h>
#include <string.h>

static const double GATE = 9.4877;              /* chi-squared: 95 % of four degrees of freedom */
static const double LOW_IOU = 0.5;              /* largest 1 - IoU in ByteTrack's second step */
static const double NO_PAIR = 1e5;
static const double COSINE_MOST = 2;            /* there is no larger distance */
static const double SAME_PLACE = 0.5;           /* largest 1 - IoU of a detection that needs no look */

/* What one step looks at */
typedef struct step {
    int *track, *found;             /* indices */
    int n_tracks, n_found;
    double limit;                   /* a pair that costs more is none */
    /* what a track and each of the detections cost */
    void (*costs)(const track_frame *f, const struct step *s, const track *t, double *cost);
    /* of detections whose looks are compared with a track's: which, their embeddings and distances */
    int *passed;
    float *units, *products;
    double *distance;
} step;

/* ---- by appearance --------------------------------------------------------------------------------------- */

static bool passes(const track_frame *f, const track *t, int found)
{
    return t->cls == f->found[found].cls && f->unit[found]
        && motion_distance(&t->motion, f->found[found].box) <= GATE;
}

/* How far the looks of the first n that passed are from the track's: one product */
static void compare_looks(const track_frame *f, const step *s, const track *t, int n)
{
    const size_t size = (size_t)f->options->embedding;

    for (int k = 0; k < n; k++)
        memcpy(s->units + (size_t)k * size, f->unit[s->found[s->passed[k]]], size * sizeof(*s->units));
    gallery_distances(&t->look, s->units, n, s->products, s->distance);
}

/* The gate first, as it spares most comparisons. */
static void appearance_costs(const track_frame *f, const step *s, const track *t, double *cost)
{
    int n = 0;

    for (int j = 0; j < s->n_found; j++) {
        cost[j] = NO_PAIR;
        if (passes(f, t, s->found[j]))
            s->passed[n++] = j;
    }
    compare_looks(f, s, t, n);
    for (int k = 0; k < n; k++)
        cost[s->passed[k]] = s->distance[k];
}

static lt_status make_room(const track_frame *f, step *s)
{
    const size_t n = (size_t)f->n_found + 1;

    s->passed = lt_arena_array(f->scratch, n, sizeof(*s->passed));
    s->units = lt_arena_array(f->scratch, n * (size_t)f->options->embedding, sizeof(*s->units));
    s->products = lt_arena_array(f->scratch, n * (size_t)f->options->budget, sizeof(*s->products));
    s->distance = lt_arena_array(f->scratch, n, sizeof(*s->distance));
    return s->passed && s->units && s->products && s->distance
        ? LT_OK : lt_error(LT_ENOMEM, "no memory to compare %d detections with tracks", f->n_found);
}

/* ---- by overlap ------------------------------------------------------------------------------------------ */

static double overlap_cost(const track *t, const float b[4])
{
    double a[4], w, h, both, all;

    motion_box(&t->motion, a);
    w = fmin(a[2], (double)b[2]) - fmax(a[0], (double)b[0]);
    h = fmin(a[3], (double)b[3]) - fmax(a[1], (double)b[1]);
    if (!(w > 0 && h > 0))                      /* also where a height was predicted to be negative */
        return 1;
    both = w * h;
    all = (a[2] - a[0]) * (a[3] - a[1]) + ((double)b[2] - (double)b[0]) * ((double)b[3] - (double)b[1]) - both;
    return 1 - both / all;
}

/* What is where a track should be, and looks like somebody else, is somebody else. What is too unsure for a look has to
 * be there all the more. */
static void overlap_costs(const track_frame *f, const step *s, const track *t, double *cost)
{
    const tracker_options *o = f->options;
    int n = 0;

    for (int j = 0; j < s->n_found; j++) {
        const track_detection *d = &f->found[s->found[j]];
        const bool unsure = track_appearance(o) && (double)d->score < o->look_conf;

        cost[j] = t->cls == d->cls ? overlap_cost(t, d->box) : NO_PAIR;
        if (unsure && cost[j] > o->unsure_iou)
            cost[j] = NO_PAIR;
        if (cost[j] <= s->limit && f->unit[s->found[j]] && t->look.n)
            s->passed[n++] = j;
    }
    if (n)
        compare_looks(f, s, t, n);
    for (int k = 0; k < n; k++)
        if (s->distance[k] > o->overlap_cosine)
            cost[s->passed[k]] = NO_PAIR;
}

/* Whether overlap alone might take one for the other */
static bool meets(const tracker_options *o, const track *t, const track_detection *d)
{
    return t->cls == d->cls && overlap_cost(t, d->box) <= o->max_iou;
}

const track *track_alone(const tracker_options *o, const track *tracks, int n, const track_detection *found,
                         int n_found, int j)
{
    const track *own = NULL;

    for (int i = 0; i < n; i++)
        if (meets(o, &tracks[i], &found[j])) {
            if (own)
                return NULL;
            own = &tracks[i];
        }
    if (!own || !own->confirmed || own->age > 0 || overlap_cost(own, found[j].box) > SAME_PLACE)
        return NULL;
    for (int k = 0; k < n_found; k++)
        if (k != j && meets(o, own, &found[k]))
            return NULL;
    return own;
}

/* ---- steps ----------------------------------------------------------------------------------------------- */

static lt_status run(track_frame *f, const step *s)
{
    double *cost;
    int *column;
    lt_status st;

    if (!s->n_tracks || !s->n_found)
        return LT_OK;
    cost = lt_arena_array(f->scratch, (size_t)s->n_tracks * (size_t)s->n_found, sizeof(*cost));
    column = lt_arena_array(f->scratch, (size_t)s->n_tracks, sizeof(*column));
    if (!cost || !column)
        return lt_error(LT_ENOMEM, "no memory to match %d detections to %d tracks", s->n_found, s->n_tracks);
    for (int i = 0; i < s->n_tracks; i++) {
        double *row = cost + i * s->n_found;

        s->costs(f, s, &f->tracks[s->track[i]], row);
        for (int j = 0; j < s->n_found; j++)
            row[j] = row[j] <= s->limit ? row[j] : s->limit + 1e-5;
    }
    st = assignment_solve(f->scratch, cost, s->n_tracks, s->n_found, column);
    for (int i = 0; !st && i < s->n_tracks; i++)
        if (column[i] >= 0 && cost[i * s->n_found + column[i]] <= s->limit) {
            f->found_of[s->track[i]] = s->found[column[i]];
            f->track_of[s->found[column[i]]] = s->track[i];
        }
    return st;
}

/* Detections that are left, of scores from lo to below hi */
static void pick_found(const track_frame *f, double lo, double hi, step *s)
{
    s->n_found = 0;
    for (int j = 0; j < f->n_found; j++) {
        const double score = (double)f->found[j].score;

        if (f->track_of[j] < 0 && score >= lo && score < hi && track_usable(&f->found[j]))
            s->found[s->n_found++] = j;
    }
}

/* A long-hidden track has a wide gate, and would take the detections of those seen lately: these choose first. */
static lt_status cascade(track_frame *f, step *s)
{
    const tracker_options *o = f->options;
    lt_status st = LT_OK;

    s->limit = o->max_cosine;
    s->costs = appearance_costs;
    for (int age = 1; !st && age <= o->max_age; age++) {
        s->n_tracks = 0;
        for (int i = 0; i < f->n_tracks; i++)
            if (f->tracks[i].confirmed && f->tracks[i].age == age)
                s->track[s->n_tracks++] = i;
        if (!s->n_tracks)
            continue;
        pick_found(f, o->min_conf, INFINITY, s);
        st = run(f, s);
    }
    return st;
}

/* Tracks that are left and were seen in the last frame; `all`: those hidden for longer too; `confirmed`: these alone */
static void pick_tracks(const track_frame *f, bool all, bool confirmed, step *s)
{
    s->n_tracks = 0;
    for (int i = 0; i < f->n_tracks; i++) {
        const track *t = &f->tracks[i];

        if (f->found_of[i] < 0 && (all ? t->age <= f->options->max_age : t->age == f->elapsed)
            && (t->confirmed || !confirmed))
            s->track[s->n_tracks++] = i;
    }
}

/* Where looks have no say, what is hidden for longer is left to its looks. */
static lt_status by_overlap(track_frame *f, step *s)
{
    s->limit = f->options->max_iou;
    s->costs = overlap_costs;
    pick_tracks(f, !track_appearance(f->options) || f->options->overlap_cosine < COSINE_MOST, false, s);
    pick_found(f, f->options->min_conf, INFINITY, s);
    return run(f, s);
}

static lt_status by_low_scores(track_frame *f, step *s)
{
    s->limit = LOW_IOU;
    s->costs = overlap_costs;
    pick_tracks(f, false, true, s);
    pick_found(f, f->options->low_conf, f->options->min_conf, s);
    return run(f, s);
}

lt_status track_match(track_frame *f)
{
    step s = { .track = lt_arena_array(f->scratch, (size_t)f->n_tracks + 1, sizeof(int)),
               .found = lt_arena_array(f->scratch, (size_t)f->n_found + 1, sizeof(int)) };
    lt_status st = s.track && s.found ? LT_OK : lt_error(LT_ENOMEM, "no memory to match detections to tracks");

    if (!st && track_appearance(f->options))
        st = make_room(f, &s);
    if (!st && track_appearance(f->options))
        st = cascade(f, &s);
    if (!st)
        st = by_overlap(f, &s);
    if (!st && f->options->method == TRACK_BYTE)
        st = by_low_scores(f, &s);
    return st;
}
