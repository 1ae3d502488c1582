/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What an op is. An op is a constant struct and a constructor in one file; whoever calls the
 * constructor links the op, and nothing else knows its name. docs/adding-a-layer.md walks through one.
 */
#ifndef LT_GRAPH_OP_H
#define LT_GRAPH_OP_H

#include "libtensor/base/rng.h"
#include "libtensor/base/status.h"
#include "libtensor/graph/tensor.h"
#include "libtensor/kernels/kernels.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lt_onnx lt_onnx;     /* a graph in ONNX's words, while it is described */

enum { LT_MAX_IN = 12, LT_MAX_OUT = 4, LT_MAX_SAVED = 4 };

/*
 * One use of an op: what its functions are handed. Optional inputs that were left out are NULL, and so
 * are gradients that nobody wants.
 */
typedef struct lt_call {
    const void *attr;               /* the op's own struct, as given to lt_apply */
    const lt_node *node;
    int n_in, n_out;
    lt_tensor *in[LT_MAX_IN];
    lt_tensor *outs[LT_MAX_OUT], *out;          /* out is outs[0] */

    /* backward: add into din[i]. Only an op that declares LT_OP_ASSIGNS looks at fresh: where it is
     * true the buffer holds garbage and must be written, every element, instead of added to. */
    lt_real *din[LT_MAX_IN];
    bool fresh[LT_MAX_IN];
    const lt_real *douts[LT_MAX_OUT], *dout;    /* dout is douts[0] */

    bool train;                     /* its own backward pass follows */
    bool goes_back;                 /* this plan has a backward pass, of this op or of others */

    /* Of an op that shares (lt_op.forward_share): the same use of it in each part of the batch, this one among them.
     * NULL where the batch has but one part. */
    struct lt_call *const *part;
    int n_parts;

    void *saved[LT_MAX_SAVED];      /* from forward to backward; contents are the op's own */
    void *work;                     /* for the length of one function; contents undefined */
    lt_rng rng;                     /* a stream of its own for each node and step */

    size_t saved_bytes[LT_MAX_SAVED], work_bytes;   /* set by .plan */
} lt_call;

/* What backward reads, besides dout and saved. With none of these bits set it may read everything. */
#define LT_KEEP_IN(i) (1u << (i))
#define LT_KEEP_OUT(i) (1u << (LT_MAX_IN + (i)))
#define LT_KEEP_NOTHING (1u << 31)

/* Which maps are in blocks of channels (libtensor/kernels/blocks/blocks.h): (B, blocks, H, W, LT_BLOCK) in the place of
 * (B, C, H, W) */
#define LT_BLOCKS_IN(i) LT_KEEP_IN(i)
#define LT_BLOCKS_OUT LT_KEEP_OUT(0)

/* What may be left out; what need not be LT_F32. */
#define LT_OPTIONAL_IN(i) (1u << (i))
#define LT_ANY_TYPE_IN(i) (1u << (i))

enum {
    LT_OP_INPLACE = 1,              /* out may be the memory of in[0] when that dies here */
    LT_OP_VIEW = 2,                 /* out is the memory of in[0]; forward and backward do nothing */
    LT_OP_DETACH = 4,               /* no gradient passes, on purpose: a target, an index */
    LT_OP_CHEAP = 8,                /* its result may be recomputed for backward instead of kept */
    LT_OP_ASSIGNS = 16,             /* backward honours lt_call.fresh */
    LT_OP_RANDOM = 32,              /* draws from lt_call.rng: never folded */
    LT_OP_CHANNEL_MEAN = 64,        /* out (B, C) is the mean of each map of in[0] (B, C, H, W) */
    LT_OP_INPLACE_GRAD = 128,       /* a fresh din[0] may be the memory of dout when that dies here */
    LT_OP_ROWS = 256,               /* of a parameter in[0] with rows (rows.h) backward adds to touched ones only */
};

/* An element-wise tail that a producer may take over: y = act(scale[c] * x + shift[c] + addend) */
typedef struct {
    lt_tensor *scale, *shift;       /* (C), constants, over dimension 1; both or neither */
    lt_tensor *addend;              /* the shape of x; or NULL */
    lt_act act;
} lt_tail;

typedef struct lt_op {
    const char *name;
    int n_out;                      /* 0 means 1 */
    unsigned flags;
    unsigned keeps;                 /* LT_KEEP_IN(i) | LT_KEEP_OUT(i) ...; 0: everything */
    unsigned optional;              /* LT_OPTIONAL_IN(i) ...: inputs that may be NULL */
    unsigned any_type;              /* LT_ANY_TYPE_IN(i) ...: inputs whose type infer looks at */

    /* Shape rule: check in and attr, set shape (and dtype, LT_F32 unless set) of every out. Fails with
     * lt_fail. Data is not there. */
    lt_status (*infer)(lt_call *c);

    /* Ask for saved_bytes and work_bytes; shapes are known, c->train says whether backward will come.
     * Optional. */
    void (*plan)(lt_call *c);

    /* Run. Cannot fail, allocate, or keep state anywhere but in saved. Without backward the op may not stand between a
     * loss and what it learns, unless it says LT_OP_DETACH. */
    void (*forward)(const lt_call *c);
    void (*backward)(const lt_call *c);

    /* Of an op whose results depend on the whole batch: leave in saved what the other parts want to know. In a plan
     * with parts these run first, in all of them, before forward or backward does in any; what they leave stays until
     * all parts meet again. One part may share for backward while another is still in forward, so the two use different
     * places. Optional, both or neither. */
    void (*forward_share)(const lt_call *c);
    void (*backward_share)(const lt_call *c);

    /* Make out again from in and saved, for LT_OP_CHEAP. Optional: forward. */
    void (*recompute)(const lt_call *c);

    /* Multiply-adds of one forward. Optional: 0. */
    int64_t (*macs)(const lt_call *c);

    /* How forward computes this call, for profiles: "winograd". Optional. */
    const char *(*algorithm)(const lt_call *c);

    /* ---- what passes ask; all optional, and but for .._for_training in plans without backward only ---- */

    /* Record something simpler instead, on in[0]'s graph, and return its result, or NULL to stay. */
    lt_tensor *(*lower)(const lt_node *node, lt_tensor *const *in);

    /* Describe this node as a tail on in[i]. Take a tail over, changing attr and inputs of the node, or refuse; the
     * same in a plan with backward, which honours the tail from now on. */
    bool (*as_tail)(const lt_node *node, int i, lt_tail *tail);
    bool (*absorb)(lt_node *node, const lt_tail *tail);
    bool (*absorb_for_training)(lt_node *node, const lt_tail *tail);

    /* Make the mean of each map as a second result from now on, or refuse. */
    bool (*absorb_mean)(lt_node *node);

    /* Is the result in[0] (B, C, H, W) times in[1] (B, C, 1, 1)? Read x times gate as in[0] from now on, or refuse. */
    bool (*as_gate)(const lt_node *node);
    bool (*absorb_gate)(lt_node *node, lt_tensor *x, lt_tensor *gate);

    /* Do the work of the node that makes in[0] as well, or refuse; the same in a plan with backward. */
    bool (*absorb_before)(lt_node *node, const lt_node *before);
    bool (*absorb_before_for_training)(lt_node *node, const lt_node *before);

    /* The inputs that the node could read in blocks, all of them or none, and whether its result would be in blocks
     * then; 0: it cannot. */
    unsigned (*takes_blocks)(const lt_node *node);

    /* Is in[i] a piece of the result, or the result one of in[0], as both lie in memory? Then the element of the whole
     * with which it begins, else -1. In a plan without backward forward may find the piece where it belongs. */
    int64_t (*in_piece)(const lt_node *node, int i);
    int64_t (*out_piece)(const lt_node *node);

    /* The graph is final: inputs that are constant may be replaced by a form computed from them. */
    void (*prepare)(lt_node *node);

    /* Could the node, not prepared, read in[0] as 8-bit integers? In place of prepare, do so. */
    bool (*takes_int8)(const lt_node *node);
    void (*prepare_int8)(lt_node *node, const lt_int8_range *range);

    /* Say what the node is in ONNX, with the words of libtensor/graph/onnx/onnx.h. Optional: no ONNX form. */
    void (*onnx)(lt_onnx *w, const lt_node *node);
} lt_op;

struct lt_node {
    const lt_op *op;
    void *attr;
    size_t attr_bytes;
    int n_in, n_out;
    lt_tensor *in[LT_MAX_IN], *outs[LT_MAX_OUT];
    const char *name;               /* the layer: "fpn.hand.lateral3", or "" */
    const char *file;               /* where it was recorded; NULL: not by a call that says so (LT_HERE) */
    int line;
    int id;
    bool constant;                  /* lt_is_constant of its results */
};

/**
 * lt_apply - record one use of op; attr is copied
 *
 * The graph is that of the first input that is not NULL. After an error, here or earlier in the graph, returns a tensor
 * that is harmless to pass on; where no input is there, and so no graph, NULL, which is harmless too: the next
 * lt_compile of this thread reports it.
 * Errors: an op without infer or forward; an input is missing that is not optional, is not LT_F32 where the op says
 * nothing else, belongs to another graph; more than LT_MAX_IN of them; and those of the op's shape rule, which must set
 * the shape of every result.
 */
LT_API lt_tensor *lt_apply(const lt_op *op, const void *attr, size_t attr_bytes,
                           lt_tensor *const *in, int n_in);

/* lt_become - let a node be another op's from now on, with a copy of attr and other inputs; for passes. False, and
 * nothing changed, without memory. */
LT_API bool lt_become(lt_node *node, const lt_op *op, const void *attr, size_t attr_bytes, lt_tensor *const *in,
                      int n_in);

/* lt_result - another output of the node that made t: lt_result(t, 1) is its second */
LT_API lt_tensor *lt_result(lt_tensor *t, int i);

/**
 * lt_fail - the shape rule's way to refuse; returns LT_ESHAPE
 *
 * The graph remembers the first: op "layer": message (file:line).
 */
LT_API lt_status lt_fail(lt_call *c, const char *fmt, ...) LT_PRINTF(2, 3);

/* lt_want_rank, lt_want_shape - fail unless in[i] is there with that rank or shape; what names it */
LT_API lt_status lt_want_rank(lt_call *c, int i, const char *what, int rank);
LT_API lt_status lt_want_shape(lt_call *c, int i, const char *what, lt_shape want);

/* lt_in_blocks - maps in blocks of channels, as an op's takes_blocks allowed */
static inline bool lt_in_blocks(const lt_tensor *t) { return t->shape.rank == 5; }

/* lt_is_constant - known when an inference plan is compiled: no input of the graph goes into it */
LT_API bool lt_is_constant(const lt_tensor *t);

/*
 * The place of a call, for messages. Constructors of ops and layers are wrapped in a macro of their own
 * name: #define lt_gelu(...) LT_HERE(lt_gelu(__VA_ARGS__)). The outermost wrapped call counts, so a
 * layer's inside reports the line of the model that used the layer. A definition is written
 * lt_tensor *(lt_gelu)(lt_tensor *x), in parentheses, which keeps the macro out of it.
 */
#define LT_HERE(call) (lt_here_enter(__FILE__, __LINE__), lt_here_leave(call))
LT_API void lt_here_enter(const char *file, int line);
LT_API lt_tensor *lt_here_leave(lt_tensor *result);

#ifdef __cplusplus
}
#endif
#endif
