/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Looking into a pickle's values.
 */
#include "libtensor/io/pickle/pickle.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const lt_pvalue *lt_pdict_get(const lt_pvalue *d, const char *key)
{
    const size_t n = strlen(key);

    for (size_t i = d && d->kind == LT_PDICT ? d->n : 0; i-- > 0;) {
        const lt_pvalue *k = d->u.item[2 * i];

        if ((k->kind == LT_PSTR || k->kind == LT_PBYTES) && k->n == n && memcmp(k->u.text, key, n) == 0)
            return d->u.item[2 * i + 1];
    }
    return NULL;
}

const lt_array *lt_parray(const lt_pvalue *v)
{
    return v && v->kind == LT_PARRAY ? v->u.array : NULL;
}

const char *lt_pstr(const lt_pvalue *v)
{
    if (v && v->kind == LT_PSTR)
        return v->u.text;
    if (v && v->kind == LT_PARRAY && lt_array_count(v->u.array) == 1)
        return lt_array_text(v->u.array, 0);
    return NULL;
}

/* The array behind v when it is one number, or NULL. */
static const lt_array *single(const lt_pvalue *v)
{
    const lt_array *a = lt_parray(v);

    return a && a->type != LT_ELEM_TEXT && lt_array_count(a) == 1 ? a : NULL;
}

bool lt_pint(const lt_pvalue *v, int64_t *out)
{
    const lt_array *a = single(v);

    if (v && (v->kind == LT_PINT || v->kind == LT_PBOOL))
        *out = v->u.integer;
    else if (a && a->type != LT_ELEM_F2 && a->type != LT_ELEM_F4 && a->type != LT_ELEM_F8)
        *out = lt_array_int(a, 0);
    else
        return false;
    return true;
}

bool lt_pfloat(const lt_pvalue *v, double *out)
{
    const lt_array *a = single(v);

    if (v && v->kind == LT_PFLOAT)
        *out = v->u.number;
    else if (v && (v->kind == LT_PINT || v->kind == LT_PBOOL))
        *out = (double)v->u.integer;
    else if (a)
        *out = lt_array_get(a, 0);
    else
        return false;
    return true;
}

bool lt_pis_none(const lt_pvalue *v)
{
    return !v || v->kind == LT_PNONE;
}

/* Numbers gathered from nested lists. Lists may be shared, so steps bounds the walk. */
typedef struct {
    float *out;
    size_t n, found, steps;
} gathering;

static bool gather(gathering *g, const lt_pvalue *v)
{
    const lt_array *a = lt_parray(v);
    double x;

    if (g->steps-- == 0)
        return false;
    if (v->kind == LT_PLIST || v->kind == LT_PTUPLE) {
        for (size_t i = 0; i < v->n; i++)
            if (!gather(g, v->u.item[i]))
                return false;
        return true;
    }
    if (a) {
        const size_t count = lt_array_count(a);

        if (a->type == LT_ELEM_TEXT || count > g->n - g->found)
            return false;
        lt_array_to_float(a, g->out + g->found, count);
        g->found += count;
        return true;
    }
    if (g->found == g->n || !lt_pfloat(v, &x))
        return false;
    g->out[g->found++] = (float)x;
    return true;
}

const char *lt_pdescribe(const lt_pvalue *v, char *out, size_t n)
{
    static const char *const names[] = {
        [LT_PNONE] = "None", [LT_PBOOL] = "a bool", [LT_PINT] = "an integer", [LT_PFLOAT] = "a number",
        [LT_PSTR] = "text", [LT_PBYTES] = "bytes", [LT_PLIST] = "a list", [LT_PTUPLE] = "a tuple",
        [LT_PSET] = "a set", [LT_PDICT] = "a dict", [LT_PCLASS] = "a class", [LT_PDTYPE] = "a dtype",
        [LT_POWN] = "an object",
    };

    if (v->kind == LT_PARRAY)
        return lt_array_shape_text(v->u.array, out, n);
    if (v->kind == LT_POBJECT)
        snprintf(out, n, "an object of %s", v->u.object.class_name);
    else
        snprintf(out, n, "%s", names[v->kind]);
    return out;
}

lt_status lt_pfloats(const lt_pvalue *v, const char *what, float *out, size_t n)
{
    gathering g = { .out = out, .n = n, .steps = 16 * n + 64 };
    char found[160];

    if (!v)
        return lt_error(LT_EFORMAT, "%s: missing", what);
    if (!gather(&g, v) || g.found != n)
        return lt_error(LT_EFORMAT, "%s: want %zu numbers, found %s", what, n,
                        lt_pdescribe(v, found, sizeof(found)));
    for (size_t i = 0; i < n; i++)
        if (!isfinite(out[i]))
            return lt_error(LT_EFORMAT, "%s: number %zu is not finite", what, i);
    return LT_OK;
}
