/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A plan in the making: steps, buffers with lifetimes, and the calls that bind them.
 */
#ifndef LT_GRAPH_PLAN_INTERNAL_H
#define LT_GRAPH_PLAN_INTERNAL_H

#include "libtensor/graph/internal.h"
#include "libtensor/graph/plan.h"

typedef enum { STEP_FORWARD, STEP_RECOMPUTE, STEP_ZERO, STEP_BACKWARD } step_kind;

typedef struct {
    step_kind kind;
    lt_node *node;                  /* NULL for STEP_ZERO */
    int zero;                       /* STEP_ZERO: the tensor (root) whose gradient starts here */
    bool fresh[LT_MAX_IN];          /* STEP_BACKWARD: first to write that gradient */
    lt_call call;
    void *zero_data;
    size_t zero_bytes;
    const lt_param *zero_rows;      /* only its touched rows start here; NULL: zero_bytes */
    double seconds;
} plan_step;

/* A piece of memory needed from one step to another, both included. */
typedef struct {
    size_t bytes, offset;
    int first, last;
    int same_as;                    /* lives in this other buffer, in place of it or as a piece, or -1 */
    size_t shift;                   /* of a piece: where it begins */
    bool replaced;                  /* another buffer was made in place of this one */
} plan_buffer;

/* What the compiler knows of a tensor of the plan's graph. Views speak through their root. */
typedef struct {
    int root;                       /* the tensor whose memory this is; itself mostly */
    bool needs_grad;
    bool touched;                   /* some reader has written its gradient */
    bool needed;                    /* its value is read in the backward pass */
    bool at_hand;                   /* needed, or can be made from what is */
    bool redo;                      /* made again in the backward pass instead of kept */
    bool redone;                    /* the step that does it is in the list */
    int value, again, grad;         /* buffers, or -1 */
    lt_real *param_grad;            /* of a parameter */
    uint64_t moves;                 /* of a parameter: how often it had moved when the plan was compiled */
    lt_tensor *backward_view;       /* this tensor as the backward pass sees it */
} plan_tensor;

typedef struct {
    bool constant;                  /* runs in the prologue */
    bool active;                    /* has a backward step */
    int saved[LT_MAX_SAVED];        /* buffers, or -1 */
    size_t saved_bytes[LT_MAX_SAVED], work_bytes;
} plan_node;

struct lt_plan {
    lt_arena *arena;
    lt_graph *g;                    /* our own copy */
    const lt_graph *recorded;       /* to tell its tensors from others'; may be gone */
    int n_of;
    lt_tensor **of;                 /* tensor of the recorded graph, by id -> ours */
    plan_tensor *tensor;            /* by id in g */
    plan_node *node;
    plan_step *step;
    int n_steps, n_forward;
    size_t steps_room;
    plan_step *prologue;
    int n_prologue;
    plan_buffer *buffer;
    int n_buffers;
    size_t buffers_room;
    char *memory;
    size_t memory_bytes, fixed_bytes;
    lt_tensor *loss;
    lt_real *loss_grad;
    double loss_weight;
    uint64_t seed, run;
    bool train, replace_grads, profile;
    struct plan_set {
        lt_params *set;
        uint64_t version, moves;    /* as last packed; when its parameters were last seen where the plan knows them */
    } *set;                         /* of the parameters */
    int n_sets;
    struct lt_plan **part;          /* of the batch, itself first; a later part knows only itself */
    int n_parts;
    bool later_part;                /* has gradients of its own */
};

/* step.c: append a step; NULL without memory */
plan_step *plan_add_step(lt_plan *p, step_kind kind, lt_node *node);

/* one step of a run; the same, numbered, timed if that is wanted, and with what begins there */
void plan_run_step(lt_plan *p, plan_step *s);
void plan_run_at(lt_plan *p, int step);

/* plan_share_of   - what a step's op does of its part before all parts meet, or NULL
 * plan_next_share - the first step from `from` on that has such, or n_steps */
typedef void (*plan_share_fn)(const lt_call *c);
plan_share_fn plan_share_of(const lt_plan *p, int step);
int plan_next_share(const lt_plan *p, int from);

/* parts.c: let the first one's parts know of each other; run them all; run one step of them all, after what its op
 * shares */
lt_status plan_join_parts(lt_plan *first);
void plan_run_parts(lt_plan *first);
void plan_run_parts_at(lt_plan *first, int step);

/* plan_parts_abreast - whether they run at the same time, rather than one after another */
bool plan_parts_abreast(const lt_plan *first);

/* autodiff.c: append the backward pass to the steps; decides what is kept and what is made again */
lt_status plan_autodiff(lt_plan *p, bool recompute);

/* memory.c: lifetimes of all buffers, in-place sharing, offsets; then allocate and bind every call */
lt_status plan_memory(lt_plan *p);

/* plan_grad - where t's gradient stands; NULL where it has none */
lt_real *plan_grad(const lt_plan *p, const lt_tensor *t);

/* consume.c: the prologue, giving back each parameter after its last use, for good */
void plan_consume(lt_plan *p);

static inline plan_tensor *plan_root(const lt_plan *p, const lt_tensor *t)
{
    return &p->tensor[p->tensor[t->id].root];
}

static inline lt_tensor *plan_root_tensor(const lt_plan *p, const lt_tensor *t)
{
    return p->g->tensor[p->tensor[t->id].root];
}

/* plan_keeps_in, plan_keeps_out - whether the op's backward reads that tensor */
static inline bool plan_keeps_in(const lt_op *op, int i)
{
    return op->keeps == 0 || (op->keeps & LT_KEEP_IN(i));
}

static inline bool plan_keeps_out(const lt_op *op, int i)
{
    return op->keeps == 0 || (op->keeps & LT_KEEP_OUT(i));
}

#endif
