/* SPDX-License-Identifier: Apache-2.0 */
/* How long runs take: a plan is made and filled, then timed. */
#include "eval/bench/internal.h"

#include "estimate/feed.h"
#include "libtensor/base/clock.h"
#include "libtensor/base/order.h"
#include "libtensor/base/rng.h"
#include "libtensor/graph/rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <zlib.h>

enum { WARM_UP = 3, MIN_RUNS = 3, MAX_RUNS = 10000 };

/* ---- setting up --------------------------------------------------------------------------------------- */

/* Boxes inside the crop; everything else between 0 and 1. */
static void fill_input(const model *m, const lt_plan *p, const model_port *port)
{
    const double S = m->image_size;
    lt_real *x = lt_plan_data(p, port->tensor);
    lt_rng r = lt_rng_make(1, 0);

    if (!x)
        return;
    if (m->cls->fill) {
        m->cls->fill(m, port->name, x);
        return;
    }
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

/* What a model draws is the same on every machine of the same instruction set, and so is its checksum. */
static void look_at_image(bench *b)
{
    const lt_tensor *image = model_port_find(&b->record.outputs, "image");
    const lt_tensor *instances = model_port_find(&b->record.outputs, "instances");

    b->draws = image && instances;
    if (!b->draws)
        return;
    lt_kernels_use(b->o.kernels);
    lt_run(b->plan);
    b->instances = (double)*(const lt_real *)lt_plan_data(b->plan, instances);
    b->image_crc32 = (uint32_t)crc32_z(0, lt_plan_data(b->plan, image), lt_nbytes(image));
}

/* A step moves all rows of what is stepped by rows. */
static lt_status touch_rows(const bench *b)
{
    lt_status st = LT_OK;

    for (lt_param *p = lt_params_first(b->o.m->params); p && !st; p = p->next)
        if (p->rows)
            st = lt_param_touch(p, 0, p->shape.dim[0]);
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
    if (has_step(b) && !b->optim)
        return lt_last_status();
    return b->o.train ? touch_rows(b) : LT_OK;
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
    look_at_image(b);
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

void bench_run_once(bench *b)
{
    lt_run(b->plan);
    if (has_step(b))
        lt_optim_step(b->optim, 1e-6, lt_optim_grad_norm(b->optim));
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
        bench_run_once(b);
}

/* Runs until there are enough of them or they have taken long enough. */
static bench_result measure(bench *b, int runs, double seconds)
{
    const int copies = b->o.copies ? b->o.copies : 1;
    bench_result r = { .macs = lt_plan_macs(b->plan) / copies, .plan_bytes = lt_plan_bytes(b->plan) };
    double start;

    lt_kernels_use(b->o.kernels);
    r.fma_before = lt_fma_peak_gflops(BENCH_PEAK_MS);
    start = lt_clock();
    while (r.runs < runs && (r.runs < MIN_RUNS || lt_clock() - start < seconds)) {
        const double t = lt_clock();

        bench_run_once(b);
        b->ms[r.runs++] = 1e3 * (lt_clock() - t) / copies;
    }
    r.fma_after = lt_fma_peak_gflops(BENCH_PEAK_MS);
    qsort(b->ms, (size_t)r.runs, sizeof(*b->ms), lt_ascending);
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
