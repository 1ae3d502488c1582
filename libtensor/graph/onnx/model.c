/* SPDX-License-Identifier: Apache-2.0 */
/* The model that is being described: its mistakes, memory, names, and its lists of operators and tensors. */
#include "libtensor/graph/onnx/internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

lt_status lt_onnx_fail(lt_onnx *w, lt_status status, const char *fmt, ...)
{
    va_list args;

    if (w->status)
        return w->status;
    w->status = status;
    va_start(args, fmt);
    lt_verror(status, fmt, args);
    va_end(args);
    return status;
}

void lt_onnx_refuse(lt_onnx *w, const char *fmt, ...)
{
    char why[512], where[LT_WHERE];
    va_list args;

    va_start(args, fmt);
    vsnprintf(why, sizeof(why), fmt, args);
    va_end(args);
    lt_onnx_fail(w, LT_EINVAL, "%s%s%s%s: %s%s", w->at->op->name, *w->at->name ? " \"" : "", w->at->name,
                 *w->at->name ? "\"" : "", why, lt_where(w->at->file, w->at->line, where));
}

void *lt_onnx_alloc(lt_onnx *w, size_t count, size_t size)
{
    void *memory = w->status ? NULL : lt_arena_array(w->arena, count, size);

    if (!memory)
        lt_onnx_fail(w, LT_ENOMEM, "no memory to describe the graph");
    return memory;
}

/* ---- names ------------------------------------------------------------------------------------------------------ */

const char *lt_onnx_name_of(lt_onnx *w, const lt_node *n, const char *suffix)
{
    const char *name = lt_arena_printf(w->arena, "%s%s%s.%d%s", n->name, *n->name ? "/" : "", n->op->name, n->id,
                                       suffix);

    if (!name)
        lt_onnx_fail(w, LT_ENOMEM, "no memory to describe the graph");
    return name ? name : "";
}

const char *lt_onnx_part_name(lt_onnx *w)
{
    char suffix[32];

    snprintf(suffix, sizeof(suffix), "/%d", ++w->part);
    return lt_onnx_name_of(w, w->at, suffix);
}

/* ---- operators and tensors --------------------------------------------------------------------------------------- */

/* Room for one more in a list. */
static void *grown(lt_onnx *w, void *list, int n, size_t *room, size_t size)
{
    void *longer = w->status ? NULL : lt_arena_grow(w->arena, list, (size_t)n, room, size);

    if (!longer && !w->status)
        lt_onnx_fail(w, LT_ENOMEM, "no memory to describe the model");
    return longer;
}

const char *lt_onnx_put(lt_onnx *w, const char *op, const char *const *in, int n_in)
{
    const lt_onnx_node node = {
        .op = op, .name = lt_onnx_part_name(w), .n_in = n_in, .n_out = 1,
        .in = lt_onnx_alloc(w, (size_t)n_in, sizeof(*node.in)), .out = lt_onnx_alloc(w, 1, sizeof(*node.out)),
    };
    lt_onnx_node *list = grown(w, w->model.node, w->model.n_nodes, &w->nodes_room, sizeof(*list));

    if (w->status)
        return "";
    if (n_in)
        memcpy(node.in, in, (size_t)n_in * sizeof(*in));
    node.out[0] = node.name;
    w->model.node = list;
    list[w->model.n_nodes++] = node;
    return node.out[0];
}

static const void *as_floats(lt_onnx *w, const lt_real *x, int64_t n)
{
    float *copy;

    if (sizeof(*x) == sizeof(*copy))
        return x;
    copy = lt_onnx_alloc(w, (size_t)n, sizeof(*copy));
    for (int64_t i = 0; copy && i < n; i++)
        copy[i] = (float)x[i];
    return copy;
}

const char *lt_onnx_add_tensor(lt_onnx *w, const char *name, lt_onnx_type type, lt_shape shape, const void *data,
                               bool reals)
{
    lt_onnx_tensor *list = grown(w, w->model.tensor, w->model.n_tensors, &w->tensors_room, sizeof(*list));
    const void *bytes = reals ? as_floats(w, data, lt_shape_numel(&shape)) : data;

    if (w->status)
        return "";
    w->model.tensor = list;
    list[w->model.n_tensors++] = (lt_onnx_tensor){ name, type, shape, bytes };
    return name;
}
