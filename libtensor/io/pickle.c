/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pickle reader's opcodes: a stack, marks on it, and a memo.
 *
 * Source: CPython Lib/pickletools.py, protocols 0 to 5.
 */
#include "libtensor/io/pickle.h"

#include "libtensor/io/file.h"
#include "libtensor/io/number.h"
#include "libtensor/io/pickle_machine.h"
#include "libtensor/io/utf8.h"

#include <stdio.h>
#include <string.h>

enum { FIRST_ROOM = 64, SMALL_INTS = 256 };

/* ---- input --------------------------------------------------------------------------------------- */

/* The next n bytes, or NULL and a failure. */
static const uint8_t *take(lt_pmachine *m, uint64_t n)
{
    const uint8_t *p = m->bytes + m->pos;

    if (n > m->n - m->pos) {
        lt_pm_fail(m, "ends early, wants %ju bytes more and has %zu", (uintmax_t)n, m->n - m->pos);
        return NULL;
    }
    m->pos += (size_t)n;
    return p;
}

/* The next n <= 8 bytes as a little-endian number. */
static uint64_t take_uint(lt_pmachine *m, int n)
{
    const uint8_t *p = take(m, (uint64_t)n);
    uint64_t x = 0;

    for (int i = 0; p && i < n; i++)
        x |= (uint64_t)p[i] << (8 * i);
    return x;
}

/* Text up to a newline, which is skipped; NULL after a failure. */
static const char *take_line(lt_pmachine *m, size_t *n)
{
    const uint8_t *start = m->bytes + m->pos;
    const uint8_t *end = m->pos < m->n ? memchr(start, '\n', m->n - m->pos) : NULL;

    *n = 0;
    if (!end) {
        lt_pm_fail(m, "ends early, in a line of text");
        return NULL;
    }
    *n = (size_t)(end - start);
    m->pos += *n + 1;
    return (const char *)start;
}

/* ---- stack, marks, memo -------------------------------------------------------------------------- */

/* array with room for want words, perhaps elsewhere; NULL, and array as it was, after a failure */
static void *grow(lt_pmachine *m, void *array, size_t *room, size_t want)
{
    size_t more = *room ? *room : FIRST_ROOM;
    void *p;

    while (more < want)
        more *= 2;
    if (more == *room)
        return array;
    if (!lt_pm_spend(m, more * sizeof(void *)))
        return NULL;
    p = lt_alloc(more * sizeof(void *));
    if (!p) {
        lt_pm_no_memory(m);
        return NULL;
    }
    if (*room)
        memcpy(p, array, *room * sizeof(void *));
    lt_release(array);
    m->spent -= *room * sizeof(void *);
    *room = more;
    return p;
}

static void push(lt_pmachine *m, lt_pvalue *v)
{
    lt_pvalue **stack = m->status ? NULL : grow(m, m->stack, &m->stack_room, m->n_stack + 1);

    if (!stack)
        return;
    m->stack = stack;
    m->stack[m->n_stack++] = v;
}

/* How low the stack may be popped: to the last mark. */
static size_t floor_of(const lt_pmachine *m)
{
    return m->n_mark ? m->mark[m->n_mark - 1] : 0;
}

static lt_pvalue *top(lt_pmachine *m)
{
    if (m->n_stack > floor_of(m))
        return m->stack[m->n_stack - 1];
    lt_pm_fail(m, "takes from an empty stack");
    return m->none;
}

static lt_pvalue *pop(lt_pmachine *m)
{
    lt_pvalue *v = top(m);

    if (!m->status)
        m->n_stack--;
    return v;
}

/* Everything above the last mark, which goes; still in the stack's memory until the next push. */
static lt_pvalue **pop_mark(lt_pmachine *m, size_t *n)
{
    *n = 0;
    if (m->n_mark == 0) {
        lt_pm_fail(m, "no mark to go back to");
        return NULL;
    }
    m->n_mark--;
    *n = m->n_stack - m->mark[m->n_mark];
    m->n_stack = m->mark[m->n_mark];
    return m->stack ? m->stack + m->n_stack : NULL;
}

/* Every entry before this one took at least two bytes of the file, a value and its MEMOIZE; beyond that a
 * little is granted to whoever counts from elsewhere than 0. */
static void memo_put(lt_pmachine *m, uint64_t index)
{
    lt_pvalue *v = top(m), **memo;

    if (index > m->op_start / 2 + FIRST_ROOM)
        lt_pm_fail(m, "memo index %ju is beyond any that this file can have", (uintmax_t)index);
    memo = m->status ? NULL : grow(m, m->memo, &m->memo_room, (size_t)index + 1);
    if (!memo)
        return;
    m->memo = memo;
    m->memo[index] = v;
}

static void memo_get(lt_pmachine *m, uint64_t index)
{
    if (index >= m->memo_room || !m->memo[index])
        lt_pm_fail(m, "memo index %ju was never stored", (uintmax_t)index);
    else
        push(m, m->memo[index]);
}

/* ---- opcodes: constants -------------------------------------------------------------------------- */

/* Small integers are what files are full of, and are shared. */
static lt_pvalue *make_int(lt_pmachine *m, lt_pkind kind, int64_t x)
{
    const bool small = kind == LT_PINT && x >= 0 && x < SMALL_INTS;
    lt_pvalue *v = small ? m->small_int[x] : NULL;

    if (v)
        return v;
    v = lt_pm_value(m, kind);
    if (m->status)
        return v;
    v->u.integer = x;
    if (small)
        m->small_int[x] = v;
    return v;
}

static void push_int(lt_pmachine *m, lt_pkind kind, int64_t x)
{
    push(m, make_int(m, kind, x));
}

static void push_float(lt_pmachine *m, double x)
{
    lt_pvalue *v = lt_pm_value(m, LT_PFLOAT);

    if (m->status)
        return;
    v->u.number = x;
    push(m, v);
}

static void op_none(lt_pmachine *m)     { push(m, m->none); }
static void op_true(lt_pmachine *m)     { push_int(m, LT_PBOOL, 1); }
static void op_false(lt_pmachine *m)    { push_int(m, LT_PBOOL, 0); }
static void op_binint(lt_pmachine *m)   { push_int(m, LT_PINT, (int32_t)take_uint(m, 4)); }
static void op_binint1(lt_pmachine *m)  { push_int(m, LT_PINT, (int64_t)take_uint(m, 1)); }
static void op_binint2(lt_pmachine *m)  { push_int(m, LT_PINT, (int64_t)take_uint(m, 2)); }

/* A decimal integer that fills the line up to an optional L. */
static bool parse_int(const char *text, size_t n, int64_t *out)
{
    const bool negative = n && text[0] == '-';
    size_t i = negative;

    if (n > i + 1 && text[n - 1] == 'L')
        n--;
    if (i == n)
        return false;
    for (*out = 0; i < n; i++) {
        const int digit = text[i] - '0';

        if (digit < 0 || digit > 9 || __builtin_mul_overflow(*out, 10, out) ||
            __builtin_sub_overflow(*out, digit, out))           /* below zero there is room for one more */
            return false;
    }
    return negative || !__builtin_sub_overflow((int64_t)0, *out, out);
}

static void op_int(lt_pmachine *m)
{
    size_t n;
    const char *text = take_line(m, &n);
    int64_t x = 0;

    if (text && !parse_int(text, n, &x))
        lt_pm_fail(m, "not a 64-bit integer");
    else if (text)
        push_int(m, n == 2 && text[0] == '0' && (text[1] | 1) == '1' ? LT_PBOOL : LT_PINT, x);
}

static void push_long(lt_pmachine *m, uint64_t n)
{
    const uint8_t *p = take(m, n);
    uint64_t x = 0;

    if (!p)
        return;
    if (n > 8) {
        lt_pm_fail(m, "integer of %ju bytes, want at most 8", (uintmax_t)n);
        return;
    }
    for (uint64_t i = 0; i < 8; i++)            /* two's complement: the last bit goes on for ever */
        x |= (uint64_t)(i < n ? p[i] : n && (p[n - 1] & 0x80) ? 0xff : 0) << (8 * i);
    push_int(m, LT_PINT, (int64_t)x);
}

static void op_long1(lt_pmachine *m)    { push_long(m, take_uint(m, 1)); }
static void op_long4(lt_pmachine *m)    { push_long(m, take_uint(m, 4)); }

static void op_float(lt_pmachine *m)
{
    size_t n;
    const char *text = take_line(m, &n), *end;
    char copy[64];
    double x;

    if (!text)
        return;
    if (n >= sizeof(copy)) {
        lt_pm_fail(m, "number of %zu characters", n);
        return;
    }
    memcpy(copy, text, n);
    copy[n] = '\0';
    x = lt_strtod(copy, &end);
    if (n == 0 || end != copy + n)
        lt_pm_fail(m, "not a number");
    else
        push_float(m, x);
}

static void op_binfloat(lt_pmachine *m)
{
    const uint8_t *p = take(m, 8);
    uint64_t bits = 0;
    double x;

    for (int i = 0; p && i < 8; i++)
        bits = bits << 8 | p[i];
    memcpy(&x, &bits, sizeof(x));
    push_float(m, x);
}

/* ---- opcodes: text ------------------------------------------------------------------------------- */

static void push_text(lt_pmachine *m, lt_pkind kind, uint64_t n)
{
    const uint8_t *p = m->status ? NULL : take(m, n);

    if (p)
        push(m, lt_pm_text(m, kind, (const char *)p, (size_t)n));
}

/* Bytes stay where they are: they are what arrays are made of, and copied then. */
static void push_bytes(lt_pmachine *m, uint64_t n)
{
    const uint8_t *p = m->status ? NULL : take(m, n);
    lt_pvalue *v = p ? lt_pm_value(m, LT_PBYTES) : m->none;

    if (m->status)
        return;
    v->u.text = (const char *)p;
    v->n = (size_t)n;
    push(m, v);
}

static void op_str1(lt_pmachine *m)     { push_text(m, LT_PSTR, take_uint(m, 1)); }
static void op_str4(lt_pmachine *m)     { push_text(m, LT_PSTR, take_uint(m, 4)); }
static void op_str8(lt_pmachine *m)     { push_text(m, LT_PSTR, take_uint(m, 8)); }
static void op_bytes1(lt_pmachine *m)   { push_bytes(m, take_uint(m, 1)); }
static void op_bytes4(lt_pmachine *m)   { push_bytes(m, take_uint(m, 4)); }
static void op_bytes8(lt_pmachine *m)   { push_bytes(m, take_uint(m, 8)); }

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    c |= 0x20;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* n hex digits at p < end; false when there are fewer. */
static bool parse_hex(const char *p, const char *end, int n, uint32_t *out)
{
    *out = 0;
    if (end - p < n)
        return false;
    for (int i = 0; i < n; i++) {
        if (hex_digit(p[i]) < 0)
            return false;
        *out = *out << 4 | (uint32_t)hex_digit(p[i]);
    }
    return true;
}

/* What follows a backslash in Python 2's repr of a string; returns its length, 0 when it is wrong. */
static int unescape(const char *p, const char *end, char *out)
{
    static const char plain[] = "\\\\''\"\"a\ab\bf\fn\nr\rt\tv\v";
    uint32_t code;

    if (p == end)
        return 0;
    for (size_t i = 0; i + 1 < sizeof(plain); i += 2) {
        if (*p == plain[i]) {
            *out = plain[i + 1];
            return 1;
        }
    }
    if (*p == 'x' && parse_hex(p + 1, end, 2, &code)) {
        *out = (char)code;
        return 3;
    }
    return 0;
}

/* STRING: a quoted line of Python 2 */
static void op_string(lt_pmachine *m)
{
    size_t n, used = 0;
    const char *p = take_line(m, &n), *end;
    char *out;

    if (!p)
        return;
    if (n < 2 || (*p != '\'' && *p != '"') || p[n - 1] != *p) {
        lt_pm_fail(m, "string without quotes");
        return;
    }
    end = p + n - 1;
    out = lt_pm_alloc(m, n);
    for (p++; out && p < end; used++) {
        int length = 1;

        if (*p != '\\') {
            out[used] = *p++;
            continue;
        }
        length = unescape(p + 1, end, &out[used]);
        if (length == 0) {
            lt_pm_fail(m, "string with an unknown escape");
            return;
        }
        p += 1 + length;
    }
    push(m, lt_pm_text(m, LT_PSTR, out, out ? used : 0));
}

/* UNICODE: a line of Latin-1 with \uXXXX and \UXXXXXXXX */
static void op_unicode(lt_pmachine *m)
{
    size_t n, used = 0;
    const char *p = take_line(m, &n), *end = p ? p + n : NULL;
    char *out = p ? lt_pm_alloc(m, 2 * n + LT_UTF8_MAX) : NULL;

    while (out && p < end) {
        const int digits = *p == '\\' && end - p > 1 ? (p[1] == 'u' ? 4 : p[1] == 'U' ? 8 : 0) : 0;
        uint32_t code = (uint8_t)*p;
        size_t length;

        if (digits && !parse_hex(p + 2, end, digits, &code))
            code = UINT32_MAX;
        length = lt_utf8_put(out + used, code);
        if (length == 0) {
            lt_pm_fail(m, "text with a character that is none");
            return;
        }
        used += length;
        p += digits ? 2 + digits : 1;
    }
    if (out)
        push(m, lt_pm_text(m, LT_PSTR, out, used));
}

/* ---- opcodes: containers ------------------------------------------------------------------------- */

static void push_items(lt_pmachine *m, lt_pkind kind)
{
    size_t n;
    lt_pvalue **item = pop_mark(m, &n);

    if (kind == LT_PDICT && n % 2)
        lt_pm_fail(m, "dict with a key that has no value");
    if (!m->status)
        push(m, lt_pm_items(m, kind, item, kind == LT_PDICT ? n / 2 : n));
}

/* Moves what is above the mark into the container below it. */
static void extend_top(lt_pmachine *m, lt_pkind kind)
{
    size_t n;
    lt_pvalue **item = pop_mark(m, &n), *to = top(m);

    if (to->kind == LT_POBJECT && m->dialect)
        return;                             /* of a class that is a list or dict besides: not looked into */
    if (to->kind != kind)
        lt_pm_fail(m, "adds items to what is no %s",
                   kind == LT_PLIST ? "list" : kind == LT_PSET ? "set" : "dict");
    if (kind == LT_PDICT && n % 2)
        lt_pm_fail(m, "dict with a key that has no value");
    if (!m->status)
        lt_pm_extend(m, to, item, n);
}

static void op_empty_list(lt_pmachine *m)   { push(m, lt_pm_items(m, LT_PLIST, NULL, 0)); }
static void op_empty_tuple(lt_pmachine *m)  { push(m, m->empty); }
static void op_empty_dict(lt_pmachine *m)   { push(m, lt_pm_items(m, LT_PDICT, NULL, 0)); }
static void op_empty_set(lt_pmachine *m)    { push(m, lt_pm_items(m, LT_PSET, NULL, 0)); }
static void op_list(lt_pmachine *m)         { push_items(m, LT_PLIST); }
static void op_tuple(lt_pmachine *m)        { push_items(m, LT_PTUPLE); }
static void op_dict(lt_pmachine *m)         { push_items(m, LT_PDICT); }
static void op_frozenset(lt_pmachine *m)    { push_items(m, LT_PSET); }
static void op_appends(lt_pmachine *m)      { extend_top(m, LT_PLIST); }
static void op_setitems(lt_pmachine *m)     { extend_top(m, LT_PDICT); }
static void op_additems(lt_pmachine *m)     { extend_top(m, LT_PSET); }

static void push_tuple(lt_pmachine *m, size_t n)
{
    if (m->n_stack < floor_of(m) + n) {
        lt_pm_fail(m, "takes from an empty stack");
        return;
    }
    m->n_stack -= n;
    push(m, lt_pm_items(m, LT_PTUPLE, m->stack + m->n_stack, n));
}

static void op_tuple1(lt_pmachine *m)       { push_tuple(m, 1); }
static void op_tuple2(lt_pmachine *m)       { push_tuple(m, 2); }
static void op_tuple3(lt_pmachine *m)       { push_tuple(m, 3); }

static void op_append(lt_pmachine *m)
{
    lt_pvalue *v = pop(m), *list = top(m);

    if (list->kind != LT_PLIST && !(list->kind == LT_POBJECT && m->dialect))
        lt_pm_fail(m, "adds an item to what is no list");
    if (!m->status && list->kind == LT_PLIST)
        lt_pm_extend(m, list, &v, 1);
}

static void op_setitem(lt_pmachine *m)
{
    lt_pvalue *value = pop(m), *key = pop(m), *dict = top(m);
    lt_pvalue *pair[2] = { key, value };

    if (dict->kind != LT_PDICT && !(dict->kind == LT_POBJECT && m->dialect))
        lt_pm_fail(m, "adds an item to what is no dict");
    if (!m->status && dict->kind == LT_PDICT)
        lt_pm_extend(m, dict, pair, 2);
}

/* ---- opcodes: stack and memo --------------------------------------------------------------------- */

static void op_mark(lt_pmachine *m)
{
    size_t *mark = grow(m, m->mark, &m->mark_room, m->n_mark + 1);

    if (!mark)
        return;
    m->mark = mark;
    m->mark[m->n_mark++] = m->n_stack;
}

/* POP takes a mark when there is nothing above it, as Python does. */
static void op_pop(lt_pmachine *m)
{
    if (m->n_mark && m->n_stack == floor_of(m))
        m->n_mark--;
    else
        pop(m);
}

static void op_pop_mark(lt_pmachine *m)
{
    size_t n;

    pop_mark(m, &n);
}

/* The number on a line, for PUT and GET in protocol 0. */
static uint64_t take_index(lt_pmachine *m)
{
    size_t n;
    const char *text = take_line(m, &n);
    int64_t x = 0;

    if (text && (!parse_int(text, n, &x) || x < 0))
        lt_pm_fail(m, "memo index is no number");
    return x < 0 ? 0 : (uint64_t)x;
}

static void get_at(lt_pmachine *m, uint64_t index)
{
    if (!m->status)
        memo_get(m, index);
}

static void op_dup(lt_pmachine *m)          { push(m, top(m)); }
static void op_put(lt_pmachine *m)          { memo_put(m, take_index(m)); }
static void op_binput(lt_pmachine *m)       { memo_put(m, take_uint(m, 1)); }
static void op_long_binput(lt_pmachine *m)  { memo_put(m, take_uint(m, 4)); }
static void op_get(lt_pmachine *m)          { get_at(m, take_index(m)); }
static void op_binget(lt_pmachine *m)       { get_at(m, take_uint(m, 1)); }
static void op_long_binget(lt_pmachine *m)  { get_at(m, take_uint(m, 4)); }

static void op_memoize(lt_pmachine *m)      { memo_put(m, m->n_memoized++); }

/* ---- opcodes: classes ---------------------------------------------------------------------------- */

static void op_global(lt_pmachine *m)
{
    size_t n_module, n_name;
    const char *module = take_line(m, &n_module);
    const char *name = module ? take_line(m, &n_name) : NULL;

    if (name)
        push(m, lt_pm_global(m, module, n_module, name, n_name));
}

static void op_stack_global(lt_pmachine *m)
{
    lt_pvalue *name = pop(m), *module = pop(m);

    if (name->kind != LT_PSTR || module->kind != LT_PSTR)
        lt_pm_fail(m, "a class whose name is no text");
    else
        push(m, lt_pm_global(m, module->u.text, module->n, name->u.text, name->n));
}

static void op_reduce(lt_pmachine *m)
{
    lt_pvalue *args = pop(m), *callee = pop(m);

    if (!m->status)
        push(m, lt_pm_call(m, callee, args));
}

static void op_newobj(lt_pmachine *m)
{
    lt_pvalue *args = pop(m), *class_value = pop(m);

    if (!m->status)
        push(m, lt_pm_new(m, class_value, args));
}

static void op_newobj_ex(lt_pmachine *m)
{
    lt_pvalue *named = pop(m);

    if (named->kind != LT_PDICT || named->n)
        lt_pm_fail(m, "an object made with named arguments");
    op_newobj(m);
}

static void op_build(lt_pmachine *m)
{
    lt_pvalue *state = pop(m), *object = top(m);

    if (!m->status)
        lt_pm_build(m, object, state);
}

static void op_binpersid(lt_pmachine *m)
{
    lt_pvalue *id = pop(m);

    if (m->status)
        return;
    if (m->dialect && m->dialect->persistent)
        push(m, m->dialect->persistent(m, id));
    else
        lt_pm_fail(m, "BINPERSID: names something outside the file");
}

static void op_persid(lt_pmachine *m)
{
    size_t n;
    const char *text = take_line(m, &n);

    if (!text)
        return;
    push(m, lt_pm_text(m, LT_PSTR, text, n));
    op_binpersid(m);
}

/* Opcodes that no data needs: what each would do is in its line. */
static void op_inst(lt_pmachine *m)     { lt_pm_fail(m, "INST: makes an object of an old-style class"); }
static void op_obj(lt_pmachine *m)      { lt_pm_fail(m, "OBJ: makes an object of an old-style class"); }
static void op_ext(lt_pmachine *m)      { lt_pm_fail(m, "EXT: a class by its number in the writer's registry"); }
static void op_buffer(lt_pmachine *m)   { lt_pm_fail(m, "NEXT_BUFFER: bytes that are outside the file"); }
static void op_readonly(lt_pmachine *m) { lt_pm_fail(m, "READONLY_BUFFER: of bytes that are outside the file"); }

/* ---- opcodes: the file --------------------------------------------------------------------------- */

static void op_proto(lt_pmachine *m)
{
    const uint64_t protocol = take_uint(m, 1);

    if (protocol > 5)
        lt_pm_fail(m, "protocol %ju, want 0 to 5", (uintmax_t)protocol);
}

static void op_frame(lt_pmachine *m)        { take_uint(m, 8); }
static void op_stop(lt_pmachine *m)         { m->result = pop(m); }

static void (*const ops[256])(lt_pmachine *) = {
    [0x80] = op_proto, [0x95] = op_frame, ['.'] = op_stop,
    ['('] = op_mark, ['0'] = op_pop, ['1'] = op_pop_mark, ['2'] = op_dup,
    ['N'] = op_none, [0x88] = op_true, [0x89] = op_false,
    ['I'] = op_int, ['L'] = op_int, ['J'] = op_binint, ['K'] = op_binint1, ['M'] = op_binint2,
    [0x8a] = op_long1, [0x8b] = op_long4, ['F'] = op_float, ['G'] = op_binfloat,
    ['S'] = op_string, ['T'] = op_str4, ['U'] = op_str1,
    ['V'] = op_unicode, ['X'] = op_str4, [0x8c] = op_str1, [0x8d] = op_str8,
    ['B'] = op_bytes4, ['C'] = op_bytes1, [0x8e] = op_bytes8, [0x96] = op_bytes8,
    [']'] = op_empty_list, ['a'] = op_append, ['e'] = op_appends, ['l'] = op_list,
    [')'] = op_empty_tuple, ['t'] = op_tuple, [0x85] = op_tuple1, [0x86] = op_tuple2,
    [0x87] = op_tuple3,
    ['}'] = op_empty_dict, ['d'] = op_dict, ['s'] = op_setitem, ['u'] = op_setitems,
    [0x8f] = op_empty_set, [0x90] = op_additems, [0x91] = op_frozenset,
    ['p'] = op_put, ['q'] = op_binput, ['r'] = op_long_binput, [0x94] = op_memoize,
    ['g'] = op_get, ['h'] = op_binget, ['j'] = op_long_binget,
    ['c'] = op_global, [0x93] = op_stack_global, ['R'] = op_reduce, ['b'] = op_build,
    [0x81] = op_newobj, [0x92] = op_newobj_ex, ['P'] = op_persid, ['Q'] = op_binpersid,
    ['i'] = op_inst, ['o'] = op_obj, [0x82] = op_ext, [0x83] = op_ext, [0x84] = op_ext,
    [0x97] = op_buffer, [0x98] = op_readonly,
};

static void run_opcodes(lt_pmachine *m)
{
    while (!m->status && !m->result) {
        const uint8_t *op;

        m->op_start = m->pos;
        op = take(m, 1);
        if (op && !ops[*op])
            lt_pm_fail(m, "opcode 0x%02x is not one that is read", *op);
        else if (op)
            ops[*op](m);
    }
    if (!m->status)
        lt_pm_check(m);
}

lt_status lt_pm_run(lt_pmachine *m, const lt_pvalue **out)
{
    m->none = lt_arena_alloc(m->arena, sizeof(*m->none));
    m->empty = lt_arena_alloc(m->arena, sizeof(*m->empty));
    m->small_int = lt_arena_array(m->arena, SMALL_INTS, sizeof(*m->small_int));
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

lt_status lt_pickle_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                          const lt_pvalue **out)
{
    lt_pmachine m = { .arena = arena, .name = name, .bytes = bytes, .n = n, .file_bytes = n,
                      .budget = lt_pm_budget(n) };

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
