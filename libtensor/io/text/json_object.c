/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/text/json_object.h"

#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <string.h>

static lt_status wrong(const lt_json_object *o, const char *want)
{
    size_t line = 1;

    if (o->at >= o->n)
        return lt_error(LT_EFORMAT, "%s: ends early, want %s", o->name, want);
    for (size_t i = 0; i < o->at; i++)
        line += o->text[i] == '\n';
    return lt_error(LT_EFORMAT, "%s:%zu: byte %zu is 0x%02x, want %s", o->name, line, o->at,
                    (unsigned char)o->text[o->at], want);
}

static char look(const lt_json_object *o)
{
    return o->at < o->n ? o->text[o->at] : '\0';
}

static void skip_blanks(lt_json_object *o)
{
    while (o->at < o->n && strchr(" \t\r\n", o->text[o->at]) && o->text[o->at])
        o->at++;
}

/* From a quote to behind the one that closes it. */
static bool skip_string(lt_json_object *o)
{
    for (o->at++; o->at < o->n; o->at++) {
        if (o->text[o->at] == '\\')
            o->at++;
        else if (o->text[o->at] == '"') {
            o->at++;
            return true;
        }
    }
    o->at = o->n;
    return false;
}

/* From the first byte of a value to behind its last: as far as brackets and quotes tell. */
static bool skip_value(lt_json_object *o)
{
    size_t depth = 0;

    while (o->at < o->n) {
        const char c = look(o);

        if (c == '"') {
            if (!skip_string(o))
                return false;
            if (depth == 0)
                return true;
            continue;
        }
        if (depth == 0 && (c == ',' || c == '}' || c == ']' || c == ' ' || c == '\t' || c == '\r' || c == '\n'))
            return true;                                /* behind a number or a word */
        o->at++;
        depth += c == '{' || c == '[';
        if ((c == '}' || c == ']') && --depth == 0)
            return true;
    }
    return depth == 0;
}

/* open: the bracket that it begins with; want: that in words */
static lt_status begin(const char *name, const char *text, size_t n, char open, const char *want, lt_json_object *out)
{
    const bool mark = n >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0;
    lt_json_object o = { .name = name, .text = text, .n = n, .at = mark ? 3 : 0, .first = true };

    skip_blanks(&o);
    if (look(&o) != open)
        return wrong(&o, want);
    o.at++;
    *out = o;
    return LT_OK;
}

lt_status lt_json_object_open(const char *name, const char *text, size_t n, lt_json_object *out)
{
    return begin(name, text, n, '{', "{, the beginning of an object", out);
}

lt_status lt_json_list_open(const char *name, const char *text, size_t n, lt_json_object *out)
{
    return begin(name, text, n, '[', "[, the beginning of a list", out);
}

static lt_status read_key(lt_json_object *o, lt_arena *arena, const char **out)
{
    const size_t begin = o->at;
    cJSON *key;
    lt_status st;

    if (look(o) != '"' || !skip_string(o))
        return wrong(o, "a key in quotes");
    st = lt_json_parse(o->name, o->text + begin, o->at - begin, &key);
    if (st)
        return st;
    *out = lt_arena_strdup(arena, key->valuestring);
    cJSON_Delete(key);
    return *out ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", o->name);
}

static lt_status end_of(lt_json_object *o)
{
    o->at++;
    skip_blanks(o);
    return o->at == o->n ? LT_OK : wrong(o, "the end of the file");
}

/* To the next member or item; *more is false behind the bracket that closes. */
static lt_status go_on(lt_json_object *o, char close, const char *want, bool *more)
{
    *more = false;
    skip_blanks(o);
    if (look(o) == close)
        return end_of(o);
    if (!o->first && look(o) != ',')
        return wrong(o, want);
    if (!o->first)
        o->at++;
    o->first = false;
    skip_blanks(o);
    *more = true;
    return LT_OK;
}

static lt_status take_value(lt_json_object *o, lt_json_member *out)
{
    out->value = o->text + o->at;
    if (!skip_value(o) || out->value == o->text + o->at)
        return wrong(o, "a value");
    out->n = (size_t)(o->text + o->at - out->value);
    return LT_OK;
}

lt_status lt_json_object_next(lt_json_object *o, lt_arena *arena, lt_json_member *out, bool *more)
{
    lt_status st = go_on(o, '}', "a comma or }", more);

    if (st || !*more)
        return st;
    *more = false;
    st = read_key(o, arena, &out->key);
    if (st)
        return st;
    skip_blanks(o);
    if (look(o) != ':')
        return wrong(o, "a colon");
    o->at++;
    skip_blanks(o);
    st = take_value(o, out);
    *more = st == LT_OK;
    return st;
}

lt_status lt_json_list_next(lt_json_object *o, lt_json_member *out, bool *more)
{
    lt_status st = go_on(o, ']', "a comma or ]", more);

    if (st || !*more)
        return st;
    out->key = NULL;
    st = take_value(o, out);
    *more = st == LT_OK;
    return st;
}
