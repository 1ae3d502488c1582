/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/compiled.h"

#include <math.h>

lt_status compiled_new(const recipe *by, int batch, bool train, compiled *out)
{
    const int parts = train && by->parts ? by->parts(by->ctx, batch) : 1;
    const int samples = !train && by->batch ? by->batch : batch;
    compiled c = { .by = *by, .record = { .g = lt_graph_new(), .batch = samples / parts }, .parts = parts };
    lt_compile_opts opts = { .train = train, .replace_grads = true, .parts = parts };
    lt_status st, graph;

    if (!c.record.g)
        return lt_error(LT_ENOMEM, "no memory for the graph");
    st = by->record(by->ctx, &c.record);
    graph = lt_graph_status(c.record.g);
    st = graph ? graph : st;
    if (st == LT_OK) {
        opts.loss = train ? c.record.loss : NULL;
        c.plan = lt_compile(c.record.g, &opts);
        st = c.plan ? LT_OK : lt_last_status();
    }
    if (st)
        compiled_free(&c);
    else
        *out = c;
    return st;
}

void compiled_free(compiled *c)
{
    lt_plan_free(c->plan);
    lt_graph_free(c->record.g);
    *c = (compiled){ .plan = NULL };
}

const lt_real *compiled_output(const compiled *c, const char *name)
{
    const lt_tensor *t = model_port_find(&c->record.outputs, name);

    return t ? lt_plan_data(c->plan, t) : NULL;
}

double compiled_loss(const compiled *c, const lt_tensor *loss)
{
    return loss ? (double)*(const lt_real *)lt_plan_data(c->plan, loss) : NAN;
}

static lt_status walk(const compiled *c, loader *l, compiled_visit visit, void *ctx, bool (*stop)(void))
{
    for (;;) {
        void *batch;
        lt_status st;

        if (stop && stop())
            return lt_error(LT_ESTOPPED, "stopped by a signal");
        st = loader_next(l, &batch);
        if (st || !batch)
            return st;
        if (!(c->by.feed(c->by.ctx, c->plan, &c->record, batch, 0, 0, 1) > 0))
            continue;
        lt_run(c->plan);
        st = visit(ctx, c, batch);
        if (st)
            return st;
    }
}

lt_status compiled_walk(const compiled *c, const loader_source *source, int threads, double tolerate,
                        compiled_visit visit, compiled_skipped skipped, void *ctx, bool (*stop)(void))
{
    const loader_options o = { .batch = c->record.batch, .threads = threads, .ahead = COMPILED_AHEAD,
                               .tolerate = tolerate };
    loader *l;
    lt_status st = loader_new(source, &o, (loader_position){ 0 }, &l);

    if (st)
        return st;
    st = walk(c, l, visit, ctx, stop);
    for (int i = 0; st == LT_OK && i < loader_skipped(l); i++)
        skipped(ctx, i, loader_skipped_line(l, i));
    loader_free(l);
    return st;
}
