/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a run will take: memory, disk and time.
 */
#include "train/trainer_internal.h"

#include "libtensor/base/clock.h"
#include "libtensor/base/cpu.h"
#include "libtensor/base/parallel.h"
#include "libtensor/graph/rows.h"
#include "libtensor/kernels/kernels.h"

#include <inttypes.h>
#include <stdlib.h>
#include <unistd.h>

/* ---- memory ---------------------------------------------------------------------------------------------- */

/* What the kernel can give without swapping, bytes; 0: it does not say. */
static double free_memory(void)
{
    FILE *f = fopen("/proc/meminfo", "r");
    char line[128];
    unsigned long kB = 0;

    while (f && !kB && fgets(line, sizeof(line), f))
        sscanf(line, "MemAvailable: %lu kB", &kB);
    if (f)
        fclose(f);
    return 1024.0 * (double)kB;
}

lt_status forecast_task(const trainer *t)
{
    const task *of = t->config.task;
    const char *less = "";
    const double all = of->bytes ? (double)of->bytes(&t->config, &less) : 0, have = free_memory();

    if (have == 0 || all <= have)
        return LT_OK;
    return lt_error(LT_ENOMEM, "%s: the run takes %.1f MB of memory beside its network, and %.1f are free; a smaller "
                    "%s takes less", t->config.path, 1e-6 * all, 1e-6 * have, less);
}

size_t trainer_plan_bytes(const trainer *t)
{
    return lt_plan_bytes(t->train.plan) + (t->check.plan ? lt_plan_bytes(t->check.plan) : 0);
}

static size_t batch_bytes(const trainer *t)
{
    const size_t batches = (size_t)t->config.data->ahead + 1 + (t->check.plan ? COMPILED_AHEAD + 1 : 0);

    return batches * (size_t)t->phase.batch * t->config.task->sample_bytes(t->run);
}

size_t trainer_bytes(const trainer *t)
{
    const char *less;
    size_t n = t->resident + trainer_plan_bytes(t) + batch_bytes(t) + tree_sum_bytes(t->sum)
        + lt_arena_bytes(lt_params_arena(t->params));

    for (int i = 0; i < lt_optim_state_count(t->optim); i++) {
        const lt_optim_state s = lt_optim_state_at(t->optim, i);

        n += (size_t)lt_shape_numel(&s.shape) * sizeof(lt_real);
    }
    return n + (t->config.task->bytes ? t->config.task->bytes(&t->config, &less) : 0);
}

/* ---- time ------------------------------------------------------------------------------------------------ */

enum { TRIED = 3 };

/* Of a step of a phase: of its plan, run on whatever is in its inputs. The first run pays for memory's first touch. */
static double seconds_of_step(trainer *t)
{
    double best = 0;

    lt_params_untouch(t->params);
    lt_run(t->train.plan);
    for (int i = 0; i < TRIED; i++) {
        const double began = lt_clock();
        double took;

        lt_run(t->train.plan);
        took = lt_clock() - began;
        best = i && best < took ? best : took;
    }
    return best * t->phase.shards;
}

lt_status forecast_seconds(trainer *t, double *out)
{
    const int64_t from = t->state.step;
    lt_status st = LT_OK;

    *out = 0;
    while (st == LT_OK && t->state.step < t->total_steps) {
        st = trainer_enter(t);
        if (st == LT_OK)
            *out += seconds_of_step(t) * (double)(t->phase.until - t->state.step);
        t->state.step = t->phase.until;
    }
    t->state.step = from;
    return st;
}

/* ---- said ------------------------------------------------------------------------------------------------ */

static void describe_data(trainer *t)
{
    const train_optim_config *o = &t->config.optim;

    t->config.task->describe(t->run, &t->progress);
    progress_note(&t->progress, "steps        %" PRId64 " of %d samples in %d shard%s, %" PRId64 " an epoch",
                  t->total_steps, o->batch, o->shards, o->shards > 1 ? "s" : "", t->steps_of_epoch);
}

static void describe_memory(trainer *t)
{
    const double all = (double)trainer_bytes(t), have = free_memory() + (double)t->resident;

    progress_note(&t->progress, "memory       %.1f MB, of which plans %.1f MB", 1e-6 * all,
                  1e-6 * (double)trainer_plan_bytes(t));
    if (have > (double)t->resident && all > have)
        progress_warn(&t->progress, "the run takes %.1f MB of memory, and %.1f are free: a smaller optim.batch takes "
                      "less", 1e-6 * all, 1e-6 * have);
}

void trainer_describe(trainer *t)
{
    progress_note(&t->progress, "model        %s (%s), %.2f M parameters, %.2f GMAC an image",
                  t->model.cls->name, t->model.variant,
                  1e-6 * (double)lt_params_count(t->params, LT_WEIGHT, ""),
                  1e-9 * (double)lt_plan_macs(t->train.plan) / (t->train.parts * t->train.record.batch));
    describe_data(t);
    progress_note(&t->progress, "machine      %s, %s, %d thread%s", lt_cpu_model(), lt_isa_name(lt_k->isa),
                  lt_threads(), lt_threads() > 1 ? "s" : "");
    describe_memory(t);
}
