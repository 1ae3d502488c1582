/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Optimisers, gradient clipping, an average of the weights, running statistics and schedules.
 */
#ifndef LT_OPTIM_OPTIM_H
#define LT_OPTIM_OPTIM_H

#include "libtensor/graph/param.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LT_SGD,                         /* Nesterov momentum where nesterov is set; weight decay coupled */
    LT_ADAM,                        /* coupled L2: gradient + weight_decay * w   [Kingma and Ba 2015] */
    LT_ADAMW,                       /* decoupled weight decay           [Loshchilov and Hutter 2019] */
} lt_optim_kind;

typedef struct {
    lt_optim_kind kind;
    double beta1, beta2, eps;       /* 0: 0.9, 0.999, 1e-8 */
    double momentum;                /* of LT_SGD */
    bool nesterov;
    double weight_decay;
    double clip_norm;               /* scale gradients down to this L2 norm over all; 0: never */
    double ema_decay;               /* keep an average of the weights with this decay, in step t at most t / (t + 9);
                                     * 0: none */
} lt_optim_opts;

typedef struct lt_optim lt_optim;

/**
 * lt_optim_new - an optimiser for every weight of the set that has a gradient
 *
 * Make it after lt_compile of the training plan: parameters that no plan reaches have no gradient, and
 * are neither moved nor decayed. The set must outlive it. NULL without memory.
 */
LT_API lt_optim *lt_optim_new(lt_params *set, const lt_optim_opts *opts);
LT_API void lt_optim_free(lt_optim *o);

/* lt_optim_grad_norm - the L2 norm of all gradients of weights; not finite when any of them is not */
LT_API double lt_optim_grad_norm(const lt_optim *o);

/* lt_optim_step - move the weights, and the running statistics of the set by what the runs since the last update have
 * collected, unless lt_statistics_update has done that; norm is lt_optim_grad_norm's, used for clipping */
LT_API void lt_optim_step(lt_optim *o, double lr, double norm);

/* lt_optim_steps - steps taken so far; settable for a resume */
LT_API int64_t lt_optim_steps(const lt_optim *o);
LT_API void lt_optim_set_steps(lt_optim *o, int64_t steps);

/* What the optimiser remembers of a parameter, to be saved and put back: state i of 0 .. count - 1. */
typedef struct {
    const char *name;               /* "optim.m.layer1.0.conv1.weight" */
    lt_real *data;
    lt_shape shape;
} lt_optim_state;

LT_API int lt_optim_state_count(const lt_optim *o);
LT_API lt_optim_state lt_optim_state_at(const lt_optim *o, int i);

/* lt_optim_swap_ema - exchange weights and their average, to evaluate with it; swap again to go on */
LT_API void lt_optim_swap_ema(lt_optim *o);

/* lt_statistics_update - move running statistics by their momentum towards the mean of what n batches (shards) collected,
 * and forget what was collected: for whoever has no optimiser, or adds up the sums of several runs by hand before its
 * step. Each batch must have gone through every layer of the set whose statistics a training plan collects; frozen ones
 * stay. Does nothing when no training plan has run since the last update. */
LT_API void lt_statistics_update(lt_params *set, int n);

typedef enum { LT_CONSTANT_LR, LT_STEP_LR, LT_COSINE_LR } lt_schedule_kind;

typedef struct {
    lt_schedule_kind kind;
    double lr;                      /* the highest */
    double gamma;                   /* LT_STEP_LR: times gamma every `every` epochs */
    int every;                      /* 1 and more */
    double min_lr;                  /* LT_COSINE_LR: where it ends after epochs */
    int epochs;
    double warmup;                  /* epochs of a linear rise from 0 in front; 0: none */
} lt_schedule;

/* lt_schedule_lr - at a time in epochs, fractions counting for warm-up and cosine */
LT_API double lt_schedule_lr(const lt_schedule *s, double epoch);

#ifdef __cplusplus
}
#endif
#endif
