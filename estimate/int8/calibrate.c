/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/int8/calibrate.h"

#include "libtensor/base/arena.h"

#include <math.h>
#include <string.h>

/* ---- how large numbers are ----------------------------------------------------------------------------- */

enum {
    BINS = 2048,
    LEAST_BINS = 64,                /* of the largest number's: nothing is cut off below a 32nd of it */
    LOOKED_AT = 1 << 16,            /* numbers of an input that are counted; the largest is always seen */
};

typedef struct seen_layer {
    struct seen_layer *next;
    const char *name;
    double limit, largest;          /* |x|; bins reach to limit */
    bool has_negative;
    double count[BINS];             /* of numbers that are not 0, which no scale rounds */
    double signal, noise;
} seen_layer;

typedef struct {
    lt_arena *arena;
    seen_layer *first, **end;
    int n;
    bool no_memory;
} seen_layers;

static seen_layer *seen_find(seen_layers *s, const char *name)
{
    seen_layer *l = s->first;

    while (l && strcmp(l->name, name) != 0)
        l = l->next;
    return l;
}

static seen_layer *seen_add(seen_layers *s, const char *name)
{
    seen_layer *l = lt_arena_alloc(s->arena, sizeof(*l));

    if (!l || !(l->name = lt_arena_strdup(s->arena, name))) {
        s->no_memory = true;
        return NULL;
    }
    *s->end = l;
    s->end = &l->next;
    s->n++;
    return l;
}

/* Twice the limit, half the bins */
static void widen(seen_layer *l)
{
    for (int i = 0; i < BINS; i++)
        l->count[i] = i < BINS / 2 ? l->count[2 * i] + l->count[2 * i + 1] : 0;
    l->limit *= 2;
}

static void count(seen_layer *l, double size)
{
    const int bin = (int)(size / l->limit * BINS);

    if (size > 0)
        l->count[bin < BINS ? bin : BINS - 1]++;
}

/* NaN and infinities are passed over: a model that makes them has no use for a range. */
static void see_input(void *ctx, const char *name, const lt_real *x, int64_t n)
{
    seen_layer *l = seen_find(ctx, name);
    const int64_t step = n / LOOKED_AT + 1;
    double least = 0, most = 0;

    l = l ? l : seen_add(ctx, name);
    for (int64_t i = 0; l && i < n; i++) {
        least = x[i] < least && isfinite(x[i]) ? x[i] : least;
        most = x[i] > most && isfinite(x[i]) ? x[i] : most;
    }
    if (!l || (least == 0 && most == 0))
        return;
    l->has_negative |= least < 0;
    l->largest = fmax(l->largest, fmax(most, -least));
    l->limit = l->limit > 0 ? l->limit : l->largest;
    while (l->limit < l->largest)
        widen(l);
    for (int64_t i = 0; i < n; i += step)
        if (isfinite(x[i]))
            count(l, fabs((double)x[i]));
}

/* ---- the scale of least error ------------------------------------------------------------------------------ */

/* The squared error when sizes above `top` are cut off there: rounding leaves a twelfth of a step's square. */
static double loss_at(const seen_layer *l, double top, double levels)
{
    const double step = top / levels;
    double loss = 0;

    for (int i = 0; i < BINS; i++) {
        const double size = (i + 0.5) / BINS * l->limit, over = size - top;

        loss += l->count[i] * (over > 0 ? over * over : step * step / 12);
    }
    return loss;
}

static lt_int8_range range_of(const seen_layer *l)
{
    const double levels = l->has_negative ? 127 : 255;
    double best = l->largest, least = INFINITY;

    if (!(l->largest > 0))
        return (lt_int8_range){ 0 };
    for (int i = LEAST_BINS; i <= BINS; i += 8) {
        const double top = l->largest * i / BINS, loss = loss_at(l, top, levels);

        if (loss <= least) {
            least = loss;
            best = top;
        }
    }
    return (lt_int8_range){ (lt_real)(best / levels), l->has_negative };
}

/* ---- what integers cost a layer ------------------------------------------------------------------------------ */

static void see_result(void *ctx, const char *name, const lt_real *exact, const lt_real *rounded, int64_t n)
{
    seen_layer *l = seen_find(ctx, name);

    for (int64_t i = 0; l && i < n; i++) {
        const double y = (double)exact[i], error = (double)rounded[i] - y;

        l->signal += y * y;
        l->noise += error * error;
    }
}

static double decibels(const seen_layer *l)
{
    if (!(l->signal > 0))
        return l->noise == 0 ? INFINITY : -INFINITY;
    return l->noise > 0 ? 10 * log10(l->signal / l->noise) : INFINITY;
}

/* ---- two walks ----------------------------------------------------------------------------------------------- */

typedef struct {
    model_record record;
    lt_plan *plan, *rounded;
    const lt_int8_table *table;
    seen_layers seen;
} job;

static void observe(void *ctx)
{
    job *j = ctx;

    lt_plan_observe(j->plan, see_input, &j->seen);
}

static void compare(void *ctx)
{
    job *j = ctx;

    lt_plan_compare(j->plan, j->rounded, j->table, see_result, &j->seen);
}

static lt_status walk(const calibrate_options *o, job *j, const lt_compile_opts *opts, void (*run)(void *))
{
    lt_status st;

    j->plan = lt_compile(j->record.g, opts);
    if (!j->plan)
        return lt_last_status();
    st = o->walk(o->ctx, j->plan, &j->record, run, j);
    lt_plan_free(j->plan);
    return st == LT_OK && j->seen.no_memory ? lt_error(LT_ENOMEM, "no memory to calibrate") : st;
}

static lt_status walk_beside(const calibrate_options *o, job *j, const lt_int8_table *table)
{
    static const lt_int8_table none;
    const lt_compile_opts exact = { .int8 = &none };         /* as plain as the other */
    lt_status st;

    j->table = table;
    j->rounded = lt_compile(j->record.g, &(lt_compile_opts){ .int8 = table });
    if (!j->rounded)
        return lt_last_status();
    st = walk(o, j, &exact, compare);
    lt_plan_free(j->rounded);
    return st;
}

/* All layers that had a range, or of these those that bear it. */
static void fill_table(calibration *c, lt_int8_layer *list)
{
    int n = 0;

    for (int i = 0; i < c->n; i++)
        if (c->layer[i].integers)
            list[n++] = (lt_int8_layer){ c->layer[i].layer, c->layer[i].range };
    c->table = (lt_int8_table){ list, n };
}

static lt_status judge(lt_arena *arena, const calibrate_options *o, job *j, calibration *out)
{
    calibrated_layer *list = lt_arena_array(arena, (size_t)j->seen.n, sizeof(*list));
    lt_int8_layer *table = lt_arena_array(arena, (size_t)j->seen.n, sizeof(*table));
    calibration c = { list, 0, { 0 } };
    lt_status st;

    for (seen_layer *l = j->seen.first; list && l; l = l->next) {
        const lt_int8_range range = range_of(l);
        const char *name = lt_arena_strdup(arena, l->name);

        if (!name)
            return lt_error(LT_ENOMEM, "no memory to calibrate");
        list[c.n++] = (calibrated_layer){ name, range, 0, range.scale > 0 };
    }
    if (!list || !table)
        return lt_error(LT_ENOMEM, "no memory to calibrate");
    fill_table(&c, table);
    st = walk_beside(o, j, &c.table);
    for (int i = 0; i < c.n; i++) {
        list[i].db = decibels(seen_find(&j->seen, list[i].layer));
        list[i].integers &= list[i].db >= CALIBRATE_LEAST_DB;
    }
    fill_table(&c, table);
    *out = c;
    return st;
}

lt_status calibrate(lt_arena *arena, const calibrate_options *o, calibration *out)
{
    job j = { .record = { .g = lt_graph_new(), .batch = o->batch } };      /* whole maps: all of them are known */
    lt_status st;

    j.seen = (seen_layers){ .arena = lt_arena_new() };
    j.seen.end = &j.seen.first;
    st = j.record.g && j.seen.arena ? LT_OK : lt_error(LT_ENOMEM, "no memory to calibrate");
    if (st == LT_OK) {
        o->m->cls->record(o->m, false, &j.record);
        st = walk(o, &j, &(lt_compile_opts){ .no_fusion = true }, observe);
    }
    if (st == LT_OK)
        st = judge(arena, o, &j, out);
    lt_graph_free(j.record.g);
    lt_arena_free(j.seen.arena);
    return st;
}

void calibration_print(const calibration *c, FILE *f)
{
    fprintf(f,
            "%d of %d layers read 8-bit integers; outputs of the model, depthwise and grouped convolutions, those of "
            "few channels and attention stay as they are\n", c->table.n, c->n);
    for (int i = 0; i < c->n; i++)
        if (!c->layer[i].range.scale)
            fprintf(f, "  %-40s stays float: nothing but zeros came in\n", c->layer[i].layer);
        else if (!c->layer[i].integers)
            fprintf(f, "  %-40s stays float: %.1f dB, want %.0f\n", c->layer[i].layer, c->layer[i].db,
                    CALIBRATE_LEAST_DB);
}
