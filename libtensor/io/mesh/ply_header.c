/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PLY: the lines up to end_header.
 */
#include "libtensor/io/kind.h"
#include "libtensor/io/mesh/ply_internal.h"

#include <stdlib.h>
#include <string.h>

enum { ELEMENTS_MAX = 64, PROPERTIES_MAX = 512, LINE_MAX_CHARS = 1024, WORDS_MAX = 5 };

typedef struct {
    lt_arena *arena;
    const char *name;
    const uint8_t *bytes;
    size_t n, pos, line;
    char text[LINE_MAX_CHARS];          /* the line at hand, cut into words */
    char *word[WORDS_MAX];
    int words;
    lt_ply_head *head;
    int n_properties;                   /* in all */
} reader;

static lt_status bad(const reader *r, const char *reason)
{
    return lt_error(LT_EFORMAT, "%s:%zu: %s", r->name, r->line, reason);
}

/* The next line as at most five words; the rest of a comment is no matter. */
static lt_status next_line(reader *r)
{
    const uint8_t *start = r->bytes + r->pos, *end;
    char *rest = NULL;
    size_t n;

    r->line++;
    end = r->pos < r->n ? memchr(start, '\n', r->n - r->pos) : NULL;
    n = end ? (size_t)(end - start) : 0;
    if (!end || n >= LINE_MAX_CHARS || memchr(start, '\0', n))
        return bad(r, end ? "a header line that is too long or no text" : "the header does not end");
    memcpy(r->text, start, n);
    r->text[n] = '\0';
    r->pos += n + 1;
    r->words = 0;
    for (char *p = strtok_r(r->text, " \t\r", &rest); p && r->words < WORDS_MAX; p = strtok_r(NULL, " \t\r", &rest))
        r->word[r->words++] = p;
    return LT_OK;
}

static bool is(const reader *r, int i, const char *word)
{
    return i < r->words && strcmp(r->word[i], word) == 0;
}

static bool type_of(const char *word, lt_elem *out)
{
    static const struct {
        const char *name, *sized;
        lt_elem type;
    } types[] = {
        { "char", "int8", LT_ELEM_I1 }, { "uchar", "uint8", LT_ELEM_U1 }, { "short", "int16", LT_ELEM_I2 },
        { "ushort", "uint16", LT_ELEM_U2 }, { "int", "int32", LT_ELEM_I4 }, { "uint", "uint32", LT_ELEM_U4 },
        { "float", "float32", LT_ELEM_F4 }, { "double", "float64", LT_ELEM_F8 },
    };

    for (size_t i = 0; i < LT_COUNT(types); i++) {
        *out = types[i].type;
        if (strcmp(word, types[i].name) == 0 || strcmp(word, types[i].sized) == 0)
            return true;
    }
    return false;
}

static lt_status take_format(reader *r)
{
    static const char *const names[] = { "ascii", "binary_little_endian", "binary_big_endian" };

    for (int i = 0; i < 3; i++) {
        if (!is(r, 1, names[i]) || !is(r, 2, "1.0"))
            continue;
        r->head->format = (lt_ply_format)i;
        r->head->ply.format = names[i];
        return LT_OK;
    }
    return bad(r, "a format other than ascii, binary_little_endian and binary_big_endian 1.0");
}

/* element NAME COUNT; every row takes at least a byte where it has any property */
static lt_status take_element(reader *r)
{
    lt_ply *ply = &r->head->ply;
    lt_ply_element *e = &ply->element[ply->n];
    char *end;

    if (ply->n == ELEMENTS_MAX || r->words != 3 || r->word[2][0] < '0' || r->word[2][0] > '9')
        return bad(r, "want \"element NAME COUNT\", at most 64 times");
    e->count = strtoull(r->word[2], &end, 10);
    if (*end || e->count > r->n)
        return bad(r, "more rows than the file can hold");
    for (int i = 0; i < ply->n; i++)
        if (strcmp(ply->element[i].name, r->word[1]) == 0)
            return bad(r, "the second element of this name");
    e->name = lt_arena_strdup(r->arena, r->word[1]);
    ply->n++;
    return e->name ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", r->name);
}

/* Property arrays grow by doubling, and the types of counts with them. */
static bool grow(reader *r, lt_ply_element *e, lt_elem **count_type)
{
    lt_ply_property *property;
    lt_elem *counts;

    if (e->n & (e->n - 1))
        return true;
    property = lt_arena_array(r->arena, e->n ? 2 * (size_t)e->n : 1, sizeof(*property));
    counts = lt_arena_array(r->arena, e->n ? 2 * (size_t)e->n : 1, sizeof(*counts));
    if (!property || !counts)
        return false;
    if (e->n) {
        memcpy(property, e->property, (size_t)e->n * sizeof(*property));
        memcpy(counts, *count_type, (size_t)e->n * sizeof(*counts));
    }
    e->property = property;
    *count_type = counts;
    return true;
}

/* property TYPE NAME, or property list COUNT-TYPE TYPE NAME */
static lt_status take_property(reader *r)
{
    lt_ply *ply = &r->head->ply;
    lt_ply_element *e = ply->n ? &ply->element[ply->n - 1] : NULL;
    const bool list = is(r, 1, "list");
    const int at = list ? 3 : 1;
    lt_elem type, count = LT_ELEM_U1;

    if (!e || r->words != at + 2 || ++r->n_properties > PROPERTIES_MAX)
        return bad(r, "want \"property [list TYPE] TYPE NAME\" of an element, at most 512 times");
    if (!type_of(r->word[at], &type) || (list && !type_of(r->word[2], &count)))
        return bad(r, "a type that PLY does not have");
    if (list && (count == LT_ELEM_F4 || count == LT_ELEM_F8))
        return bad(r, "a list whose length is no integer");
    for (int i = 0; i < e->n; i++)
        if (strcmp(e->property[i].name, r->word[at + 1]) == 0)
            return bad(r, "the second property of this name");
    if (!grow(r, e, &r->head->count_type[ply->n - 1]))
        return lt_error(LT_ENOMEM, "%s: no memory", r->name);
    r->head->count_type[ply->n - 1][e->n] = count;
    e->property[e->n] = (lt_ply_property){ .name = lt_arena_strdup(r->arena, r->word[at + 1]), .is_list = list,
                                           .values = { .type = type, .rank = 1 } };
    return e->property[e->n++].name ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", r->name);
}

static lt_status take_line(reader *r)
{
    if (is(r, 0, "format"))
        return take_format(r);
    if (is(r, 0, "element"))
        return take_element(r);
    if (is(r, 0, "property"))
        return take_property(r);
    if (r->words == 0 || is(r, 0, "comment") || is(r, 0, "obj_info"))
        return LT_OK;
    return bad(r, "a header line that is neither format, element, property nor comment");
}

lt_status lt_ply_header(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_ply_head *out)
{
    reader r = { .arena = arena, .name = name, .bytes = bytes, .n = n, .head = out };
    lt_status st;

    *out = (lt_ply_head){ .ply.path = lt_arena_strdup(arena, name) };
    out->ply.element = lt_arena_array(arena, ELEMENTS_MAX, sizeof(*out->ply.element));
    out->count_type = lt_arena_array(arena, ELEMENTS_MAX, sizeof(*out->count_type));
    if (!out->ply.path || !out->ply.element || !out->count_type)
        return lt_error(LT_ENOMEM, "%s: no memory", name);
    st = next_line(&r);
    if (st || r.words != 1 || strcmp(r.word[0], "ply") != 0)
        return lt_refuse(name, bytes, n, "a PLY file");
    for (st = next_line(&r); !st && !is(&r, 0, "end_header"); st = st ? st : next_line(&r))
        st = take_line(&r);
    if (!st && !out->ply.format)
        st = bad(&r, "a header without format");
    out->body = r.pos;
    return st;
}
