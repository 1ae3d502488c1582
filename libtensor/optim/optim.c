/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/optim/optim.h"

#include "libtensor/base/parallel.h"
#include "libtensor/graph/internal.h"
#include "libtensor/kernels/kernels.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 1 << 16 };           /* part of the norm's value: not a tuning knob */

typedef struct {
    lt_param *p;
    lt_real *m, *v, *ema;           /* v: Adam; ema: NULL without */
    const char *name[3];            /* of the three, in a checkpoint */
    int64_t first_chunk;
} slot;

struct lt_optim {
    lt_arena *arena;
    lt_params *set;
    lt_optim_opts opts;
    slot *slot;
    int n_slots;
    int64_t n_chunks, steps;
    double *partial;                /* of the norm, by chunk */
    int *slot_of;                   /* chunk -> slot */
};

static bool is_ours(const lt_param *p)
{
    return p->kind == LT_WEIGHT && p->grad && !p->frozen;
}

static lt_real *state_new(lt_optim *o, const lt_param *p, const char *what, const char **name)
{
    *name = lt_arena_printf(o->arena, "optim.%s.%s", what, p->name);
    return *name ? lt_arena_array(o->arena, (size_t)lt_param_numel(p), sizeof(lt_real)) : NULL;
}

static bool slot_init(lt_optim *o, slot *s, lt_param *p)
{
    s->p = p;
    s->m = state_new(o, p, "m", &s->name[0]);
    s->v = o->opts.kind == LT_SGD ? NULL : state_new(o, p, "v", &s->name[1]);
    s->ema = o->opts.ema_decay > 0 ? state_new(o, p, "ema", &s->name[2]) : NULL;
    s->first_chunk = o->n_chunks;
    o->n_chunks += lt_ceil_div(lt_param_numel(p), CHUNK);
    if (s->ema)
        memcpy(s->ema, p->data, (size_t)lt_param_numel(p) * sizeof(lt_real));
    return s->m && (s->v || o->opts.kind == LT_SGD) && (s->ema || !(o->opts.ema_decay > 0));
}

static bool fill(lt_optim *o, lt_params *set)
{
    int n = 0;

    for (lt_param *p = lt_params_first(set); p; p = p->next)
        n += is_ours(p);
    o->slot = lt_arena_array(o->arena, (size_t)n, sizeof(*o->slot));
    if (!o->slot)
        return false;
    for (lt_param *p = lt_params_first(set); p; p = p->next)
        if (is_ours(p) && !slot_init(o, &o->slot[o->n_slots++], p))
            return false;
    o->partial = lt_arena_array(o->arena, (size_t)o->n_chunks, sizeof(*o->partial));
    o->slot_of = lt_arena_array(o->arena, (size_t)o->n_chunks, sizeof(*o->slot_of));
    if (!o->partial || !o->slot_of)
        return false;
    for (int i = 0; i < o->n_slots; i++) {
        const int64_t end = i + 1 < o->n_slots ? o->slot[i + 1].first_chunk : o->n_chunks;

        for (int64_t k = o->slot[i].first_chunk; k < end; k++)
            o->slot_of[k] = i;
    }
    return true;
}

lt_optim *lt_optim_new(lt_params *set, const lt_optim_opts *opts)
{
    lt_arena *arena = lt_arena_new();
    lt_optim *o = arena ? lt_arena_alloc(arena, sizeof(*o)) : NULL;

    if (o) {
        o->arena = arena;
        o->set = set;
        o->opts = *opts;
        o->opts.beta1 = opts->beta1 > 0 ? opts->beta1 : 0.9;
        o->opts.beta2 = opts->beta2 > 0 ? opts->beta2 : 0.999;
        o->opts.eps = opts->eps > 0 ? opts->eps : 1e-8;
    }
    if (!o || !fill(o, set)) {
        lt_arena_free(arena);
        lt_error(LT_ENOMEM, "no memory for the optimiser's state");
        return NULL;
    }
    return o;
}

void lt_optim_free(lt_optim *o)
{
    if (o)
        lt_arena_free(o->arena);
}

/* ---- the norm ------------------------------------------------------------------------------------- */

/* Chunk k of all gradients: which slot, from where, how many. */
static const slot *chunk_of(const lt_optim *o, int64_t k, int64_t *at, size_t *n)
{
    const slot *s = &o->slot[o->slot_of[k]];

    *at = (k - s->first_chunk) * CHUNK;
    *n = (size_t)lt_min_i64(CHUNK, lt_param_numel(s->p) - *at);
    return s;
}

static void norm_chunk(void *ctx, int64_t k)
{
    const lt_optim *o = ctx;
    int64_t at;
    size_t n;
    const slot *s = chunk_of(o, k, &at, &n);

    o->partial[k] = s->p->frozen ? 0 : lt_k->sumsq(s->p->grad + at, n);
}

double lt_optim_grad_norm(const lt_optim *o)
{
    double sum = 0;

    lt_parallel_for(o->n_chunks, norm_chunk, (void *)o);
    for (int64_t k = 0; k < o->n_chunks; k++)
        sum += o->partial[k];
    return sqrt(sum);
}

/* ---- running statistics --------------------------------------------------------------------------- */

static void update_statistics(lt_params *set, int n)
{
    for (lt_param *p = lt_params_first(set); n > 0 && p; p = p->next) {
        const double batches = (double)n * (p->uses > 0 ? p->uses : 1);

        if (p->kind != LT_STATISTIC || !p->grad || p->frozen)
            continue;
        for (int64_t i = 0; i < lt_param_numel(p); i++) {
            p->data[i] += (lt_real)(p->momentum * (p->grad[i] / batches - p->data[i]));
            p->grad[i] = 0;
        }
    }
}

void lt_statistics_update(lt_params *set, int n)
{
    int in_grad;

    if (!lt_params_take_batches(set, &in_grad))
        return;
    update_statistics(set, n);
    lt_params_changed(set);
}

/* ---- the step ------------------------------------------------------------------------------------- */

typedef struct {
    lt_optim *o;
    lt_adam_step adam;
    lt_sgd_step sgd;
    lt_real keep;                   /* of the average, in this step */
} step_job;

/* Until ema_decay is reached, the average is over about the last tenth of the steps: weights of the beginning would
 * else stay in it for a few times 1 / (1 - ema_decay) steps. */
static double ema_keep(double ema_decay, double t)
{
    return fmin(ema_decay, t / (t + 9));
}

static void update_ema(const slot *s, int64_t at, size_t n, lt_real keep)
{
    for (size_t i = 0; i < n; i++) {
        lt_real *e = &s->ema[at + (int64_t)i];

        *e = keep * *e + (1 - keep) * s->p->data[at + (int64_t)i];
    }
}

static void step_chunk(void *ctx, int64_t k)
{
    const step_job *j = ctx;
    int64_t at;
    size_t n;
    const slot *s = chunk_of(j->o, k, &at, &n);
    lt_real *w = s->p->data + at;
    const lt_real rate = (lt_real)s->p->rate;
    lt_adam_step adam = j->adam;
    lt_sgd_step sgd = j->sgd;

    if (s->p->frozen)                   /* since the optimiser was made */
        return;
    adam.lr *= rate;
    sgd.lr *= rate;
    if (j->o->opts.kind == LT_SGD)
        lt_k->sgd(w, s->m + at, s->p->grad + at, &sgd, n);
    else
        lt_k->adam(w, s->m + at, s->v + at, s->p->grad + at, &adam, n);
    if (s->ema)
        update_ema(s, at, n, j->keep);
}

/* 1 - beta^t of the beta that the kernel has: 1 - 0.999f is not 0.001, by 1.3e-5 of it. */
static lt_real correction(double beta, double t)
{
    return (lt_real)(1 - pow((lt_real)beta, t));
}

void lt_optim_step(lt_optim *o, double lr, double norm)
{
    const lt_optim_opts *p = &o->opts;
    const double t = (double)++o->steps;
    int batches;
    const lt_real scale = (lt_real)(p->clip_norm > 0 && norm > p->clip_norm ? p->clip_norm / norm : 1);
    step_job j = {
        .o = o,
        .adam = {
            .lr = (lt_real)lr, .beta1 = (lt_real)p->beta1, .beta2 = (lt_real)p->beta2, .eps = (lt_real)p->eps,
            .l2 = (lt_real)(p->kind == LT_ADAM ? p->weight_decay : 0),
            .decay = (lt_real)(p->kind == LT_ADAMW ? p->weight_decay : 0),
            .correct1 = correction(p->beta1, t), .correct2 = correction(p->beta2, t),
            .grad_scale = scale,
        },
        .sgd = {
            .lr = (lt_real)lr, .momentum = (lt_real)p->momentum, .l2 = (lt_real)p->weight_decay,
            .grad_scale = scale, .nesterov = p->nesterov,
        },
        .keep = (lt_real)ema_keep(p->ema_decay, t),
    };

    lt_parallel_for(o->n_chunks, step_chunk, &j);
    if (lt_params_take_batches(o->set, &batches))
        update_statistics(o->set, batches);
    lt_params_changed(o->set);
}

int64_t lt_optim_steps(const lt_optim *o)
{
    return o->steps;
}

void lt_optim_set_steps(lt_optim *o, int64_t steps)
{
    o->steps = steps;
}

/* ---- state ---------------------------------------------------------------------------------------- */

static int per_slot(const lt_optim *o)
{
    return 1 + (o->opts.kind != LT_SGD) + (o->opts.ema_decay > 0);
}

int lt_optim_state_count(const lt_optim *o)
{
    return o->n_slots * per_slot(o);
}

lt_optim_state lt_optim_state_at(const lt_optim *o, int i)
{
    const slot *s = &o->slot[i / per_slot(o)];
    lt_real *const have[] = { s->m, s->v, s->ema };
    int k = 0;

    for (int skip = i % per_slot(o); !have[k] || skip; k++)
        skip -= have[k] != NULL;
    return (lt_optim_state){ s->name[k], have[k], s->p->shape };
}

static void swap_slot(void *ctx, int64_t i)
{
    const slot *s = &((const lt_optim *)ctx)->slot[i];

    for (int64_t k = 0; s->ema && k < lt_param_numel(s->p); k++) {
        const lt_real w = s->p->data[k];

        s->p->data[k] = s->ema[k];
        s->ema[k] = w;
    }
}

void lt_optim_swap_ema(lt_optim *o)
{
    lt_parallel_for(o->n_slots, swap_slot, o);
    lt_params_changed(o->set);
}
