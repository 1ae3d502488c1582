/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How good the model is in the middle of a run: the task's scores and the losses on samples that it does not learn
 * from.
 */
#include "train/trainer_internal.h"

#include "train/signals.h"

#include <math.h>

typedef struct {
    trainer *t;
    records records;
    double loss, part[MODEL_PORTS];     /* sums over samples */
    bool no_losses;
} sums;

static lt_status visit(void *ctx, const compiled *c, const void *batch)
{
    sums *s = ctx;
    const task *of = s->t->config.task;
    const int64_t before = s->records.n;
    const lt_status st = of->score(s->t->run, c, batch, &s->records, &s->no_losses);
    const double n = (double)(s->records.n - before);

    for (int i = 0; i < c->record.losses.n; i++)
        s->part[i] += n * compiled_loss(c, c->record.losses.port[i].tensor);
    s->loss += n * compiled_loss(c, c->record.loss);
    return st;
}

/* Each once, though every validation comes by it */
static void warn_skipped(void *ctx, int i, const char *line)
{
    trainer *t = ((sums *)ctx)->t;

    if (i < t->checks_warned)
        return;
    t->checks_warned = i + 1;
    progress_warn(&t->progress, "%s", line);
}

static bool stop_asked(void)
{
    return signals_stop() != 0;
}

static void fill(sums *s, train_validation *out)
{
    const model_ports *losses = &s->t->check.record.losses;
    const double n = (double)s->records.n;
    const bool any = s->records.n && !s->no_losses;

    out->samples = s->records.n;
    records_sort(&s->records);
    s->t->config.task->measure(s->t->run, &s->records, out->value);
    out->loss = any ? s->loss / n : NAN;
    out->n_parts = losses->n;
    for (int i = 0; i < losses->n; i++) {
        out->part_name[i] = losses->port[i].name;
        out->part[i] = any ? s->part[i] / n : NAN;
    }
}

lt_status trainer_validate(trainer *t, train_validation *out)
{
    const loader_source samples = t->config.task->checked(t->run);
    const train_data_config *d = t->config.data;
    sums s = { .t = t };
    const lt_status st = compiled_walk(&t->check, &samples, d->threads, d->tolerate, visit, warn_skipped, &s,
                                       stop_asked);

    if (st == LT_OK)
        fill(&s, out);
    records_free(&s.records);
    return st;
}
