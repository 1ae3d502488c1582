/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Named parameters. They outlive graphs and plans: a training plan and an inference plan of one model
 * share them, and so do checkpoints and optimisers.
 */
#ifndef LT_GRAPH_PARAM_H
#define LT_GRAPH_PARAM_H

#include "libtensor/base/arena.h"
#include "libtensor/graph/tensor.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LT_WEIGHT,                      /* grad is the gradient of the loss */
    LT_STATISTIC,                   /* a running mean: grad collects what the batch measured */
} lt_param_kind;

typedef struct lt_params lt_params;
typedef struct lt_param_rows lt_param_rows;

struct lt_param {
    const char *name;               /* "layer1.0.conv1.weight" */
    lt_shape shape;
    lt_param_kind kind;
    lt_real *data;
    lt_real *grad;                  /* NULL until a training plan reaches it: nothing to update then */
    bool frozen;                    /* kept as it is: no gradient, no update */
    double rate;                    /* LT_WEIGHT: factor of the learning rate; 1 */
    double momentum;                /* LT_STATISTIC: share of the batch in an update */
    int uses;                       /* how many ops of the last training plan add to grad; LT_STATISTIC: each its own */
    lt_param_rows *rows;            /* of one that is stepped by rows (rows.h); else NULL */
    lt_params *set;
    lt_param *next;                 /* in the order of registration */
};

/* lt_params_new - an empty set, NULL without memory; the set owns its parameters */
LT_API lt_params *lt_params_new(void);
LT_API void lt_params_free(lt_params *set);

/**
 * lt_params_add - a zeroed parameter named prefix.name (name alone when prefix is empty)
 *
 * The first problem (a name taken, a shape without values, no memory) is kept in the set, and the parameter returned
 * for it and after it is a harmless stand-in. Ask lt_params_status when the model is complete; a graph that uses a
 * parameter of such a set has its error.
 */
LT_API lt_param *lt_params_add(lt_params *set, const char *prefix, const char *name, lt_param_kind kind,
                               lt_shape shape);
LT_API lt_status lt_params_status(const lt_params *set);

/**
 * lt_params_defer - parameters that are added from now on have names and shapes, and no values: data is NULL
 * lt_params_allocate - zeros for all that have none, and for those that are added later
 *
 * To hold a model against a file before memory is taken for it. LT_ENOMEM.
 */
LT_API void lt_params_defer(lt_params *set);
LT_API lt_status lt_params_allocate(lt_params *set);

/* lt_name - a name put together, living as long as the set: lt_name(set, "%s.%d", prefix, i); "" without memory, which
 * is a problem that the set keeps */
LT_API const char *lt_name(lt_params *set, const char *fmt, ...) LT_PRINTF(2, 3);

/* lt_params_arena - lives as long as the set: for whatever belongs to it */
LT_API lt_arena *lt_params_arena(lt_params *set);

/* lt_params_first - walk with p->next; lt_params_find - by name, NULL when there is none */
LT_API lt_param *lt_params_first(const lt_params *set);
LT_API lt_param *lt_params_find(const lt_params *set, const char *name);

/* lt_params_count - numbers in all parameters of kind whose name starts with prefix ("" for all) */
LT_API int64_t lt_params_count(const lt_params *set, lt_param_kind kind, const char *prefix);

/* lt_params_zero_grad - forget the gradients */
LT_API void lt_params_zero_grad(lt_params *set);

/* lt_params_changed - for whoever writes p->data by hand: inference plans fold and pack the weights again in their next
 * run. Optimisers, initial values and whatever else of the library writes parameters say it themselves. */
LT_API void lt_params_changed(lt_params *set);

/* lt_param_need_grad - give the parameter its grad; false without memory */
LT_API bool lt_param_need_grad(lt_param *p);

static inline int64_t lt_param_numel(const lt_param *p) { return lt_shape_numel(&p->shape); }

#ifdef __cplusplus
}
#endif
#endif
