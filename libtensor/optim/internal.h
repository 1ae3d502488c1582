/* SPDX-License-Identifier: Apache-2.0 */
/* What an optimiser is, to the files of this room. */
#ifndef LT_OPTIM_INTERNAL_H
#define LT_OPTIM_INTERNAL_H

#include "libtensor/graph/rows.h"
#include "libtensor/kernels/kernels.h"
#include "libtensor/optim/optim.h"

/* A weight and what is remembered of it. Arrays go along with the rows of one that is stepped by rows. */
typedef struct {
    lt_param *p;
    int group;
    bool decays;
    lt_row_array m, v, ema;         /* v: Adam, ema: with an average; else their data is NULL */
    lt_row_array clock;             /* (rows, 1): steps that each row has taken; NULL where not stepped by rows */
    int64_t first_chunk, n_chunks;  /* of the weights that are not stepped by rows */
} optim_slot;

typedef struct {
    lt_optim_group recipe;
    lt_real clock;                  /* steps that it has taken */
    double sumsq;                   /* of its gradients, as last measured */

    /* for the step that is being taken */
    bool steps;
    lt_adam_step adam;
    lt_sgd_step sgd;
    lt_real keep;                   /* of the average */
} optim_group;

/* One line of the list of state. */
typedef struct {
    const char *name;
    lt_real *const *data;
    const lt_param *of;             /* the parameter whose shape it has, */
    bool a_row;                     /* or one number of each of its rows; NULL: a number */
} optim_entry;

/* A running statistic that is averaged. */
typedef struct {
    lt_param *p;
    lt_real *ema;
} optim_statistic;

struct lt_optim {
    lt_arena *arena;
    lt_params *set;
    optim_group *group;
    int n_groups;
    bool one_recipe;                /* by lt_optim_new: the group has no name, and its clock is steps */
    lt_optim_average average;
    optim_slot *slot;
    int n_slots;
    optim_statistic *statistic;
    int n_statistics;
    optim_entry *entry;
    int n_entries;
    int64_t n_chunks, steps;
    double *partial;                /* of the norm, by chunk */
    lt_real *scratch;               /* of the largest matrix that goes by Muon, or NULL */
    int *slot_of;                   /* chunk -> slot */
    uint64_t measured;              /* the groups whose norm is taken */
};

/* optim_chunk - chunk k of the weights that are not stepped by rows: which slot, from where, how many */
const optim_slot *optim_chunk(const lt_optim *o, int64_t k, int64_t *at, size_t *n);

/* optim_by_muon - is this weight a matrix of a group of LT_MUON?  optim_muon_scratch - elements that its step needs;
 * optim_muon - takes the step, by the group's sgd */
bool optim_by_muon(const lt_optim *o, const optim_slot *s);
int64_t optim_muon_scratch(const lt_param *p);
void optim_muon(const lt_optim *o, const optim_slot *s);

/* optim_list - write the list of state; false without memory */
bool optim_list(lt_optim *o);

/* optim_update_statistics - by the n batches that were collected */
void optim_update_statistics(lt_params *set, int n);

static inline bool optim_chosen(uint64_t groups, int k) { return groups >> k & 1; }

#endif
