/* SPDX-License-Identifier: Apache-2.0 */
/* What rules ask of the node that they record: its inputs, as tensors or known numbers, and its attributes. */
#include "libtensor/io/onnx/import.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void onnx_fail(onnx_call *c, const char *fmt, ...)
{
    char why[512];
    va_list args;

    if (c->status)
        return;
    va_start(args, fmt);
    vsnprintf(why, sizeof(why), fmt, args);
    va_end(args);
    c->status = lt_error(LT_EFORMAT, "%s \"%s\": %s", c->node->op, c->node->name, why);
}

void onnx_no_memory(onnx_call *c)
{
    if (c->status == LT_OK)
        c->status = lt_error(LT_ENOMEM, "%s \"%s\": no memory", c->node->op, c->node->name);
}

/* A graph that cannot be is the file's mistake. */
lt_status onnx_status(const lt_graph *g, const lt_onnx_node *n)
{
    const lt_status st = lt_graph_status(g);

    return st ? lt_error_prefix(st == LT_ENOMEM ? st : LT_EFORMAT, "%s \"%s\"", n->op, n->name) : LT_OK;
}

/* A constant to be filled, or NULL: what a rule says of the harmless tensor then does not count. */
static lt_real *constant_new(onnx_call *c, lt_shape shape, lt_tensor **out)
{
    lt_real *x = lt_constant_reals(c->g, shape, out);

    if (!x && c->status == LT_OK)
        c->status = onnx_status(c->g, c->node);
    return x;
}

/* Constants are tensors from when someone wants them as such: shapes and indices never are. */
static lt_tensor *constant_tensor(onnx_call *c, const lt_onnx_tensor *k)
{
    const size_t n = (size_t)lt_shape_numel(&k->shape);
    lt_tensor *t;
    lt_real *x = constant_new(c, k->shape, &t);

    for (size_t i = 0; x && i < n; i++) {
        float f;

        memcpy(&f, (const char *)k->data + i * sizeof(f), sizeof(f));
        x[i] = f;
    }
    return t;
}

/* Of any number, as it stands in the file */
static int64_t whole_number(const lt_onnx_tensor *t, size_t i)
{
    int64_t wide;
    int32_t narrow;

    if (t->type == LT_ONNX_BOOL)
        return ((const uint8_t *)t->data)[i] != 0;
    if (t->type == LT_ONNX_INT64) {
        memcpy(&wide, (const char *)t->data + 8 * i, 8);
        return wide;
    }
    memcpy(&narrow, (const char *)t->data + 4 * i, 4);
    return narrow;
}

lt_status onnx_value_of(lt_arena *arena, const lt_onnx_tensor *t, onnx_value *out)
{
    const size_t n = (size_t)lt_shape_numel(&t->shape);
    int64_t *ints;

    *out = (onnx_value){ .shape = t->shape };
    if (t->type == LT_ONNX_FLOAT) {
        out->constant = t;
        return LT_OK;
    }
    out->ints = ints = lt_arena_array(arena, n, sizeof(*ints));
    if (!ints)
        return lt_error(LT_ENOMEM, "no memory for \"%s\"", t->name);
    for (size_t i = 0; i < n; i++)
        ints[i] = whole_number(t, i);
    return LT_OK;
}

bool onnx_has(const onnx_call *c, int i)
{
    return i < c->n_in && c->in[i];
}

lt_tensor *onnx_tensor(onnx_call *c, int i)
{
    onnx_value *v = i < c->n_in ? c->in[i] : NULL;

    if (v && !v->t && v->constant)
        v->t = constant_tensor(c, v->constant);
    if (v && !v->t)
        onnx_fail(c, "input %d holds whole numbers, want reals", i);
    return v ? v->t : NULL;
}

lt_tensor *onnx_either(onnx_call *c, int i)
{
    const lt_shape shape = onnx_shape(c, i);

    if (!onnx_is_known(c, i))
        return onnx_tensor(c, i);
    return onnx_charge(c, lt_shape_numel(&shape)) ? onnx_reals(c, i, shape) : NULL;
}

bool onnx_is_known(const onnx_call *c, int i)
{
    return onnx_has(c, i) && c->in[i]->ints;
}

bool onnx_all_known(const onnx_call *c)
{
    for (int i = 0; i < c->n_in; i++)
        if (!onnx_is_known(c, i))
            return false;
    return c->n_in > 0;
}

bool onnx_all_whole(const onnx_call *c)
{
    int n = 0;

    for (int i = 0; i < c->n_in; i++) {
        const onnx_value *v = c->in[i];

        if (v && !v->ints && !v->whole)
            return false;
        n += v != NULL;
    }
    return n > 0;
}

const int64_t *onnx_ints(onnx_call *c, int i, int *n)
{
    static const int64_t none[1];

    *n = 0;
    if (!onnx_is_known(c, i)) {
        onnx_fail(c, "input %d is not known before the model runs, which is wanted", i);
        return none;
    }
    *n = (int)lt_shape_numel(&c->in[i]->shape);
    return c->in[i]->ints;
}

bool onnx_charge(onnx_call *c, int64_t n)
{
    if (n > ONNX_MAX_LISTED - *c->listed)
        onnx_fail(c, "%jd known numbers, more than %d with those of the nodes before", (intmax_t)n, ONNX_MAX_LISTED);
    else
        *c->listed += n;
    return c->status == LT_OK;
}

int64_t *onnx_list(onnx_call *c, int64_t n)
{
    int64_t *list = onnx_charge(c, n) ? lt_arena_array(c->arena, (size_t)n, sizeof(*list)) : NULL;

    if (!list)
        onnx_no_memory(c);              /* a failure before this one stays */
    return list;
}

lt_tensor *onnx_reals(onnx_call *c, int i, lt_shape shape)
{
    int n;
    const int64_t *whole = onnx_ints(c, i, &n);
    lt_tensor *t;
    lt_real *x = constant_new(c, shape, &t);

    for (int k = 0; x && k < n; k++)
        x[k] = (lt_real)whole[k];
    return t;
}

lt_shape onnx_shape(const onnx_call *c, int i)
{
    const onnx_value *v = i < c->n_in ? c->in[i] : NULL;

    if (!v)
        return (lt_shape){ 0 };
    return v->ints ? v->shape : v->t ? v->t->shape : v->constant->shape;
}

const lt_onnx_attr *onnx_attr(const onnx_call *c, const char *name)
{
    for (int i = 0; i < c->node->n_attr; i++)
        if (strcmp(c->node->attr[i].name, name) == 0)
            return &c->node->attr[i];
    return NULL;
}

static const lt_onnx_attr *attr_of_kind(onnx_call *c, const char *name, lt_onnx_attr_kind kind)
{
    const lt_onnx_attr *a = onnx_attr(c, name);

    if (a && a->kind != kind) {
        onnx_fail(c, "attribute \"%s\" is of kind %d, want %d", name, (int)a->kind, (int)kind);
        return NULL;
    }
    return a;
}

static int64_t within(onnx_call *c, const char *name, int64_t x, int64_t lo, int64_t hi)
{
    if (x >= lo && x <= hi)
        return x;
    onnx_fail(c, "attribute \"%s\" is %jd, want %jd to %jd", name, (intmax_t)x, (intmax_t)lo, (intmax_t)hi);
    return lo;
}

int onnx_attr_int(onnx_call *c, const char *name, int64_t fallback, int64_t lo, int64_t hi)
{
    const lt_onnx_attr *a = attr_of_kind(c, name, LT_ONNX_A_INT);

    return (int)within(c, name, a ? a->i : fallback, lo, hi);
}

int onnx_attr_equal(onnx_call *c, const char *name, int n, int64_t fallback, int64_t lo, int64_t hi)
{
    const lt_onnx_attr *a = attr_of_kind(c, name, LT_ONNX_A_INTS);

    if (!a)
        return (int)within(c, name, fallback, lo, hi);
    if (a->n_ints != n)
        onnx_fail(c, "attribute \"%s\" has %d numbers, want %d", name, a->n_ints, n);
    for (int i = 1; i < a->n_ints; i++)
        if (a->ints[i] != a->ints[0])
            onnx_fail(c, "attribute \"%s\" has numbers that differ, want equal ones", name);
    return (int)within(c, name, a->n_ints ? a->ints[0] : lo, lo, hi);
}

const int64_t *onnx_attr_ints(onnx_call *c, const char *name, int *n)
{
    const lt_onnx_attr *a = attr_of_kind(c, name, LT_ONNX_A_INTS);

    *n = a ? a->n_ints : 0;
    return a ? a->ints : NULL;
}

unsigned onnx_axes(onnx_call *c, int i, int rank)
{
    int n;
    const int64_t *given = onnx_attr_ints(c, "axes", &n);
    unsigned axes = 0;

    if (!given && onnx_has(c, i))
        given = onnx_ints(c, i, &n);
    for (int k = 0; k < n; k++) {
        const int64_t axis = given[k] < 0 ? given[k] + rank : given[k];

        if (axis < 0 || axis >= rank || axes & 1u << axis) {
            onnx_fail(c, "axis %jd of %d dimensions, or twice", (intmax_t)given[k], rank);
            return 0;
        }
        axes |= 1u << axis;
    }
    return axes;
}

int onnx_axis(onnx_call *c, int64_t fallback)
{
    const int rank = onnx_shape(c, 0).rank, axis = onnx_attr_int(c, "axis", fallback, -rank, rank - 1);

    return axis < 0 ? axis + rank : axis;
}

double onnx_attr_float(onnx_call *c, const char *name, double fallback)
{
    const lt_onnx_attr *a = attr_of_kind(c, name, LT_ONNX_A_FLOAT);

    return a ? (double)a->f : fallback;
}

bool onnx_attr_is(onnx_call *c, const char *name, const char *fallback, const char *value)
{
    const lt_onnx_attr *a = attr_of_kind(c, name, LT_ONNX_A_TEXT);

    return strcmp(a ? a->text : fallback, value) == 0;
}

/* ---- broadcasting ------------------------------------------------------------------------------------------------ */

static int64_t dim_from_end(const lt_shape *s, int i)
{
    return i < s->rank ? s->dim[s->rank - 1 - i] : 1;
}

lt_shape onnx_stretched(onnx_call *c, lt_shape a, lt_shape b)
{
    lt_shape out = { .rank = a.rank > b.rank ? a.rank : b.rank };
    char ta[LT_SHAPE_TEXT], tb[LT_SHAPE_TEXT];
    size_t n = 1;

    for (int i = 0; i < out.rank; i++) {
        const int64_t da = dim_from_end(&a, i), db = dim_from_end(&b, i);

        if (da != db && da != 1 && db != 1)
            onnx_fail(c, "%s and %s do not broadcast", lt_shape_text(&a, ta), lt_shape_text(&b, tb));
        out.dim[out.rank - 1 - i] = da == 1 ? db : da;
        if (!lt_size_mul(n, (size_t)out.dim[out.rank - 1 - i], &n) || n > PTRDIFF_MAX / sizeof(int64_t))
            onnx_fail(c, "%s and %s are too large together", lt_shape_text(&a, ta), lt_shape_text(&b, tb));
    }
    return c->status ? (lt_shape){ 0 } : out;
}

int64_t onnx_met(const lt_shape *s, const lt_shape *out, int64_t at)
{
    int64_t place = 0, step = 1;

    for (int i = 0; i < out->rank; i++) {
        const int64_t dim = dim_from_end(out, i), own = dim_from_end(s, i);

        place += own == 1 ? 0 : at % dim * step;
        at /= dim;
        step *= own;
    }
    return place;
}

void onnx_fold(onnx_call *c, int64_t (*fn)(onnx_call *c, const int64_t *x))
{
    lt_shape shape = onnx_shape(c, 0);
    int64_t n, *out, x[ONNX_MAX_IN];

    for (int i = 1; i < c->n_in; i++)
        shape = onnx_stretched(c, shape, onnx_shape(c, i));
    if (c->status)
        return;
    n = lt_shape_numel(&shape);
    out = onnx_list(c, n);
    for (int64_t at = 0; out && at < n; at++) {
        for (int i = 0; i < c->n_in; i++)
            x[i] = c->in[i]->ints[onnx_met(&c->in[i]->shape, &shape, at)];
        out[at] = fn(c, x);
    }
    c->out.ints = out;
    c->out.shape = shape;
}
