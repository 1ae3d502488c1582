/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Builds a run up to its first batch.
 */
#include "train/trainer_internal.h"

#include "estimate/checkpoint/folder.h"
#include "libtensor/base/resident.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- configuration ------------------------------------------------------------------------------------ */

static lt_status load_config(trainer *t)
{
    const train_options *o = t->opt;
    const char *own = lt_path_join(t->arena, o->out, "config.json"), *from;
    checkpoint_head head;
    lt_status st;

    if (o->config)
        return train_config_load(t->arena, o->tasks, o->config, o->set, o->n_set, &t->config);
    if (!o->resume)
        return lt_error(LT_EINVAL, "no configuration given");
    if (!own)
        return lt_error(LT_ENOMEM, "%s: no memory", o->out);
    if (!*o->resume || access(own, R_OK) == 0)
        return train_config_load(t->arena, o->tasks, own, o->set, o->n_set, &t->config);
    from = checkpoint_last(t->arena, o->resume);
    st = from ? checkpoint_head_read(t->arena, from, &head) : lt_error(LT_ENOMEM, "%s: no memory", o->resume);
    return st ? st : train_config_parse(t->arena, o->tasks, from, head.config, o->set, o->n_set, &t->config);
}

/* The resolved configuration as one line, the same for the same settings. */
static lt_status print_config(trainer *t)
{
    cJSON *tree = train_config_json(&t->config, &t->model);
    char *text = NULL;
    size_t n = 0;
    FILE *f = tree ? open_memstream(&text, &n) : NULL;

    if (f) {
        lt_json_print(f, tree);
        fclose(f);
        t->config_text = text ? lt_arena_strdup(t->arena, text) : NULL;
        free(text);
    }
    cJSON_Delete(tree);
    return t->config_text ? LT_OK : lt_error(LT_ENOMEM, "no memory for the configuration");
}

/* ---- model and plans ---------------------------------------------------------------------------------- */

static lt_optim_opts optim_opts(const train_optim_config *o)
{
    return (lt_optim_opts){
        .kind = (lt_optim_kind)o->kind, .beta1 = o->beta1, .beta2 = o->beta2, .eps = o->eps,
        .momentum = o->momentum, .nesterov = o->nesterov, .weight_decay = o->weight_decay,
        .clip_norm = o->clip_norm, .ema_decay = o->ema_decay,
    };
}

static void tell_weights(trainer *t, lt_arena *arena, const weights_report *r)
{
    progress_note(&t->progress, "init         %s: %s, names of %s; %d parameters loaded", t->opt->init, r->format,
                  r->family, r->n_loaded);
    if (*r->taken)
        progress_note(&t->progress, "  taken      what stands behind \"%s\"", r->taken);
    if (r->n_also)
        progress_note(&t->progress, "  not taken  what fits as well, behind: %s",
                      weights_list(arena, r->also, r->n_also));
    progress_note(&t->progress, "  not in it  %d: %s", r->n_missing, weights_list(arena, r->missing, r->n_missing));
    progress_note(&t->progress, "  left over  %d: %s", r->n_left_over,
                  weights_list(arena, r->left_over, r->n_left_over));
    if (r->note)
        progress_note(&t->progress, "  mind       %s", r->note);
}

static lt_status init_weights(trainer *t)
{
    lt_arena *arena;
    weights_report report;
    lt_status st;

    if (!t->opt->init)
        return LT_OK;
    arena = lt_arena_new();
    st = arena ? weights_init(arena, t->opt->init, &t->model, &report)
               : lt_error(LT_ENOMEM, "%s: no memory", t->opt->init);
    if (st == LT_OK)
        tell_weights(t, arena, &report);
    lt_arena_free(arena);
    return st;
}

/* The values of a run that goes on come from a checkpoint. One that is named may be anybody's, and its shapes are
 * looked at before memory is taken; but not where parameters grow, which then have the shapes of the checkpoint. */
static lt_status check_resumed(trainer *t)
{
    const char *named = *t->opt->resume ? checkpoint_last(t->arena, t->opt->resume) : "";
    const lt_status st = !named ? lt_error(LT_ENOMEM, "%s: no memory", t->opt->resume)
        : *named && !t->config.task->load ? checkpoint_check(named, &t->model) : LT_OK;

    return st ? st : lt_params_allocate(t->params);
}

static lt_status build_model(trainer *t)
{
    lt_status st;

    t->params = lt_params_new();
    if (!t->params)
        return lt_error(LT_ENOMEM, "no memory for the model");
    st = t->config.task->build(t->run, &t->config, t->params, &t->model);
    if (st == LT_OK)
        st = t->opt->resume ? check_resumed(t) : train_config_init(&t->config, &t->model);
    if (st == LT_OK)
        st = init_weights(t);
    if (st == LT_OK)
        st = print_config(t);
    return st;
}

/* A run of phases is as long as they are. */
static int64_t steps_of_phases(const trainer *t)
{
    task_phase p = t->config.task->phase(t->run, 0);

    while (p.until < t->config.task->phase(t->run, p.until).until)
        p = t->config.task->phase(t->run, p.until);
    return p.until;
}

static void count_steps(trainer *t)
{
    const train_optim_config *o = &t->config.optim;

    t->steps_of_epoch = lt_ceil_div(t->samples.count, o->batch);
    t->total_steps = t->config.task->phase ? steps_of_phases(t) : t->steps_of_epoch * o->epochs;
    if (o->steps)
        t->total_steps = lt_min_i64(t->total_steps, o->steps);
}

/* ---- phases ------------------------------------------------------------------------------------------- */

static task_phase phase_of(const trainer *t, int64_t step)
{
    const train_optim_config *o = &t->config.optim;
    task_phase p = { .batch = o->batch, .shards = o->shards, .until = t->total_steps };

    if (t->config.task->phase)
        p = t->config.task->phase(t->run, step);
    p.until = lt_min_i64(p.until, t->total_steps);
    return p;
}

static lt_status check_ranks(const trainer *t, const task_phase *p)
{
    const train_ranks *r = t->opt->ranks;

    if (!r || r->size <= p->shards)
        return LT_OK;
    if (p->name)
        return lt_error(LT_EINVAL, "%d ranks, and a batch of phase %s has %d shard%s: some ranks would have nothing to "
                        "do", r->size, p->name, p->shards, p->shards > 1 ? "s" : "");
    return lt_error(LT_EINVAL, "%d ranks, and optim.shards is %d: some ranks would have nothing to do; raise "
                    "optim.shards, or start fewer", r->size, p->shards);
}

static lt_status compile_phase(trainer *t, const task_phase *p)
{
    const recipe how = t->config.task->recipe(t->run, p);
    lt_status st = check_ranks(t, p);

    if (st)
        return st;
    compiled_free(&t->train);
    st = compiled_new(&how, p->batch / p->shards, true, &t->train);
    t->phase = *p;
    return st;
}

static lt_status compile_check(trainer *t, const task_phase *p)
{
    const recipe how = t->config.task->recipe(t->run, NULL);

    compiled_free(&t->check);
    return t->checked.count ? compiled_new(&how, p->batch / p->shards, false, &t->check) : LT_OK;
}

static bool same_plans(const task_phase *a, const task_phase *b)
{
    return a->batch == b->batch && a->shards == b->shards && a->groups == b->groups && a->shape == b->shape;
}

/* Behind the last step a validation may still come. */
lt_status trainer_enter(trainer *t)
{
    const task_phase was = t->phase;
    const task_phase p = phase_of(t, lt_min_i64(t->state.step, t->total_steps - 1));
    lt_status st;

    t->phase.until = p.until;
    if (same_plans(&p, &was))
        return LT_OK;
    if (p.name && (!was.name || strcmp(p.name, was.name)))
        progress_note(&t->progress, "phase        %s, from step %" PRId64, p.name, t->state.step + 1);
    t->log.n_norms = 0;                         /* what is usual was another phase's */
    lt_params_zero_grad(t->params);
    st = compile_phase(t, &p);
    if (st == LT_OK)
        st = compile_check(t, &p);
    return st ? st : shards_new(t);
}

static lt_optim *optim_new(trainer *t)
{
    const lt_optim_opts opts = optim_opts(&t->config.optim);
    lt_optim_average average = { 0 };
    const lt_optim_group *group;
    int n;

    if (!t->config.task->groups)
        return lt_optim_new(t->params, &opts);
    group = t->config.task->groups(t->run, &n, &average);
    return lt_optim_new_groups(t->params, group, n, average.decay > 0 ? &average : NULL);
}

/* The first phase's plans last, after those of all others: what any of them reaches the optimiser knows of. */
static lt_status compile_plans(trainer *t)
{
    task_phase first = phase_of(t, 0), p = first;
    lt_status st = LT_OK;

    while (st == LT_OK && p.until < t->total_steps) {
        p = phase_of(t, p.until);
        st = compile_phase(t, &p);
    }
    if (st == LT_OK)
        st = compile_phase(t, &first);
    if (st == LT_OK)
        st = compile_check(t, &first);
    if (st == LT_OK)
        st = shards_new(t);
    if (st)
        return st;
    t->optim = optim_new(t);
    return t->optim ? LT_OK : LT_ENOMEM;
}

lt_status trainer_init(trainer *t, const train_options *o)
{
    lt_status st;

    *t = (trainer){ .opt = o, .saved_step = -1, .locked = -1, .state = { .best = INFINITY } };
    progress_init(&t->progress, o->progress ? o->progress : stderr, o->quiet || !ranks_lead(o->ranks));
    t->arena = lt_arena_new();
    t->checkpoints = t->arena ? lt_path_join(t->arena, o->out, "checkpoints") : NULL;
    if (!t->checkpoints)
        return lt_error(LT_ENOMEM, "no memory to begin");
    st = run_folder_lock(t);
    if (st == LT_OK)
        st = load_config(t);
    if (st == LT_OK)
        st = forecast_task(t);
    if (st == LT_OK)
        st = t->config.task->open(t->arena, &t->config, &t->run);
    t->resident = lt_resident();                /* the program, and what it knows of the data */
    if (st == LT_OK)
        st = build_model(t);
    if (st)
        return st;
    t->state.seed = (uint64_t)t->config.loop.seed;
    t->samples = t->config.task->samples(t->run);
    t->checked = t->config.task->checked(t->run);
    count_steps(t);
    return compile_plans(t);
}

void trainer_fini(trainer *t)
{
    loader_free(t->loader);
    if (t->locked >= 0)
        close(t->locked);
    train_log_close(&t->log);
    lt_optim_free(t->optim);
    shards_free(t);
    compiled_free(&t->train);
    compiled_free(&t->check);
    lt_params_free(t->params);
    if (t->run)
        t->config.task->close(t->run);
    train_config_fini(&t->config);
    progress_fini(&t->progress);
    lt_arena_free(t->arena);
}
