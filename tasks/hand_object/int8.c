/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hand_object/int8.h"

#include "estimate/checkpoint/checkpoint.h"
#include "estimate/feed.h"
#include "eval/bench/bench.h"
#include "tasks/hand_object/each_batch.h"

#include <sys/stat.h>

enum { BATCH = 4 };                     /* images that are calibrated on at a time */

/* ---- calibration ---------------------------------------------------------------------------------------- */

typedef struct {
    const lt_plan *plan;
    const model_record *record;
    void (*run)(void *ctx);
    void *run_ctx;
} feed_job;

static lt_status feed_one(void *ctx, const hand_object_batch *b, int64_t done)
{
    const feed_job *j = ctx;

    (void)done;
    if (feed_batch(j->plan, j->record, b, 0) > 0)
        j->run(j->run_ctx);
    return LT_OK;
}

static lt_status walk(void *ctx, const lt_plan *p, const model_record *r, void (*run)(void *), void *run_ctx)
{
    const export_int8_options *o = ctx;
    const evaluate_options samples = {
        .m = o->m, .data = o->calibration, .bilinear = o->bilinear, .batch = BATCH, .limit = o->samples,
        .progress = o->progress, .progress_ctx = o->progress_ctx,
    };
    feed_job j = { p, r, run, run_ctx };
    lt_status st = feed_check(r);

    return st ? st : eval_each_batch(&samples, feed_one, &j);
}

static lt_status write_table(const export_int8_options *o, const char *path, const calibration *c, size_t *bytes)
{
    struct stat s;
    lt_status st;

    o->m->int8 = &c->table;
    st = checkpoint_save_inference(path, o->from, o->m, false);
    if (st == LT_OK)
        st = checkpoint_load_model(path, o->m);
    if (st)
        o->m->int8 = NULL;
    *bytes = st == LT_OK && stat(path, &s) == 0 ? (size_t)s.st_size : 0;
    return st;
}

/* ---- figures -------------------------------------------------------------------------------------------- */

static lt_status score(const export_int8_options *o, const model *m, double *mm)
{
    evaluation *e;
    lt_status st = evaluate(&(evaluate_options){ .m = m, .data = o->scored, .hand = o->hand, .hand_name = o->hand_name,
                                                 .checkpoint = o->from, .bilinear = o->bilinear, .batch = 8,
                                                 .limit = o->limit,
                                                 .progress = o->progress, .progress_ctx = o->progress_ctx }, &e);

    if (st)
        return st;
    *mm = evaluation_score(e, EVALUATE_MODEL, "pa_mpjpe_mm");
    evaluation_free(e);
    return LT_OK;
}

static lt_status measure(const model *const m[2], double ms[2])
{
    bench *b[2] = { NULL, NULL };
    bench_result r[2];
    lt_status st = LT_OK;

    for (int i = 0; st == LT_OK && i < 2; i++)
        st = bench_new(&(bench_options){ .m = m[i], .batch = 1, .runs = 50, .seconds = 5 }, &b[i]);
    if (st == LT_OK)
        bench_compare(b[0], b[1], r);
    for (int i = 0; i < 2; i++) {
        ms[i] = st == LT_OK ? r[i].median_ms : 0;
        bench_free(b[i]);
    }
    return st;
}

lt_status export_int8(lt_arena *arena, const export_int8_options *o, const char *path, export_int8_report *report)
{
    const calibrate_options how = { .m = o->m, .batch = BATCH, .walk = walk, .ctx = (void *)o };
    export_int8_report r = { .bytes = 0 };
    lt_status st = calibrate(arena, &how, &r.layers);

    if (st == LT_OK)
        st = write_table(o, path, &r.layers, &r.bytes);
    if (st == LT_OK) {
        model exact = *o->m;
        const model *const both[2] = { &exact, o->m };

        exact.int8 = NULL;
        for (int i = 0; st == LT_OK && o->scored && i < 2; i++)
            st = score(o, both[i], &r.pa_mpjpe_mm[i]);
        if (o->scored)
            r.scored = lt_min_i64(o->limit, o->scored->count);
        if (st == LT_OK)
            st = measure(both, r.ms);
    }
    *report = r;
    return st;
}
