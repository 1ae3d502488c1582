/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/onnx/fields.h"
#include "libtensor/io/onnx/reader.h"

#include <string.h>

/* The elements, as they came */
typedef struct {
    const uint8_t *at;
    pb_field raw, packed;
    int n_raw, n_packed;
    int64_t type;
    int64_t dim[LT_MAX_RANK + 1];
    int rank;
} tensor_parts;

static size_t width_of(lt_onnx_type type)
{
    return type == LT_ONNX_INT64 ? 8 : type == LT_ONNX_BOOL ? 1 : 4;
}

static lt_status tensor_field(onnx_reader *r, const pb_field *f, tensor_parts *p, lt_onnx_tensor *t)
{
    switch (f->number) {
    case TENSOR_DIMS: return onnx_add_ints(r, f, p->dim, LT_MAX_RANK + 1, &p->rank);
    case TENSOR_TYPE: return onnx_take_int(r, f, &p->type);
    case TENSOR_NAME: return onnx_take_text(r, f, &t->name);
    case TENSOR_RAW:
        p->raw = *f;
        p->n_raw++;
        return onnx_want(r, f, PB_BYTES);
    case TENSOR_FLOATS: case TENSOR_INT32S: case TENSOR_INT64S:
        p->packed = *f;
        p->n_packed++;
        return onnx_want(r, f, PB_BYTES);
    case TENSOR_EXTERNAL:
        return onnx_bad(r, f->at, "numbers are kept in another file, which is not opened; save the model as one file");
    case TENSOR_LOCATION:
        return f->value == 0 ? LT_OK
                             : onnx_bad(r, f->at, "numbers are kept in another file, which is not opened; save the "
                                        "model as one file");
    default: return LT_OK;
    }
}

static lt_status check_shape(const onnx_reader *r, const tensor_parts *p, lt_shape *shape, size_t *numel)
{
    if (p->rank > LT_MAX_RANK)
        return onnx_bad(r, p->at, "more than %d dimensions", LT_MAX_RANK);
    shape->rank = p->rank;
    *numel = 1;
    for (int i = 0; i < p->rank; i++) {
        shape->dim[i] = p->dim[i];
        if (p->dim[i] < 0 || !lt_size_mul(*numel, (size_t)p->dim[i], numel) || *numel > INT64_MAX / 8)
            return onnx_bad(r, p->at, "a shape that cannot be");
    }
    return LT_OK;
}

/* Packed whole numbers are varints; they become the array that raw ones are. */
static lt_status unpack(onnx_reader *r, const tensor_parts *p, size_t numel, lt_onnx_tensor *t)
{
    pb_span list = p->packed.body;
    char *data;
    lt_status st;

    if (numel > pb_size(list))
        return onnx_bad(r, p->at, "tensor \"%s\" has less data than its shape wants", t->name);
    st = onnx_take(r, p->at, numel, width_of(t->type), &data);
    if (st)
        return st;
    for (size_t i = 0; i < numel; i++) {
        uint64_t x;

        if (!pb_varint(&list, &x))
            return onnx_bad(r, p->at, "tensor \"%s\" has less data than its shape wants", t->name);
        if (t->type == LT_ONNX_BOOL)
            data[i] = x != 0;
        else if (t->type == LT_ONNX_INT64)
            memcpy(data + 8 * i, &x, 8);
        else
            memcpy(data + 4 * i, &(int32_t){ (int32_t)x }, 4);
    }
    t->data = data;
    return list.at == list.end ? LT_OK
                               : onnx_bad(r, p->at, "tensor \"%s\" has more data than its shape wants", t->name);
}

static lt_status take_data(onnx_reader *r, const tensor_parts *p, size_t numel, lt_onnx_tensor *t)
{
    static const uint8_t nothing[1];
    const pb_field *f = p->n_raw ? &p->raw : &p->packed;
    const size_t width = width_of(t->type);

    if (p->n_raw + p->n_packed > 1)
        return onnx_bad(r, p->at, "tensor \"%s\" has its data in several pieces", t->name);
    if (p->n_packed && p->packed.number != TENSOR_FLOATS && t->type != LT_ONNX_FLOAT)
        return unpack(r, p, numel, t);
    if (p->n_packed && (p->packed.number == TENSOR_FLOATS) != (t->type == LT_ONNX_FLOAT))
        return onnx_bad(r, p->at, "tensor \"%s\" has data of another type", t->name);
    if (numel * width != pb_size(f->body))
        return onnx_bad(r, p->at, "tensor \"%s\" has %zu bytes of data, its shape wants %zu", t->name, pb_size(f->body),
                   numel * width);
    t->data = f->body.at ? f->body.at : nothing;
    return LT_OK;
}

lt_status onnx_take_tensor(onnx_reader *r, const pb_field *field, lt_onnx_tensor *t)
{
    tensor_parts p = { .at = field->at };
    pb_span m = field->body;
    lt_status st = onnx_want(r, field, PB_BYTES);
    size_t numel = 0;
    pb_field f;

    t->name = "";
    while (onnx_next(r, &m, &f, &st))
        st = tensor_field(r, &f, &p, t);
    if (st == LT_OK && p.type != LT_ONNX_FLOAT && p.type != LT_ONNX_INT32 && p.type != LT_ONNX_INT64
        && p.type != LT_ONNX_BOOL)
        st = onnx_bad(r, p.at, "tensor \"%s\" is of type %jd; 1 (FLOAT), 6 (INT32), 7 (INT64), 9 (BOOL) are read",
                      t->name, (intmax_t)p.type);
    if (st == LT_OK)
        st = check_shape(r, &p, &t->shape, &numel);
    if (st)
        return st;
    t->type = (lt_onnx_type)p.type;
    return take_data(r, &p, numel, t);
}
