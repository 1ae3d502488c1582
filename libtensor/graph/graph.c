/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/graph/internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- the place of a call -------------------------------------------------------------------------- */

static _Thread_local struct {
    const char *file;
    int line, depth;
} here;

void lt_here_enter(const char *file, int line)
{
    if (here.depth++ == 0) {
        here.file = file;
        here.line = line;
    }
}

lt_tensor *lt_here_leave(lt_tensor *result)
{
    here.depth--;
    return result;
}

const char *lt_where(const char *file, int line, char out[LT_WHERE])
{
    out[0] = '\0';
    if (file)
        snprintf(out, LT_WHERE, " (%s:%d)", file, line);
    return out;
}

/* What passes record is called from nowhere. */
static const char *here_file(void)
{
    return here.depth ? here.file : NULL;
}

/* ---- a graph and its tensors ---------------------------------------------------------------------- */

lt_graph *lt_graph_new(void)
{
    lt_arena *arena = lt_arena_new();
    lt_graph *g = arena ? lt_arena_alloc(arena, sizeof(*g)) : NULL;

    if (g) {
        g->arena = arena;
        g->scope = "";
        g->harmless = lt_arena_alloc(arena, sizeof(lt_tensor));
    }
    if (!g || !g->harmless) {
        lt_arena_free(arena);
        lt_error(LT_ENOMEM, "no memory for a graph");
        return NULL;
    }
    *g->harmless = (lt_tensor){ .name = "", .graph = g, .kind = LT_INPUT, .id = -1 };
    return g;
}

void lt_graph_free(lt_graph *g)
{
    if (g)
        lt_arena_free(g->arena);
}

lt_status lt_graph_status(const lt_graph *g)
{
    return g->status ? lt_error(g->status, "%s", g->error) : LT_OK;
}

static void remember(lt_graph *g, lt_status status, const char *text)
{
    if (g->status)
        return;
    g->status = status;
    snprintf(g->error, sizeof(g->error), "%s", text);
}

static void LT_PRINTF(2, 3) refuse(lt_graph *g, const char *fmt, ...)
{
    char text[sizeof(g->error)];
    va_list args;

    va_start(args, fmt);
    vsnprintf(text, sizeof(text), fmt, args);
    va_end(args);
    remember(g, LT_ESHAPE, text);
}

bool lt_graph_add_tensor(lt_graph *g, lt_tensor *t)
{
    lt_tensor **list = lt_arena_grow(g->arena, g->tensor, (size_t)g->n_tensors, &g->tensors_room, sizeof(*list));

    if (!list) {
        remember(g, LT_ENOMEM, "no memory to record the graph");
        return false;
    }
    g->tensor = list;
    t->id = g->n_tensors;
    g->tensor[g->n_tensors++] = t;
    return true;
}

static bool all_constant(const lt_node *n)
{
    if (n->op->flags & LT_OP_RANDOM)
        return false;
    for (int i = 0; i < n->n_in; i++)
        if (n->in[i] && !lt_is_constant(n->in[i]))
            return false;
    return true;
}

bool lt_graph_add_node(lt_graph *g, lt_node *n)
{
    lt_node **list = lt_arena_grow(g->arena, g->node, (size_t)g->n_nodes, &g->nodes_room, sizeof(*list));

    if (!list) {
        remember(g, LT_ENOMEM, "no memory to record the graph");
        return false;
    }
    g->node = list;
    n->id = g->n_nodes;
    n->constant = all_constant(n);
    g->node[g->n_nodes++] = n;
    return true;
}

lt_tensor *lt_tensor_new(lt_graph *g, lt_tensor_kind kind, const char *name, lt_dtype dtype, lt_shape shape)
{
    lt_tensor *t = lt_arena_alloc(g->arena, sizeof(*t));

    if (!t || !lt_graph_add_tensor(g, t)) {
        remember(g, LT_ENOMEM, "no memory to record the graph");
        return NULL;
    }
    t->shape = shape;
    t->dtype = dtype;
    t->name = name;
    t->graph = g;
    t->kind = kind;
    return t;
}

static lt_tensor *or_harmless(lt_graph *g, lt_tensor *t)
{
    return t ? t : g->harmless;
}

/* A call without a tensor has no graph to keep its mistake in. */
static _Thread_local lt_status stray_status;
static _Thread_local char stray_error[1024];

static lt_tensor *stray(const char *fmt, ...) LT_PRINTF(1, 2);

static lt_tensor *stray(const char *fmt, ...)
{
    char where[LT_WHERE];
    va_list args;
    int n;

    if (stray_status)
        return NULL;
    stray_status = LT_EINVAL;
    va_start(args, fmt);
    n = vsnprintf(stray_error, sizeof(stray_error), fmt, args);
    va_end(args);
    if (n >= 0 && (size_t)n < sizeof(stray_error))
        snprintf(stray_error + n, sizeof(stray_error) - (size_t)n, "%s", lt_where(here_file(), here.line, where));
    return NULL;
}

lt_status lt_take_stray_error(void)
{
    const lt_status st = stray_status;

    stray_status = LT_OK;
    return st ? lt_error(st, "%s", stray_error) : LT_OK;
}

lt_tensor *lt_input(lt_graph *g, const char *name, lt_dtype dtype, int rank, const int64_t *dim)
{
    lt_shape shape = { .rank = rank };
    char text[LT_SHAPE_TEXT];

    if (!g)
        return stray("input \"%s\": there is no graph; lt_graph_new had no memory?", name);
    if (g->status)
        return g->harmless;
    if (rank < 0 || rank > LT_MAX_RANK) {
        refuse(g, "input \"%s\" has rank %d, at most %d is possible", name, rank, LT_MAX_RANK);
        return g->harmless;
    }
    if (rank)
        memcpy(shape.dim, dim, (size_t)rank * sizeof(dim[0]));
    if (!lt_shape_fits_memory(&shape)) {
        refuse(g, "input \"%s\" is %s, which no memory holds", name, lt_shape_text(&shape, text));
        return g->harmless;
    }
    name = lt_arena_strdup(g->arena, name);
    return or_harmless(g, lt_tensor_new(g, LT_INPUT, name ? name : "", dtype, shape));
}

lt_tensor *lt_use(lt_graph *g, lt_param *p)
{
    lt_tensor *t;

    if (g->status)
        return g->harmless;
    if (p->set && lt_params_status(p->set)) {
        remember(g, lt_params_status(p->set), lt_last_error());
        return g->harmless;
    }
    for (int i = g->n_tensors - 1; i >= 0; i--)         /* mostly just recorded, or never */
        if (g->tensor[i]->param == p)
            return g->tensor[i];
    t = lt_tensor_new(g, LT_PARAM, p->name, LT_F32, p->shape);
    if (t)
        t->param = p;
    return or_harmless(g, t);
}

/* A constant of zeros */
static lt_tensor *constant_new(lt_graph *g, lt_dtype dtype, lt_shape shape)
{
    char text[LT_SHAPE_TEXT];
    lt_tensor *t;

    if (g->status)
        return g->harmless;
    if (!lt_shape_fits_memory(&shape)) {
        refuse(g, "a constant is %s, which no memory holds", lt_shape_text(&shape, text));
        return g->harmless;
    }
    t = lt_tensor_new(g, LT_CONSTANT, "constant", dtype, shape);
    if (!t)
        return g->harmless;
    t->data = lt_arena_alloc(g->arena, lt_nbytes(t));
    if (!t->data) {
        remember(g, LT_ENOMEM, "no memory for a constant");
        return g->harmless;
    }
    return t;
}

lt_tensor *lt_constant(lt_graph *g, lt_dtype dtype, lt_shape shape, const void *values)
{
    lt_tensor *t = constant_new(g, dtype, shape);

    if (t != g->harmless)
        memcpy(t->data, values, lt_nbytes(t));
    return t;
}

lt_real *lt_constant_reals(lt_graph *g, lt_shape shape, lt_tensor **out)
{
    *out = constant_new(g, LT_F32, shape);
    return (*out)->data;
}

lt_tensor *lt_scalar(lt_graph *g, double value)
{
    const lt_real v = (lt_real)value;

    return lt_constant(g, LT_F32, (lt_shape){ 0 }, &v);
}

lt_tensor *lt_output(lt_tensor *t, const char *name)
{
    const char *copy;

    if (!t)
        return stray("output \"%s\": there is no tensor", name);
    copy = lt_arena_strdup(t->graph->arena, name);
    if (t->graph->status == LT_OK) {
        t->is_output = true;
        t->name = copy ? copy : t->name;
    }
    return t;
}

lt_tensor *lt_want_grad(lt_tensor *input)
{
    if (!input)
        return stray("lt_want_grad: there is no tensor");
    if (input->kind == LT_RESULT)
        refuse(input->graph, "a gradient is wanted of \"%s\", a result; only inputs and parameters have one afterwards",
               input->name);
    input->wants_grad = true;
    return input;
}

void lt_scope(lt_graph *g, const char *name)
{
    const char *copy = lt_arena_strdup(g->arena, name);

    g->scope = copy ? copy : "";
}

/* ---- recording ops -------------------------------------------------------------------------------- */

static lt_graph *graph_of(lt_tensor *const *in, int n_in)
{
    for (int i = 0; i < n_in; i++)
        if (in[i])
            return in[i]->graph;
    return NULL;
}

/* A layer is named after its first parameter, "a.b.weight" -> "a.b"; else after the scope. */
static const char *layer_name(lt_graph *g, const lt_node *n)
{
    for (int i = 0; i < n->n_in; i++) {
        const char *dot, *name = n->in[i] && n->in[i]->kind == LT_PARAM ? n->in[i]->name : NULL;

        if (name && (dot = strrchr(name, '.'))) {
            char *copy = lt_arena_strdup(g->arena, name);

            if (copy)
                copy[dot - name] = '\0';
            return copy ? copy : "";
        }
    }
    return g->scope;
}

void lt_call_init(lt_call *c, const lt_node *n)
{
    *c = (lt_call){ .attr = n->attr, .node = n, .n_in = n->n_in, .n_out = n->n_out };
    memcpy(c->in, n->in, sizeof(c->in));
    memcpy(c->outs, n->outs, sizeof(c->outs));
    c->out = c->outs[0];
}

enum { NO_SHAPE = -1 };                             /* of a result before the shape rule has set one */

static lt_node *node_new(lt_graph *g, const lt_op *op, const void *attr, size_t attr_bytes,
                         lt_tensor *const *in, int n_in)
{
    lt_node *n = lt_arena_alloc(g->arena, sizeof(*n));

    if (!n)
        return NULL;
    n->attr = lt_arena_alloc(g->arena, attr_bytes);
    if (!n->attr)
        return NULL;
    if (attr_bytes)
        memcpy(n->attr, attr, attr_bytes);
    n->op = op;
    n->attr_bytes = attr_bytes;
    n->n_in = n_in;
    n->n_out = op->n_out ? op->n_out : 1;
    memcpy(n->in, in, (size_t)n_in * sizeof(*in));
    n->file = here_file();
    n->line = here.line;
    n->name = layer_name(g, n);
    for (int i = 0; i < n->n_out; i++) {
        n->outs[i] = lt_tensor_new(g, LT_RESULT, n->name, LT_F32, (lt_shape){ .rank = NO_SHAPE });
        if (!n->outs[i])
            return NULL;
        n->outs[i]->node = n;
    }
    return n;
}

static lt_status check_inputs(lt_call *c)
{
    const lt_graph *g = graph_of(c->in, c->n_in);

    for (int i = 0; i < c->n_in; i++) {
        if (!c->in[i] && !(c->node->op->optional & LT_OPTIONAL_IN(i)))
            return lt_fail(c, "input %d is missing", i);
        if (c->in[i] && c->in[i]->graph != g)
            return lt_fail(c, "input %d belongs to another graph", i);
        if (c->in[i] && c->in[i]->dtype != LT_F32 && !(c->node->op->any_type & LT_ANY_TYPE_IN(i)))
            return lt_fail(c, "input %d holds whole numbers, want real ones", i);
    }
    return LT_OK;
}

static lt_status check_results(lt_call *c)
{
    char text[LT_SHAPE_TEXT];

    for (int i = 0; i < c->n_out; i++) {
        if (c->outs[i]->shape.rank == NO_SHAPE)
            return lt_fail(c, "its shape rule set no shape for result %d", i);
        if (!lt_shape_fits_memory(&c->outs[i]->shape))
            return lt_fail(c, "its result would be %s, which no memory holds",
                           lt_shape_text(&c->outs[i]->shape, text));
    }
    return LT_OK;
}

static bool infer(lt_graph *g, const lt_node *n)
{
    lt_call c;

    lt_call_init(&c, n);
    if (check_inputs(&c))
        return false;
    if (n->op->infer(&c) == LT_OK)
        return check_results(&c) == LT_OK;
    if (g->status == LT_OK)
        lt_fail(&c, "its shape rule refused without a reason");
    return false;
}

lt_tensor *lt_apply(const lt_op *op, const void *attr, size_t attr_bytes, lt_tensor *const *in, int n_in)
{
    lt_graph *g = graph_of(in, n_in);
    char where[LT_WHERE];
    lt_node *n;

    if (!g)
        return stray("%s: no input is there", op->name ? op->name : "an op without a name");
    if (g->status)
        return g->harmless;
    if (!op->name || !op->infer || (!op->forward && !(op->flags & LT_OP_VIEW))) {
        refuse(g, "%s: an op without %s%s", op->name ? op->name : "lt_apply",
               !op->name ? "a name" : !op->infer ? "a shape rule (infer)" : "forward",
               lt_where(here_file(), here.line, where));
        return g->harmless;
    }
    if (n_in > LT_MAX_IN) {
        refuse(g, "%s: %d inputs, at most %d are possible%s", op->name, n_in, LT_MAX_IN,
               lt_where(here_file(), here.line, where));
        return g->harmless;
    }
    n = node_new(g, op, attr, attr_bytes, in, n_in);
    if (!n) {
        remember(g, LT_ENOMEM, "no memory to record the graph");
        return g->harmless;
    }
    if (!infer(g, n) || !lt_graph_add_node(g, n))
        return g->harmless;
    return n->outs[0];
}

bool lt_become(lt_node *node, const lt_op *op, const void *attr, size_t attr_bytes, lt_tensor *const *in, int n_in)
{
    void *copy = lt_arena_alloc(node->outs[0]->graph->arena, attr_bytes);

    if (!copy)
        return false;
    node->op = op;
    node->attr = memcpy(copy, attr, attr_bytes);
    node->attr_bytes = attr_bytes;
    node->n_in = n_in;
    for (int i = 0; i < n_in; i++)
        node->in[i] = in[i];
    return true;
}

lt_tensor *lt_result(lt_tensor *t, int i)
{
    if (!t)
        return stray("lt_result: there is no tensor");
    if (t->node && i >= 0 && i < t->node->n_out)
        return t->node->outs[i];
    if (t != t->graph->harmless)
        refuse(t->graph, "lt_result: result %d of %s, which has %d", i, t->node ? t->node->op->name : "an input",
               t->node ? t->node->n_out : 0);
    return t->graph->harmless;
}

lt_status lt_fail(lt_call *c, const char *fmt, ...)
{
    const lt_node *n = c->node;
    lt_graph *g = graph_of(n->in, n->n_in);
    char why[640], line[1024], where[LT_WHERE];
    va_list args;

    va_start(args, fmt);
    vsnprintf(why, sizeof(why), fmt, args);
    va_end(args);
    snprintf(line, sizeof(line), "%s%s%s%s: %s%s", n->op->name, *n->name ? " \"" : "", n->name,
             *n->name ? "\"" : "", why, lt_where(n->file, n->line, where));
    remember(g, LT_ESHAPE, line);
    return LT_ESHAPE;
}

bool lt_is_constant(const lt_tensor *t)
{
    return t->kind == LT_RESULT ? t->node->constant : t->kind != LT_INPUT;
}
