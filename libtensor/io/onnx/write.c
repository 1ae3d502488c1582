/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A model as bytes: one function for each message of onnx.proto.
 */
#include "libtensor/io/onnx/fields.h"
#include "libtensor/io/onnx/onnx.h"
#include "libtensor/io/protobuf.h"

static void put_tensor(pb_sink *s, const void *what)
{
    const lt_onnx_tensor *t = what;
    const size_t width = t->type == LT_ONNX_INT64 ? 8 : t->type == LT_ONNX_BOOL ? 1 : 4;

    for (int i = 0; i < t->shape.rank; i++)
        pb_put_int(s, TENSOR_DIMS, t->shape.dim[i]);
    pb_put_int(s, TENSOR_TYPE, t->type);
    pb_put_text(s, TENSOR_NAME, t->name);
    pb_put_bytes(s, TENSOR_RAW, t->data, (size_t)lt_shape_numel(&t->shape) * width);
}

static void put_attr(pb_sink *s, const void *what)
{
    const lt_onnx_attr *a = what;

    pb_put_text(s, ATTR_NAME, a->name);
    switch (a->kind) {
    case LT_ONNX_A_FLOAT: pb_put_float(s, ATTR_F, a->f); break;
    case LT_ONNX_A_INT: pb_put_int(s, ATTR_I, a->i); break;
    case LT_ONNX_A_TEXT: pb_put_text(s, ATTR_S, a->text); break;
    case LT_ONNX_A_INTS:
        for (int i = 0; i < a->n_ints; i++)
            pb_put_int(s, ATTR_INTS, a->ints[i]);
        break;
    case LT_ONNX_A_FLOATS:
        for (int i = 0; i < a->n_floats; i++)
            pb_put_float(s, ATTR_FLOATS, a->floats[i]);
        break;
    case LT_ONNX_A_TENSOR: pb_put_message(s, ATTR_T, put_tensor, a->tensor); break;
    }
    pb_put_int(s, ATTR_TYPE, a->kind);
}

static void put_node(pb_sink *s, const void *what)
{
    const lt_onnx_node *n = what;

    for (int i = 0; i < n->n_in; i++)
        pb_put_text(s, NODE_INPUT, n->in[i]);
    for (int i = 0; i < n->n_out; i++)
        pb_put_text(s, NODE_OUTPUT, n->out[i]);
    pb_put_text(s, NODE_NAME, n->name);
    pb_put_text(s, NODE_OP, n->op);
    for (int i = 0; i < n->n_attr; i++)
        pb_put_message(s, NODE_ATTRIBUTE, put_attr, &n->attr[i]);
}

/* ---- inputs and outputs ------------------------------------------------------------------------------------- */

static void put_dim(pb_sink *s, const void *what)
{
    const int64_t n = *(const int64_t *)what;

    if (n >= 0)
        pb_put_int(s, DIM_VALUE, n);
    else
        pb_put_text(s, DIM_PARAM, "batch");
}

static void put_shape(pb_sink *s, const void *what)
{
    const lt_shape *shape = what;

    for (int i = 0; i < shape->rank; i++)
        pb_put_message(s, SHAPE_DIM, put_dim, &shape->dim[i]);
}

static void put_tensor_type(pb_sink *s, const void *what)
{
    const lt_onnx_port *p = what;

    pb_put_int(s, TENSOR_TYPE_ELEM, p->type);
    pb_put_message(s, TENSOR_TYPE_SHAPE, put_shape, &p->shape);
}

static void put_type(pb_sink *s, const void *what)
{
    pb_put_message(s, TYPE_TENSOR, put_tensor_type, what);
}

static void put_port(pb_sink *s, const void *what)
{
    pb_put_text(s, VALUE_NAME, ((const lt_onnx_port *)what)->name);
    pb_put_message(s, VALUE_TYPE, put_type, what);
}

/* ---- the whole ------------------------------------------------------------------------------------------------ */

static void put_graph(pb_sink *s, const void *what)
{
    const lt_onnx_model *m = what;

    for (int i = 0; i < m->n_nodes; i++)
        pb_put_message(s, GRAPH_NODE, put_node, &m->node[i]);
    pb_put_text(s, GRAPH_NAME, m->name);
    for (int i = 0; i < m->n_tensors; i++)
        pb_put_message(s, GRAPH_INITIALIZER, put_tensor, &m->tensor[i]);
    for (int i = 0; i < m->n_inputs; i++)
        pb_put_message(s, GRAPH_INPUT, put_port, &m->input[i]);
    for (int i = 0; i < m->n_outputs; i++)
        pb_put_message(s, GRAPH_OUTPUT, put_port, &m->output[i]);
}

static void put_opset(pb_sink *s, const void *what)
{
    pb_put_text(s, OPSET_DOMAIN, "");
    pb_put_int(s, OPSET_VERSION, ((const lt_onnx_model *)what)->opset);
}

static void put_meta(pb_sink *s, const void *what)
{
    const lt_onnx_text *t = what;

    pb_put_text(s, META_KEY, t->key);
    pb_put_text(s, META_VALUE, t->value);
}

static void put_model(pb_sink *s, const lt_onnx_model *m)
{
    pb_put_int(s, MODEL_IR, LT_ONNX_IR);
    if (m->producer)
        pb_put_text(s, MODEL_PRODUCER, m->producer);
    if (m->version)
        pb_put_text(s, MODEL_PRODUCER_VERSION, m->version);
    pb_put_message(s, MODEL_GRAPH, put_graph, m);
    pb_put_message(s, MODEL_OPSET, put_opset, m);
    for (int i = 0; i < m->n_meta; i++)
        pb_put_message(s, MODEL_META, put_meta, &m->meta[i]);
}

lt_status lt_onnx_write(FILE *f, const char *name, const lt_onnx_model *m)
{
    pb_sink size = { NULL, 0 }, out = { f, 0 };

    put_model(&size, m);
    if (size.bytes > INT32_MAX)
        return lt_error(LT_EINVAL, "%s: %ju bytes, but an ONNX file holds at most %d", name, (uintmax_t)size.bytes,
                        INT32_MAX);
    put_model(&out, m);
    return LT_OK;
}
