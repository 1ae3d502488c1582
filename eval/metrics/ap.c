/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/metrics/ap.h"

#include "libtensor/base/arena.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One thing found: at which thresholds it is right, and at which it does not count */
typedef struct {
    double score;
    int64_t order;
    unsigned hit, ignored;          /* bit t: threshold t */
} entry;

typedef struct {
    lt_arena *memory;               /* of a class */
    entry *list;
    size_t n, room;
    int64_t objects;                /* that count */
} tally;

/* Both as NumPy's linspace rounds them */
static double threshold(int t)
{
    return t == AP_THRESHOLDS - 1 ? 0.95 : 0.5 + t * ((0.95 - 0.5) / (AP_THRESHOLDS - 1));
}

static double recall_at(int k)
{
    return k == AP_RECALLS - 1 ? 1 : k * 0.01;
}

/* ---- one class in one image ---- */

typedef struct {
    const ap_image *image;
    ap_range area;
    int found[AP_MOST], n_found;    /* the surest first */
    int *truth, n_truth;            /* those that count, then those that do not */
    int n_counted;
} scene;

static bool outside(double area, ap_range r)
{
    return area < r.lo || area > r.hi;
}

static bool ignored_truth(const scene *s, int k)
{
    return k >= s->n_counted;
}

static void pick_found(scene *s, int cls)
{
    for (int i = 0; i < s->image->n_found; i++) {
        const ap_found *f = &s->image->found[i];
        int at = s->n_found;

        if (f->cls != cls)
            continue;
        while (at > 0 && f->score > s->image->found[s->found[at - 1]].score)
            at--;
        if (at == AP_MOST)
            continue;
        s->n_found += s->n_found < AP_MOST;
        memmove(s->found + at + 1, s->found + at, (size_t)(s->n_found - 1 - at) * sizeof(*s->found));
        s->found[at] = i;
    }
}

static bool pick_truth(scene *s, int cls, lt_arena *scratch)
{
    s->truth = lt_arena_array(scratch, (size_t)s->image->n_truth + 1, sizeof(*s->truth));
    if (!s->truth)
        return false;
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < s->image->n_truth; i++) {
            const ap_truth *t = &s->image->truth[i];

            if (t->cls == cls && (t->crowd || outside(t->area, s->area)) == (pass == 1))
                s->truth[s->n_truth++] = i;
        }
        if (pass == 0)
            s->n_counted = s->n_truth;
    }
    return true;
}

/* The free object that overlaps most, from the threshold on; one that counts is preferred. -1: none */
static int match(const scene *s, int found, double least, const bool *taken)
{
    double best = fmin(least, 1 - 1e-10);
    int at = -1;

    for (int k = 0; k < s->n_truth; k++) {
        const int i = s->truth[k];
        const double iou = (double)s->image->iou[(int64_t)found * s->image->n_truth + i];

        if (taken[k] && !s->image->truth[i].crowd)
            continue;
        if (at >= 0 && !ignored_truth(s, at) && ignored_truth(s, k))
            break;
        if (iou < best)
            continue;
        best = iou;
        at = k;
    }
    return at;
}

/* What was found and where it belongs, at one threshold */
static void match_all(const scene *s, int t, entry *e, bool *taken)
{
    memset(taken, 0, (size_t)s->n_truth * sizeof(*taken));
    for (int i = 0; i < s->n_found; i++) {
        const int k = match(s, s->found[i], threshold(t), taken);

        if (k < 0) {
            e[i].ignored |= (unsigned)outside(s->image->found[s->found[i]].area, s->area) << t;
            continue;
        }
        taken[k] = true;
        e[i].hit |= 1u << t;
        e[i].ignored |= (unsigned)ignored_truth(s, k) << t;
    }
}

static bool add_scene(tally *to, const scene *s, lt_arena *scratch)
{
    bool *taken = lt_arena_array(scratch, (size_t)s->n_truth + 1, sizeof(*taken));
    entry e[AP_MOST] = { { 0 } };

    if (!taken)
        return false;
    for (int t = 0; t < AP_THRESHOLDS; t++)
        match_all(s, t, e, taken);
    for (int i = 0; i < s->n_found; i++) {
        to->list = lt_arena_grow(to->memory, to->list, to->n, &to->room, sizeof(*to->list));
        if (!to->list)
            return false;
        e[i].score = s->image->found[s->found[i]].score;
        e[i].order = (int64_t)to->n;
        to->list[to->n++] = e[i];
    }
    to->objects += s->n_counted;
    return true;
}

/* ---- one class ---- */

enum { CURVES = AP_THRESHOLDS * AP_RECALLS };

static int surest_first(const void *a, const void *b)
{
    const entry *x = a, *y = b;

    if (x->score != y->score)
        return x->score > y->score ? -1 : 1;
    return x->order < y->order ? -1 : x->order > y->order;
}

/* The best precision at each recall and beyond */
static void draw_curve(const tally *of, int t, double *precision, double *recall, double *out)
{
    double hits = 0, misses = 0;
    size_t n = 0, at = 0;

    for (size_t i = 0; i < of->n; i++) {
        if (of->list[i].ignored >> t & 1)
            continue;
        hits += of->list[i].hit >> t & 1;
        misses += !(of->list[i].hit >> t & 1);
        recall[n] = hits / (double)of->objects;
        precision[n++] = hits / (hits + misses);
    }
    for (size_t i = n; i-- > 1; )
        precision[i - 1] = fmax(precision[i - 1], precision[i]);
    for (int k = 0; k < AP_RECALLS; k++) {
        while (at < n && recall[at] < recall_at(k))
            at++;
        out[k] = at < n ? precision[at] : 0;
    }
}

static bool measure_class(const ap_image *image, int64_t n, int cls, ap_range area, tally *to, double *out)
{
    lt_arena *scratch = lt_arena_new();
    bool ok = scratch != NULL;
    double *room;

    for (int64_t i = 0; i < n && ok; i++) {
        scene s = { .image = &image[i], .area = area };

        lt_arena_reset(scratch);
        pick_found(&s, cls);
        ok = pick_truth(&s, cls, scratch) && add_scene(to, &s, scratch);
    }
    lt_arena_free(scratch);
    room = ok ? lt_arena_array(to->memory, 2 * to->n + 1, sizeof(*room)) : NULL;
    if (!room)
        return false;
    if (to->n)
        qsort(to->list, to->n, sizeof(*to->list), surest_first);
    for (int t = 0; t < AP_THRESHOLDS && to->objects; t++)
        draw_curve(to, t, room, room + to->n, out + t * AP_RECALLS);
    for (int k = 0; k < CURVES && !to->objects; k++)
        out[k] = NAN;
    return true;
}

static lt_status curves_of(const ap_image *image, int64_t n, int cls, ap_range area, double out[CURVES])
{
    tally t = { .memory = lt_arena_new() };
    const bool ok = t.memory && measure_class(image, n, cls, area, &t, out);

    lt_arena_free(t.memory);
    return ok ? LT_OK : lt_error(LT_ENOMEM, "no memory to measure the average precision");
}

lt_status ap_curves(const ap_image *image, int64_t n, int classes, ap_range area, double *out)
{
    lt_status st = LT_OK;

    for (int c = 0; c < classes && !st; c++)
        st = curves_of(image, n, c, area, out + (int64_t)c * CURVES);
    return st;
}

lt_status ap_measure(const ap_image *image, int64_t n, int classes, ap_range area, double *out)
{
    double curve[CURVES];
    lt_status st = LT_OK;

    for (int c = 0; c < classes && !st; c++) {
        st = curves_of(image, n, c, area, curve);
        for (int t = 0; t < AP_THRESHOLDS && !st; t++) {
            double sum = 0;

            for (int k = 0; k < AP_RECALLS; k++)
                sum += curve[t * AP_RECALLS + k];
            out[c * AP_THRESHOLDS + t] = sum / AP_RECALLS;
        }
    }
    return st;
}

double ap_mean(const double *ap, int first, int end, int thresholds)
{
    double sum = 0;
    int n = 0;

    for (int c = first; c < end; c++)
        for (int t = 0; t < thresholds; t++)
            if (!isnan(ap[c * AP_THRESHOLDS + t])) {
                sum += ap[c * AP_THRESHOLDS + t];
                n++;
            }
    return n ? sum / n : NAN;
}
