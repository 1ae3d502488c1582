/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/metrics/track.h"

#include "libtensor/base/arena.h"
#include "vision/assignment.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double CLEAR_IOU = 0.5;
static const double CONTINUES = 1000;           /* what CLEAR gives a pair of the frame before, above any IoU */
static const int64_t MOST_PAIRS = 1 << 26;

/* ---- identities by number ---- */

typedef struct {
    int64_t *id;                    /* (n) ascending */
    int64_t *frames;                /* (n) in which it is */
    int64_t *last;                  /* (n) the scene that it was last in */
    int64_t n, boxes;
} identities;

static int by_id(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;

    return x < y ? -1 : x > y;
}

static int number_of(const identities *all, int64_t id)
{
    const int64_t *at = bsearch(&id, all->id, (size_t)all->n, sizeof(id), by_id);

    return (int)(at - all->id);
}

static lt_status find_identities(lt_arena *arena, const track_scored_frame *frame, int64_t n, bool truth,
                                 identities *out)
{
    int64_t k = 0;

    *out = (identities){ 0 };
    for (int64_t f = 0; f < n; f++)
        out->boxes += truth ? frame[f].n_truth : frame[f].n_found;
    out->id = lt_arena_array(arena, (size_t)out->boxes + 1, sizeof(*out->id));
    out->frames = lt_arena_array(arena, (size_t)out->boxes + 1, sizeof(*out->frames));
    out->last = lt_arena_array(arena, (size_t)out->boxes + 1, sizeof(*out->last));
    if (!out->id || !out->frames || !out->last)
        return lt_error(LT_ENOMEM, "no memory to score %lld boxes", (long long)out->boxes);
    for (int64_t f = 0; f < n; f++) {
        const track_scored *b = truth ? frame[f].truth : frame[f].found;
        const int m = truth ? frame[f].n_truth : frame[f].n_found;

        for (int i = 0; i < m; i++)
            out->id[k++] = b[i].id;
    }
    qsort(out->id, (size_t)k, sizeof(*out->id), by_id);
    for (int64_t i = 0; i < k; i++)
        if (out->n == 0 || out->id[out->n - 1] != out->id[i])
            out->id[out->n++] = out->id[i];
    return LT_OK;
}

/* ---- one sequence ---- */

/* A pair that HOTA makes in a frame; at which thresholds it counts, its IoU says */
typedef struct { int truth, found; double iou; } pair;

typedef struct {
    const track_scored_frame *frame;
    int64_t n, scenes;
    lt_arena *arena, *scratch;      /* of the sequence, of a frame */
    identities truth, found;
    double *alignment;              /* (truth.n, found.n) of identities over the whole sequence */
    double *shared;                 /* (truth.n, found.n) frames, of what is counted just now */
    pair *pairs;
    int64_t n_pairs;
} sequence;

/* One frame: identities by number, and the IoU of all its pairs */
typedef struct {
    int n_truth, n_found;
    int *truth, *found, *column;
    double *iou, *cost;
} scene;

static double area(const double b[4])
{
    return (b[2] - b[0]) * (b[3] - b[1]);
}

double track_iou(const double a[4], const double b[4])
{
    const double w = fmin(a[2], b[2]) - fmax(a[0], b[0]), h = fmin(a[3], b[3]) - fmax(a[1], b[1]);
    const double both = w > 0 && h > 0 ? w * h : 0;

    return both > 0 && area(a) > DBL_EPSILON && area(b) > DBL_EPSILON ? both / (area(a) + area(b) - both) : 0;
}

static lt_status number_boxes(const sequence *s, identities *all, const track_scored *b, int n, int64_t f, int *number)
{
    for (int i = 0; i < n; i++) {
        number[i] = number_of(all, b[i].id);
        for (int c = 0; c < 4; c++)
            if (!isfinite(b[i].box[c]))
                return lt_error(LT_EINVAL, "frame %lld: the box of identity %lld is not finite", (long long)f + 1,
                                (long long)b[i].id);
        if (all->last[number[i]] == s->scenes)
            return lt_error(LT_EINVAL, "frame %lld: identity %lld is there twice, expected once", (long long)f + 1,
                            (long long)b[i].id);
        all->last[number[i]] = s->scenes;
    }
    return LT_OK;
}

/* v lives until the next one */
static lt_status open_scene(sequence *s, int64_t f, scene *v)
{
    const track_scored_frame *of = &s->frame[f];
    const size_t pairs = (size_t)of->n_truth * (size_t)of->n_found;
    lt_status st;

    lt_arena_reset(s->scratch);
    s->scenes++;
    *v = (scene){
        .n_truth = of->n_truth, .n_found = of->n_found,
        .truth = lt_arena_array(s->scratch, (size_t)of->n_truth + 1, sizeof(int)),
        .found = lt_arena_array(s->scratch, (size_t)of->n_found + 1, sizeof(int)),
        .column = lt_arena_array(s->scratch, (size_t)of->n_truth + 1, sizeof(int)),
        .iou = lt_arena_array(s->scratch, pairs + 1, sizeof(double)),
        .cost = lt_arena_array(s->scratch, pairs + 1, sizeof(double)),
    };
    if (!v->truth || !v->found || !v->column || !v->iou || !v->cost)
        return lt_error(LT_ENOMEM, "no memory to score a frame of %d and %d boxes", of->n_truth, of->n_found);
    st = number_boxes(s, &s->truth, of->truth, of->n_truth, f, v->truth);
    if (!st)
        st = number_boxes(s, &s->found, of->found, of->n_found, f, v->found);
    for (int i = 0; !st && i < of->n_truth; i++)
        for (int j = 0; j < of->n_found; j++)
            v->iou[i * of->n_found + j] = track_iou(of->truth[i].box, of->found[j].box);
    return st;
}

static int64_t cell(const sequence *s, const scene *v, int i, int j)
{
    return v->truth[i] * s->found.n + v->found[j];
}

static int64_t cells(const sequence *s)
{
    return s->truth.n * s->found.n;
}

/* ---- HOTA ---- */

static double alpha(int a)
{
    return 0.05 + a * 0.05;
}

/* How far two identities could be one: the frames they may share over those that either is in. A box that several
 * overlap is shared by them. */
static lt_status align(sequence *s)
{
    lt_status st = LT_OK;
    scene v;

    for (int64_t f = 0; !st && f < s->n; f++) {
        st = open_scene(s, f, &v);
        for (int i = 0; !st && i < v.n_truth; i++) {
            s->truth.frames[v.truth[i]]++;
            for (int j = 0; j < v.n_found; j++) {
                const double *iou = v.iou + i * v.n_found;
                double all = -iou[j];

                for (int k = 0; k < v.n_found; k++)
                    all += iou[k];
                for (int k = 0; k < v.n_truth; k++)
                    all += v.iou[k * v.n_found + j];
                if (all > DBL_EPSILON)
                    s->alignment[cell(s, &v, i, j)] += iou[j] / all;
            }
        }
        for (int j = 0; !st && j < v.n_found; j++)
            s->found.frames[v.found[j]]++;
    }
    for (int64_t k = 0; !st && k < cells(s); k++) {
        const int64_t frames = s->truth.frames[k / s->found.n] + s->found.frames[k % s->found.n];

        s->alignment[k] /= (double)frames - s->alignment[k];
    }
    return st;
}

/* One assignment of a frame, which serves all thresholds */
static lt_status pair_up(sequence *s, scene *v)
{
    lt_status st;

    for (int i = 0; i < v->n_truth; i++)
        for (int j = 0; j < v->n_found; j++)
            v->cost[i * v->n_found + j] = -s->alignment[cell(s, v, i, j)] * v->iou[i * v->n_found + j];
    st = assignment_solve(s->scratch, v->cost, v->n_truth, v->n_found, v->column);
    for (int i = 0; !st && i < v->n_truth; i++)
        if (v->column[i] >= 0)
            s->pairs[s->n_pairs++] = (pair){ v->truth[i], v->found[v->column[i]],
                                             v->iou[i * v->n_found + v->column[i]] };
    return st;
}

static void count_associations(sequence *s, int a, track_counts *out)
{
    double tp = 0;

    memset(s->shared, 0, (size_t)cells(s) * sizeof(*s->shared));
    for (int64_t k = 0; k < s->n_pairs; k++)
        if (s->pairs[k].iou >= alpha(a) - DBL_EPSILON) {
            s->shared[s->pairs[k].truth * s->found.n + s->pairs[k].found]++;
            tp++;
        }
    for (int64_t k = 0; k < cells(s); k++) {
        const int64_t frames = s->truth.frames[k / s->found.n] + s->found.frames[k % s->found.n];

        out->associated[a] += s->shared[k] * s->shared[k] / fmax(1, (double)frames - s->shared[k]);
    }
    out->tp[a] = tp;
    out->fn[a] = (double)s->truth.boxes - tp;
    out->fp[a] = (double)s->found.boxes - tp;
}

static lt_status count_hota(sequence *s, track_counts *out)
{
    lt_status st = align(s);
    scene v;

    for (int64_t f = 0; !st && f < s->n; f++) {
        st = open_scene(s, f, &v);
        if (!st)
            st = pair_up(s, &v);
    }
    for (int a = 0; !st && a < TRACK_ALPHAS; a++)
        count_associations(s, a, out);
    return st;
}

/* ---- CLEAR ---- */

/* Whom each identity of the truth was last taken for, ever and in the last frame that had boxes on both sides; who had
 * each found one last, and how he looks; -1 */
typedef struct {
    int *ever, *before, *owner;
    int64_t *look;
} history;

static bool is_taken(const history *h, int found, int truth, int64_t look)
{
    return h->owner[found] >= 0 && h->owner[found] != truth && h->look[found] != look;
}

static lt_status match_clear(sequence *s, const track_scored *truth, scene *v, history *h, track_counts *out)
{
    int matched = 0;
    lt_status st;

    for (int i = 0; i < v->n_truth; i++)
        for (int j = 0; j < v->n_found; j++) {
            const double iou = v->iou[i * v->n_found + j];
            const double more = h->before[v->truth[i]] == v->found[j] ? CONTINUES : 0;

            v->cost[i * v->n_found + j] = iou < CLEAR_IOU - DBL_EPSILON ? 0 : -(more + iou);
        }
    st = assignment_solve(s->scratch, v->cost, v->n_truth, v->n_found, v->column);
    if (st)
        return st;
    for (int64_t k = 0; k < s->truth.n; k++)
        h->before[k] = -1;
    for (int i = 0; i < v->n_truth; i++) {
        const int j = v->column[i], of = v->truth[i];

        if (j < 0 || v->cost[i * v->n_found + j] >= -DBL_EPSILON)
            continue;
        out->switches += h->ever[of] >= 0 && h->ever[of] != v->found[j];
        out->taken += is_taken(h, v->found[j], of, truth[i].look);
        h->ever[of] = h->before[of] = v->found[j];
        h->owner[v->found[j]] = of;
        h->look[v->found[j]] = truth[i].look;
        matched++;
    }
    out->clear_tp += matched;
    return LT_OK;
}

static lt_status count_clear(sequence *s, track_counts *out)
{
    history h = { lt_arena_array(s->arena, (size_t)s->truth.n + 1, sizeof(int)),
                  lt_arena_array(s->arena, (size_t)s->truth.n + 1, sizeof(int)),
                  lt_arena_array(s->arena, (size_t)s->found.n + 1, sizeof(int)),
                  lt_arena_array(s->arena, (size_t)s->found.n + 1, sizeof(int64_t)) };
    lt_status st = h.ever && h.before && h.owner && h.look ? LT_OK
                                                           : lt_error(LT_ENOMEM, "no memory to score switches");
    scene v;

    for (int64_t k = 0; !st && k < s->truth.n; k++)
        h.ever[k] = h.before[k] = -1;
    for (int64_t k = 0; !st && k < s->found.n; k++)
        h.owner[k] = -1;
    for (int64_t f = 0; !st && f < s->n; f++) {
        st = open_scene(s, f, &v);
        if (!st && v.n_truth && v.n_found)      /* a frame with nothing on one side is no history */
            st = match_clear(s, s->frame[f].truth, &v, &h, out);
    }
    out->clear_fn = (double)s->truth.boxes - out->clear_tp;
    out->clear_fp = (double)s->found.boxes - out->clear_tp;
    return st;
}

/* ---- identities ---- */

/* Who is whom for the whole sequence, so that most frames are right */
static lt_status count_identities(sequence *s, track_counts *out)
{
    int *column = lt_arena_array(s->arena, (size_t)s->truth.n + 1, sizeof(*column));
    lt_status st = column ? LT_OK : lt_error(LT_ENOMEM, "no memory to score identities");
    scene v;

    memset(s->shared, 0, (size_t)cells(s) * sizeof(*s->shared));
    for (int64_t f = 0; !st && f < s->n; f++) {
        st = open_scene(s, f, &v);
        for (int i = 0; !st && i < v.n_truth; i++)
            for (int j = 0; j < v.n_found; j++)
                s->shared[cell(s, &v, i, j)] -= v.iou[i * v.n_found + j] >= CLEAR_IOU;
    }
    if (!st)
        st = assignment_solve(s->arena, s->shared, (int)s->truth.n, (int)s->found.n, column);
    for (int64_t i = 0; !st && i < s->truth.n; i++)
        out->id_tp -= column[i] >= 0 ? s->shared[i * s->found.n + column[i]] : 0;
    out->id_fn = (double)s->truth.boxes - out->id_tp;
    out->id_fp = (double)s->found.boxes - out->id_tp;
    return st;
}

/* ---- all of it ---- */

static lt_status open_sequence(sequence *s)
{
    lt_status st = s->arena && s->scratch ? LT_OK : lt_error(LT_ENOMEM, "no memory to score a sequence");

    if (!st)
        st = find_identities(s->arena, s->frame, s->n, true, &s->truth);
    if (!st)
        st = find_identities(s->arena, s->frame, s->n, false, &s->found);
    if (st)
        return st;
    if (s->found.n && s->truth.n > MOST_PAIRS / s->found.n)
        return lt_error(LT_EINVAL, "%lld identities of the truth and %lld found ones, expected at most %lld pairs",
                        (long long)s->truth.n, (long long)s->found.n, (long long)MOST_PAIRS);
    s->alignment = lt_arena_array(s->arena, (size_t)cells(s) + 1, sizeof(*s->alignment));
    s->shared = lt_arena_array(s->arena, (size_t)cells(s) + 1, sizeof(*s->shared));
    s->pairs = lt_arena_array(s->arena, (size_t)lt_min_i64(s->truth.boxes, s->found.boxes) + 1, sizeof(*s->pairs));
    return s->alignment && s->shared && s->pairs ? LT_OK : lt_error(LT_ENOMEM, "no memory to score a sequence");
}

lt_status track_count(const track_scored_frame *frame, int64_t n, track_counts *out)
{
    sequence s = { .frame = frame, .n = n, .arena = lt_arena_new(), .scratch = lt_arena_new() };
    lt_status st = open_sequence(&s);

    *out = (track_counts){ 0 };
    if (!st)
        st = count_hota(&s, out);
    if (!st)
        st = count_clear(&s, out);
    if (!st)
        st = count_identities(&s, out);
    lt_arena_free(s.scratch);
    lt_arena_free(s.arena);
    return st;
}

void track_counts_add(track_counts *sum, const track_counts *more)
{
    double *a = (double *)sum;
    const double *b = (const double *)more;

    for (int k = 0; k < TRACK_COUNTS; k++)
        a[k] += b[k];
}

track_scores track_scores_of(const track_counts *c)
{
    track_scores s = { .switches = c->switches, .taken = c->taken };

    for (int a = 0; a < TRACK_ALPHAS; a++) {
        const double deta = c->tp[a] / fmax(1, c->tp[a] + c->fn[a] + c->fp[a]);
        const double assa = c->associated[a] / fmax(1, c->tp[a]);

        s.deta += deta / TRACK_ALPHAS;
        s.assa += assa / TRACK_ALPHAS;
        s.hota += sqrt(deta * assa) / TRACK_ALPHAS;
    }
    s.mota = (c->clear_tp - c->clear_fp - c->switches) / fmax(1, c->clear_tp + c->clear_fn);
    s.idf1 = c->id_tp / fmax(1, c->id_tp + (c->id_fp + c->id_fn) / 2);
    return s;
}
