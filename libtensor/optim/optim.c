/* SPDX-License-Identifier: Apache-2.0 */
/* Optimisers made: which weight is in which group, and memory for what is remembered of it. */
#include "libtensor/optim/internal.h"

#include <string.h>

enum { CHUNK = 1 << 16 };           /* part of the norm's value: not a tuning knob */

/* ---- groups ------------------------------------------------------------------------------------------- */

static bool begins_with(const char *name, const char *prefix)
{
    return strncmp(name, prefix, strlen(prefix)) == 0;
}

static bool ends_with(const char *name, const char *suffix)
{
    const size_t n = strlen(name), k = strlen(suffix);

    return n >= k && strcmp(name + n - k, suffix) == 0;
}

static bool any(const char *const *list, const char *name, bool (*fits)(const char *, const char *))
{
    for (; list && *list; list++)
        if (fits(name, *list))
            return true;
    return false;
}

/* -1: none */
static int group_of(const lt_optim *o, const char *name)
{
    for (int k = 0; k < o->n_groups; k++) {
        const lt_optim_group *g = &o->group[k].recipe;

        if ((!g->prefix || any(g->prefix, name, begins_with)) && (!g->suffix || any(g->suffix, name, ends_with)))
            return k;
    }
    return -1;
}

static bool decays(const lt_optim_group *g, const lt_param *p)
{
    return p->shape.rank >= g->decay_rank && !any(g->no_decay, p->name, ends_with);
}

static lt_optim_group with_defaults(const lt_optim_group *from)
{
    lt_optim_group g = *from;

    g.beta1 = g.beta1 > 0 ? g.beta1 : 0.9;
    g.beta2 = g.beta2 > 0 ? g.beta2 : 0.999;
    g.eps = g.eps > 0 ? g.eps : 1e-8;
    return g;
}

void lt_optim_set_group(lt_optim *o, int k, const lt_optim_group *group)
{
    lt_optim_group *g = &o->group[k].recipe;
    const lt_optim_group was = *g;

    *g = with_defaults(group);
    g->name = was.name;
    g->kind = was.kind;
    for (int i = 0; i < o->n_slots; i++)
        if (o->slot[i].group == k)
            o->slot[i].decays = decays(g, o->slot[i].p);
}

static lt_status check_groups(const lt_optim_group *group, int n)
{
    if (n < 1 || n > LT_OPTIM_GROUPS)
        return lt_error(LT_EINVAL, "an optimiser of %d groups, want 1 to %d", n, LT_OPTIM_GROUPS);
    for (int k = 0; k < n; k++) {
        if (!group[k].name || !*group[k].name)
            return lt_error(LT_EINVAL, "group %d of an optimiser has no name", k);
        for (int i = 0; i < k; i++)
            if (strcmp(group[i].name, group[k].name) == 0)
                return lt_error(LT_EINVAL, "two groups of an optimiser are \"%s\"", group[k].name);
    }
    return LT_OK;
}

/* ---- what is remembered ------------------------------------------------------------------------------- */

static bool is_moved(const lt_param *p)
{
    return p->kind == LT_WEIGHT && p->grad && !p->frozen;
}

static bool is_averaged(const lt_optim *o, const lt_param *p)
{
    return o->average.decay > 0 && o->average.statistics && p->kind == LT_STATISTIC && p->grad;
}

static bool array_init(lt_optim *o, const optim_slot *s, lt_row_array *a, int64_t width)
{
    a->width = width;
    if (s->p->rows)
        return lt_param_attach(s->p, a) == LT_OK;
    a->data = lt_arena_array(o->arena, (size_t)lt_param_numel(s->p), sizeof(lt_real));
    return a->data;
}

static bool slot_init(lt_optim *o, optim_slot *s)
{
    const int64_t width = lt_param_width(s->p);
    const bool adam = o->group[s->group].recipe.kind != LT_SGD && !optim_by_muon(o, s);
    const bool average = o->average.decay > 0;

    s->decays = decays(&o->group[s->group].recipe, s->p);
    s->ema.keeps = s->clock.keeps = true;
    if (!array_init(o, s, &s->m, width) || (adam && !array_init(o, s, &s->v, width))
        || (average && !array_init(o, s, &s->ema, width)) || (s->p->rows && !array_init(o, s, &s->clock, 1)))
        return false;
    if (average)
        memcpy(s->ema.data, s->p->data, (size_t)lt_param_numel(s->p) * sizeof(lt_real));
    s->first_chunk = o->n_chunks;
    s->n_chunks = s->p->rows ? 0 : lt_ceil_div(lt_param_numel(s->p), CHUNK);
    o->n_chunks += s->n_chunks;
    return true;
}

static bool statistic_init(lt_optim *o, optim_statistic *s, lt_param *p)
{
    const size_t n = (size_t)lt_param_numel(p);

    s->p = p;
    s->ema = lt_arena_array(o->arena, n, sizeof(lt_real));
    if (s->ema)
        memcpy(s->ema, p->data, n * sizeof(lt_real));
    return s->ema;
}

static bool chunks_init(lt_optim *o)
{
    o->partial = lt_arena_array(o->arena, (size_t)o->n_chunks, sizeof(*o->partial));
    o->slot_of = lt_arena_array(o->arena, (size_t)o->n_chunks, sizeof(*o->slot_of));
    if (!o->partial || !o->slot_of)
        return false;
    for (int i = 0; i < o->n_slots; i++)
        for (int64_t k = 0; k < o->slot[i].n_chunks; k++)
            o->slot_of[o->slot[i].first_chunk + k] = i;
    return true;
}

/* Matrices go one after the other, each on all threads. */
static bool scratch_init(lt_optim *o)
{
    int64_t most = 0;

    for (int i = 0; i < o->n_slots; i++)
        if (optim_by_muon(o, &o->slot[i]))
            most = lt_max_i64(most, optim_muon_scratch(o->slot[i].p));
    if (most > 0)
        o->scratch = lt_arena_array(o->arena, (size_t)most, sizeof(*o->scratch));
    return most == 0 || o->scratch;
}

static lt_status fill(lt_optim *o)
{
    int moved = 0, averaged = 0;
    bool ok;

    for (lt_param *p = lt_params_first(o->set); p; p = p->next) {
        moved += is_moved(p);
        averaged += is_averaged(o, p);
    }
    o->slot = lt_arena_array(o->arena, (size_t)moved, sizeof(*o->slot));
    o->statistic = lt_arena_array(o->arena, (size_t)averaged, sizeof(*o->statistic));
    ok = o->slot && o->statistic;
    for (lt_param *p = lt_params_first(o->set); ok && p; p = p->next) {
        if (is_moved(p)) {
            optim_slot *s = &o->slot[o->n_slots++];

            s->p = p;
            s->group = group_of(o, p->name);
            if (s->group < 0)
                return lt_error(LT_EINVAL, "parameter \"%s\" is in no group of the optimiser; name it in one, or "
                                "freeze it", p->name);
            ok = slot_init(o, s);
        } else if (is_averaged(o, p)) {
            ok = statistic_init(o, &o->statistic[o->n_statistics++], p);
        }
    }
    return ok && chunks_init(o) && scratch_init(o) && optim_list(o) ? LT_OK
                                                 : lt_error(LT_ENOMEM, "no memory for the optimiser's state");
}

static lt_optim *new_optim(lt_params *set, const lt_optim_group *group, int n, const lt_optim_average *average,
                           bool one_recipe)
{
    lt_arena *arena = lt_arena_new();
    lt_optim *o = arena ? lt_arena_alloc(arena, sizeof(*o)) : NULL;
    optim_group *groups = o ? lt_arena_array(arena, (size_t)n, sizeof(*groups)) : NULL;

    if (!groups) {
        lt_arena_free(arena);
        lt_error(LT_ENOMEM, "no memory for the optimiser's state");
        return NULL;
    }
    *o = (lt_optim){ .arena = arena, .set = set, .group = groups, .n_groups = n, .one_recipe = one_recipe };
    if (average)
        o->average = *average;
    for (int k = 0; k < n; k++)
        o->group[k].recipe = with_defaults(&group[k]);
    if (fill(o)) {
        lt_optim_free(o);
        return NULL;
    }
    return o;
}

lt_optim *lt_optim_new(lt_params *set, const lt_optim_opts *opts)
{
    const lt_optim_group all = {
        .name = "", .kind = opts->kind, .beta1 = opts->beta1, .beta2 = opts->beta2, .eps = opts->eps,
        .momentum = opts->momentum, .nesterov = opts->nesterov, .weight_decay = opts->weight_decay,
        .clip_norm = opts->clip_norm,
    };

    return new_optim(set, &all, 1, &(lt_optim_average){ .decay = opts->ema_decay }, true);
}

lt_optim *lt_optim_new_groups(lt_params *set, const lt_optim_group *group, int n, const lt_optim_average *average)
{
    return check_groups(group, n) ? NULL : new_optim(set, group, n, average, false);
}

void lt_optim_free(lt_optim *o)
{
    if (!o)
        return;
    for (int i = 0; i < o->n_slots; i++) {
        optim_slot *s = &o->slot[i];
        lt_row_array *const array[] = { &s->m, &s->v, &s->ema, &s->clock };

        for (size_t k = 0; s->p->rows && k < LT_COUNT(array); k++)
            lt_param_detach(s->p, array[k]);
    }
    lt_arena_free(o->arena);
}

const optim_slot *optim_chunk(const lt_optim *o, int64_t k, int64_t *at, size_t *n)
{
    const optim_slot *s = &o->slot[o->slot_of[k]];

    *at = (k - s->first_chunk) * CHUNK;
    *n = (size_t)lt_min_i64(CHUNK, lt_param_numel(s->p) - *at);
    return s;
}
