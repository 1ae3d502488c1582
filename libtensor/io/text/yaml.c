/* SPDX-License-Identifier: Apache-2.0 */
/* libyaml's events into a tree, with a stack of our own: no recursion, and nothing that a file can grow. */
#include "libtensor/io/text/yaml.h"

#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/text/number.h"

#include <math.h>
#include <string.h>
#include <yaml.h>

/* A list or map that is still open. */
typedef struct {
    lt_yaml *node, *last;
    const char *key;                        /* of the value that comes next; NULL: a key comes next */
} level;

typedef struct {
    lt_arena *arena;
    const char *path;
    level stack[LT_YAML_DEPTH];
    int depth, nodes;
    lt_yaml *root;
    bool done;
} builder;

/* ---- building ---- */

static int line_of(const yaml_event_t *e)
{
    return (int)e->start_mark.line + 1;
}

static lt_status refuse(const builder *b, const yaml_event_t *e, const char *reason)
{
    return lt_error(LT_EFORMAT, "%s:%d: %s", b->path, line_of(e), reason);
}

/* Tags that only say what a plain value is anyway. */
static bool harmless(const yaml_char_t *tag)
{
    static const char *const known[] = {
        "python/tuple", "python/unicode", "python/str", "str", "int", "float", "seq", "map", "opencv-matrix",
    };
    static const char prefix[] = "tag:yaml.org,2002:";
    const char *t = (const char *)tag;

    if (!t || !strcmp(t, "!"))
        return true;
    for (size_t i = 0; !strncmp(t, prefix, sizeof(prefix) - 1) && i < LT_COUNT(known); i++)
        if (!strcmp(t + sizeof(prefix) - 1, known[i]))
            return true;
    return false;
}

static lt_status check(const builder *b, const yaml_event_t *e, const yaml_char_t *anchor, const yaml_char_t *tag)
{
    if (anchor)
        return refuse(b, e, "found an anchor (&name), which is not read");
    if (!harmless(tag))
        return lt_error(LT_EFORMAT, "%s:%d: found the tag %.60s; only plain values are read", b->path, line_of(e),
                        (const char *)tag);
    return LT_OK;
}

/* A new value below the open one; text is copied, and NULL for lists and maps. */
static lt_status add(builder *b, const yaml_event_t *e, lt_yaml_kind kind, const char *text, size_t n, lt_yaml **out)
{
    level *in = b->depth ? &b->stack[b->depth - 1] : NULL;
    lt_yaml *v;
    lt_status st;

    if (++b->nodes > LT_YAML_NODES)
        return lt_error(LT_EFORMAT, "%s:%d: more than %d values", b->path, line_of(e), LT_YAML_NODES);
    st = lt_arena_try(b->arena, sizeof(*v) + n + 1, (void **)&v);
    if (st)
        return st;
    *v = (lt_yaml){ .path = b->path, .key = "", .text = "", .kind = kind, .line = line_of(e) };
    if (text) {
        memcpy(v + 1, text, n);
        ((char *)(v + 1))[n] = 0;
        v->text = (const char *)(v + 1);
    }
    *out = v;
    if (!in) {
        b->root = v;
        return LT_OK;
    }
    if (in->key)
        v->key = in->key;
    in->key = NULL;
    if (in->last)
        in->last->next = v;
    else
        in->node->first = v;
    in->last = v;
    in->node->n++;
    return LT_OK;
}

static lt_status take_key(builder *b, level *in, const yaml_event_t *e, const char *text, size_t n)
{
    char *copy;
    lt_status st;

    if (!strcmp(text, "<<"))
        return refuse(b, e, "found a merge key (<<), which is not read");
    for (const lt_yaml *v = in->node->first; v; v = v->next)
        if (!strcmp(v->key, text))
            return lt_error(LT_EFORMAT, "%s:%d: the key %.60s comes twice, first on line %d", b->path, line_of(e),
                            text, v->line);
    if (in->node->n >= LT_YAML_NODES / 64)
        return refuse(b, e, "more than 256 keys in a map");
    st = lt_arena_try(b->arena, n + 1, (void **)&copy);
    if (st)
        return st;
    memcpy(copy, text, n + 1);
    in->key = copy;
    return LT_OK;
}

static lt_status on_scalar(builder *b, const yaml_event_t *e)
{
    const char *text = (const char *)e->data.scalar.value;
    const size_t n = e->data.scalar.length;
    level *in = b->depth ? &b->stack[b->depth - 1] : NULL;
    lt_yaml *v;
    lt_status st = check(b, e, e->data.scalar.anchor, e->data.scalar.tag);

    if (!st && strlen(text) != n)
        st = refuse(b, e, "found a NUL character in a text");
    if (st)
        return st;
    if (in && in->node->kind == LT_YAML_MAP && !in->key)
        return take_key(b, in, e, text, n);
    return add(b, e, LT_YAML_SCALAR, text, n, &v);
}

static lt_status open_level(builder *b, const yaml_event_t *e, lt_yaml_kind kind)
{
    level *in = b->depth ? &b->stack[b->depth - 1] : NULL;
    lt_yaml *v;
    lt_status st;

    if (in && in->node->kind == LT_YAML_MAP && !in->key)
        return refuse(b, e, "found a list or map as a key, expected a text");
    if (b->depth == LT_YAML_DEPTH)
        return lt_error(LT_EFORMAT, "%s:%d: nested more than %d deep", b->path, line_of(e), LT_YAML_DEPTH);
    st = add(b, e, kind, NULL, 0, &v);
    if (!st)
        b->stack[b->depth++] = (level){ .node = v };
    return st;
}

static lt_status on_event(builder *b, const yaml_event_t *e)
{
    lt_status st;

    switch (e->type) {
    case YAML_DOCUMENT_START_EVENT:
        return b->root ? refuse(b, e, "found a second document, expected the end") : LT_OK;
    case YAML_SCALAR_EVENT:
        return on_scalar(b, e);
    case YAML_SEQUENCE_START_EVENT:
        st = check(b, e, e->data.sequence_start.anchor, e->data.sequence_start.tag);
        return st ? st : open_level(b, e, LT_YAML_LIST);
    case YAML_MAPPING_START_EVENT:
        st = check(b, e, e->data.mapping_start.anchor, e->data.mapping_start.tag);
        return st ? st : open_level(b, e, LT_YAML_MAP);
    case YAML_SEQUENCE_END_EVENT:
    case YAML_MAPPING_END_EVENT:
        b->depth--;
        return LT_OK;
    case YAML_ALIAS_EVENT:
        return refuse(b, e, "found an alias (*name), which is not read");
    case YAML_STREAM_END_EVENT:
        b->done = true;
        return b->root ? LT_OK : refuse(b, e, "is empty, expected values");
    default:
        return LT_OK;
    }
}

static lt_status complain(const builder *b, const yaml_parser_t *p)
{
    if (p->error == YAML_MEMORY_ERROR)
        return lt_error(LT_ENOMEM, "%s: no memory", b->path);
    if (p->error == YAML_READER_ERROR)
        return lt_error(LT_EFORMAT, "%s: byte %zu: %s", b->path, p->problem_offset, p->problem);
    return lt_error(LT_EFORMAT, "%s:%zu: %s", b->path, p->problem_mark.line + 1,
                    p->problem ? p->problem : "no YAML");
}

/* The line that the first %TAG begins, or 0. libyaml compares each with all before it, and no file that is read needs
 * one. A line may follow a byte order mark and the line ends of Unicode as well, which no plain character ends in. */
static int find_tag_line(const uint8_t *bytes, size_t n)
{
    uint8_t before = '\n';
    int line = 1;

    for (size_t i = 0; i + 4 <= n; before = bytes[i++]) {
        line += i && before == '\n';
        if ((before == '\n' || before == '\r' || before >= 0x80) && memcmp(bytes + i, "%TAG", 4) == 0)
            return line;
    }
    return 0;
}

/* The length of OpenCV's first line, "%YAML:1.0", which is no YAML; its end stays, so that lines are counted. */
static size_t opencv_head(const uint8_t *bytes, size_t n)
{
    size_t at = 0;

    if (n < 6 || memcmp(bytes, "%YAML:", 6) != 0)
        return 0;
    while (at < n && bytes[at] != '\n' && bytes[at] != '\r')
        at++;
    return at;
}

lt_status lt_yaml_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, const lt_yaml **out)
{
    builder b = { .arena = arena, .path = name };
    yaml_parser_t parser;
    yaml_event_t event;
    lt_status st;
    size_t head;
    int tag_line;

    if (n > LT_YAML_MAX)
        return lt_error(LT_EFORMAT, "%s: %zu bytes, at most %zu are read", name, n, LT_YAML_MAX);
    st = lt_refuse_other(name, bytes, n, LT_KIND_JSON, "YAML");         /* which JSON is too */
    if (st)
        return st;
    tag_line = find_tag_line(bytes, n);
    if (tag_line)
        return lt_error(LT_EFORMAT, "%s:%d: found a %%TAG line, which is not read", name, tag_line);
    if (!yaml_parser_initialize(&parser))
        return lt_error(LT_ENOMEM, "%s: no memory", name);
    head = opencv_head(bytes, n);
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser, bytes + head, n - head);
    while (!st && !b.done) {
        if (!yaml_parser_parse(&parser, &event)) {
            st = complain(&b, &parser);
            break;
        }
        st = on_event(&b, &event);
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    if (!st)
        *out = b.root;
    return st;
}

lt_status lt_yaml_read(lt_arena *arena, const char *path, const lt_yaml **out)
{
    const char *name = lt_arena_strdup(arena, path);
    uint8_t *bytes;
    size_t n;
    lt_status st;

    if (!name)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    st = lt_read_file(arena, path, LT_YAML_MAX, &bytes, &n);
    return st ? st : lt_yaml_parse(arena, name, bytes, n, out);
}

/* ---- reading values ---- */

static const char *kind_name(const lt_yaml *v)
{
    return v->kind == LT_YAML_MAP ? "a map" : v->kind == LT_YAML_LIST ? "a list" : "a text";
}

/* "path:line: key: found ..., expected ..." */
static lt_status unexpected(const lt_yaml *v, const char *wanted)
{
    const bool scalar = v->kind == LT_YAML_SCALAR;

    return lt_error(LT_EFORMAT, "%s:%d: %s%sfound %s%.40s%s, expected %s", v->path, v->line, v->key,
                    *v->key ? ": " : "", scalar ? "\"" : kind_name(v), scalar ? v->text : "", scalar ? "\"" : "",
                    wanted);
}

lt_status lt_yaml_get(const lt_yaml *v, const char *key, const lt_yaml **out)
{
    if (v->kind != LT_YAML_MAP)
        return unexpected(v, "a map");
    for (const lt_yaml *c = v->first; c; c = c->next)
        if (!strcmp(c->key, key)) {
            *out = c;
            return LT_OK;
        }
    return lt_error(LT_EFORMAT, "%s:%d: no key \"%s\"", v->path, v->line, key);
}

lt_status lt_yaml_list(const lt_yaml *v, int n)
{
    if (v->kind != LT_YAML_LIST)
        return unexpected(v, "a list");
    if (n >= 0 && v->n != n)
        return lt_error(LT_EFORMAT, "%s:%d: %s%sfound a list of %d, expected %d", v->path, v->line, v->key,
                        *v->key ? ": " : "", v->n, n);
    return LT_OK;
}

lt_status lt_yaml_text(const lt_yaml *v, const char **out)
{
    if (v->kind != LT_YAML_SCALAR)
        return unexpected(v, "a text");
    *out = v->text;
    return LT_OK;
}

static lt_status number(const lt_yaml *v, double *out)
{
    const char *end = v->text;
    const double x = v->kind == LT_YAML_SCALAR ? lt_strtod(v->text, &end) : 0;

    if (end == v->text || *end || !isfinite(x))
        return unexpected(v, "a number");
    *out = x;
    return LT_OK;
}

lt_status lt_yaml_int(const lt_yaml *v, int lo, int hi, int *out)
{
    double x;
    const lt_status st = number(v, &x);

    if (st)
        return st;
    if (x != floor(x) || x < lo || x > hi)
        return lt_error(LT_EFORMAT, "%s:%d: %s%sfound %.40s, expected a whole number from %d to %d", v->path, v->line,
                        v->key, *v->key ? ": " : "", v->text, lo, hi);
    *out = (int)x;
    return LT_OK;
}

lt_status lt_yaml_numbers(const lt_yaml *v, double *out, int n)
{
    lt_status st;
    int i = 0;

    if (n == 1 && v->kind == LT_YAML_SCALAR)
        return number(v, out);
    st = lt_yaml_list(v, n);
    for (const lt_yaml *c = v->first; !st && c; c = c->next)
        st = number(c, &out[i++]);
    return st;
}
