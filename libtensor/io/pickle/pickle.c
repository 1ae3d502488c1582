/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pickle reader: opcodes for containers and classes, and the loop over all of them.
 *
 * Source: CPython Lib/pickletools.py, protocols 0 to 5.
 */
#include "libtensor/io/pickle/pickle.h"

#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/pickle/machine.h"

#include <string.h>

/* ---- opcodes: containers ------------------------------------------------------------------------- */

static void push_items(lt_pmachine *m, lt_pkind kind)
{
    size_t n;
    lt_pvalue **item = lt_pm_pop_mark(m, &n);

    if (kind == LT_PDICT && n % 2)
        lt_pm_fail(m, "dict with a key that has no value");
    if (!m->status)
        lt_pm_push(m, lt_pm_items(m, kind, item, kind == LT_PDICT ? n / 2 : n));
}

/* What items are put into: an object has a container for them beside its state. What is put into one besides that is of
 * another kind goes nowhere. */
static lt_pvalue *container(lt_pmachine *m, lt_pvalue *to, lt_pkind kind)
{
    static const char *const names[] = { [LT_PLIST] = "list", [LT_PSET] = "set", [LT_PDICT] = "dict" };

    if (to->kind == LT_POBJECT && to->items && to->items->kind != kind)
        return lt_pm_items(m, kind, NULL, 0);
    if (to->kind == LT_POBJECT) {
        if (!to->items)
            to->items = lt_pm_items(m, kind, NULL, 0);
        to = to->items;
    }
    if (!m->status && to->kind != kind)
        lt_pm_fail(m, "adds items to what is no %s", names[kind]);
    return to;
}

/* Moves what is above the mark into the container below it. */
static void extend_top(lt_pmachine *m, lt_pkind kind)
{
    size_t n;
    lt_pvalue **item = lt_pm_pop_mark(m, &n), *to = container(m, lt_pm_top(m), kind);

    if (kind == LT_PDICT && n % 2)
        lt_pm_fail(m, "dict with a key that has no value");
    if (!m->status)
        lt_pm_extend(m, to, item, n);
}

static void op_empty_list(lt_pmachine *m)   { lt_pm_push(m, lt_pm_items(m, LT_PLIST, NULL, 0)); }
static void op_empty_tuple(lt_pmachine *m)  { lt_pm_push(m, m->empty); }
static void op_empty_dict(lt_pmachine *m)   { lt_pm_push(m, lt_pm_items(m, LT_PDICT, NULL, 0)); }
static void op_empty_set(lt_pmachine *m)    { lt_pm_push(m, lt_pm_items(m, LT_PSET, NULL, 0)); }
static void op_list(lt_pmachine *m)         { push_items(m, LT_PLIST); }
static void op_tuple(lt_pmachine *m)        { push_items(m, LT_PTUPLE); }
static void op_dict(lt_pmachine *m)         { push_items(m, LT_PDICT); }
static void op_frozenset(lt_pmachine *m)    { push_items(m, LT_PSET); }
static void op_appends(lt_pmachine *m)      { extend_top(m, LT_PLIST); }
static void op_setitems(lt_pmachine *m)     { extend_top(m, LT_PDICT); }
static void op_additems(lt_pmachine *m)     { extend_top(m, LT_PSET); }

static void push_tuple(lt_pmachine *m, size_t n)
{
    if (m->n_stack < lt_pm_floor(m) + n) {
        lt_pm_fail(m, "takes from an empty stack");
        return;
    }
    m->n_stack -= n;
    lt_pm_push(m, lt_pm_items(m, LT_PTUPLE, m->stack + m->n_stack, n));
}

static void op_tuple1(lt_pmachine *m)       { push_tuple(m, 1); }
static void op_tuple2(lt_pmachine *m)       { push_tuple(m, 2); }
static void op_tuple3(lt_pmachine *m)       { push_tuple(m, 3); }

static void op_append(lt_pmachine *m)
{
    lt_pvalue *v = lt_pm_pop(m), *list = container(m, lt_pm_top(m), LT_PLIST);

    if (!m->status)
        lt_pm_extend(m, list, &v, 1);
}

static void op_setitem(lt_pmachine *m)
{
    lt_pvalue *value = lt_pm_pop(m), *key = lt_pm_pop(m), *dict = container(m, lt_pm_top(m), LT_PDICT);
    lt_pvalue *pair[2] = { key, value };

    if (!m->status)
        lt_pm_extend(m, dict, pair, 2);
}

/* ---- opcodes: stack and memo --------------------------------------------------------------------- */

/* POP takes a mark when there is nothing above it, as Python does. */
static void op_pop(lt_pmachine *m)
{
    if (m->n_mark && m->n_stack == lt_pm_floor(m))
        m->n_mark--;
    else
        lt_pm_pop(m);
}

static void op_pop_mark(lt_pmachine *m)
{
    size_t n;

    lt_pm_pop_mark(m, &n);
}

/* The number on a line, for PUT and GET in protocol 0. */
static uint64_t take_index(lt_pmachine *m)
{
    size_t n;
    const char *text = lt_pm_take_line(m, &n);
    int64_t x = 0;

    if (text && (!lt_pm_parse_int(text, n, &x) || x < 0))
        lt_pm_fail(m, "memo index is no number");
    return x < 0 ? 0 : (uint64_t)x;
}

static void get_at(lt_pmachine *m, uint64_t index)
{
    if (!m->status)
        lt_pm_memo_get(m, index);
}

static void op_dup(lt_pmachine *m)          { lt_pm_push(m, lt_pm_top(m)); }
static void op_put(lt_pmachine *m)          { lt_pm_memo_put(m, take_index(m)); }
static void op_binput(lt_pmachine *m)       { lt_pm_memo_put(m, lt_pm_take_uint(m, 1)); }
static void op_long_binput(lt_pmachine *m)  { lt_pm_memo_put(m, lt_pm_take_uint(m, 4)); }
static void op_get(lt_pmachine *m)          { get_at(m, take_index(m)); }
static void op_binget(lt_pmachine *m)       { get_at(m, lt_pm_take_uint(m, 1)); }
static void op_long_binget(lt_pmachine *m)  { get_at(m, lt_pm_take_uint(m, 4)); }

static void op_memoize(lt_pmachine *m)      { lt_pm_memo_put(m, m->n_memoized++); }

/* ---- opcodes: classes ---------------------------------------------------------------------------- */

static void op_global(lt_pmachine *m)
{
    size_t n_module, n_name;
    const char *module = lt_pm_take_line(m, &n_module);
    const char *name = module ? lt_pm_take_line(m, &n_name) : NULL;

    if (name)
        lt_pm_push(m, lt_pm_global(m, module, n_module, name, n_name));
}

static void op_stack_global(lt_pmachine *m)
{
    lt_pvalue *name = lt_pm_pop(m), *module = lt_pm_pop(m);

    if (name->kind != LT_PSTR || module->kind != LT_PSTR)
        lt_pm_fail(m, "a class whose name is no text");
    else
        lt_pm_push(m, lt_pm_global(m, module->u.text, module->n, name->u.text, name->n));
}

static void call(lt_pmachine *m, lt_pvalue *callee, lt_pvalue *args)
{
    if (!m->status)
        lt_pm_push(m, lt_pm_call(m, callee, args));
}

static void op_reduce(lt_pmachine *m)
{
    lt_pvalue *args = lt_pm_pop(m);

    call(m, lt_pm_pop(m), args);
}

/* The same with arguments by name, which mean nothing to the classes that are known. */
static void op_newobj_ex(lt_pmachine *m)
{
    if (lt_pm_pop(m)->kind != LT_PDICT)
        lt_pm_fail(m, "an object made with what is no dict of arguments");
    op_reduce(m);
}

/* Python 2's classes: the name in two lines, or the first value above the mark, and arguments above that. */
static void op_inst(lt_pmachine *m)
{
    lt_pvalue *callee, **above;
    size_t n;

    op_global(m);
    callee = lt_pm_pop(m);
    above = lt_pm_pop_mark(m, &n);
    call(m, callee, lt_pm_items(m, LT_PTUPLE, above, n));
}

static void op_obj(lt_pmachine *m)
{
    size_t n;
    lt_pvalue **above = lt_pm_pop_mark(m, &n);

    if (n == 0)
        lt_pm_fail(m, "makes an object of no class");
    if (!m->status)
        call(m, above[0], lt_pm_items(m, LT_PTUPLE, above + 1, n - 1));
}

static void op_build(lt_pmachine *m)
{
    lt_pvalue *state = lt_pm_pop(m), *object = lt_pm_top(m);

    if (!m->status)
        lt_pm_build(m, object, state);
}

static void op_binpersid(lt_pmachine *m)
{
    lt_pvalue *id = lt_pm_pop(m);

    if (m->status)
        return;
    if (m->dialect && m->dialect->persistent)
        lt_pm_push(m, m->dialect->persistent(m, id));
    else
        lt_pm_fail(m, "BINPERSID: names something outside the file");
}

static void op_persid(lt_pmachine *m)
{
    size_t n;
    const char *text = lt_pm_take_line(m, &n);

    if (!text)
        return;
    lt_pm_push(m, lt_pm_text(m, LT_PSTR, text, n));
    op_binpersid(m);
}

/* Opcodes that no data needs: what each would do is in its line. */
static void op_ext(lt_pmachine *m)      { lt_pm_fail(m, "EXT: a class by its number in the writer's registry"); }
static void op_buffer(lt_pmachine *m)   { lt_pm_fail(m, "NEXT_BUFFER: bytes that are outside the file"); }
static void op_readonly(lt_pmachine *m) { lt_pm_fail(m, "READONLY_BUFFER: of bytes that are outside the file"); }

/* ---- opcodes: the file --------------------------------------------------------------------------- */

static void op_proto(lt_pmachine *m)
{
    const uint64_t protocol = lt_pm_take_uint(m, 1);

    if (protocol > 5)
        lt_pm_fail(m, "protocol %ju, want 0 to 5", (uintmax_t)protocol);
}

static void op_frame(lt_pmachine *m)        { lt_pm_take_uint(m, 8); }
static void op_stop(lt_pmachine *m)         { m->result = lt_pm_pop(m); }

static const lt_pm_opcode ops[256] = {
    [0x80] = op_proto, [0x95] = op_frame, ['.'] = op_stop, ['('] = lt_pm_mark, ['0'] = op_pop,
    ['1'] = op_pop_mark, ['2'] = op_dup, [']'] = op_empty_list, ['a'] = op_append, ['e'] = op_appends,
    ['l'] = op_list, [')'] = op_empty_tuple, ['t'] = op_tuple, [0x85] = op_tuple1, [0x86] = op_tuple2,
    [0x87] = op_tuple3, ['}'] = op_empty_dict, ['d'] = op_dict, ['s'] = op_setitem, ['u'] = op_setitems,
    [0x8f] = op_empty_set, [0x90] = op_additems, [0x91] = op_frozenset, ['p'] = op_put, ['q'] = op_binput,
    ['r'] = op_long_binput, [0x94] = op_memoize, ['g'] = op_get, ['h'] = op_binget, ['j'] = op_long_binget,
    ['c'] = op_global, [0x93] = op_stack_global, ['R'] = op_reduce, ['b'] = op_build, [0x81] = op_reduce,
    [0x92] = op_newobj_ex, ['P'] = op_persid, ['Q'] = op_binpersid, ['i'] = op_inst, ['o'] = op_obj,
    [0x82] = op_ext, [0x83] = op_ext, [0x84] = op_ext, [0x97] = op_buffer, [0x98] = op_readonly,
};

static void refuse_opcode(lt_pmachine *m, uint8_t code)
{
    lt_pm_fail(m, "opcode 0x%02x is not one that is read%s", code, m->op_start ? "" : "; is the file a pickle?");
}

static void run_opcodes(lt_pmachine *m)
{
    while (!m->status && !m->result) {
        const uint8_t *code;
        lt_pm_opcode op;

        m->op_start = m->pos;
        code = lt_pm_take(m, 1);
        op = !code ? NULL : ops[*code] ? ops[*code] : lt_pm_scalar(*code);
        if (op)
            op(m);
        else if (code)
            refuse_opcode(m, *code);
    }
    if (!m->status)
        lt_pm_check(m);
}

lt_status lt_pm_run(lt_pmachine *m, const lt_pvalue **out)
{
    m->none = lt_arena_alloc(m->arena, sizeof(*m->none));
    m->empty = lt_arena_alloc(m->arena, sizeof(*m->empty));
    m->small_int = lt_arena_array(m->arena, LT_PM_SMALL_INTS, sizeof(*m->small_int));
    if (!m->none || !m->empty || !m->small_int)
        return lt_error(LT_ENOMEM, "%s: no memory", m->name);
    m->none->kind = LT_PNONE;
    m->empty->kind = LT_PTUPLE;
    run_opcodes(m);
    if (!m->status)
        *out = m->result;
    lt_release(m->stack);
    lt_release(m->mark);
    lt_release(m->memo);
    return m->status;
}

bool lt_pickle_sniff(const uint8_t *bytes, size_t n)
{
    const lt_kind kind = lt_kind_of(bytes, n);

    return kind == LT_KIND_PICKLE || (!kind && memchr("(})]cN", bytes[0], 6));
}

lt_status lt_pickle_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                          const lt_pvalue **out)
{
    lt_pmachine m = { .arena = arena, .name = name, .bytes = bytes, .n = n, .file_bytes = n,
                      .budget = lt_pm_budget(n) };
    const lt_kind kind = lt_kind_of(bytes, n);

    if (kind && kind != LT_KIND_PICKLE)
        return lt_refuse(name, bytes, n, "a pickle of Python");
    return lt_pm_run(&m, out);
}

lt_status lt_pickle_read(lt_arena *arena, const char *path, const lt_pvalue **out)
{
    uint8_t *bytes;
    lt_status st;
    size_t n;

    st = lt_read_file(arena, path, LT_FILE_MAX, &bytes, &n);
    return st ? st : lt_pickle_parse(arena, path, bytes, n, out);
}
