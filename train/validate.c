/* SPDX-License-Identifier: Apache-2.0 */
#include "train/validate.h"

#include "eval/metrics/metrics.h"

#include <math.h>

enum { J = LT_HAND_KEYPOINTS };

typedef struct {
    double pa, mpjpe, loss, part[MODEL_PORTS];      /* sums over samples */
    int64_t n_joints, n_samples;
    bool no_losses;
    compiled_skipped told;
    void *told_ctx;
} sums;

static void add_joints(sums *s, const lt_real *predicted, const float *truth)
{
    double p[3 * J], g[3 * J], aligned[3 * J];

    for (int i = 0; i < 3 * J; i++)
        p[i] = predicted[i];
    eval_widen(3 * J, truth, g);
    eval_align_root(J, p, g, 0, aligned);
    s->mpjpe += eval_mpjpe(J, aligned, g);
    eval_align_procrustes(EVAL_REFLECT, J, p, g, aligned);
    s->pa += eval_mpjpe(J, aligned, g);
    s->n_joints++;
}

static double value(const compiled *c, const lt_tensor *t)
{
    return *(const lt_real *)lt_plan_data(c->plan, t);
}

static void add_losses(sums *s, const compiled *c, int64_t n)
{
    for (int i = 0; i < c->record.losses.n; i++)
        s->part[i] += (double)n * value(c, c->record.losses.port[i].tensor);
    s->loss += (double)n * value(c, c->record.loss);
}

static void visit(void *ctx, const compiled *c, const hand_object_batch *b)
{
    const lt_real *joints = compiled_output(c, "joints");
    sums *s = ctx;
    int64_t n = 0;

    for (int i = 0; i < b->count; i++) {
        if (!(b->weight[i] > 0))
            continue;
        n++;
        if (joints && (b->flags[i] & SAMPLE_JOINTS))
            add_joints(s, joints + 3 * J * i, b->joints + 3 * J * i);
        s->no_losses |= !(b->flags[i] & SAMPLE_HAND_POSE);
    }
    s->n_samples += n;
    add_losses(s, c, n);
}

static void skipped(void *ctx, int i, const char *line)
{
    const sums *s = ctx;

    s->told(s->told_ctx, i, line);
}

static double mean(double sum, int64_t n)
{
    return n ? sum / (double)n : NAN;
}

lt_status validate_run(const compiled *c, const train_source *source, const train_data_config *data,
                       compiled_skipped told, void *ctx, bool (*stop)(void), train_validation *out)
{
    const loader_source samples = train_source_checker(source);
    sums s = { .told = told, .told_ctx = ctx };
    const lt_status st = compiled_walk(c, &samples, data->threads, data->tolerate, visit, skipped, &s, stop);

    if (st)
        return st;
    out->samples = s.n_samples;
    out->pa_mpjpe_mm = 1000 * mean(s.pa, s.n_joints);
    out->mpjpe_mm = 1000 * mean(s.mpjpe, s.n_joints);
    out->loss = s.no_losses ? NAN : mean(s.loss, s.n_samples);
    out->n_parts = c->record.losses.n;
    for (int i = 0; i < out->n_parts; i++) {
        out->part_name[i] = c->record.losses.port[i].name;
        out->part[i] = s.no_losses ? NAN : mean(s.part[i], s.n_samples);
    }
    return LT_OK;
}
