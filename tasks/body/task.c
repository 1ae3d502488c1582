/* SPDX-License-Identifier: Apache-2.0 */
/* Whole bodies from pictures of persons: what the trainer asks. */
#include "tasks/body/task.h"

#include "libtensor/io/file.h"
#include "tasks/body/batch.h"
#include "tasks/body/evaluate.h"
#include "tasks/body/truth.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

struct task_run {
    lt_arena *arena;
    run_body body;
    body_set set, checked_set;
    body_feed train, checked;
    body_graph graph;
    task_phase phase;
    double ema_decay;
    lt_optim_group group[BODY_GROUPS];
};

/* ---- opening ---- */

static lt_status open_data(task_run *r, const train_config *c)
{
    const body_data_config *d = body_data_of(c);
    const bool validates = c->loop.validate_every > 0 || c->loop.validate_steps > 0;
    lt_status st = body_set_open(r->arena, d->common.dir, "train", &r->set);

    if (!st)
        st = run_body_open(r->arena, d->body, &r->body);
    if (!st)
        st = body_truth_check(&r->body, &r->set);
    if (st)
        return st;
    r->train = (body_feed){ .set = &r->set, .count = r->set.n, .scale = d->scale, .shift = d->shift,
                             .rotation_deg = d->rotation_deg, .flip = d->flip,
                            .colour = d->colour, .seed = (uint64_t)c->loop.seed };
    if (!validates)
        return LT_OK;
    st = body_set_open(r->arena, d->common.dir, "evaluation", &r->checked_set);
    r->checked = (body_feed){ .set = &r->checked_set,
                              .count = lt_min_i64(c->loop.validate_samples, r->checked_set.n) };
    return st;
}

static void open_optimiser(task_run *r, const train_config *c)
{
    const train_optim_config *o = &c->optim;

    r->phase = (task_phase){ .batch = o->batch, .shards = o->shards, .groups = (1u << BODY_GROUPS) - 1,
                             .until = lt_ceil_div(r->train.count, o->batch) * o->epochs };
    r->ema_decay = o->ema_decay;
    body_groups(c, r->group);
}

/* So that the run's config finds the same data and body from any folder, and whatever $PALMAR_BODY says then */
static lt_status keep_paths(const task_run *r, train_config *c)
{
    ((body_data_config *)c->data)->body = r->body.path;
    c->data->dir = lt_path_whole(r->arena, c->data->dir);
    return c->data->dir ? LT_OK : lt_error(LT_ENOMEM, "no memory to begin");
}

static lt_status run_open(lt_arena *arena, train_config *c, task_run **out)
{
    task_run *r = lt_arena_alloc(arena, sizeof(*r));
    lt_skin_layer *layer;
    lt_status st;

    *out = r;
    if (!r)
        return lt_error(LT_ENOMEM, "no memory to begin");
    *r = (task_run){ .arena = arena };
    if (!*c->data->dir)
        return lt_error(LT_EUSAGE, "%s: data.dir: no dataset given; name its folder with --data or --set "
                        "data.dir=FOLDER", c->path);
    st = open_data(r, c);
    if (!st)
        st = run_body_layer(arena, r->body.model, &layer);
    if (st)
        return st;
    r->graph.layer = layer;
    open_optimiser(r, c);
    return keep_paths(r, c);
}

static void run_close(task_run *r)
{
    (void)r;                        /* all of it is in the arena */
}

static lt_status run_build(task_run *r, const train_config *c, lt_params *set, model *out)
{
    r->graph.model = out;
    return train_config_model(c, NULL, set, out);
}

static void run_describe(const task_run *r, train_progress *p)
{
    progress_note(p, "%-13spictures of persons%s, %s: %lld of %d subjects", "data",
                  r->set.synthetic ? " (synthetic)" : "", r->set.root, (long long)r->set.n, r->set.subjects);
    if (r->checked.count)
        progress_note(p, "%-13s%lld of %d subjects", "validation", (long long)r->checked.count,
                      r->checked_set.subjects);
    progress_note(p, "%-13s%s%s", "body", r->body.name,
                  r->body.model->synthetic && !run_body_is_embedded(&r->body) ? " (synthetic)" : "");
    if (run_body_is_embedded(&r->body))
        progress_note(p, "%-13s%s", "", run_body_note());
}

static void run_facts(const task_run *r, cJSON *env)
{
    cJSON_AddStringToObject(env, "data", "pictures of persons");
    cJSON_AddBoolToObject(env, "synthetic_data", r->set.synthetic);
    cJSON_AddBoolToObject(env, "synthetic_body", r->body.model->synthetic);
}

/* ---- batches ---- */

static loader_source run_samples(const task_run *r)
{
    return body_source(&r->train);
}

static loader_source run_checked(const task_run *r)
{
    return body_source(&r->checked);
}

static size_t run_sample_bytes(const task_run *r)
{
    (void)r;
    return BODY_PICTURE_FLOATS * sizeof(float) + sizeof(body_target);
}

static double batch_weight(const void *batch)
{
    const body_batch *b = batch;
    double sum = 0;

    for (int i = 0; i < b->count; i++)
        sum += b->weight[i];
    return sum;
}

static const char *run_sample_name(const task_run *r, const void *batch, int i)
{
    const body_batch *b = batch;

    return i < b->count ? r->set.name[b->index[i]] : NULL;
}

static recipe run_recipe(const task_run *r, const task_phase *phase)
{
    (void)phase;
    return body_batch_recipe(&r->graph, true);
}

/* ---- steps ---- */

static task_phase run_phase(const task_run *r, int64_t step)
{
    (void)step;
    return r->phase;
}

static const lt_optim_group *run_groups(const task_run *r, int *n, lt_optim_average *average)
{
    *n = BODY_GROUPS;
    *average = (lt_optim_average){ .decay = r->ema_decay };
    return r->group;
}

/* ---- scores ---- */

static lt_status run_score(task_run *r, const compiled *c, const void *batch, records *out, bool *no_losses)
{
    const body_batch *b = batch;
    lt_status st = LT_OK;

    (void)no_losses;
    for (int i = 0; !st && i < b->count; i++) {
        double nodes[BODY_NODES][3], true_nodes[BODY_NODES][3];
        body_errors e;

        if (!(b->weight[i] > 0))
            continue;
        body_graph_nodes(c, i, nodes);
        for (int k = 0; k < BODY_NODES * 3; k++)
            true_nodes[k / 3][k % 3] = r->checked_set.row[b->index[i]].nodes_3d[k / 3][k % 3];
        body_errors_of((const double (*)[3])nodes, (const double (*)[3])true_nodes, NULL, NULL, &e);
        st = records_add(out, b->index[i], &e, sizeof(e));
    }
    return st;
}

static void run_measure(task_run *r, const records *all, double *out)
{
    (void)r;
    for (int k = 0; k < BODY_PVE; k++)
        out[k] = all->n ? 0 : NAN;
    for (int64_t i = 0; i < all->n; i++) {
        body_errors e;

        memcpy(&e, records_at(all, i, NULL), sizeof(e));
        for (int k = 0; k < BODY_PVE; k++)
            out[k] += e.mm[k] / (double)all->n;
    }
}

static const char *const metrics[] = { "mpjpe_mm", "hand_mpjpe_mm", "pa_mpjpe_mm", NULL };
static const metric own_metrics[] = {
    { "hand_mpjpe_mm", "MPJPE, hands", "mm", false, "mean error of a hand's joints, wrist on wrist", "OSX" },
    { .key = NULL },
};

const task body_task = {
    .name = "body", .data_size = sizeof(body_data_config), .data_keys = body_data_keys, .metrics = metrics,
    .own_metrics = own_metrics, .open = run_open, .close = run_close, .build = run_build, .describe = run_describe,
    .facts = run_facts, .samples = run_samples, .checked = run_checked, .sample_bytes = run_sample_bytes,
    .recipe = run_recipe, .weight = batch_weight, .sample_name = run_sample_name, .score = run_score,
    .measure = run_measure, .phase = run_phase, .groups = run_groups, .evaluate = body_evaluate_run,
    .scores = body_score_keys,
};
