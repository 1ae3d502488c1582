/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pickle reader's opcodes for what has no parts: None, numbers, text and bytes.
 *
 * Source: CPython Lib/pickletools.py, protocols 0 to 5.
 */
#include "libtensor/io/pickle/machine.h"
#include "libtensor/io/text/number.h"
#include "libtensor/io/text/utf8.h"

#include <stdio.h>
#include <string.h>

/* ---- constants ----------------------------------------------------------------------------------- */

/* Small integers and truths are what files are full of, and are shared. */
static lt_pvalue *make_int(lt_pmachine *m, lt_pkind kind, int64_t x)
{
    const bool small = x >= 0 && x < LT_PM_SMALL_INTS;
    lt_pvalue **shared = kind == LT_PBOOL ? &m->truth[x] : small ? &m->small_int[x] : NULL;
    lt_pvalue *v = shared ? *shared : NULL;

    if (v)
        return v;
    v = lt_pm_value(m, kind);
    if (m->status)
        return v;
    v->u.integer = x;
    if (shared)
        *shared = v;
    return v;
}

static void push_int(lt_pmachine *m, lt_pkind kind, int64_t x)
{
    lt_pm_push(m, make_int(m, kind, x));
}

static void push_float(lt_pmachine *m, double x)
{
    lt_pvalue *v = lt_pm_value(m, LT_PFLOAT);

    if (m->status)
        return;
    v->u.number = x;
    lt_pm_push(m, v);
}

static void op_none(lt_pmachine *m)     { lt_pm_push(m, m->none); }
static void op_true(lt_pmachine *m)     { push_int(m, LT_PBOOL, 1); }
static void op_false(lt_pmachine *m)    { push_int(m, LT_PBOOL, 0); }
static void op_binint(lt_pmachine *m)   { push_int(m, LT_PINT, (int32_t)lt_pm_take_uint(m, 4)); }
static void op_binint1(lt_pmachine *m)  { push_int(m, LT_PINT, (int64_t)lt_pm_take_uint(m, 1)); }
static void op_binint2(lt_pmachine *m)  { push_int(m, LT_PINT, (int64_t)lt_pm_take_uint(m, 2)); }

/* Digits, a sign before and an L behind them perhaps. */
static bool is_integer(const char *text, size_t n)
{
    size_t i = n && *text == '-';
    const size_t first = i;

    while (i < n && text[i] >= '0' && text[i] <= '9')
        i++;
    return i > first && (i == n || (i + 1 == n && text[i] == 'L'));
}

/* Generators of random numbers have states of 128 bits, which nobody asks for. */
static void push_huge(lt_pmachine *m)
{
    lt_pm_push(m, lt_pm_object(m, "builtins.int"));
}

static void op_int(lt_pmachine *m)
{
    size_t n;
    const char *text = lt_pm_take_line(m, &n);
    int64_t x = 0;

    if (!text)
        return;
    if (lt_pm_parse_int(text, n, &x))
        push_int(m, n == 2 && text[0] == '0' && (text[1] | 1) == '1' ? LT_PBOOL : LT_PINT, x);
    else if (is_integer(text, n))
        push_huge(m);
    else
        lt_pm_fail(m, "not an integer");
}

static void push_long(lt_pmachine *m, uint64_t n)
{
    const uint8_t *p = lt_pm_take(m, n);
    uint64_t x = 0;

    if (!p)
        return;
    if (n > 8) {
        push_huge(m);
        return;
    }
    for (uint64_t i = 0; i < 8; i++)            /* two's complement: the last bit goes on for ever */
        x |= (uint64_t)(i < n ? p[i] : n && (p[n - 1] & 0x80) ? 0xff : 0) << (8 * i);
    push_int(m, LT_PINT, (int64_t)x);
}

static void op_long1(lt_pmachine *m)    { push_long(m, lt_pm_take_uint(m, 1)); }
static void op_long4(lt_pmachine *m)    { push_long(m, lt_pm_take_uint(m, 4)); }

static void op_float(lt_pmachine *m)
{
    size_t n;
    const char *text = lt_pm_take_line(m, &n), *end;
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
    const uint8_t *p = lt_pm_take(m, 8);
    uint64_t bits = 0;
    double x;

    for (int i = 0; p && i < 8; i++)
        bits = bits << 8 | p[i];
    memcpy(&x, &bits, sizeof(x));
    push_float(m, x);
}

/* ---- text ---------------------------------------------------------------------------------------- */

static void push_text(lt_pmachine *m, lt_pkind kind, uint64_t n)
{
    const uint8_t *p = m->status ? NULL : lt_pm_take(m, n);

    if (p)
        lt_pm_push(m, lt_pm_text(m, kind, (const char *)p, (size_t)n));
}

/* Bytes stay where they are: they are what arrays are made of, and copied then. */
static void push_bytes(lt_pmachine *m, uint64_t n)
{
    const uint8_t *p = m->status ? NULL : lt_pm_take(m, n);
    lt_pvalue *v = p ? lt_pm_value(m, LT_PBYTES) : m->none;

    if (m->status)
        return;
    v->u.text = (const char *)p;
    v->n = (size_t)n;
    lt_pm_push(m, v);
}

static void op_str1(lt_pmachine *m)     { push_text(m, LT_PSTR, lt_pm_take_uint(m, 1)); }
static void op_str4(lt_pmachine *m)     { push_text(m, LT_PSTR, lt_pm_take_uint(m, 4)); }
static void op_str8(lt_pmachine *m)     { push_text(m, LT_PSTR, lt_pm_take_uint(m, 8)); }
static void op_bytes1(lt_pmachine *m)   { push_bytes(m, lt_pm_take_uint(m, 1)); }
static void op_bytes4(lt_pmachine *m)   { push_bytes(m, lt_pm_take_uint(m, 4)); }
static void op_bytes8(lt_pmachine *m)   { push_bytes(m, lt_pm_take_uint(m, 8)); }

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
    const char *p = lt_pm_take_line(m, &n), *end;
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
    lt_pm_push(m, lt_pm_text(m, LT_PSTR, out, out ? used : 0));
}

/* UNICODE: a line of Latin-1 with \uXXXX and \UXXXXXXXX */
static void op_unicode(lt_pmachine *m)
{
    size_t n, used = 0;
    const char *p = lt_pm_take_line(m, &n), *end = p ? p + n : NULL;
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
        lt_pm_push(m, lt_pm_text(m, LT_PSTR, out, used));
}

static const lt_pm_opcode ops[256] = {
    ['N'] = op_none, [0x88] = op_true, [0x89] = op_false, ['I'] = op_int, ['L'] = op_int, ['J'] = op_binint,
    ['K'] = op_binint1, ['M'] = op_binint2, [0x8a] = op_long1, [0x8b] = op_long4, ['F'] = op_float,
    ['G'] = op_binfloat, ['S'] = op_string, ['T'] = op_str4, ['U'] = op_str1, ['V'] = op_unicode,
    ['X'] = op_str4, [0x8c] = op_str1, [0x8d] = op_str8, ['B'] = op_bytes4, ['C'] = op_bytes1,
    [0x8e] = op_bytes8, [0x96] = op_bytes8,
};

lt_pm_opcode lt_pm_scalar(uint8_t code)
{
    return ops[code];
}
