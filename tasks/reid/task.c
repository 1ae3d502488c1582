/* SPDX-License-Identifier: Apache-2.0 */
/* Who is who, learnt from boxes in films: what the trainer asks. */
#include "tasks/reid/task.h"

#include "libtensor/io/file.h"
#include "models/reid/reid.h"
#include "tasks/reid/evaluate.h"
#include "tasks/reid/looks.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

enum { CHECKED_EVERY = 10, PIXELS = 3 * REID_HEIGHT * REID_WIDTH };

struct task_run {
    lt_arena *arena;
    const train_config *config;
    looks train, evaluation;        /* the second: no looks where nothing is validated */
    look_feed feed, check_feed;
    model *model;
};

/* ---- opening ---- */

/* As many as there are, where the configuration leaves it open */
static lt_status set_identities(train_config *c, const looks *l)
{
    cJSON *item = cJSON_GetObjectItemCaseSensitive(c->model_keys, "identities");
    const double n = cJSON_IsNumber(item) ? item->valuedouble : 0;

    if (n >= l->identities)
        return LT_OK;
    if (n > 0)
        return lt_error(LT_EINVAL, "%s: model.identities: %g, but %s has %d: leave it out", c->path, n, l->set.root,
                        l->identities);
    cJSON_DeleteItemFromObjectCaseSensitive(c->model_keys, "identities");
    return cJSON_AddNumberToObject(c->model_keys, "identities", l->identities)
        ? LT_OK : lt_error(LT_ENOMEM, "no memory to begin");
}

static bool validates(const train_config *c)
{
    return c->loop.validate_every > 0 || c->loop.validate_steps > 0;
}

static lt_status run_open(lt_arena *arena, train_config *c, task_run **out)
{
    task_run *r = lt_arena_alloc(arena, sizeof(*r));
    const reid_data_config *how = reid_data_of(c);
    lt_status st;

    *out = r;
    if (!r)
        return lt_error(LT_ENOMEM, "no memory to begin");
    r->arena = arena;
    r->config = c;
    if (!*c->data->dir)
        return lt_error(LT_EUSAGE, "%s: data.dir: no dataset given; name its folder with --data or --set "
                        "data.dir=FOLDER", c->path);
    st = looks_open(arena, c->data->dir, "train", how->every, how->visible, &r->train);
    if (!st && validates(c))
        st = looks_open(arena, c->data->dir, "evaluation", CHECKED_EVERY, how->visible, &r->evaluation);
    if (!st)
        st = set_identities(c, &r->train);
    if (st)
        return st;
    c->data->dir = lt_path_whole(arena, c->data->dir);
    return c->data->dir ? LT_OK : lt_error(LT_ENOMEM, "no memory to begin");
}

static void run_close(task_run *r)
{
    (void)r;                        /* all of it is in the arena */
}

static lt_status run_build(task_run *r, const train_config *c, lt_params *set, model *out)
{
    r->model = out;
    r->feed = (look_feed){ .of = &r->train, .how = reid_data_of(c), .seed = (uint64_t)c->loop.seed,
                           .count = r->train.n };
    r->check_feed = (look_feed){ .of = &r->evaluation,
                                 .count = lt_min_i64(r->evaluation.n, c->loop.validate_samples) };
    return train_config_model(c, NULL, set, out);
}

static void describe_looks(const looks *l, const char *what, train_progress *p)
{
    progress_note(p, "%-13sMOTChallenge%s, %s: %lld boxes of %d identities in %d sequences", what,
                  l->set.synthetic ? " (synthetic)" : "", l->set.root, (long long)l->n, l->identities, l->set.n);
}

static void run_describe(const task_run *r, train_progress *p)
{
    describe_looks(&r->train, "data", p);
    if (r->evaluation.n)
        describe_looks(&r->evaluation, "validation", p);
}

static void run_facts(const task_run *r, cJSON *env)
{
    cJSON_AddStringToObject(env, "data", "MOTChallenge");
    cJSON_AddBoolToObject(env, "synthetic_data", r->train.set.synthetic);
}

/* ---- batches ---- */

static loader_source run_samples(const task_run *r)
{
    return look_source(&r->feed);
}

static loader_source run_checked(const task_run *r)
{
    return look_source(&r->check_feed);
}

static size_t run_sample_bytes(const task_run *r)
{
    (void)r;
    return PIXELS * sizeof(float);
}

static double batch_weight(const void *batch)
{
    const look_batch *b = batch;
    double sum = 0;

    for (int i = 0; i < b->count; i++)
        sum += b->there[i];
    return sum;
}

static const char *run_sample_name(const task_run *r, const void *batch, int i)
{
    const look_batch *b = batch;

    return i < b->count ? r->train.set.sequence[r->train.look[b->index[i]].sequence].name : NULL;
}

/* ---- the graph ---- */

static lt_status record_training(const void *ctx, model_record *r)
{
    reid_class.record(((const task_run *)ctx)->model, true, r);
    return LT_OK;
}

/* Who is validated was never learnt: there is no loss. */
static lt_status record_validation(const void *ctx, model_record *r)
{
    reid_class.record(((const task_run *)ctx)->model, false, r);
    return LT_OK;
}

static lt_real *input(const lt_plan *p, const model_record *r, const char *name)
{
    const lt_tensor *t = model_port_find(&r->inputs, name);

    return t ? lt_plan_data(p, t) : NULL;
}

/* A place without a sample has one that is there, for batch norm, and counts for nothing. */
static double feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch, int first, int part,
                   int n)
{
    const task_run *run = ctx;
    const look_batch *b = batch;
    const int identities = reid_identities(run->model);
    lt_real *image = input(p, r, "image"), *target = input(p, r, "identity"), *weight = input(p, r, "weight");
    double sum = 0;

    (void)part, (void)n;
    if (target)
        memset(target, 0, (size_t)r->batch * (size_t)identities * sizeof(*target));
    for (int i = 0; i < r->batch && b->count; i++) {
        const bool there = first + i < b->count && b->there[first + i];
        int from = there ? first + i : 0;

        while (!there && from + 1 < b->count && !b->there[from])
            from++;
        memcpy(image + (size_t)i * PIXELS, b->image + (size_t)from * PIXELS, PIXELS * sizeof(*image));
        if (target)
            target[i * identities + run->train.look[b->index[from]].identity] = 1;
        if (weight)
            weight[i] = there;
        sum += there;
    }
    return sum;
}

static recipe run_recipe(const task_run *r, const task_phase *phase)
{
    return (recipe){ .ctx = r, .record = phase ? record_training : record_validation, .feed = feed };
}

/* ---- scores ---- */

typedef struct {
    int64_t frame;
    int sequence, identity;
    lt_real embedding[REID_EMBEDDING];
} seen;

static lt_status run_score(task_run *r, const compiled *c, const void *batch, records *out, bool *no_losses)
{
    const look_batch *b = batch;
    const lt_real *embedding = compiled_output(c, "embedding");
    lt_status st = LT_OK;

    *no_losses = true;
    for (int i = 0; !st && i < b->count; i++) {
        const look *l = &r->evaluation.look[b->index[i]];
        seen s = { .frame = l->frame, .sequence = l->sequence, .identity = l->identity };

        if (!b->there[i])
            continue;
        memcpy(s.embedding, embedding + (size_t)i * REID_EMBEDDING, sizeof(s.embedding));
        st = records_add(out, b->index[i], &s, sizeof(s));
    }
    return st;
}

static double similarity(const lt_real *a, const lt_real *b)
{
    double sum = 0;

    for (int k = 0; k < REID_EMBEDDING; k++)
        sum += (double)a[k] * b[k];
    return sum;
}

/* Whether of all boxes of other frames the one that looks most alike is the same thing. Persons meet persons, hands
 * hands, as trackers have classes. */
static bool recognised(const task_run *r, const records *all, const seen *mine)
{
    const bool person = looks_person(&r->evaluation.set.sequence[mine->sequence]);
    double most = -2;
    bool same = false;

    for (int64_t i = 0; i < all->n; i++) {
        seen other;
        double alike;

        memcpy(&other, records_at(all, i, NULL), sizeof(other));
        if ((other.sequence == mine->sequence && other.frame == mine->frame) ||
            looks_person(&r->evaluation.set.sequence[other.sequence]) != person)
            continue;
        alike = similarity(mine->embedding, other.embedding);
        if (alike > most) {
            most = alike;
            same = other.identity == mine->identity;
        }
    }
    return same;
}

static void run_measure(task_run *r, const records *all, double *out)
{
    int64_t right = 0;

    for (int64_t i = 0; i < all->n; i++) {
        seen mine;

        memcpy(&mine, records_at(all, i, NULL), sizeof(mine));
        right += recognised(r, all, &mine);
    }
    out[0] = all->n ? (double)right / (double)all->n : NAN;
}

static const char *const metrics[] = { "rank1", NULL };
static const metric own_metrics[] = {
    { "rank1", "rank-1", "", true, "share of boxes whose most alike box of another frame is of the same identity",
      "Wojke and Bewley 2018" },
    { .key = NULL },
};

const task reid_task = {
    .name = "reid", .data_size = sizeof(reid_data_config), .data_keys = reid_data_keys, .metrics = metrics,
    .own_metrics = own_metrics, .open = run_open, .close = run_close, .build = run_build, .describe = run_describe,
    .facts = run_facts, .samples = run_samples, .checked = run_checked, .sample_bytes = run_sample_bytes,
    .recipe = run_recipe, .weight = batch_weight, .sample_name = run_sample_name, .score = run_score,
    .measure = run_measure, .evaluate = reid_evaluate_run, .scores = track_score_keys,
};
