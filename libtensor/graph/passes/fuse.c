/* SPDX-License-Identifier: Apache-2.0 */
/*
 * conv2d, batch norm, add, leaky relu -> one conv2d: a producer whose only reader describes itself as an
 * element-wise tail may take that tail over. So may one the mean of each of its maps, and a reader of maps the
 * gates that they are multiplied with: of a squeeze and excitation the small products are left. And a product or a
 * convolution may take over the one before it, so that nobody stores what lies between. Which ops can is the ops' own
 * affair.
 */
#include "libtensor/graph/passes/passes.h"

typedef struct {
    int *of, n;                     /* by tensor; constants recorded while fusing lie behind n */
} reader_count;

static void count_readers(const lt_graph *g, int *readers)
{
    for (int k = 0; k < g->n_nodes; k++)
        for (int i = 0; g->node[k] && i < g->node[k]->n_in; i++)
            if (g->node[k]->in[i])
                readers[g->node[k]->in[i]->id]++;
}

/* The producer of in[i], if nobody else sees what it makes. */
static lt_node *sole_producer(const lt_node *reader, int i, reader_count readers)
{
    const lt_tensor *x = reader->in[i];

    if (!x || !x->node || x->is_output || x->id >= readers.n || readers.of[x->id] != 1
        || x->node->n_out != 1)
        return NULL;
    return x->node;
}

/* The producer now makes what its reader made, in the reader's place, where the addend is there too. */
static void merge(lt_graph *g, lt_node *producer, lt_node *reader)
{
    producer->outs[0] = reader->outs[0];
    producer->outs[0]->node = producer;
    g->node[producer->id] = NULL;
    g->node[reader->id] = producer;
    producer->id = reader->id;
    producer->constant = reader->constant;
}

typedef bool (*absorb_fn)(lt_node *node, const lt_tail *tail);

static absorb_fn for_inference(const lt_op *op) { return op->absorb; }
static absorb_fn for_training(const lt_op *op) { return op->absorb_for_training; }

static void fuse_tail(lt_graph *g, lt_node *reader, reader_count readers, absorb_fn (*of)(const lt_op *op))
{
    for (int i = 0; i < reader->n_in; i++) {
        lt_node *producer = sole_producer(reader, i, readers);
        absorb_fn absorb = producer ? of(producer->op) : NULL;
        lt_tail tail = { 0 };

        if (absorb && reader->op->as_tail(reader, i, &tail) && absorb(producer, &tail)) {
            merge(g, producer, reader);
            return;
        }
    }
}

/* The producer of the maps makes their means as well. */
static void fuse_mean(lt_graph *g, lt_node *mean)
{
    lt_node *producer = mean->in[0]->node;

    if (!producer || producer->n_out != 1 || !producer->op->absorb_mean || !producer->op->absorb_mean(producer))
        return;
    producer->outs[producer->n_out++] = mean->outs[0];
    mean->outs[0]->node = producer;
    g->node[mean->id] = NULL;
}

static void fuse_gate(lt_graph *g, lt_node *reader, reader_count readers)
{
    const lt_node *gated = sole_producer(reader, 0, readers);

    if (gated && gated->op->as_gate && gated->op->as_gate(gated)
        && reader->op->absorb_gate(reader, gated->in[0], gated->in[1]))
        g->node[gated->id] = NULL;
}

typedef bool (*before_fn)(lt_node *node, const lt_node *before);

static void fuse_before(lt_graph *g, lt_node *reader, reader_count readers, before_fn absorb)
{
    const lt_node *before = sole_producer(reader, 0, readers);

    if (before && absorb(reader, before))
        g->node[before->id] = NULL;
}

static void fuse_node(lt_graph *g, lt_node *n, reader_count readers)
{
    if (n->op->flags & LT_OP_CHANNEL_MEAN)
        fuse_mean(g, n);
    if (n->op->absorb_gate)
        fuse_gate(g, n, readers);
    if (n->op->as_tail)
        fuse_tail(g, n, readers, for_inference);
}

static lt_status read_counts(const lt_graph *g, reader_count *readers)
{
    *readers = (reader_count){ lt_arena_array(g->arena, (size_t)g->n_tensors, sizeof(int)), g->n_tensors };
    if (!readers->of)
        return lt_error(LT_ENOMEM, "no memory to compile the graph");
    count_readers(g, readers->of);
    return LT_OK;
}

lt_status pass_fuse(lt_graph *g)
{
    const int n_nodes = g->n_nodes;             /* absorbing records more, all of them constant */
    reader_count readers;

    if (read_counts(g, &readers))
        return LT_ENOMEM;
    for (int k = 0; k < n_nodes; k++)
        if (g->node[k] && !g->node[k]->constant)        /* a constant one runs once, before what it would absorb */
            fuse_node(g, g->node[k], readers);
    return lt_graph_status(g);
}

lt_status pass_pair(lt_graph *g)
{
    reader_count readers;

    if (read_counts(g, &readers))
        return LT_ENOMEM;
    for (int k = 0; k < g->n_nodes; k++)
        if (g->node[k] && !g->node[k]->constant && g->node[k]->op->absorb_before)
            fuse_before(g, g->node[k], readers, g->node[k]->op->absorb_before);
    return LT_OK;
}

lt_status pass_fuse_for_training(lt_graph *g)
{
    reader_count readers;

    if (read_counts(g, &readers))
        return LT_ENOMEM;
    for (int k = 0; k < g->n_nodes; k++)
        if (g->node[k] && g->node[k]->op->as_tail)
            fuse_tail(g, g->node[k], readers, for_training);
    for (int k = 0; k < g->n_nodes; k++)
        if (g->node[k] && g->node[k]->op->absorb_before_for_training)
            fuse_before(g, g->node[k], readers, g->node[k]->op->absorb_before_for_training);
    return LT_OK;
}
