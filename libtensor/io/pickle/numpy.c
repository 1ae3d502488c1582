/* SPDX-License-Identifier: Apache-2.0 */
/*
 * NumPy's own names in a pickle: dtypes, arrays in both of their forms, scalars. What has elements of Python's is a
 * list of them; what has others that are not read is an object that says so.
 *
 * Source: numpy/core/src/multiarray, __reduce__ and __setstate__ of ndarray, dtype and scalars.
 */
#include "libtensor/io/pickle/machine.h"

#include "libtensor/io/array/raw_array.h"

#include <string.h>

/* A dtype value is the plain array that callers see, then what we need to read elements of it. */
typedef struct {
    lt_array plain;                     /* first: lt_pvalue points to it */
    lt_raw_array raw;
    const char *refused;                /* why elements of it are not read; NULL: they are */
} dtype_value;

static dtype_value *dtype_of(const lt_pvalue *v)
{
    return v->kind == LT_PDTYPE ? (dtype_value *)(void *)v->u.array : NULL;
}

/* dtype("f4", align, copy); its byte order comes with BUILD */
lt_pvalue *lt_pm_numpy_dtype(lt_pmachine *m, const lt_pvalue *args)
{
    dtype_value *d = lt_pm_alloc(m, sizeof(*d));
    lt_pvalue *v = lt_pm_value(m, LT_PDTYPE);
    const char *code;
    size_t n;

    if (m->status)
        return m->none;
    if (args->n < 1 || args->u.item[0]->kind != LT_PSTR)
        return lt_pm_bad_args(m, "numpy.dtype");
    code = args->u.item[0]->u.text;
    n = args->u.item[0]->n;
    memset(d, 0, sizeof(*d));
    if (n && lt_raw_order(&d->raw, *code)) {
        code++;
        n--;
    }
    d->refused = lt_raw_type(&d->raw, code, n);
    d->plain.type = d->raw.type;
    v->u.array = &d->plain;
    return v;
}

/* (version, byte order, None, None, None, ...): no parts, no names, no fields */
void lt_pm_build_dtype(lt_pmachine *m, lt_pvalue *v, const lt_pvalue *state)
{
    dtype_value *d = dtype_of(v);
    bool good = state->kind == LT_PTUPLE && state->n >= 5 && state->u.item[1]->kind == LT_PSTR &&
                state->u.item[1]->n == 1 && lt_raw_order(&d->raw, state->u.item[1]->u.text[0]);

    if (!good)
        lt_pm_fail(m, "state of a numpy.dtype that is not one");
    for (size_t i = 2; good && i < 5; i++)
        if (state->u.item[i]->kind != LT_PNONE)
            d->refused = "elements are structures";
}

/* _reconstruct(ndarray, (0,), "b"), or a class that is one as well, as matrix and memmap are: an array whose elements
 * come with BUILD */
lt_pvalue *lt_pm_numpy_reconstruct(lt_pmachine *m, const lt_pvalue *args)
{
    if (args->n != 3 || args->u.item[0]->kind != LT_PCLASS)
        return lt_pm_bad_args(m, "numpy _reconstruct");
    return lt_pm_value(m, LT_PARRAY);
}

static bool take_shape(lt_raw_array *raw, const lt_pvalue *shape)
{
    if (shape->kind != LT_PTUPLE || shape->n > LT_ARRAY_MAX_RANK)
        return false;
    raw->rank = (int)shape->n;
    for (size_t i = 0; i < shape->n; i++) {
        if (shape->u.item[i]->kind != LT_PINT)
            return false;
        raw->shape[i] = shape->u.item[i]->u.integer;
    }
    return true;
}

/* The next values as lists in lists, from dimension d of a shape on. */
static lt_pvalue *nest(lt_pmachine *m, const lt_raw_array *raw, int d, lt_pvalue *const **item)
{
    lt_pvalue *list;

    if (d == raw->rank)
        return *(*item)++;
    list = lt_pm_items(m, LT_PLIST, NULL, 0);
    for (int64_t i = 0; !m->status && i < raw->shape[d]; i++) {
        lt_pvalue *inner = nest(m, raw, d + 1, item);

        if (!m->status)
            lt_pm_extend(m, list, &inner, 1);
    }
    return list;
}

/* An array of Python's objects: v becomes the list of them, or where it has no dimensions the one that there is. They
 * stand in C order, whatever the array's own is. */
static void fill_objects(lt_pmachine *m, lt_pvalue *v, const lt_raw_array *raw, const lt_pvalue *data)
{
    lt_pvalue *const *item = data->u.item;
    const lt_pvalue *filled;
    size_t count = 1;

    for (int d = 0; d < raw->rank; d++)
        if (raw->shape[d] < 0 || !lt_size_mul(count, (size_t)raw->shape[d], &count))
            count = SIZE_MAX;
    if (data->kind != LT_PLIST || data->n != count) {
        lt_pm_fail(m, "array of Python objects whose list of them is not what its shape wants");
        return;
    }
    filled = count ? nest(m, raw, 0, &item) : lt_pm_items(m, LT_PLIST, NULL, 0);
    if (!m->status)
        *v = *filled;
}

/* The elements of v, out of bytes or of a Python 2 string; exactly as many as the shape wants. */
static void fill_numbers(lt_pmachine *m, lt_pvalue *v, const lt_raw_array *raw, const lt_pvalue *data)
{
    lt_array *a = lt_pm_alloc(m, sizeof(*a));
    size_t want;
    lt_status st;

    if (m->status)
        return;
    if (data->kind != LT_PBYTES && data->kind != LT_PSTR) {
        lt_pm_fail(m, "elements of an array are not given as bytes");
    } else if (!lt_raw_bytes(raw, &want) || want != data->n) {
        lt_pm_fail(m, "array whose elements take %zu bytes, which is not what its shape wants", data->n);
    } else if (lt_pm_spend(m, raw->type == LT_ELEM_TEXT ? 12 * want : want)) {
        st = lt_raw_load(m->arena, raw, (const uint8_t *)data->u.text, a);
        if (st)
            m->status = lt_error_prefix(st, "%s: offset %zu", m->name, m->op_start);
        else
            v->u.array = a;
    }
}

/* An array that nobody can read becomes an object that says why. */
static void close_array(lt_pmachine *m, lt_pvalue *v, const char *why)
{
    static const char start[] = "numpy.ndarray whose ";
    char *name = lt_pm_alloc(m, sizeof(start) + strlen(why));

    if (!name)
        return;
    memcpy(name, start, sizeof(start));
    strcat(name, why);
    *v = (lt_pvalue){ .kind = LT_POBJECT, .u.object.class_name = name };
}

static void fill_array(lt_pmachine *m, lt_pvalue *v, const dtype_value *d, const lt_raw_array *raw,
                       const lt_pvalue *data)
{
    if (d->raw.objects)
        fill_objects(m, v, raw, data);
    else if (d->refused)
        close_array(m, v, d->refused);
    else
        fill_numbers(m, v, raw, data);
}

/* (version, shape, dtype, is_fortran, data), and what a class of somebody's has besides; the oldest files have no
 * version */
void lt_pm_build_array(lt_pmachine *m, lt_pvalue *v, const lt_pvalue *state)
{
    const size_t first = state->kind == LT_PTUPLE && state->n >= 5;
    const bool good = state->kind == LT_PTUPLE && state->n >= 4 && !v->u.array;
    lt_pvalue *const *part = good ? state->u.item + first : NULL;
    const dtype_value *d = good ? dtype_of(part[1]) : NULL;
    lt_raw_array raw;

    if (good && part[1]->kind == LT_POBJECT) {              /* NumPy's dtypes of variable length, say */
        close_array(m, v, "elements are of a type that is not read");
        return;
    }
    if (!d || (part[2]->kind != LT_PBOOL && part[2]->kind != LT_PINT)) {
        lt_pm_fail(m, "state of a numpy.ndarray that is not one");
        return;
    }
    raw = d->raw;
    raw.fortran = part[2]->u.integer != 0;
    if (!take_shape(&raw, part[0]))
        lt_pm_fail(m, "shape of an array is not a tuple of at most %d integers", LT_ARRAY_MAX_RANK);
    else
        fill_array(m, v, d, &raw, part[3]);
}

/* _frombuffer(bytes, dtype, shape, "C" or "F"): protocol 5 */
lt_pvalue *lt_pm_numpy_frombuffer(lt_pmachine *m, const lt_pvalue *args)
{
    const dtype_value *d = args->n == 4 ? dtype_of(args->u.item[1]) : NULL;
    lt_pvalue *v = lt_pm_value(m, LT_PARRAY);
    lt_raw_array raw;

    if (!d || args->u.item[3]->kind != LT_PSTR)
        return lt_pm_bad_args(m, "numpy _frombuffer");
    raw = d->raw;
    raw.fortran = lt_pm_is_text(args->u.item[3], "F");
    if (!take_shape(&raw, args->u.item[2]))
        return lt_pm_bad_args(m, "numpy _frombuffer");
    fill_array(m, v, d, &raw, args->u.item[0]);
    return v;
}

/* scalar(dtype, bytes): an array of rank 0 */
lt_pvalue *lt_pm_numpy_scalar(lt_pmachine *m, const lt_pvalue *args)
{
    const dtype_value *d = args->n == 2 ? dtype_of(args->u.item[0]) : NULL;
    lt_pvalue *v = lt_pm_value(m, LT_PARRAY);

    if (!d)
        return lt_pm_bad_args(m, "numpy scalar");
    fill_array(m, v, d, &d->raw, args->u.item[1]);
    return v;
}
