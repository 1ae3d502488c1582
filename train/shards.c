/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shards of a step, of which each rank computes its own: their losses, and their gradients summed over the tree.
 */
#include "train/trainer_internal.h"

#include <stdlib.h>
#include <string.h>

void shards_free(trainer *t)
{
    tree_sum_free(t->sum);
    free(t->shard_loss);
    free(t->message);
    t->sum = NULL;
    t->shard_loss = NULL;
    t->message = NULL;
}

static int own_nodes(const trainer *t, tree_node out[TREE_NODES_MAX])
{
    int first, end;

    ranks_own(t->opt->ranks, t->phase.shards, &first, &end);
    return tree_nodes(first, end, out);
}

lt_status shards_new(trainer *t)
{
    const train_ranks *ranks = t->opt->ranks;
    tree_node node[TREE_NODES_MAX];
    int64_t n = 0;
    lt_real *observed = t->config.task->observed ? t->config.task->observed(t->run, &n) : NULL;

    shards_free(t);
    t->sum = tree_sum_new(t->params, observed, n, t->phase.shards);
    t->shard_loss = calloc((size_t)(t->phase.shards * t->train.parts), sizeof(*t->shard_loss));
    if (t->sum && ranks)
        t->message = malloc((size_t)own_nodes(t, node) * (size_t)tree_sum_room(t->sum) * sizeof(lt_real));
    if (!t->sum || !t->shard_loss || (ranks && !t->message))
        return lt_error(LT_ENOMEM, "no memory for the gradients of %d shards", t->phase.shards);
    return LT_OK;
}

/* Of a batch, the slots that this rank reads: those of its shards. Which rows a step moves depends on all of them. */
void shards_slots(const trainer *t, int *first, int *n)
{
    const int size = t->phase.batch / t->phase.shards;
    int end;

    ranks_own(t->config.task->rows ? NULL : t->opt->ranks, t->phase.shards, first, &end);
    *n = (end - *first) * size;
    *first *= size;
}

/* ---- one shard ------------------------------------------------------------------------------------------- */

static double value(const lt_plan *p, const lt_tensor *tensor)
{
    return *(const lt_real *)lt_plan_data(p, tensor);
}

/* Where the shard begins among the slots that are here. */
static int slot_of(const trainer *t, int shard)
{
    int first, n;

    shards_slots(t, &first, &n);
    return shard * t->train.parts * t->train.record.batch - first;
}

static shard_loss *losses_of(const trainer *t, int shard)
{
    return t->shard_loss + shard * t->train.parts;
}

/* Fill the plan with a shard and set what depends on it; false when no sample counts. */
static bool load_shard(trainer *t, const void *batch, int shard, double total)
{
    const compiled *c = &t->train;
    shard_loss *l = losses_of(t, shard);
    const int first = slot_of(t, shard);
    double share = 0;

    lt_plan_set_step(c->plan, t->state.seed, (uint64_t)(t->state.step * t->phase.shards + shard));
    for (int k = 0; k < c->parts; k++) {
        lt_plan *part = lt_plan_part(c->plan, k);

        l[k] = (shard_loss){ .share = c->by.feed(c->by.ctx, part, &c->record, batch, first, k, c->parts) / total };
        lt_plan_set_loss_weight(part, l[k].share);
        share += l[k].share;
    }
    return share > 0;
}

static void note_losses(trainer *t, int shard)
{
    const model_record *r = &t->train.record;
    shard_loss *l = losses_of(t, shard);

    for (int k = 0; k < t->train.parts; k++) {
        const lt_plan *part = lt_plan_part(t->train.plan, k);

        l[k].loss = value(part, r->loss);
        for (int i = 0; i < r->losses.n; i++)
            l[k].part[i] = value(part, r->losses.port[i].tensor);
    }
}

/* A shard without samples saw nothing. */
static void clear_observed(const trainer *t)
{
    int64_t n = 0;
    lt_real *x = t->config.task->observed ? t->config.task->observed(t->run, &n) : NULL;

    for (int64_t i = 0; i < n; i++)
        x[i] = 0;
}

static void run_shard(trainer *t, const void *batch, int shard, double total)
{
    const task *of = t->config.task;

    if (load_shard(t, batch, shard, total)) {
        lt_run(t->train.plan);
        note_losses(t, shard);
        if (of->observe)
            of->observe(t->run, &t->train, batch, slot_of(t, shard));
    } else {
        lt_params_zero_grad(t->params);
        clear_observed(t);
    }
    tree_sum_add(t->sum, (tree_node){ shard, 0 });
}

/* ---- all of them ----------------------------------------------------------------------------------------- */

static size_t bytes_of(const trainer *t, int shards)
{
    return (size_t)(shards * t->train.parts) * sizeof(shard_loss);
}

/* Rank 0, whose shards are the first ones: add what the others send behind them. */
static lt_status gather(trainer *t)
{
    const train_ranks *r = t->opt->ranks;
    tree_node node[TREE_NODES_MAX];
    lt_status st = LT_OK;

    for (int from = 1; from < r->size && st == LT_OK; from++) {
        const size_t bytes = (size_t)tree_sum_numel(t->sum) * sizeof(lt_real);
        int first, end, n;

        ranks_own(&(train_ranks){ .rank = from, .size = r->size }, t->phase.shards, &first, &end);
        n = tree_nodes(first, end, node);
        st = r->receive(r->ctx, from, losses_of(t, first), bytes_of(t, end - first));
        for (int k = 0; k < n && st == LT_OK; k++) {
            st = r->receive(r->ctx, from, t->message, bytes);
            tree_sum_unpack(t->sum, t->message);
            tree_sum_add(t->sum, node[k]);
        }
    }
    tree_sum_pack(t->sum, t->message);
    return st;
}

/* Another rank: sums of whole subtrees, sent when all are there, as rank 0 is busy till then. */
static lt_status contribute(trainer *t, const void *batch, double total)
{
    const train_ranks *r = t->opt->ranks;
    const size_t numel = (size_t)tree_sum_numel(t->sum);
    tree_node node[TREE_NODES_MAX];
    const int n = own_nodes(t, node);
    int first, end;
    lt_status st;

    for (int k = 0; k < n; k++) {
        const int last = node[k].first + (1 << node[k].level);

        tree_sum_begin(t->sum, node[k].first, last);
        for (int s = node[k].first; s < last; s++)
            run_shard(t, batch, s, total);
        tree_sum_pack(t->sum, t->message + (size_t)k * numel);
    }
    ranks_own(r, t->phase.shards, &first, &end);
    st = r->send(r->ctx, 0, losses_of(t, first), bytes_of(t, end - first));
    for (int k = 0; k < n && st == LT_OK; k++)
        st = r->send(r->ctx, 0, t->message + (size_t)k * numel, numel * sizeof(lt_real));
    return st;
}

static lt_status sum_shards(trainer *t, const void *batch, double total)
{
    const train_ranks *r = t->opt->ranks;
    lt_status st = LT_OK;
    int first, end;

    ranks_own(r, t->phase.shards, &first, &end);
    tree_sum_begin(t->sum, 0, t->phase.shards);
    if (!ranks_lead(r))
        st = contribute(t, batch, total);
    for (int s = 0; ranks_lead(r) && s < end; s++)
        run_shard(t, batch, s, total);
    if (!r)
        return LT_OK;
    if (ranks_lead(r))
        st = gather(t);
    if (st == LT_OK)
        st = ranks_tell(r, t->shard_loss, bytes_of(t, t->phase.shards));
    if (st == LT_OK)
        st = ranks_tell(r, t->message, (size_t)tree_sum_numel(t->sum) * sizeof(lt_real));
    if (st == LT_OK)
        tree_sum_unpack(t->sum, t->message);
    return st;
}

/* Losses into the record, in the shards' order; the number of shards with samples */
static int add_losses(trainer *t)
{
    int ran = 0;

    for (int s = 0; s < t->phase.shards; s++) {
        const shard_loss *l = losses_of(t, s);
        double share = 0;

        for (int k = 0; k < t->train.parts; k++)
            share += l[k].share;
        for (int k = 0; k < t->train.parts && share > 0; k++) {
            t->record.loss += l[k].share * l[k].loss;
            for (int i = 0; i < t->train.record.losses.n; i++)
                t->record.part[i] += l[k].share * l[k].part[i];
        }
        ran += share > 0;
    }
    return ran;
}

lt_status shards_run(trainer *t, const void *batch, double total, int *ran)
{
    const lt_status st = sum_shards(t, batch, total);

    if (st == LT_OK)
        *ran = add_losses(t);
    return st;
}

/* Run the shards again, tensor by tensor, until one is not finite. */
lt_status shards_find_culprit(trainer *t, const void *batch, double total, char where[SHARDS_WHERE])
{
    const train_ranks *r = t->opt->ranks;
    char (*all)[SHARDS_WHERE] = calloc((size_t)(r ? r->size : 1), sizeof(*all));
    lt_status st = all ? LT_OK : lt_error(LT_ENOMEM, "no memory to look for what is not finite");
    int first, end;

    memset(where, 0, SHARDS_WHERE);
    ranks_own(r, t->phase.shards, &first, &end);
    for (int s = first; s < end && !where[0]; s++)
        if (load_shard(t, batch, s, total))
            lt_plan_find_nonfinite(t->train.plan, where, SHARDS_WHERE);
    if (st == LT_OK)
        st = ranks_share(r, where, SHARDS_WHERE, all);
    for (int i = 0; st == LT_OK && !where[0] && i < (r ? r->size : 1); i++)
        memcpy(where, all[i], SHARDS_WHERE);
    if (!where[0])
        snprintf(where, SHARDS_WHERE, "the sum of the shards' gradients");
    free(all);
    return st;
}
