/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Small JSON files, over cJSON.
 */
#include "libtensor/io/text/json.h"

#include "libtensor/base/printable.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/text/number.h"
#include "libtensor/io/text/utf8.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>


/* ---- memory -------------------------------------------------------------------------------------- */

/* cJSON reports a failed allocation like bad JSON, or leaves out what it was for. */
static _Thread_local bool memory_failed;

static void *watched_malloc(size_t n)
{
    void *memory = malloc(n);

    memory_failed = memory_failed || !memory;
    return memory;
}

void lt_json_watch_memory(void)
{
    cJSON_InitHooks(&(cJSON_Hooks){ .malloc_fn = watched_malloc, .free_fn = free });
}

bool lt_json_lacked_memory(void)
{
    const bool failed = memory_failed;

    memory_failed = false;
    return failed;
}

static pthread_once_t watching = PTHREAD_ONCE_INIT;

/* ---- reading ------------------------------------------------------------------------------------- */

static lt_status error_at(const char *name, const char *text, const char *at, const char *reason)
{
    size_t line = 1, column = 1;

    for (const char *p = text; p < at; p++) {
        line += *p == '\n';
        column = *p == '\n' ? 1 : column + 1;
    }
    return lt_error(LT_EFORMAT, "%s:%zu:%zu: %s", name, line, column, reason);
}

/* Past a string whose quote stands at p, or end. */
static const char *skip_string(const char *p, const char *end)
{
    for (p++; p < end && *p != '"'; p++)
        p += *p == '\\' && end - p > 1;
    return p < end ? p + 1 : end;
}

static bool has_nul_escape(const char *p, const char *end)
{
    for (; end - p >= 6; p++) {
        if (memcmp(p, "\\u0000", 6) == 0)
            return true;
        p += *p == '\\';
    }
    return false;
}

/* What cJSON does not look at: it recurses to 1000, cuts a string at \u0000, and takes about 80 bytes for a value,
 * be it two bytes long. words: whether there may be words for numbers. */
static lt_status check_limits(const char *name, const char *text, const char *end, bool *words)
{
    const size_t n = (size_t)(end - text);
    size_t values = 1;
    int depth = 0;

    *words = false;
    for (const char *p = text; p < end;) {
        const char *start = p;

        if (*p == '"') {
            p = skip_string(p, end);
            if (has_nul_escape(start, p))
                return error_at(name, text, start, "string with \\u0000");
            continue;
        }
        depth += *p == '{' || *p == '[';
        depth -= *p == '}' || *p == ']';
        if (depth > LT_JSON_DEPTH)
            return error_at(name, text, p, "nested deeper than 64");
        values += *p == '{' || *p == '[' || *p == ',';
        if (values > 8192 + n / 6)
            return error_at(name, text, p, "more values than a file of its size should have");
        *words |= *p == 'N' || *p == 'I';
        p++;
    }
    return LT_OK;
}

/* A text in which Python's words for numbers, which cJSON does not know, are written over by numbers of the
 * same length: infinities by what is too large, NaN by zeros. */
typedef struct {
    char *text;
    size_t n_numbers, n_nan, *nan;  /* which of the numbers are NaN, ascending */
} plain_text;

static void write_over(plain_text *t, char *word, size_t n)
{
    const bool minus = *word == '-';

    if (n == 3 && memcmp(word, "NaN", 3) == 0) {
        memcpy(word, "0  ", 3);
        t->nan[t->n_nan++] = t->n_numbers++;
    } else if (n == 8 + (size_t)minus && memcmp(word + minus, "Infinity", 8) == 0) {
        memcpy(word + minus, "1e999999", 8);
        t->n_numbers++;
    } else {
        t->n_numbers += minus || (*word >= '0' && *word <= '9');
    }
}

static bool make_plain(lt_arena *arena, const char *text, size_t n, plain_text *out)
{
    static const char token[] = "+-.0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    plain_text t = { .text = lt_arena_alloc(arena, n + 1),
                     .nan = lt_arena_array(arena, n / 3 + 1, sizeof(size_t)) };

    if (!t.text || !t.nan)
        return false;
    memcpy(t.text, text, n);
    t.text[n] = 0;
    for (char *p = t.text, *end = p + n; p < end;) {
        const size_t length = strspn(p, token);

        if (length)
            write_over(&t, p, length);
        p = *p == '"' ? p + (skip_string(p, end) - p) : p + (length ? length : 1);
    }
    *out = t;
    return true;
}

/* Gives the numbers that are NaN their value; at and next count numbers and NaN on the way. */
static void put_nan(cJSON *value, const plain_text *t, size_t *at, size_t *next)
{
    if (cJSON_IsNumber(value)) {
        if (*next < t->n_nan && t->nan[*next] == *at) {
            value->valuedouble = NAN;
            ++*next;
        }
        ++*at;
    }
    for (cJSON *c = value->child; c; c = c->next)
        put_nan(c, t, at, next);
}

/* text as cJSON's tree; NULL when it is not JSON, or goes on behind, and then *stop says from where. */
static cJSON *parse(const char *text, size_t n, size_t *stop)
{
    const char *at = text, *end = text + n;
    cJSON *value = cJSON_ParseWithLengthOpts(text, n, &at, 0);

    if (!value)
        at = at && at < end ? at : end;
    while (value && at < end && strchr(" \t\r\n", *at) && *at)
        at++;
    *stop = (size_t)(at - text);
    return value;
}

/* The same for a text with words for numbers; LT_ENOMEM. */
static lt_status parse_words(const char *name, const char *text, size_t n, size_t *stop, cJSON **out)
{
    lt_arena *scratch = lt_arena_new();
    size_t at = 0, next = 0;
    plain_text plain;
    lt_status st = LT_OK;

    if (!scratch || !make_plain(scratch, text, n, &plain)) {
        st = lt_error(LT_ENOMEM, "%s: no memory", name);
        goto done;
    }
    *out = parse(plain.text, n, stop);
    if (*out)
        put_nan(*out, &plain, &at, &next);
done:
    lt_arena_free(scratch);
    return st;
}

lt_status lt_json_parse(const char *name, const char *text, size_t n, cJSON **out)
{
    const char *end = text + n;
    cJSON *value = NULL;
    bool words;
    size_t stop = 0;
    lt_status st;

    if (n >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0)
        text += 3;
    if (text == end)
        return lt_error(LT_EFORMAT, "%s: empty, want JSON", name);
    n = (size_t)(end - text);
    st = lt_refuse_other(name, (const uint8_t *)text, n, LT_KIND_JSON, "JSON");
    if (st)
        return st;
    st = check_limits(name, text, end, &words);
    if (st)
        return st;
    pthread_once(&watching, lt_json_watch_memory);
    lt_json_lacked_memory();
    if (words)
        st = parse_words(name, text, n, &stop, &value);
    else
        value = parse(text, n, &stop);
    if (st)
        return st;
    if (value && stop == n) {
        *out = value;
        return LT_OK;
    }
    if (lt_json_lacked_memory()) {
        cJSON_Delete(value);
        return lt_error(LT_ENOMEM, "%s: no memory to read it", name);
    }
    st = error_at(name, text, text + stop, value ? "text after the JSON value" : "not valid JSON from here on");
    cJSON_Delete(value);
    return st;
}

lt_status lt_json_read(const char *path, cJSON **out)
{
    lt_file file;
    lt_status st = lt_file_load(&file, path, LT_JSON_MAX);

    if (!st)
        st = lt_json_parse(path, (const char *)file.bytes, file.n, out);
    lt_file_free(&file);
    return st;
}

/* ---- writing ------------------------------------------------------------------------------------- */

_Static_assert((int)LT_JSON_NUMBER == (int)LT_NUMBER_TEXT, "one buffer for numbers");

const char *lt_json_number(double x, char out[LT_JSON_NUMBER])
{
    if (!isfinite(x)) {
        memcpy(out, "null", 5);
        return out;
    }
    return lt_print_double(x, out);
}

void lt_json_print_string(FILE *f, const char *text)
{
    const char *p = text, *end = text + strlen(text);

    fputc('"', f);
    while (p < end) {
        const uint32_t code = lt_utf8_next(&p, end);
        char utf8[LT_UTF8_MAX];

        if (code == '"' || code == '\\')
            fprintf(f, "\\%c", (int)code);
        else if (code == '\n')
            fputs("\\n", f);
        else if (code == '\t')
            fputs("\\t", f);
        else if (lt_is_control(code))
            fprintf(f, "\\u%04x", (unsigned)code);
        else
            fwrite(utf8, 1, lt_utf8_put(utf8, code), f);
    }
    fputc('"', f);
}

/* A container of nothing but numbers, strings and the like stays on one line. */
static bool is_flat(const cJSON *value)
{
    for (const cJSON *c = value->child; c; c = c->next)
        if (c->child)
            return false;
    return cJSON_IsArray(value);
}

static void new_line(FILE *f, int indent)
{
    fprintf(f, "\n%*s", 2 * indent, "");
}

/* indent < 0: all on one line */
static void print_value(FILE *f, const cJSON *value, int indent)
{
    const bool object = cJSON_IsObject(value);
    const int inner = indent < 0 || is_flat(value) ? -1 : indent + 1;
    char number[LT_JSON_NUMBER];

    if (cJSON_IsString(value)) {
        lt_json_print_string(f, value->valuestring);
    } else if (cJSON_IsNumber(value)) {
        fputs(lt_json_number(value->valuedouble, number), f);
    } else if (cJSON_IsBool(value)) {
        fputs(cJSON_IsTrue(value) ? "true" : "false", f);
    } else if (!object && !cJSON_IsArray(value)) {
        fputs("null", f);
    } else {
        fputc(object ? '{' : '[', f);
        for (const cJSON *c = value->child; c; c = c->next) {
            if (inner >= 0)
                new_line(f, inner);
            if (object) {
                lt_json_print_string(f, c->string);
                fputs(": ", f);
            }
            print_value(f, c, inner);
            if (c->next)
                fputs(inner >= 0 ? "," : ", ", f);
        }
        if (inner >= 0 && value->child)
            new_line(f, indent);
        fputc(object ? '}' : ']', f);
    }
}

void lt_json_print(FILE *f, const cJSON *value)
{
    print_value(f, value, -1);
}

lt_status lt_json_write(const char *path, const cJSON *value)
{
    lt_atomic_file f;
    lt_status st = lt_json_lacked_memory() ? lt_error(LT_ENOMEM, "%s: no memory for all that belongs in it", path)
                                   : lt_atomic_open(&f, path);

    if (st)
        return st;
    print_value(f.stream, value, 0);
    fputc('\n', f.stream);
    return lt_atomic_commit(&f);
}
