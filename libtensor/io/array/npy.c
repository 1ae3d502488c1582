/* SPDX-License-Identifier: Apache-2.0 */
/*
 * NumPy's .npy: a header that is a Python dict literal of three known keys, then the elements.
 */
#include "libtensor/io/array/npy.h"

#include "libtensor/io/array/npy_entry.h"
#include "libtensor/io/array/raw_array.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { HEADER_MAX = 1 << 16 };

static const uint8_t magic[6] = { 0x93, 'N', 'U', 'M', 'P', 'Y' };

/* Where we are in the header's text. */
typedef struct {
    const char *p, *end;
} cursor;

static void skip_space(cursor *c)
{
    while (c->p < c->end && (*c->p == ' ' || *c->p == '\t' || *c->p == '\n' || *c->p == '\r'))
        c->p++;
}

static bool take(cursor *c, char wanted)
{
    skip_space(c);
    if (c->p == c->end || *c->p != wanted)
        return false;
    c->p++;
    return true;
}

static bool take_word(cursor *c, const char *word)
{
    const size_t n = strlen(word);

    skip_space(c);
    if ((size_t)(c->end - c->p) < n || memcmp(c->p, word, n) != 0)
        return false;
    c->p += n;
    return true;
}

/* A quoted string without escapes. */
static bool take_string(cursor *c, const char **text, size_t *n)
{
    const char *quote;

    skip_space(c);
    if (c->p == c->end || (*c->p != '\'' && *c->p != '"'))
        return false;
    quote = memchr(c->p + 1, *c->p, (size_t)(c->end - c->p - 1));
    if (!quote)
        return false;
    *text = c->p + 1;
    *n = (size_t)(quote - *text);
    c->p = quote + 1;
    return true;
}

/* A non-negative integer below 2^31, perhaps with Python 2's L. */
static bool take_int(cursor *c, int64_t *out)
{
    const char *start;

    skip_space(c);
    start = c->p;
    for (*out = 0; c->p < c->end && *c->p >= '0' && *c->p <= '9'; c->p++) {
        *out = *out * 10 + (*c->p - '0');
        if (*out > INT32_MAX)
            return false;
    }
    if (c->p == start)
        return false;
    if (c->p < c->end && *c->p == 'L')
        c->p++;
    return true;
}

/* (), (n,) or (a, b, ...) */
static const char *take_shape(cursor *c, lt_raw_array *raw)
{
    if (!take(c, '('))
        return "shape is no tuple";
    while (!take(c, ')')) {
        if (raw->rank == LT_ARRAY_MAX_RANK)
            return "shape has more than 8 dimensions";
        if (!take_int(c, &raw->shape[raw->rank]))
            return "shape has a dimension that is no number below 2^31";
        raw->rank++;
        if (take(c, ','))
            continue;
        if (take(c, ')'))
            return NULL;
        return "shape is no tuple";
    }
    return NULL;
}

/* Sets *refused for a type that is sound but not for us: nothing after it is looked at. */
static const char *take_descr(cursor *c, lt_raw_array *raw, const char **refused)
{
    const char *text;
    size_t n;

    if (take(c, '[')) {
        *refused = "elements are structures";
        return NULL;
    }
    if (!take_string(c, &text, &n) || n < 2 || !lt_raw_order(raw, text[0]))
        return "descr is no type code such as '<f4'";
    *refused = lt_raw_type(raw, text + 1, n - 1);
    return NULL;
}

static const char *take_fortran(cursor *c, lt_raw_array *raw)
{
    raw->fortran = take_word(c, "True");
    return raw->fortran || take_word(c, "False") ? NULL : "fortran_order is neither True nor False";
}

/* The dict; NULL, or what is wrong with it. */
static const char *parse_header(cursor *c, lt_raw_array *raw, const char **refused)
{
    enum { DESCR = 1, FORTRAN = 2, SHAPE = 4 };
    int seen = 0;

    if (!take(c, '{'))
        return "header is no dict";
    while (!take(c, '}')) {
        const char *key, *wrong;
        size_t n;
        int bit;

        if (!take_string(c, &key, &n) || !take(c, ':'))
            return "header is no dict of string keys";
        if (n == 5 && memcmp(key, "descr", n) == 0) {
            bit = DESCR;
            wrong = take_descr(c, raw, refused);
        } else if (n == 13 && memcmp(key, "fortran_order", n) == 0) {
            bit = FORTRAN;
            wrong = take_fortran(c, raw);
        } else if (n == 5 && memcmp(key, "shape", n) == 0) {
            bit = SHAPE;
            wrong = take_shape(c, raw);
        } else {
            return "header has a key that is none of descr, fortran_order, shape";
        }
        if (wrong || *refused)
            return wrong;
        if (seen & bit)
            return "header has a key twice";
        seen |= bit;
        take(c, ',');
    }
    return seen == (DESCR | FORTRAN | SHAPE) ? NULL : "header lacks descr, fortran_order or shape";
}

/* The header's text, and where the elements start; false when bytes are no .npy file. */
static bool find_header(const uint8_t *bytes, size_t n, cursor *c, size_t *data_start)
{
    size_t length, start = 10;

    if (n < 12 || memcmp(bytes, magic, sizeof(magic)) != 0 || bytes[6] < 1 || bytes[6] > 3)
        return false;
    length = bytes[8] | (size_t)bytes[9] << 8;
    if (bytes[6] > 1) {
        length |= (size_t)bytes[10] << 16 | (size_t)bytes[11] << 24;
        start = 12;
    }
    if (length > HEADER_MAX || length > n - start)
        return false;
    c->p = (const char *)bytes + start;
    c->end = c->p + length;
    *data_start = start + length;
    return true;
}

/* What begins as a .npy file and goes on as none, or does not even begin so. */
static lt_status refuse(const char *name, const uint8_t *bytes, size_t n)
{
    if (lt_kind_of(bytes, n) != LT_KIND_NPY)
        return lt_refuse(name, bytes, n, "a .npy array");
    if (n >= 12 && (bytes[6] < 1 || bytes[6] > 3))
        return lt_error(LT_EFORMAT, "%s: a .npy array of version %d, want 1 to 3", name, bytes[6]);
    return lt_refuse_cut(name, LT_KIND_NPY, "in its header");
}

/* The header in the first n bytes of a file of `all`: how the elements lie, and where they begin. */
static lt_status take_head(const char *name, const uint8_t *bytes, size_t n, size_t all, lt_raw_array *raw,
                           size_t *start, const char **refused)
{
    const char *wrong;
    size_t want;
    cursor c;

    *refused = NULL;
    if (!find_header(bytes, n, &c, start))
        return refuse(name, bytes, n);
    wrong = parse_header(&c, raw, refused);
    if (wrong)
        return lt_error(LT_EFORMAT, "%s: offset %zu: %s", name,
                        (size_t)(c.p - (const char *)bytes), wrong);
    if (*refused)
        return LT_OK;
    if (!lt_raw_bytes(raw, &want))
        return lt_error(LT_EFORMAT, "%s: shape of more than %zu bytes", name, LT_FILE_MAX);
    if (want > all - *start)
        return lt_refuse_cut(name, LT_KIND_NPY, "ends early, header promises %zu bytes of data, found %zu", want,
                             all - *start);
    return LT_OK;
}

lt_status lt_npy_describe(const char *name, const uint8_t *bytes, size_t n, size_t all, lt_array *out,
                          const char **refused)
{
    lt_raw_array raw = { .rank = 0 };
    size_t start;
    const lt_status st = take_head(name, bytes, n, all, &raw, &start, refused);

    if (!st && !*refused)
        *out = lt_array_make(raw.type, raw.rank, raw.shape, NULL);
    return st;
}

lt_status lt_npy_parse_entry(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                             lt_array *out, lt_refused_array *refused)
{
    lt_raw_array raw = { .rank = 0 };
    size_t start = 0;
    lt_status st = take_head(name, bytes, n, n, &raw, &start, &refused->reason);

    if (st)
        return st;
    if (refused->reason) {
        refused->pickle = raw.objects ? bytes + start : NULL;
        refused->n = raw.objects ? n - start : 0;
        return LT_OK;
    }
    st = lt_raw_load(arena, &raw, bytes + start, out);
    return st ? lt_error_prefix(st, "%s", name) : LT_OK;
}

lt_status lt_npy_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_array *out)
{
    lt_refused_array refused;
    lt_status st = lt_npy_parse_entry(arena, name, bytes, n, out, &refused);

    if (!st && refused.reason)
        return lt_error(LT_EFORMAT, "%s: %s", name, refused.reason);
    return st;
}

lt_status lt_npy_read(lt_arena *arena, const char *path, lt_array *out)
{
    lt_file file;
    lt_status st = lt_file_load(&file, path, LT_FILE_MAX);

    if (!st)
        st = lt_npy_parse(arena, path, file.bytes, file.n, out);
    lt_file_free(&file);
    return st;
}

/* The type as NumPy writes it: "<f4", "|u1", "<U7". */
static void format_descr(const lt_array *a, size_t text_width, char *out, size_t size)
{
    static const uint16_t one = 1;
    const char order = *(const uint8_t *)&one ? '<' : '>';

    if (a->type == LT_ELEM_TEXT)
        snprintf(out, size, "%cU%zu", order, text_width);
    else if (a->type == LT_ELEM_BOOL)
        snprintf(out, size, "|b1");
    else
        snprintf(out, size, "%c%s", lt_elem_size(a->type) > 1 ? order : '|', lt_elem_name(a->type));
}

size_t lt_npy_header(const lt_array *a, size_t text_width, uint8_t out[LT_NPY_HEADER_MAX])
{
    char descr[32], shape[8 * 24] = "";
    size_t used = 0, length;

    format_descr(a, text_width, descr, sizeof(descr));
    for (int i = 0; i < a->rank; i++)
        used += (size_t)snprintf(shape + used, sizeof(shape) - used, "%s%" PRId64 "%s", i ? " " : "",
                                 a->shape[i], i + 1 < a->rank || a->rank == 1 ? "," : "");
    memcpy(out, magic, sizeof(magic));
    out[6] = 1;
    out[7] = 0;
    length = 10 + (size_t)snprintf((char *)out + 10, LT_NPY_HEADER_MAX - 10,
                                   "{'descr': '%s', 'fortran_order': False, 'shape': (%s), }", descr,
                                   shape);
    while ((length + 1) % 64)
        out[length++] = ' ';
    out[length++] = '\n';
    out[8] = (uint8_t)(length - 10);
    out[9] = (uint8_t)((length - 10) >> 8);
    return length;
}

lt_status lt_npy_write(const char *path, const lt_array *a)
{
    uint8_t header[LT_NPY_HEADER_MAX];
    lt_atomic_file f;
    lt_status st;
    size_t n;

    if (a->type == LT_ELEM_BF16 || a->type == LT_ELEM_TEXT)
        return lt_error(LT_EINVAL, "%s: a .npy of %s is not written", path, lt_elem_name(a->type));
    if (!lt_array_bytes(a, &n))
        return lt_error(LT_EINVAL, "%s: array with an impossible shape", path);
    st = lt_atomic_open(&f, path);
    if (st)
        return st;
    fwrite(header, 1, lt_npy_header(a, 0, header), f.stream);
    if (n)
        fwrite(a->data, 1, n, f.stream);
    return lt_atomic_commit(&f);
}
