/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compiling and running. A plan owns the memory of every result of its graph; running it allocates
 * nothing, looks nothing up and cannot fail.
 */
#ifndef LT_GRAPH_PLAN_H
#define LT_GRAPH_PLAN_H

#include "libtensor/graph/graph.h"
#include "libtensor/graph/int8.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lt_plan lt_plan;

typedef struct {
    lt_tensor *loss;                /* one number; needed for train, else optional */
    bool train;                     /* with backward, and less fused; else folded and fused for speed */
    bool no_fusion;                 /* without folding and fusing, to compare with */
    bool consume_params;            /* infer: for a process that does nothing else with the parameters. Those that
                                     * the plan holds packed are cleared and their memory is given back;
                                     * lt_plan_refresh does nothing from then on */
    const lt_int8_table *int8;      /* infer: layers that read their inputs as 8-bit integers; with a table, an empty
                                     * one too, maps stay (B, C, H, W). NULL: none. Not kept */
    bool replace_grads;             /* train: a run's gradients take the place of those before, for less time than to
                                     * clear them and add; else lt_run adds */
    int parts;                      /* train, with replace_grads: the graph is of one part of the batch, of which there
                                     * are so many, alike and with memory of their own (lt_plan_part). Batch norms
                                     * measure the whole batch, gradients are sums over all parts. 0: 1 */
    bool no_recompute;              /* train: keep what could be recomputed, to compare with */
} lt_compile_opts;

/**
 * lt_compile - turn a recorded graph into a plan
 *
 * What stays readable after a run: outputs (lt_output), the loss, inputs. The graph is not changed and
 * must outlive the plan, as must the parameters. train adds the backward pass of loss to the plan, into the
 * grad of every parameter it reaches.
 *
 * Returns NULL when the graph has a mistake (lt_last_error() tells which) or without memory.
 */
LT_API lt_plan *lt_compile(lt_graph *g, const lt_compile_opts *opts);
LT_API void lt_plan_free(lt_plan *p);

/**
 * lt_plan_part - part i of the batch, from 0 on; the first one is p itself
 *
 * Each has inputs, results and a loss weight of its own, for lt_plan_data, lt_plan_grad and lt_plan_set_loss_weight;
 * everything else is asked of p and meant of all. Borrowed.
 */
LT_API lt_plan *lt_plan_part(const lt_plan *p, int i);

/**
 * lt_run - forward, and for a training plan backward; LT_OK
 *
 * Of a plan with a parameter that has been resized since (libtensor/graph/rows.h) nothing is run, and LT_EINVAL is
 * returned: record and compile again. Who resizes no parameter need not look.
 *
 * Gradients are added into param->grad: zero them first (lt_params_zero_grad) unless sums are wanted, or let the plan
 * replace them (lt_compile_opts). An inference plan folds and packs parameters first that have changed since.
 */
LT_API lt_status lt_run(lt_plan *p);

/* lt_plan_refresh - fold and pack the parameters again, now. lt_run does it by itself where they have changed
 * (lt_params_changed). */
LT_API void lt_plan_refresh(lt_plan *p);

/* lt_plan_data - where the plan keeps t; NULL when it does not (fused away, recycled). Borrowed. */
LT_API void *lt_plan_data(const lt_plan *p, const lt_tensor *t);

/* lt_plan_grad - the gradient of an input marked with lt_want_grad; NULL when there is none */
LT_API lt_real *lt_plan_grad(const lt_plan *p, const lt_tensor *t);

/* lt_plan_set_step - the key of the random draws of the next runs */
LT_API void lt_plan_set_step(lt_plan *p, uint64_t seed, uint64_t step);

/* lt_plan_set_loss_weight - what the backward pass starts from; 1 at first. Where a part's loss is the mean over its
 * samples, this is their share of the batch */
LT_API void lt_plan_set_loss_weight(lt_plan *p, double weight);

/**
 * lt_plan_find_nonfinite - run step by step and name the first tensor that is not finite
 *
 * Writes `op "layer"` into where, of an op without a name `op after "layer"`, with " (gradient)" behind it in the
 * backward pass, or "" when all is finite. Leaves gradients as lt_run does, and does nothing where that does nothing.
 */
LT_API void lt_plan_find_nonfinite(lt_plan *p, char *where, size_t bytes);

/* lt_plan_bytes - memory of the plan's tensors; parameters not included */
LT_API size_t lt_plan_bytes(const lt_plan *p);

/* lt_plan_macs - multiply-adds of one forward run */
LT_API int64_t lt_plan_macs(const lt_plan *p);

/* One step of a plan, for profiles. */
typedef struct {
    const char *op, *layer;         /* layer: the name given by its parameters or scope */
    const char *phase;              /* "forward", "recompute", "backward" */
    const char *algorithm;          /* of the forward step: "winograd"; "" where an op has only one */
    lt_shape shape;                 /* of the first result */
    int64_t macs;                   /* of this step: a backward step counts what it computes */
    double seconds;                 /* summed over the profiled runs */
} lt_step_info;

/* lt_plan_profile - time each step of the following runs (false: stop); forgets earlier times */
LT_API void lt_plan_profile(lt_plan *p, bool on);
LT_API int lt_plan_steps(const lt_plan *p);
LT_API lt_step_info lt_plan_step(const lt_plan *p, int i);

#ifdef __cplusplus
}
#endif
#endif
