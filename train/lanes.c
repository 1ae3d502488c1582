/* SPDX-License-Identifier: Apache-2.0 */
#include "train/lanes.h"

#include "libtensor/base/parallel.h"

/* A larger network's layers keep all threads busy by themselves, and its plan is no small thing to have twice. */
enum { SMALL_BYTES = 256 << 20 };

static lt_status compile(train_lane *lane, const train_config *c)
{
    return compiled_new(&lane->model, c->optim.batch / c->optim.shards, COMPILED_TRAIN, &lane->train);
}

static lt_status add_lane(train_lanes *l, const train_config *c, const lt_hand_layer *hand)
{
    train_lane *lane = &l->lane[l->n++];
    lt_status st;

    lane->params = lt_params_new();
    if (!lane->params)
        return lt_error(LT_ENOMEM, "no memory for the gradients of shard %d", l->n);
    st = train_config_model(c, hand, lane->params, &lane->model);
    if (st == LT_OK)
        st = lt_params_share(lane->params, l->lane[0].params);
    return st ? st : compile(lane, c);
}

static int lanes_that_help(const train_config *c, const train_lane *first)
{
    if (lt_plan_bytes(first->train.plan) > SMALL_BYTES)
        return 1;
    return (int)lt_min_i64(c->optim.shards, lt_threads());
}

lt_status lanes_new(lt_arena *arena, const train_config *c, const lt_hand_layer *hand, const train_lane *first,
                    train_lanes *out)
{
    lt_status st;
    int n;

    *out = (train_lanes){ .lane = lt_arena_array(arena, (size_t)c->optim.shards, sizeof(*out->lane)) };
    if (!out->lane)
        return lt_error(LT_ENOMEM, "no memory for %d shards", c->optim.shards);
    out->lane[out->n++] = *first;
    st = compile(&out->lane[0], c);
    n = st ? 0 : lanes_that_help(c, &out->lane[0]);
    while (st == LT_OK && out->n < n)
        st = add_lane(out, c, hand);
    return st;
}

void lanes_free(train_lanes *l)
{
    for (int i = 0; i < l->n; i++)
        compiled_free(&l->lane[i].train);
    for (int i = 1; i < l->n; i++)
        lt_params_free(l->lane[i].params);
    *l = (train_lanes){ .n = 0 };
}

size_t lanes_plan_bytes(const train_lanes *l)
{
    size_t n = 0;

    for (int i = 0; i < l->n; i++)
        n += lt_plan_bytes(l->lane[i].train.plan);
    return n;
}

size_t lanes_param_bytes(const train_lanes *l)
{
    size_t n = 0;

    for (int i = 1; i < l->n; i++)
        n += lt_arena_bytes(lt_params_arena(l->lane[i].params));
    return n;
}
