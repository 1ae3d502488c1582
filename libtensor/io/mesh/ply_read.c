/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PLY: the rows. They are walked twice, once to see that they are there and how long lists are in all, once
 * to keep them.
 */
#include "libtensor/io/mesh/ply.h"

#include "libtensor/io/file.h"
#include "libtensor/io/mesh/ply_internal.h"
#include "libtensor/io/text/number.h"

#include <math.h>
#include <string.h>

enum { LIST_MAX = 255, WORD_MAX_CHARS = 64 };

typedef struct {
    const char *name;
    const uint8_t *bytes;
    size_t n, pos;
    lt_ply_format format;
} cursor;

static lt_status bad(const cursor *c, const char *reason)
{
    return lt_error(LT_EFORMAT, "%s: offset %zu: %s", c->name, c->pos, reason);
}

/* ---- one value ------------------------------------------------------------------------------------ */

/* Whether x can be held by the type: of integers the whole numbers in range, of floats anything. */
static bool holds(lt_elem type, double x)
{
    static const double lo[] = { [LT_ELEM_I1] = -128, [LT_ELEM_I2] = -32768, [LT_ELEM_I4] = -0x1p31,
                                 [LT_ELEM_U1] = 0, [LT_ELEM_U2] = 0, [LT_ELEM_U4] = 0 };
    static const double hi[] = { [LT_ELEM_I1] = 127, [LT_ELEM_I2] = 32767, [LT_ELEM_I4] = 0x1p31 - 1,
                                 [LT_ELEM_U1] = 255, [LT_ELEM_U2] = 65535, [LT_ELEM_U4] = 0x1p32 - 1 };

    return type == LT_ELEM_F4 || type == LT_ELEM_F8 || (x >= lo[type] && x <= hi[type] && x == floor(x));
}

static bool is_blank(uint8_t c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static lt_status take_word(cursor *c, lt_elem type, double *out)
{
    char word[WORD_MAX_CHARS];
    const char *end;
    size_t n = 0;

    while (c->pos < c->n && is_blank(c->bytes[c->pos]))
        c->pos++;
    while (c->pos + n < c->n && n < sizeof(word) - 1 && !is_blank(c->bytes[c->pos + n])) {
        word[n] = (char)c->bytes[c->pos + n];
        n++;
    }
    word[n] = '\0';
    *out = lt_strtod(word, &end);
    if (n == 0)
        return bad(c, "ends early");
    if (*end || end == word || !holds(type, *out))
        return bad(c, "not a number of its type");
    c->pos += n;
    return LT_OK;
}

static double double_of(lt_elem type, const uint8_t raw[8])
{
    const lt_array one = lt_array_make(type, 0, NULL, raw);

    return lt_array_get(&one, 0);
}

static lt_status take_value(cursor *c, lt_elem type, double *out)
{
    static const bool host_is_big = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;
    const size_t size = lt_elem_size(type);
    _Alignas(8) uint8_t raw[8];

    if (c->format == LT_PLY_TEXT)
        return take_word(c, type, out);
    if (c->n - c->pos < size)
        return bad(c, "ends early");
    for (size_t i = 0; i < size; i++)
        raw[(c->format == LT_PLY_BIG) == host_is_big ? i : size - 1 - i] = c->bytes[c->pos + i];
    c->pos += size;
    *out = double_of(type, raw);
    return LT_OK;
}

static void keep(lt_array *a, size_t i, double x)
{
    switch (a->type) {
    case LT_ELEM_I1: ((int8_t *)a->data)[i] = (int8_t)x; break;
    case LT_ELEM_U1: ((uint8_t *)a->data)[i] = (uint8_t)x; break;
    case LT_ELEM_I2: ((int16_t *)a->data)[i] = (int16_t)x; break;
    case LT_ELEM_U2: ((uint16_t *)a->data)[i] = (uint16_t)x; break;
    case LT_ELEM_I4: ((int32_t *)a->data)[i] = (int32_t)x; break;
    case LT_ELEM_U4: ((uint32_t *)a->data)[i] = (uint32_t)x; break;
    case LT_ELEM_F4: ((float *)a->data)[i] = (float)x; break;
    default:         ((double *)a->data)[i] = x; break;
    }
}

/* ---- rows ----------------------------------------------------------------------------------------- */

/* How many values the property has so far; in the second walk the values too. */
static lt_status take_property(cursor *c, lt_ply_property *p, lt_elem count_type, size_t row, size_t *used,
                               bool keeping)
{
    double n = 1, x = 0;
    lt_status st = p->is_list ? take_value(c, count_type, &n) : LT_OK;

    if (!st && (n < 0 || n > LIST_MAX))
        st = bad(c, "a list of more than 255 values");
    if (!st && keeping && p->is_list)
        ((uint32_t *)(uintptr_t)p->begin)[row] = (uint32_t)*used;
    for (int i = 0; !st && i < (int)n; i++) {
        st = take_value(c, p->values.type, &x);
        if (!st && keeping)
            keep(&p->values, *used, x);
        *used += !st;
    }
    return st;
}

static lt_status walk(cursor *c, lt_ply_element *e, const lt_elem *count_type, size_t *used, bool keeping)
{
    lt_status st = LT_OK;

    for (size_t row = 0; e->n && row < e->count; row++)
        for (int i = 0; !st && i < e->n; i++)
            st = take_property(c, &e->property[i], count_type[i], row, &used[i], keeping);
    return st;
}

static lt_status allocate(lt_arena *arena, const cursor *c, lt_ply_element *e, const size_t *used)
{
    for (int i = 0; i < e->n; i++) {
        lt_ply_property *p = &e->property[i];

        if (used[i] > UINT32_MAX)
            return bad(c, "a property of more than 2^32 values");
        p->values.shape[0] = (int64_t)used[i];
        p->values.data = lt_arena_array(arena, used[i], lt_elem_size(p->values.type));
        if (p->is_list)
            p->begin = lt_arena_array(arena, e->count + 1, sizeof(*p->begin));
        if (!p->values.data || (p->is_list && !p->begin))
            return lt_error(LT_ENOMEM, "%s: no memory for %zu values", c->name, used[i]);
    }
    return LT_OK;
}

static lt_status read_element(lt_arena *arena, cursor *c, lt_ply_element *e, const lt_elem *count_type)
{
    size_t *used = lt_arena_array(arena, (size_t)e->n, sizeof(*used));
    const size_t start = c->pos;
    lt_status st;

    if (!used)
        return lt_error(LT_ENOMEM, "%s: no memory", c->name);
    st = walk(c, e, count_type, used, false);
    if (!st)
        st = allocate(arena, c, e, used);
    if (st)
        return st;
    c->pos = start;
    memset(used, 0, (size_t)e->n * sizeof(*used));
    st = walk(c, e, count_type, used, true);
    for (int i = 0; i < e->n; i++)
        if (e->property[i].is_list)
            ((uint32_t *)(uintptr_t)e->property[i].begin)[e->count] = (uint32_t)used[i];
    return st;
}

lt_status lt_ply_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_ply *out)
{
    lt_ply_head head;
    lt_status st = lt_ply_header(arena, name, bytes, n, &head);
    cursor c = { .name = name, .bytes = bytes, .n = n, .pos = head.body, .format = head.format };

    for (int i = 0; !st && i < head.ply.n; i++)
        st = read_element(arena, &c, &head.ply.element[i], head.count_type[i]);
    if (!st)
        *out = head.ply;
    return st;
}

lt_status lt_ply_read(lt_arena *arena, const char *path, lt_ply *out)
{
    lt_file file;
    lt_status st = lt_file_load(&file, path, LT_FILE_MAX);

    if (!st)
        st = lt_ply_parse(arena, path, file.bytes, file.n, out);
    lt_file_free(&file);
    return st;
}

const lt_ply_property *lt_ply_find(const lt_ply *p, const char *element, const char *name, size_t *count)
{
    for (int i = 0; i < p->n; i++) {
        const lt_ply_element *e = &p->element[i];

        for (int k = 0; strcmp(e->name, element) == 0 && k < e->n; k++) {
            if (strcmp(e->property[k].name, name) != 0)
                continue;
            if (count)
                *count = e->count;
            return &e->property[k];
        }
    }
    return NULL;
}
