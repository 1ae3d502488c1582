/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/detection/detection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const detection_rules detection_rules_shown = { .score = 0.25, .iou = 0.7, .most = 300 };
const detection_rules detection_rules_scored = { .score = 0.001, .iou = 0.7, .most = 100, .every_class = true };

/* A class of a cell that is sure enough */
typedef struct {
    float logit;
    int level, cls;
    int64_t at;
} candidate;

typedef struct {
    lt_arena *arena;
    candidate *list;
    size_t n, room;
} candidates;

static int64_t plane_of(const detection_maps *m, int level)
{
    const int64_t side = m->size / (8 << level);

    return side * side;
}

static bool add(candidates *to, const candidate *c)
{
    to->list = lt_arena_grow(to->arena, to->list, to->n, &to->room, sizeof(*to->list));
    if (!to->list)
        return false;
    to->list[to->n++] = *c;
    return true;
}

static bool every_class(const detection_maps *m, int level, float least, candidates *to)
{
    const int64_t plane = plane_of(m, level);

    for (int c = 0; c < m->classes; c++)
        for (int64_t i = 0; i < plane; i++) {
            const float x = m->cls[level][c * plane + i];

            if (x > least && !add(to, &(candidate){ x, level, c, i }))
                return false;
        }
    return true;
}

enum { RUN = 256 };

/* A run of cells at a time, class by class, as classes are planes */
static bool surest_class(const detection_maps *m, int level, float least, candidates *to)
{
    const int64_t plane = plane_of(m, level);

    for (int64_t at = 0; at < plane; at += RUN) {
        const int n = (int)(plane - at < RUN ? plane - at : RUN);
        float best[RUN];
        int cls[RUN] = { 0 };

        memcpy(best, m->cls[level] + at, (size_t)n * sizeof(*best));
        for (int c = 1; c < m->classes; c++) {
            const float *x = m->cls[level] + c * plane + at;

            for (int i = 0; i < n; i++) {
                cls[i] = x[i] > best[i] ? c : cls[i];
                best[i] = x[i] > best[i] ? x[i] : best[i];
            }
        }
        for (int i = 0; i < n; i++)
            if (best[i] > least && !add(to, &(candidate){ best[i], level, cls[i], at + i }))
                return false;
    }
    return true;
}

/* Ties go by level, cell and class, so that the order is one. */
static int surest_first(const void *a, const void *b)
{
    const candidate *x = a, *y = b;

    if (x->logit != y->logit)
        return x->logit > y->logit ? -1 : 1;
    if (x->level != y->level)
        return x->level - y->level;
    if (x->at != y->at)
        return x->at < y->at ? -1 : 1;
    return x->cls - y->cls;
}

/* The mean bin of a side */
static double distance(const float *bin, int64_t plane)
{
    float top = bin[0];
    double sum = 0, mean = 0;

    for (int k = 1; k < DETECTION_BINS; k++)
        top = fmaxf(top, bin[k * plane]);
    for (int k = 0; k < DETECTION_BINS; k++) {
        const double q = (double)expf(bin[k * plane] - top);

        sum += q;
        mean += k * q;
    }
    return mean / sum;
}

static void decode(const detection_maps *m, const candidate *c, detection *out)
{
    const int64_t plane = plane_of(m, c->level), side = m->size / (8 << c->level);
    const double stride = 8 << c->level, centre[2] = { (double)(c->at % side) + 0.5, (double)(c->at / side) + 0.5 };

    out->cls = c->cls;
    out->score = 1 / (1 + expf(-c->logit));
    for (int s = 0; s < DETECTION_SIDES; s++) {
        const double d = distance(m->box[c->level] + s * DETECTION_BINS * plane + c->at, plane);

        out->box[s] = (float)(stride * (centre[s % 2] + (s < 2 ? -d : d)));
    }
    for (int k = 0; k < DETECTION_COEFFICIENTS; k++)
        out->coefficient[k] = m->mask[c->level][k * plane + c->at];
}

static double area(const float b[4])
{
    return (double)(b[2] - b[0]) * (double)(b[3] - b[1]);
}

static double iou(const float a[4], const float b[4])
{
    const double w = (double)fminf(a[2], b[2]) - (double)fmaxf(a[0], b[0]);
    const double h = (double)fminf(a[3], b[3]) - (double)fmaxf(a[1], b[1]);
    const double both = w > 0 && h > 0 ? w * h : 0;

    return both > 0 ? both / (area(a) + area(b) - both) : 0;
}

/* What is kept, class by class */
typedef struct {
    detection *found;
    int n;
    int *last, *before;             /* (classes) the class's last one, from 1; of each the one before it; 0: none */
    int *count;                     /* (classes) */
} keeper;

static bool keeper_init(lt_arena *arena, int most, int classes, keeper *k)
{
    k->found = lt_arena_array(arena, (size_t)most + 1, sizeof(*k->found));
    k->before = lt_arena_array(arena, (size_t)most + 1, sizeof(*k->before));
    k->last = lt_arena_array(arena, (size_t)classes, sizeof(*k->last));
    k->count = lt_arena_array(arena, (size_t)classes, sizeof(*k->count));
    return k->found && k->before && k->last && k->count;
}

/* Keep found[n], unless one of its class that is surer lies there. */
static void keep(keeper *k, double most_iou)
{
    const detection *d = &k->found[k->n];

    for (int i = k->last[d->cls]; i; i = k->before[i - 1])
        if (iou(k->found[i - 1].box, d->box) > most_iou)
            return;
    k->before[k->n] = k->last[d->cls];
    k->last[d->cls] = ++k->n;
    k->count[d->cls]++;
}

lt_status detection_find(lt_arena *arena, const detection_maps *m, const detection_rules *rules, detection **out,
                         int *n)
{
    const float least = (float)log(rules->score / (1 - rules->score));
    const int most = rules->every_class ? rules->most * m->classes : rules->most;
    candidates c = { .arena = arena };
    keeper k = { .n = 0 };
    bool ok = true;

    for (int level = 0; level < DETECTION_LEVELS && ok; level++)
        ok = (rules->every_class ? every_class : surest_class)(m, level, least, &c);
    if (!ok || !keeper_init(arena, most, m->classes, &k))
        return lt_error(LT_ENOMEM, "no memory for what a detector found");
    if (c.n)
        qsort(c.list, c.n, sizeof(*c.list), surest_first);
    for (size_t i = 0; i < c.n && k.n < most; i++) {
        if (rules->every_class && k.count[c.list[i].cls] == rules->most)
            continue;
        decode(m, &c.list[i], &k.found[k.n]);
        keep(&k, rules->iou);
    }
    *out = k.found;
    *n = k.n;
    return LT_OK;
}
