/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/bench.h"

#include "eval/calibrate.h"
#include "libtensor/base/arena.h"
#include "libtensor/base/clock.h"
#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "libtensor/graph/plan.h"
#include "libtensor/io/json.h"
#include "libtensor/kernels/kernels.h"
#include "libtensor/optim/optim.h"
#include "train/feed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { WARM_UP = 3, MIN_RUNS = 3, MAX_RUNS = 10000 };
static const double PEAK_MS = 20;

struct bench {
    bench_options o;
    model_record record;            /* of a part */
    lt_plan *plan;
    int parts;                      /* of a training step, as the trainer has them */
    lt_optim *optim;                /* of a training step */
    double *ms;                     /* one a run */
    lt_arena *arena;                /* with int8: of */
    calibration layers;
};

/* ---- setting up --------------------------------------------------------------------------------------- */

/* Boxes inside the crop; everything else between 0 and 1. */
static void fill_input(const model *m, const lt_plan *p, const model_port *port)
{
    const double S = m->image_size;
    lt_real *x = lt_plan_data(p, port->tensor);
    lt_rng r = lt_rng_make(1, 0);

    if (!x)
        return;
    for (int64_t i = 0; i < lt_numel(port->tensor); i++)
        x[i] = (lt_real)lt_rng_uniform(&r);
    if (!strstr(port->name, "_box"))
        return;
    for (int64_t i = 0; i < lt_numel(port->tensor); i += 4) {
        x[i] = (lt_real)(0.2 * S);
        x[i + 1] = (lt_real)(0.25 * S);
        x[i + 2] = (lt_real)(0.7 * S);
        x[i + 3] = (lt_real)(0.75 * S);
    }
}

static void fill_inputs(const model *m, const lt_plan *p, const model_record *r)
{
    for (int i = 0; i < r->inputs.n; i++)
        fill_input(m, p, &r->inputs.port[i]);
}

static void fill_parts(const bench *b)
{
    for (int i = 0; i < b->parts; i++) {
        lt_plan *part = lt_plan_part(b->plan, i);

        fill_inputs(b->o.m, part, &b->record);
        lt_plan_set_loss_weight(part, 1.0 / b->parts);
    }
}

static lt_status walk_inputs(void *ctx, const lt_plan *p, const model_record *r, void (*run)(void *), void *run_ctx)
{
    const bench *b = ctx;

    fill_inputs(b->o.m, p, r);
    run(run_ctx);
    return LT_OK;
}

/* Which layers of an inference read integers: what the model has from a file, or what --int8 finds. */
static lt_status find_table(bench *b, const lt_int8_table **out)
{
    const calibrate_options o = { .m = b->o.m, .batch = b->o.batch, .walk = walk_inputs, .ctx = b };
    lt_status st;

    *out = b->o.m->int8;
    if (!b->o.int8 || b->o.train)
        return LT_OK;
    b->arena = lt_arena_new();
    st = b->arena ? calibrate(b->arena, &o, &b->layers) : LT_ENOMEM;
    *out = &b->layers.table;
    return st;
}

static bool has_step(const bench *b)
{
    return b->o.train && !b->o.copies;
}

static lt_status compile(bench *b)
{
    const lt_optim_opts adam = { .kind = LT_ADAM, .weight_decay = 5e-4 };
    const lt_int8_table *table;
    lt_status st;

    b->record.g = lt_graph_new();
    if (!b->record.g)
        return lt_last_status();
    b->o.m->cls->record(b->o.m, b->o.train, &b->record);
    lt_kernels_use(b->o.kernels);
    st = find_table(b, &table);
    if (st)
        return st;
    b->plan = lt_compile(b->record.g, &(lt_compile_opts){ .train = b->o.train, .loss = b->record.loss,
                                                          .replace_grads = true, .parts = b->parts,
                                                          .consume_params = b->o.alone, .int8 = table });
    if (!b->plan)
        return lt_last_status();
    if (has_step(b))
        b->optim = lt_optim_new(b->o.m->params, &adam);
    return has_step(b) && !b->optim ? lt_last_status() : LT_OK;
}

lt_status bench_new(const bench_options *o, bench **out)
{
    bench *b = lt_alloc(sizeof(*b));
    lt_status st;

    if (!b)
        return lt_error(LT_ENOMEM, "no memory to measure");
    b->o = *o;
    b->o.runs = (int)lt_max_i64(MIN_RUNS, lt_min_i64(o->runs, MAX_RUNS));
    b->o.kernels = o->kernels ? o->kernels : lt_k;
    b->parts = has_step(b) ? feed_parts(o->m, o->batch) : 1;
    b->record.batch = o->batch / b->parts;
    b->ms = lt_alloc((size_t)b->o.runs * sizeof(*b->ms));
    st = b->ms ? compile(b) : lt_error(LT_ENOMEM, "no memory to measure");
    if (st) {
        bench_free(b);
        return st;
    }
    fill_parts(b);
    *out = b;
    return LT_OK;
}

void bench_free(bench *b)
{
    if (!b)
        return;
    lt_optim_free(b->optim);
    lt_plan_free(b->plan);
    lt_graph_free(b->record.g);
    lt_arena_free(b->arena);
    lt_release(b->ms);
    lt_release(b);
}

/* ---- measuring ---------------------------------------------------------------------------------------- */

static void run_once(bench *b)
{
    lt_run(b->plan);
    if (has_step(b)) {
        lt_optim_step(b->optim, 1e-6, lt_optim_grad_norm(b->optim));
        lt_statistics_update(b->o.m->params, 1);
    }
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static double percentile(const double *sorted, int n, double p)
{
    const double at = p * (n - 1);
    const int i = (int)at;

    return i + 1 < n ? sorted[i] + (at - i) * (sorted[i + 1] - sorted[i]) : sorted[n - 1];
}

static double peak_rss_mb(void)
{
    struct rusage usage;

    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

static void warm_up(bench *b)
{
    lt_kernels_use(b->o.kernels);
    for (int i = 0; i < WARM_UP; i++)
        run_once(b);
}

/* Runs until there are enough of them or they have taken long enough. */
static bench_result measure(bench *b, int runs, double seconds)
{
    const int copies = b->o.copies ? b->o.copies : 1;
    bench_result r = { .macs = lt_plan_macs(b->plan) / copies, .plan_bytes = lt_plan_bytes(b->plan) };
    double start;

    lt_kernels_use(b->o.kernels);
    r.fma_before = lt_fma_peak_gflops(PEAK_MS);
    start = lt_clock();
    while (r.runs < runs && (r.runs < MIN_RUNS || lt_clock() - start < seconds)) {
        const double t = lt_clock();

        run_once(b);
        b->ms[r.runs++] = 1e3 * (lt_clock() - t) / copies;
    }
    r.fma_after = lt_fma_peak_gflops(PEAK_MS);
    qsort(b->ms, (size_t)r.runs, sizeof(*b->ms), by_value);
    r.median_ms = percentile(b->ms, r.runs, 0.5);
    r.p5_ms = percentile(b->ms, r.runs, 0.05);
    r.p95_ms = percentile(b->ms, r.runs, 0.95);
    r.min_ms = b->ms[0];
    r.peak_rss_mb = peak_rss_mb();
    return r;
}

bench_result bench_run(bench *b)
{
    warm_up(b);
    return measure(b, b->o.runs, b->o.seconds);
}

/* ---- two in turn -------------------------------------------------------------------------------------- */

/* Keeps the round with the lower median, and the lower minimum. */
static void keep_best(bench_result *best, bench_result r)
{
    const double min_ms = best->runs ? fmin(best->min_ms, r.min_ms) : r.min_ms;

    if (!best->runs || r.median_ms < best->median_ms)
        *best = r;
    best->min_ms = min_ms;
}

/* No reading around the round below 0.9 of the best of its instruction set. */
static bool undisturbed(const bench_result *r, double *best_peak)
{
    *best_peak = fmax(*best_peak, fmax(r->fma_before, r->fma_after));
    return fmin(r->fma_before, r->fma_after) >= 0.9 * *best_peak;
}

void bench_compare(bench *a, bench *b, bench_result out[2])
{
    bench *const both[2] = { a, b };
    double peak[2] = { 0, 0 };

    warm_up(a);
    warm_up(b);
    out[0].runs = out[1].runs = 0;
    for (int quiet = 0, tries = 0; quiet < BENCH_ROUNDS && tries < 3 * BENCH_ROUNDS; tries++) {
        bool good = true;

        for (int i = 0; i < 2; i++) {
            const int runs = (int)lt_ceil_div(both[i]->o.runs, BENCH_ROUNDS);
            const bench_result r = measure(both[i], runs, both[i]->o.seconds / BENCH_ROUNDS);

            keep_best(&out[i], r);
            good = undisturbed(&r, &peak[i]) && good;
        }
        quiet += good;
    }
}

/* ---- printing ----------------------------------------------------------------------------------------- */

static const char *mode(const bench *b)
{
    return b->o.train ? "train" : b->o.int8 || b->o.m->int8 ? "infer int8" : "infer";
}

/* A training step is the forward products, and about twice as many backward. */
static double gflops(const bench *b, const bench_result *r)
{
    return (b->o.train ? 3 : 1) * 2e-6 * (double)r->macs / r->median_ms;
}

void bench_print(const bench *b, const bench_result *r, FILE *f, bool heading)
{
    const int digits = r->median_ms < 10 ? 4 : 2;

    if (heading)
        fprintf(f, "| model | variant | mode | batch | threads | isa | median ms | p5 | p95 | min | runs | "
                "GFLOP/s | FMA peak | peak MB |\n|---|---|---|--:|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    fprintf(f, "| %s | %s | %s | %d | %d | %s | %.*f | %.*f | %.*f | %.*f | %d | %.0f | %.0f .. %.0f | %.0f |\n",
            b->o.m->cls->name, b->o.m->variant, mode(b), b->o.batch, lt_threads(), lt_isa_name(b->o.kernels->isa),
            digits, r->median_ms, digits, r->p5_ms, digits, r->p95_ms, digits, r->min_ms, r->runs, gflops(b, r),
            r->fma_before, r->fma_after, r->peak_rss_mb);
}

static void print_number(FILE *f, const char *name, double value)
{
    char text[LT_JSON_NUMBER];

    fprintf(f, ", \"%s\": %s", name, lt_json_number(value, text));
}

void bench_print_json(const bench *b, const bench_result *r, FILE *f)
{
    fprintf(f, "{\"model\": \"%s\", \"variant\": \"%s\", \"mode\": \"%s\", \"isa\": \"%s\", \"cpu\": ",
            b->o.m->cls->name, b->o.m->variant, mode(b), lt_isa_name(b->o.kernels->isa));
    lt_json_print_string(f, lt_cpu_model());
    print_number(f, "batch", b->o.batch);
    print_number(f, "threads", lt_threads());
    print_number(f, "median_ms", r->median_ms);
    print_number(f, "p5_ms", r->p5_ms);
    print_number(f, "p95_ms", r->p95_ms);
    print_number(f, "min_ms", r->min_ms);
    print_number(f, "runs", r->runs);
    print_number(f, "peak_rss_mb", r->peak_rss_mb);
    print_number(f, "plan_mb", (double)r->plan_bytes / 1048576);
    print_number(f, "gmacs", 1e-9 * (double)r->macs);
    print_number(f, "fma_gflops", r->fma_before < r->fma_after ? r->fma_before : r->fma_after);
    print_number(f, "fma_gflops_before", r->fma_before);
    print_number(f, "fma_gflops_after", r->fma_after);
    fprintf(f, "}\n");
}

void bench_print_ratio(const bench *a, const bench *b, const bench_result r[2], FILE *f, bool json)
{
    const double medians = r[1].median_ms / r[0].median_ms, minima = r[1].min_ms / r[0].min_ms;
    const char *ours = lt_isa_name(a->o.kernels->isa), *other = lt_isa_name(b->o.kernels->isa);

    if (json) {
        fprintf(f, "{\"compare\": \"%s\", \"with\": \"%s\"", ours, other);
        print_number(f, "ratio_of_medians", medians);
        print_number(f, "ratio_of_minima", minima);
        fprintf(f, "}\n");
    } else {
        fprintf(f, "\n%s is %.2f times as fast as %s by the lowest medians of %d alternated rounds, %.2f by the "
                "minima\n", ours, medians, other, BENCH_ROUNDS, minima);
    }
}

void bench_print_layers(const bench *b, FILE *f)
{
    if (b->arena)
        calibration_print(&b->layers, f);
}

/* ---- the profile -------------------------------------------------------------------------------------- */

enum { MAX_GROUPS = 256, SLOWEST = 20, PROFILED = 5 };   /* runs that a profile averages */

typedef struct {
    lt_step_info first;             /* op and phase */
    double seconds;
    int64_t macs;
    int count;
} group;

static group *group_of(group *list, int *n, const lt_step_info *s)
{
    for (int i = 0; i < *n; i++)
        if (list[i].first.op == s->op && list[i].first.phase == s->phase)
            return &list[i];
    if (*n == MAX_GROUPS)
        return &list[MAX_GROUPS - 1];
    list[*n] = (group){ .first = *s };
    return &list[(*n)++];
}

static int slower_group(const void *a, const void *b)
{
    return by_value(&((const group *)b)->seconds, &((const group *)a)->seconds);
}

static int slower_step(const void *a, const void *b)
{
    return by_value(&((const lt_step_info *)b)->seconds, &((const lt_step_info *)a)->seconds);
}

static void print_line(FILE *f, const char *name, double seconds, int64_t macs, double total, double peak)
{
    const double rate = seconds > 0 ? 2e-9 * (double)macs / seconds : 0;

    fprintf(f, "  %-52s %9.3f ms %5.1f %%", name, 1e3 * seconds, total > 0 ? 100 * seconds / total : 0);
    if (macs)
        fprintf(f, " %7.1f GFLOP/s %5.1f %% of peak", rate, 100 * rate / peak);
    fputc('\n', f);
}

static void print_groups(FILE *f, const lt_step_info *step, int n, double total, double peak)
{
    static group list[MAX_GROUPS];
    int n_groups = 0;
    char name[128];

    for (int i = 0; i < n; i++) {
        group *g = group_of(list, &n_groups, &step[i]);

        g->seconds += step[i].seconds;
        g->macs += step[i].macs;
        g->count++;
    }
    qsort(list, (size_t)n_groups, sizeof(*list), slower_group);
    for (int i = 0; i < n_groups; i++) {
        snprintf(name, sizeof(name), "%s %s x%d", list[i].first.phase, list[i].first.op, list[i].count);
        print_line(f, name, list[i].seconds, list[i].macs, total, peak);
    }
}

static void print_slowest(FILE *f, lt_step_info *step, int n, double total, double peak)
{
    char name[256], shape[LT_SHAPE_TEXT];

    qsort(step, (size_t)n, sizeof(*step), slower_step);
    for (int i = 0; i < n && i < SLOWEST; i++) {
        snprintf(name, sizeof(name), "%s %s %s %s %s", step[i].phase, step[i].op, step[i].layer,
                 lt_shape_text(&step[i].shape, shape), step[i].algorithm);
        print_line(f, name, step[i].seconds, step[i].macs, total, peak);
    }
}

void bench_profile(bench *b, FILE *f)
{
    const int n = lt_plan_steps(b->plan);
    lt_step_info *step = lt_alloc((size_t)n * sizeof(*step));
    const double peak = lt_fma_peak_gflops(PEAK_MS);
    double total = 0;

    if (!step)
        return;
    lt_plan_profile(b->plan, true);
    for (int i = 0; i < PROFILED; i++)
        run_once(b);
    for (int i = 0; i < n; i++) {
        step[i] = lt_plan_step(b->plan, i);
        step[i].seconds /= PROFILED;
        total += step[i].seconds;
    }
    lt_plan_profile(b->plan, false);
    fprintf(f, "by op (%.1f ms in all, FMA peak %.0f GFLOP/s)\n", 1e3 * total, peak);
    print_groups(f, step, n, total, peak);
    fprintf(f, "slowest layers\n");
    print_slowest(f, step, n, total, peak);
    lt_release(step);
}
