/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Optimisers, gradient clipping, an average of the weights, running statistics and schedules.
 *
 * With one recipe for all weights: lt_optim_new, and in each step lt_optim_grad_norm and lt_optim_step. With a recipe
 * for each group of weights, and steps of some groups only: lt_optim_new_groups, lt_optim_groups_norm and
 * lt_optim_step_groups. A parameter that is stepped by rows (libtensor/graph/rows.h) moves in its touched rows, either
 * way.
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
    LT_MUON,                        /* matrices, weights of two dimensions, by Muon: as far as Adam moves them as a rule,
                                     * along the orthogonal matrix that is nearest to their mean gradient, which momentum
                                     * makes; what is no matrix, or is stepped by rows, by LT_ADAMW
                                     *                                  [Jordan et al. 2024; Liu et al. 2025] */
} lt_optim_kind;

typedef struct {
    lt_optim_kind kind;
    double beta1, beta2, eps;       /* 0: 0.9, 0.999, 1e-8 */
    double momentum;                /* of LT_SGD and LT_MUON */
    bool nesterov;
    double weight_decay;
    double clip_norm;               /* scale gradients down to this L2 norm over all; 0: never */
    double ema_decay;               /* keep an average of the weights with this decay, in step t at most t / (t + 9);
                                     * 0: none */
} lt_optim_opts;

/* ---- learning rates over time -------------------------------------------------------------------------- */

typedef enum {
    LT_CONSTANT_LR, LT_STEP_LR, LT_COSINE_LR,
    LT_LINEAR_LR,                   /* YOLOv8's, for one */
    LT_LOG_LINEAR_LR,               /* of the places of Gaussians [Kerbl et al. 2023] */
} lt_schedule_kind;

/* Times are in epochs, or all of them in steps. */
typedef struct {
    lt_schedule_kind kind;
    double lr;                      /* the highest; where it begins */
    double gamma;                   /* LT_STEP_LR: times gamma every `every` epochs */
    int every;                      /* LT_STEP_LR: 1 and more; LT_LINEAR_LR: goes down every so many epochs, as one does
                                     * that is asked once an epoch; 0: all the time */
    double min_lr;                  /* where it ends after epochs: LT_COSINE_LR, which begins behind the warm-up;
                                     * LT_LINEAR_LR and LT_LOG_LINEAR_LR (a line of the logarithm: lr and min_lr are
                                     * above 0), which begin at time 0 */
    int epochs;
    double warmup;                  /* epochs in front, in which it goes in a line to the rate above; 0: none */
    double warmup_lr;               /* from this rate, which may be the higher one */
} lt_schedule;

/* lt_schedule_lr - at a time in epochs, fractions counting for warm-up and whatever has no `every` */
LT_API double lt_schedule_lr(const lt_schedule *s, double epoch);

/* ---- optimisers ---------------------------------------------------------------------------------------- */

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
LT_API double lt_optim_grad_norm(lt_optim *o);

/* lt_optim_step - move the weights, and the running statistics of the set by what the runs since the last update have
 * collected, unless lt_statistics_update has done that; norm is lt_optim_grad_norm's, used for clipping. Where there
 * are groups all of them step, with this rate and this norm. */
LT_API void lt_optim_step(lt_optim *o, double lr, double norm);

/* ---- groups -------------------------------------------------------------------------------------------- */

/* Weights with a recipe of their own. What is 0 means what it means in lt_optim_opts. */
typedef struct {
    const char *name;               /* "networks": in messages, and of its clock in a checkpoint */
    const char *const *prefix;      /* it has the weights whose name begins with one of these, */
    const char *const *suffix;      /* and ends with one of these, and no group before it has. A list ends with NULL;
                                     * NULL in place of a list: any name */
    lt_optim_kind kind;
    lt_schedule schedule;
    bool by_step;                   /* the schedule's times are in steps, not in epochs */
    double beta1, beta2, eps;
    double momentum;
    double warmup_momentum;         /* from here to momentum in a line while the schedule warms up; 0: no change */
    bool nesterov;
    double weight_decay;
    int decay_rank;                 /* weights of fewer dimensions (2: biases, norms) are not decayed, */
    const char *const *no_decay;    /* nor are those whose name ends with one of these */
    double clip_norm;               /* to this norm over all groups that step and clip, */
    bool clip_alone;                /* or over this group alone, which then does not count to the others' norm */
} lt_optim_group;

/* Of the weights of all groups */
typedef struct {
    double decay;                   /* 0: no average */
    double tau;                     /* in step t the decay is decay (1 - exp(-t / tau)); 0: it is at most t / (t + 9) */
    bool statistics;                /* running statistics are averaged too */
} lt_optim_average;

enum { LT_OPTIM_GROUPS = 64 };      /* at most */

/**
 * lt_optim_new_groups - as lt_optim_new, with n groups; average: or NULL
 *
 * The groups are copied; their lists are read here and in lt_optim_set_group only. A group may have no weights. NULL,
 * with a line in lt_last_error(): a weight that would be moved and is in no group; none or more than LT_OPTIM_GROUPS
 * groups; one without a name, two of one name; no memory.
 */
LT_API lt_optim *lt_optim_new_groups(lt_params *set, const lt_optim_group *group, int n,
                                     const lt_optim_average *average);

/* Which groups step, and when. */
typedef struct {
    uint64_t groups;                /* bit k: group k. Others keep weights, moments, averages and clock as they are */
    double step, epoch;             /* times for the schedules */
} lt_optim_now;

/* lt_optim_groups_norm - the L2 norm of the gradients of these groups; not finite when any of them is not. Call it
 * before lt_optim_step_groups of the same groups, which clips by what is measured here. */
LT_API double lt_optim_groups_norm(lt_optim *o, uint64_t groups);

/* lt_optim_step_groups - as lt_optim_step, each group by its recipe */
LT_API void lt_optim_step_groups(lt_optim *o, const lt_optim_now *now);

/* lt_optim_set_group - from now on another recipe for the weights of group k: in another phase of a run rates differ,
 * or nothing is clipped. It stays what it is in name, prefix, suffix and kind. */
LT_API void lt_optim_set_group(lt_optim *o, int k, const lt_optim_group *group);

/* lt_optim_forget - moments of rows first .. first + n - 1 of p begin at 0 again, for whoever has set these rows by
 * hand; clocks go on. Rows that p does not have are left out, and so is a p that is not moved. */
LT_API void lt_optim_forget(lt_optim *o, const lt_param *p, int64_t first, int64_t n);

/* ---- what it remembers --------------------------------------------------------------------------------- */

/* lt_optim_steps - steps taken so far; settable for a resume */
LT_API int64_t lt_optim_steps(const lt_optim *o);
LT_API void lt_optim_set_steps(lt_optim *o, int64_t steps);

/* State i of 0 .. count - 1, to be saved and put back; with lt_optim_set_steps that is all there is. Where a parameter
 * is stepped by rows, resize it first if it had other rows then; data and shape hold until the next resize. */
typedef struct {
    const char *name;               /* "optim.m.layer1.0.conv1.weight": m and v: moments; ema: average, of a running
                                     * statistic too; t: steps that each row has taken; "optim.steps.networks": steps
                                     * that a group has taken. Steps are counted up to 2^24 */
    lt_real *data;
    lt_shape shape;
} lt_optim_state;

LT_API int lt_optim_state_count(const lt_optim *o);
LT_API lt_optim_state lt_optim_state_at(const lt_optim *o, int i);

/* lt_optim_swap_ema - exchange what is averaged and its average, to evaluate with it; swap again to go on */
LT_API void lt_optim_swap_ema(lt_optim *o);

/* lt_statistics_update - move running statistics by their momentum towards the mean of what n batches (shards)
 * collected, and forget what was collected: for whoever has no optimiser, or adds up the sums of several runs by hand
 * before its step. Each batch must have gone through every layer of the set whose statistics a training plan collects;
 * frozen ones stay. Does nothing when no training plan has run since the last update. */
LT_API void lt_statistics_update(lt_params *set, int n);

#ifdef __cplusplus
}
#endif
#endif
