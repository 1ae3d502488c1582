/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What PyTorch's pickled functions mean: a storage is a name and a size, a tensor is a window into one.
 * Both are checked here and get their elements when the container has found them.
 *
 * Source: pytorch torch/_utils.py (_rebuild_tensor and its kin), torch/serialization.py (persistent_load).
 */
#include "libtensor/io/torch/internal.h"

#include <stdio.h>
#include <string.h>

/* A tensor may have marks that many others share, a storage a key; PyTorch's marks are two, its keys numbers. */
enum { MARKS_MAX = 16, KEY_BYTES_MAX = 256 };

/* A storage and a tensor that is not read are values of our own, told apart by these. Of the first own is its
 * lt_torch_storage, of the second why. */
static const char storage_kind[] = "a storage";
const char lt_torch_unread[] = "a tensor that is not read", lt_torch_makers[] = "torch._utils._rebuild_";

static const struct {
    const char *storage, *dtype;
    lt_elem type;
} types[] = {
    { "FloatStorage", "float32", LT_ELEM_F4 }, { "DoubleStorage", "float64", LT_ELEM_F8 },
    { "HalfStorage", "float16", LT_ELEM_F2 }, { "BFloat16Storage", "bfloat16", LT_ELEM_BF16 },
    { "LongStorage", "int64", LT_ELEM_I8 }, { "IntStorage", "int32", LT_ELEM_I4 },
    { "ShortStorage", "int16", LT_ELEM_I2 }, { "CharStorage", "int8", LT_ELEM_I1 },
    { "ByteStorage", "uint8", LT_ELEM_U1 }, { "BoolStorage", "bool", LT_ELEM_BOOL },
    { "UntypedStorage", "uint8", LT_ELEM_U1 },
};

/* Elements that are passed over, and their bytes, which the stream counts in elements. */
static const struct {
    const char *storage;
    uint64_t size;
} unread[] = {
    { "ComplexFloatStorage", 8 }, { "ComplexDoubleStorage", 16 }, { "QInt8Storage", 1 }, { "QUInt8Storage", 1 },
    { "QInt32Storage", 4 },
};

bool lt_torch_type(const char *dotted, lt_elem *out)
{
    const char *name = strrchr(dotted, '.');

    for (size_t i = 0; name && strncmp(dotted, "torch.", 6) == 0 && i < LT_COUNT(types); i++) {
        *out = types[i].type;
        if (strcmp(name + 1, types[i].storage) == 0 || strcmp(name + 1, types[i].dtype) == 0)
            return true;
    }
    return false;
}

/* ---- storages ------------------------------------------------------------------------------------ */

static bool is_size(const lt_pvalue *v)
{
    return v->kind == LT_PINT && v->u.integer >= 0;
}

/* (view_key, begin, count), or None */
static bool take_view(const lt_pvalue *v, lt_torch_storage *s)
{
    s->view_count = s->count;
    if (v->kind == LT_PNONE)
        return true;
    if (v->kind != LT_PTUPLE || v->n != 3 || !is_size(v->u.item[1]) || !is_size(v->u.item[2]))
        return false;
    s->view_begin = (uint64_t)v->u.item[1]->u.integer;
    s->view_count = (uint64_t)v->u.item[2]->u.integer;
    return s->view_begin <= s->count && s->view_count <= s->count - s->view_begin;
}

/* The type of a storage, as bytes where its elements are not read; false where nobody knows how large these are, which
 * matters in the stream alone: there the next one begins behind them. */
static bool take_type(const lt_torch *t, const char *dotted, lt_torch_storage *s)
{
    const char *dot = strrchr(dotted, '.'), *name = dot ? dot + 1 : dotted;
    bool known = false;

    if (lt_torch_type(dotted, &s->type))
        return true;
    s->type = LT_ELEM_U1;
    s->unread = dotted;
    for (size_t i = 0; !known && i < LT_COUNT(unread); i++)
        known = strcmp(unread[i].storage, name) == 0 && !__builtin_mul_overflow(s->count, unread[i].size, &s->count);
    return known || !t->in_stream;
}

/* ("storage", class, key, device, elements) and in the stream a view behind it */
static lt_pvalue *storage(lt_pmachine *m, const lt_pvalue *id)
{
    lt_torch *t = m->context;
    lt_torch_storage *s = lt_pm_alloc(m, sizeof(*s));
    lt_pvalue *v = lt_pm_value(m, LT_POWN), *const *part = id->u.item;

    if (m->status)
        return m->none;
    if (part[1]->kind != LT_PCLASS || part[2]->kind != LT_PSTR || !is_size(part[4])) {
        lt_pm_fail(m, "a storage without class, key and size");
        return m->none;
    }
    if (part[2]->n > KEY_BYTES_MAX)
        lt_pm_fail(m, "a storage with a key of %zu bytes, want at most %d", part[2]->n, KEY_BYTES_MAX);
    *s = (lt_torch_storage){ .key = part[2]->u.text, .count = (uint64_t)part[4]->u.integer, .at = m->op_start };
    s->stored = s->count;
    if (!take_type(t, part[1]->u.text, s))
        lt_pm_fail(m, "a storage of %s, whose elements are not read", part[1]->u.text);
    if (!s->unread && !take_view(id->n == 6 ? part[5] : m->none, s))
        lt_pm_fail(m, "a view beyond its storage");
    s->next = t->storages;
    t->storages = s;
    t->n_storages++;
    v->u.text = storage_kind;
    v->own = s;
    return v;
}

static lt_torch_storage *storage_of(const lt_pvalue *v)
{
    return v->kind == LT_POWN && v->u.text == storage_kind ? v->own : NULL;
}

static lt_pvalue *persistent(lt_pmachine *m, const lt_pvalue *id)
{
    lt_torch *t = m->context;
    const char *kind = id->kind == LT_PTUPLE && id->n > 1 ? lt_pstr(id->u.item[0]) : NULL;

    if (kind && strcmp(kind, "storage") == 0 && (id->n == 5 || id->n == 6))
        return storage(m, id);
    if (kind && strcmp(kind, "module") == 0)        /* its source text stands beside it */
        return id->u.item[1];
    if (t->by_key)
        return t->by_key(m, id);
    lt_pm_fail(m, "names something outside the file that is no storage");
    return m->none;
}

/* ---- tensors ------------------------------------------------------------------------------------- */

static bool take_sizes(const lt_pvalue *v, int rank, int64_t *out)
{
    if (v->kind != LT_PTUPLE || v->n != (size_t)rank)
        return false;
    for (int i = 0; i < rank; i++) {
        if (v->u.item[i]->kind != LT_PINT)
            return false;
        out[i] = v->u.item[i]->u.integer;
    }
    return true;
}

static lt_pvalue *unread_tensor(lt_pmachine *m, const char *what, const char *why)
{
    enum { REASON = 160 };
    char *reason = lt_pm_alloc(m, REASON);
    lt_pvalue *v = lt_pm_value(m, LT_POWN);

    if (m->status)
        return m->none;
    snprintf(reason, REASON, "%s, %s", what, why);
    v->u.text = lt_torch_unread;
    v->own = reason;
    return v;
}

static bool is_unread(const lt_pvalue *v)
{
    return v->kind == LT_POWN && v->u.text == lt_torch_unread;
}

/* An untyped storage is so many bytes; the tensor says of what. */
static lt_torch_storage *retyped(lt_pmachine *m, lt_torch_storage *s, lt_elem type)
{
    if (s->type == type)
        return s;
    lt_torch *t = m->context;
    lt_torch_storage *other = lt_pm_alloc(m, sizeof(*other));

    if (!other)
        return s;
    if (s->type != LT_ELEM_U1 || s->count % lt_elem_size(type))
        lt_pm_fail(m, "a tensor of %s over a storage of %ju bytes", lt_elem_name(type), (uintmax_t)s->count);
    *other = *s;
    other->type = type;
    other->count = s->count / lt_elem_size(type);
    other->view_begin = s->view_begin / lt_elem_size(type);
    other->view_count = s->view_count / lt_elem_size(type);
    other->next = t->storages;
    t->storages = other;
    t->n_storages++;
    return other;
}

static lt_pvalue *tensor(lt_pmachine *m, const lt_pvalue *args, lt_torch_storage *s)
{
    lt_torch *t = m->context;
    lt_torch_tensor *x = lt_pm_alloc(m, sizeof(*x));
    lt_array *array = lt_pm_alloc(m, sizeof(*array));
    lt_pvalue *v = lt_pm_value(m, LT_PARRAY), *const *part = args->u.item;
    int64_t shape[LT_ARRAY_MAX_RANK], stride[LT_ARRAY_MAX_RANK];
    const int rank = part[2]->n <= LT_ARRAY_MAX_RANK ? (int)part[2]->n : 0;
    const char *wrong;

    if (m->status)
        return m->none;
    if (!is_size(part[1]) || !take_sizes(part[2], rank, shape) || !take_sizes(part[3], rank, stride)) {
        lt_pm_fail(m, "a tensor without offset, and a size and stride for each of at most %d dimensions",
                   LT_ARRAY_MAX_RANK);
        return m->none;
    }
    array->type = s->type;
    wrong = lt_torch_view(s, (uint64_t)part[1]->u.integer, rank, shape, stride, array, x);
    if (wrong)
        lt_pm_fail(m, "a tensor with %s of %ju elements", wrong, (uintmax_t)s->view_count);
    lt_torch_add(t, x);
    v->u.array = array;
    return v;
}

static lt_pvalue *bad_tensor(lt_pmachine *m)
{
    lt_pm_fail(m, "a tensor that is not made of a storage, offset, size and stride");
    return m->none;
}

/* Views that negate or conjugate what is stored say so in a dictionary at the end. */
static bool is_marked(lt_pmachine *m, const lt_pvalue *args)
{
    const lt_pvalue *marks = args->n >= 7 ? args->u.item[6] : NULL;
    int64_t neg = 0, conj = 0;

    if (!marks || marks->kind != LT_PDICT)
        return false;
    if (marks->n > MARKS_MAX) {
        lt_pm_fail(m, "a tensor with %zu marks, want at most %d", marks->n, MARKS_MAX);
        return false;
    }
    return (lt_pint(lt_pdict_get(marks, "neg"), &neg) && neg) || (lt_pint(lt_pdict_get(marks, "conj"), &conj) && conj);
}

/* (storage, offset, size, stride, requires_grad, hooks, marks) */
static lt_pvalue *call_tensor(lt_pmachine *m, const lt_pvalue *args)
{
    lt_torch_storage *s = args->n >= 4 ? storage_of(args->u.item[0]) : NULL;

    if (!s)
        return bad_tensor(m);
    if (s->unread)
        return unread_tensor(m, s->unread, "whose elements are not read");
    if (is_marked(m, args))
        return unread_tensor(m, "a negated or conjugated view", "to be saved resolved (torch.resolve_neg)");
    return tensor(m, args, s);
}

/* (storage, offset, size, stride, requires_grad, hooks, dtype, ...) */
static lt_pvalue *call_tensor_v3(lt_pmachine *m, const lt_pvalue *args)
{
    lt_torch_storage *s = args->n >= 7 ? storage_of(args->u.item[0]) : NULL;
    lt_elem type;

    if (!s || args->u.item[6]->kind != LT_PCLASS)
        return bad_tensor(m);
    if (s->unread || !lt_torch_type(args->u.item[6]->u.text, &type))
        return unread_tensor(m, args->u.item[6]->u.text, "whose elements are not read");
    return tensor(m, args, retyped(m, s, type));
}

/* (tensor, requires_grad, hooks, ...): the tensor */
static lt_pvalue *call_parameter(lt_pmachine *m, const lt_pvalue *args)
{
    lt_pvalue *x = args->n >= 1 ? args->u.item[0] : m->none;

    return x->kind == LT_PARRAY || x->kind == LT_POBJECT || is_unread(x) ? x : bad_tensor(m);
}

/* (_rebuild_tensor_v2, class, its arguments, attributes): a parameter with attributes of its own. Tensors that are made
 * in another way are left closed. */
static lt_pvalue *call_from_type(lt_pmachine *m, const lt_pvalue *args)
{
    lt_pvalue *const *part = args->u.item;
    const char *maker = args->n == 4 && part[0]->kind == LT_PCLASS ? part[0]->u.text : "";

    if (strncmp(maker, lt_torch_makers, strlen(lt_torch_makers)) != 0 || part[2]->kind != LT_PTUPLE)
        return bad_tensor(m);
    if (strcmp(maker, "torch._utils._rebuild_tensor_v2") == 0)
        return call_tensor(m, part[2]);
    return strcmp(maker, "torch._utils._rebuild_tensor_v3") == 0 ? call_tensor_v3(m, part[2]) : lt_pm_object(m, maker);
}

/* Size((2, 3)): the tuple */
static lt_pvalue *call_size(lt_pmachine *m, const lt_pvalue *args)
{
    if (args->n == 1 && args->u.item[0]->kind == LT_PTUPLE)
        return args->u.item[0];
    lt_pm_fail(m, "a torch.Size of what is no tuple");
    return m->none;
}

/* device("cpu"): where it was, which is of no meaning here */
static lt_pvalue *call_device(lt_pmachine *m, const lt_pvalue *args)
{
    (void)args;
    return m->none;
}

static const lt_pm_class classes[] = {
    { "torch._utils", "_rebuild_tensor", call_tensor },
    { "torch._utils", "_rebuild_tensor_v2", call_tensor },
    { "torch._utils", "_rebuild_tensor_v3", call_tensor_v3 },
    { "torch._utils", "_rebuild_parameter", call_parameter },
    { "torch._utils", "_rebuild_parameter_with_state", call_parameter },
    { "torch._tensor", "_rebuild_from_type_v2", call_from_type },
    { "torch", "Size", call_size },
    { "torch", "device", call_device },
};

static const lt_pm_dialect dialect = { .classes = classes, .n = LT_COUNT(classes), .persistent = persistent };

lt_status lt_torch_pickle(lt_torch *t, const char *name, const uint8_t *bytes, size_t n, size_t *pos,
                          const lt_pvalue **out)
{
    lt_pmachine m = {
        .arena = t->arena, .name = name, .bytes = bytes, .n = n, .pos = *pos, .file_bytes = t->n,
        .dialect = &dialect, .context = t, .budget = lt_pm_budget(t->n), .spent = t->spent,
    };
    const lt_status st = lt_pm_run(&m, out);

    *pos = m.pos;
    t->spent = m.spent;
    return st;
}
