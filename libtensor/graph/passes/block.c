/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Chains of convolutions keep their maps in blocks of channels (libtensor/kernels/blocks/blocks.h): nodes that can, and
 * hand maps to each other, do so together where that spares more than it costs to bring maps into blocks and
 * back at the ends of the chain: by what was measured an element brought there costs as much as reading or writing
 * three in blocks spares. Maps in blocks are tensors of their own, (B, blocks, H, W, LT_BLOCK); those of the recorded
 * graph stay plain, and vanish where nobody reads them.
 */
#include "libtensor/graph/passes/passes.h"
#include "libtensor/kernels/blocks/blocks.h"

enum { WAY = 3 };                   /* what it costs, by element */

typedef struct {
    lt_graph *g;
    unsigned *takes;                /* by node: which maps it can read and make in blocks; 0: stays as it is */
    int *chain;                     /* by node: towards the one that stands for its chain */
    int64_t *gain;                  /* by that */
    bool *met;                      /* by tensor: its way into, or out of, blocks has been counted */
    lt_tensor **blocks;             /* by tensor: the same in blocks */
    lt_node **order;                /* the new list of nodes */
    int n;
} block_pass;

/* ---- into blocks and back ---- */

typedef struct { int64_t c; } blocks_attr;

static lt_shape shape_in_blocks(const lt_shape *s)
{
    return LT_SHAPE(s->dim[0], lt_blocks_of(s->dim[1]), s->dim[2], s->dim[3], LT_BLOCK);
}

static lt_status to_infer(lt_call *c)
{
    c->out->shape = shape_in_blocks(&c->in[0]->shape);
    return LT_OK;
}

static lt_status from_infer(lt_call *c)
{
    const lt_shape s = c->in[0]->shape;

    c->out->shape = LT_SHAPE(s.dim[0], ((const blocks_attr *)c->attr)->c, s.dim[2], s.dim[3]);
    return LT_OK;
}

static void to_forward(const lt_call *c)
{
    const lt_shape s = c->in[0]->shape;

    lt_blocks_from_maps(c->out->data, c->in[0]->data, s.dim[0], s.dim[1], s.dim[2] * s.dim[3]);
}

static void from_forward(const lt_call *c)
{
    const lt_shape s = c->out->shape;

    lt_blocks_to_maps(c->out->data, c->in[0]->data, s.dim[0], s.dim[1], s.dim[2] * s.dim[3]);
}

static const lt_op to_blocks_op = { .name = "to_blocks", .infer = to_infer, .forward = to_forward };
static const lt_op from_blocks_op = { .name = "from_blocks", .infer = from_infer, .forward = from_forward };

/* ---- which chains ---- */

static int chain_of(const block_pass *b, int node)
{
    while (b->chain[node] != node)
        node = b->chain[node];
    return node;
}

static bool reads(const block_pass *b, const lt_node *n, int i)
{
    return n->in[i] && (b->takes[n->id] & LT_BLOCKS_IN(i));
}

static bool makes(const block_pass *b, const lt_tensor *t)
{
    const lt_node *n = t->node;

    return n && n->outs[0] == t && (b->takes[n->id] & LT_BLOCKS_OUT);
}

static void find_nodes(block_pass *b)
{
    for (int k = 0; k < b->g->n_nodes; k++) {
        const lt_node *n = b->g->node[k];

        b->chain[k] = k;
        if (n && !n->constant && n->op->takes_blocks)
            b->takes[k] = n->op->takes_blocks(n);
    }
}

static void link_chains(block_pass *b)
{
    for (int k = 0; k < b->g->n_nodes; k++)
        for (int i = 0; b->takes[k] && i < b->g->node[k]->n_in; i++)
            if (reads(b, b->g->node[k], i) && makes(b, b->g->node[k]->in[i]))
                b->chain[chain_of(b, k)] = chain_of(b, b->g->node[k]->in[i]->node->id);
}

static void count_way(block_pass *b, const lt_tensor *t, int node)
{
    if (!b->met[t->id])
        b->gain[chain_of(b, node)] -= WAY * lt_numel(t);
    b->met[t->id] = true;
}

/* What the node spares if it makes maps in blocks, and the ways of what it reads. */
static void count_node(block_pass *b, const lt_node *n)
{
    int64_t *gain = &b->gain[chain_of(b, n->id)];

    for (int i = 0; i < n->n_in; i++) {
        const lt_tensor *t = n->in[i];

        if (reads(b, n, i)) {
            *gain += b->takes[n->id] & LT_BLOCKS_OUT ? lt_numel(t) : 0;
            if (!makes(b, t))
                count_way(b, t, n->id);
        } else if (t && makes(b, t)) {
            count_way(b, t, t->node->id);
        }
    }
    if (b->takes[n->id] & LT_BLOCKS_OUT) {
        *gain += lt_numel(n->outs[0]);
        if (n->outs[0]->is_output)
            count_way(b, n->outs[0], n->id);
    }
}

static void choose(block_pass *b)
{
    find_nodes(b);
    link_chains(b);
    for (int k = 0; k < b->g->n_nodes; k++)
        if (b->g->node[k])
            count_node(b, b->g->node[k]);
    for (int k = 0; k < b->g->n_nodes; k++)
        if (b->gain[chain_of(b, k)] <= 0)
            b->takes[k] = 0;
}

/* ---- the new graph ---- */

/* What was recorded last becomes the next node of the list. */
static void take_recorded(block_pass *b)
{
    b->order[b->n++] = b->g->node[--b->g->n_nodes];
}

static lt_tensor *record(block_pass *b, const lt_op *op, const blocks_attr *attr, lt_tensor *in)
{
    lt_tensor *out = lt_apply(op, attr, sizeof(*attr), &in, 1);

    if (b->g->status == LT_OK)
        take_recorded(b);
    return out;
}

/* Results of the chain become tensors of their own. */
static lt_status make_blocks(block_pass *b, lt_node *n)
{
    lt_tensor *t = n->outs[0];
    lt_tensor *own = lt_tensor_new(b->g, LT_RESULT, t->name, t->dtype, shape_in_blocks(&t->shape));

    if (!own)
        return LT_ENOMEM;
    own->node = n;
    n->outs[0] = own;
    b->blocks[t->id] = own;
    t->node = NULL;
    return LT_OK;
}

static void read_blocks(block_pass *b, lt_node *n, int i)
{
    lt_tensor **own = &b->blocks[n->in[i]->id];

    if (!*own)
        *own = record(b, &to_blocks_op, &(blocks_attr){ 0 }, n->in[i]);
    n->in[i] = *own;
}

/* A plain tensor that the chain made in blocks only */
static void need_plain(block_pass *b, lt_tensor *t)
{
    const blocks_attr attr = { lt_dim(t, 1) };
    lt_node *n;

    if (t->kind != LT_RESULT || t->node)
        return;
    n = record(b, &from_blocks_op, &attr, b->blocks[t->id])->node;
    n->outs[0] = t;
    t->node = n;
}

static lt_status add_node(block_pass *b, lt_node *n)
{
    lt_tensor *made = n->outs[0];

    b->g->scope = n->name;
    for (int i = 0; i < n->n_in; i++) {
        if (reads(b, n, i))
            read_blocks(b, n, i);
        else if (n->in[i])
            need_plain(b, n->in[i]);
    }
    b->order[b->n++] = n;
    if (!(b->takes[n->id] & LT_BLOCKS_OUT))
        return lt_graph_status(b->g);
    if (make_blocks(b, n))
        return LT_ENOMEM;
    if (made->is_output)
        need_plain(b, made);
    return lt_graph_status(b->g);
}

static lt_status rebuild(block_pass *b, int n_nodes)
{
    for (int k = 0; k < n_nodes; k++)
        if (b->g->node[k] && add_node(b, b->g->node[k]))
            return LT_ENOMEM;
    b->g->node = b->order;
    b->g->n_nodes = b->n;
    b->g->nodes_room = (size_t)b->n;
    for (int k = 0; k < b->n; k++)
        b->order[k]->id = k;
    return LT_OK;
}

lt_status pass_block(lt_graph *g)
{
    const size_t nodes = (size_t)g->n_nodes, tensors = (size_t)g->n_tensors;
    block_pass b = {
        .g = g, .takes = lt_arena_array(g->arena, nodes, sizeof(*b.takes)),
        .chain = lt_arena_array(g->arena, nodes, sizeof(*b.chain)),
        .gain = lt_arena_array(g->arena, nodes, sizeof(*b.gain)),
        .met = lt_arena_array(g->arena, tensors, sizeof(*b.met)),
        .blocks = lt_arena_array(g->arena, tensors, sizeof(*b.blocks)),
        .order = lt_arena_array(g->arena, nodes + 2 * tensors, sizeof(*b.order)),
    };

    if (!b.takes || !b.chain || !b.gain || !b.met || !b.blocks || !b.order)
        return lt_error(LT_ENOMEM, "no memory to compile the graph");
    choose(&b);
    return rebuild(&b, g->n_nodes);
}
