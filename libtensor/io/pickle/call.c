/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The classes and functions of a pickle, and what calling and building them means. Those of the table become the
 * values that they stand for. Any other name stays what it is, text: calling it makes an object that nobody opens.
 * Nothing is ever looked up anywhere else, and nothing is run.
 */
#include "libtensor/io/pickle/machine.h"

#include "libtensor/io/text/utf8.h"

#include <string.h>

typedef lt_pvalue *call_fn(lt_pmachine *m, const lt_pvalue *args);

static call_fn call_encode, call_dict, call_list, call_tuple, call_set, call_bytes, call_value, call_reconstructor;

static const lt_pm_class table[] = {
    { "numpy.core.multiarray", "_reconstruct", lt_pm_numpy_reconstruct },
    { "numpy._core.multiarray", "_reconstruct", lt_pm_numpy_reconstruct },
    { "numpy.core.multiarray", "scalar", lt_pm_numpy_scalar },
    { "numpy._core.multiarray", "scalar", lt_pm_numpy_scalar },
    { "numpy.core.numeric", "_frombuffer", lt_pm_numpy_frombuffer },
    { "numpy._core.numeric", "_frombuffer", lt_pm_numpy_frombuffer },
    { "numpy", "dtype", lt_pm_numpy_dtype },
    { "_codecs", "encode", call_encode },
    { "collections", "OrderedDict", call_dict },
    { "collections", "defaultdict", call_dict },
    { "builtins", "dict", call_dict },
    { "builtins", "list", call_list },
    { "builtins", "tuple", call_tuple },
    { "builtins", "slice", call_value },
    { "builtins", "set", call_set },
    { "builtins", "frozenset", call_set },
    { "builtins", "bytes", call_bytes },
    { "builtins", "bytearray", call_bytes },
    { "builtins", "int", call_value }, { "builtins", "long", call_value },
    { "builtins", "float", call_value }, { "builtins", "bool", call_value },
    { "builtins", "str", call_value },
    { "copyreg", "_reconstructor", call_reconstructor },
};

static bool text_is(const char *text, size_t n, const char *want)
{
    return n == strlen(want) && memcmp(text, want, n) == 0;
}

/* Python 2 knew these modules by other names. */
static bool module_is(const char *text, size_t n, const char *want)
{
    return text_is(text, n, want) ||
           (strcmp(want, "builtins") == 0 && text_is(text, n, "__builtin__")) ||
           (strcmp(want, "copyreg") == 0 && text_is(text, n, "copy_reg"));
}

/* ---- names --------------------------------------------------------------------------------------- */

/* A class value's mark is its place in the table, or behind that in the dialect's, or UNKNOWN. */
enum { UNKNOWN = LT_COUNT(table) + (1 << 16) };

/* NULL for a name that nobody knows. */
static const lt_pm_class *class_at(const lt_pmachine *m, size_t i)
{
    if (i == UNKNOWN)
        return NULL;
    return i < LT_COUNT(table) ? &table[i] : &m->dialect->classes[i - LT_COUNT(table)];
}

static size_t find_class(const lt_pmachine *m, const char *module, size_t n_module, const char *name, size_t n_name)
{
    const size_t n = LT_COUNT(table) + (m->dialect ? m->dialect->n : 0);

    for (size_t i = 0; i < n; i++) {
        const lt_pm_class *c = class_at(m, i);

        if (module_is(module, n_module, c->module) && text_is(name, n_name, c->name))
            return i;
    }
    return UNKNOWN;
}

lt_pvalue *lt_pm_global(lt_pmachine *m, const char *module, size_t n_module, const char *name,
                        size_t n_name)
{
    const size_t i = find_class(m, module, n_module, name, n_name);
    lt_pvalue *v;
    char *dotted;

    if (i != UNKNOWN) {
        module = class_at(m, i)->module;            /* what Python 3 calls it */
        n_module = strlen(module);
    }
    dotted = lt_pm_alloc(m, n_module + n_name + 2);
    v = lt_pm_value(m, LT_PCLASS);
    if (m->status)
        return m->none;
    memcpy(dotted, module, n_module);
    dotted[n_module] = '.';
    memcpy(dotted + n_module + 1, name, n_name);
    v->n = n_module + 1 + n_name;
    dotted[v->n] = '\0';
    v->u.text = dotted;
    v->mark = (uint32_t)i;
    return v;
}

/* ---- calling ------------------------------------------------------------------------------------- */

lt_pvalue *lt_pm_object(lt_pmachine *m, const char *class_name)
{
    lt_pvalue *v = lt_pm_value(m, LT_POBJECT);

    if (!m->status)
        v->u.object.class_name = class_name;
    return v;
}

/* An object that stays closed. One that is made of a dict, as many kinds of dicts are, holds what the dict does. */
static lt_pvalue *make_object(lt_pmachine *m, const char *class_name, lt_pvalue *made_of)
{
    lt_pvalue *v = lt_pm_object(m, class_name);

    if (!m->status && (made_of->kind == LT_PDICT || made_of->kind == LT_PLIST))
        v->items = made_of;
    return v;
}

lt_pvalue *lt_pm_call(lt_pmachine *m, lt_pvalue *callee, lt_pvalue *args)
{
    const lt_pm_class *c = callee->kind == LT_PCLASS ? class_at(m, callee->mark) : NULL;
    const char *name = callee->kind == LT_PCLASS ? callee->u.text : NULL;

    if (callee->kind == LT_POBJECT)                 /* what calling an unknown name gave */
        name = callee->u.object.class_name;
    if (!name || args->kind != LT_PTUPLE) {
        lt_pm_fail(m, name ? "calls %s with what is no tuple" : "calls what is no class", name);
        return m->none;
    }
    return c ? c->call(m, args) : make_object(m, name, args->n ? args->u.item[0] : m->none);
}

/* ---- Python's own -------------------------------------------------------------------------------- */

static bool is_sequence(const lt_pvalue *v)
{
    return v->kind == LT_PLIST || v->kind == LT_PTUPLE || v->kind == LT_PSET;
}

/* list(), list(items), and so for tuple and set */
static lt_pvalue *call_sequence(lt_pmachine *m, const lt_pvalue *args, lt_pkind kind, const char *name)
{
    if (args->n == 0)
        return lt_pm_items(m, kind, NULL, 0);
    if (args->n != 1 || !is_sequence(args->u.item[0]))
        return lt_pm_bad_args(m, name);
    return lt_pm_items(m, kind, args->u.item[0]->u.item, args->u.item[0]->n);
}

static lt_pvalue *call_list(lt_pmachine *m, const lt_pvalue *args)
{
    return call_sequence(m, args, LT_PLIST, "list");
}

static lt_pvalue *call_tuple(lt_pmachine *m, const lt_pvalue *args)
{
    return call_sequence(m, args, LT_PTUPLE, "tuple");
}

static lt_pvalue *call_set(lt_pmachine *m, const lt_pvalue *args)
{
    return call_sequence(m, args, LT_PSET, "set");
}

/* dict(), defaultdict(class), and Python 2's OrderedDict([[key, value], ...]) */
static lt_pvalue *call_dict(lt_pmachine *m, const lt_pvalue *args)
{
    const lt_pvalue *pairs = args->n ? args->u.item[args->n - 1] : m->none;
    lt_pvalue **item, *dict;

    if (args->n > 1 || (pairs->kind != LT_PNONE && pairs->kind != LT_PCLASS && pairs->kind != LT_PLIST))
        return lt_pm_bad_args(m, "dict");
    if (pairs->kind != LT_PLIST)
        return lt_pm_items(m, LT_PDICT, NULL, 0);
    item = lt_pm_alloc(m, 2 * pairs->n * sizeof(*item));
    for (size_t i = 0; item && i < pairs->n; i++) {
        const lt_pvalue *pair = pairs->u.item[i];

        if (!is_sequence(pair) || pair->n != 2)
            return lt_pm_bad_args(m, "dict");
        item[2 * i] = pair->u.item[0];
        item[2 * i + 1] = pair->u.item[1];
    }
    dict = item ? lt_pm_items(m, LT_PDICT, item, pairs->n) : m->none;
    return dict;
}

/* int(x), float(x), str(x) and the like: x is that already. slice(a, b, c): the tuple of the three */
static lt_pvalue *call_value(lt_pmachine *m, const lt_pvalue *args)
{
    if (args->n == 3)
        return lt_pm_items(m, LT_PTUPLE, args->u.item, 3);
    if (args->n != 1 || args->u.item[0]->kind > LT_PBYTES)
        return lt_pm_bad_args(m, "a builtin type");
    return args->u.item[0];
}

/* Text whose characters are all below 256, as those bytes: how Python 3 writes bytes at protocol 2. */
static lt_pvalue *latin1_bytes(lt_pmachine *m, const lt_pvalue *text)
{
    const char *p = text->u.text, *end = p + text->n;
    char *out = lt_pm_alloc(m, text->n + 1);
    lt_pvalue *v = lt_pm_value(m, LT_PBYTES);
    size_t n = 0;

    while (!m->status && p < end) {
        const uint32_t code = lt_utf8_next(&p, end);

        if (code > 255)
            lt_pm_fail(m, "bytes written as text with a character above 255");
        out[n++] = (char)code;
    }
    if (m->status)
        return m->none;
    v->u.text = out;
    v->n = n;
    return v;
}

/* _codecs.encode(text, "latin1") */
static lt_pvalue *call_encode(lt_pmachine *m, const lt_pvalue *args)
{
    if (args->n != 2 || args->u.item[0]->kind != LT_PSTR ||
        (!lt_pm_is_text(args->u.item[1], "latin1") && !lt_pm_is_text(args->u.item[1], "latin-1")))
        return lt_pm_bad_args(m, "_codecs.encode");
    return latin1_bytes(m, args->u.item[0]);
}

/* bytes(), bytearray(), bytearray(b), bytearray(text, "latin-1") */
static lt_pvalue *call_bytes(lt_pmachine *m, const lt_pvalue *args)
{
    if (args->n == 2)
        return call_encode(m, args);
    if (args->n == 1 && (args->u.item[0]->kind == LT_PBYTES || args->u.item[0]->kind == LT_PSTR))
        return args->u.item[0];
    return args->n == 0 ? lt_pm_text(m, LT_PBYTES, "", 0) : lt_pm_bad_args(m, "bytes");
}

/* copyreg._reconstructor(class, base, what the base is made of): NEWOBJ before there was NEWOBJ */
static lt_pvalue *call_reconstructor(lt_pmachine *m, const lt_pvalue *args)
{
    if (args->n != 3 || args->u.item[0]->kind != LT_PCLASS)
        return lt_pm_bad_args(m, "copyreg._reconstructor");
    return make_object(m, args->u.item[0]->u.text, args->u.item[2]);
}

/* ---- BUILD --------------------------------------------------------------------------------------- */

void lt_pm_build(lt_pmachine *m, lt_pvalue *object, lt_pvalue *state)
{
    switch (object->kind) {
    case LT_PARRAY:
        lt_pm_build_array(m, object, state);
        break;
    case LT_PDTYPE:
        lt_pm_build_dtype(m, object, state);
        break;
    case LT_POBJECT:
        if (object->u.object.state)
            lt_pm_fail(m, "gives an object its state twice");
        object->u.object.state = state;
        break;
    case LT_PDICT:                      /* attributes of an OrderedDict: of no meaning here */
    case LT_POWN:
        break;
    default:
        lt_pm_fail(m, "gives a state to a value that has none");
    }
}
