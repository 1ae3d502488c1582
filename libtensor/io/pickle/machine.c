/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The memory of the pickle reader's stack machine: values, their text and items, and what all of it may
 * take of a file's size.
 */
#include "libtensor/io/pickle/machine.h"

#include <stdio.h>
#include <string.h>

enum { MAX_VALUES = 16 << 20, POOL_BYTES = 1 << 16, FREE_BYTES = 64 << 20 };

void lt_pm_fail(lt_pmachine *m, const char *fmt, ...)
{
    char reason[512];
    va_list args;

    if (m->status)
        return;
    va_start(args, fmt);
    vsnprintf(reason, sizeof(reason), fmt, args);
    va_end(args);
    m->status = lt_error(LT_EFORMAT, "%s: offset %zu: %s", m->name, m->op_start, reason);
}

void lt_pm_no_memory(lt_pmachine *m)
{
    if (!m->status)
        m->status = lt_error(LT_ENOMEM, "%s: no memory for its values", m->name);
}

bool lt_pm_spend(lt_pmachine *m, size_t bytes)
{
    if (bytes > m->budget - m->spent) {
        lt_pm_fail(m, "asks for more memory than a file of %zu bytes should; write long lists of numbers as NumPy "
                   "arrays", m->file_bytes);
        return false;
    }
    m->spent += bytes;
    return true;
}

/* With the file itself 16 times its size and 64 megabytes, of which a pool is left for the last chunk: a list of
 * numbers in 2 or 3 bytes each takes 20 times its file. */
size_t lt_pm_budget(size_t file_bytes)
{
    return 15 * file_bytes + FREE_BYTES - 2 * POOL_BYTES;
}

void *lt_pm_alloc(lt_pmachine *m, size_t bytes)
{
    const size_t padded = (bytes + 7) & ~(size_t)7;
    void *p;

    if (padded < bytes || !lt_pm_spend(m, padded))
        return NULL;
    if (padded > POOL_BYTES / 4) {
        p = lt_arena_alloc(m->arena, padded);
    } else {
        if (padded > m->pool_left) {
            m->pool = lt_arena_alloc(m->arena, POOL_BYTES);
            m->pool_left = m->pool ? POOL_BYTES : 0;
        }
        p = m->pool;
        if (p) {
            m->pool += padded;
            m->pool_left -= padded;
        }
    }
    if (!p)
        lt_pm_no_memory(m);
    return p;
}

lt_pvalue *lt_pm_value(lt_pmachine *m, lt_pkind kind)
{
    lt_pvalue *v;

    if (m->n_values >= MAX_VALUES) {
        lt_pm_fail(m, "more than %d values", MAX_VALUES);
        return m->none;
    }
    v = lt_pm_alloc(m, sizeof(*v));
    if (!v)
        return m->none;
    m->n_values++;
    v->kind = kind;
    return v;
}

lt_pvalue *lt_pm_text(lt_pmachine *m, lt_pkind kind, const char *text, size_t n)
{
    char *copy = lt_pm_alloc(m, n + 1);
    lt_pvalue *v = lt_pm_value(m, kind);

    if (m->status)
        return m->none;
    if (n)
        memcpy(copy, text, n);
    copy[n] = '\0';
    v->u.text = copy;
    v->n = n;
    return v;
}

/* Room in a container's own array: the next power of two, which n alone tells; a tuple never grows. */
static size_t room_for(lt_pkind kind, size_t n)
{
    size_t room = kind == LT_PTUPLE ? n : 4;

    while (room < n)
        room *= 2;
    return n ? room : 0;
}

/* Append count values to a container; for a dict an even number of them. */
void lt_pm_extend(lt_pmachine *m, lt_pvalue *to, lt_pvalue *const *item, size_t count)
{
    const size_t width = to->kind == LT_PDICT ? 2 : 1, used = to->n * width;

    if (room_for(to->kind, used + count) > room_for(to->kind, used)) {
        lt_pvalue **grown = lt_pm_alloc(m, room_for(to->kind, used + count) * sizeof(*grown));

        if (!grown)
            return;
        if (used)
            memcpy(grown, to->u.item, used * sizeof(*grown));
        to->u.item = grown;
    }
    if (count)
        memcpy(to->u.item + used, item, count * sizeof(*item));
    to->n += count / width;
}

lt_pvalue *lt_pm_items(lt_pmachine *m, lt_pkind kind, lt_pvalue *const *item, size_t n)
{
    lt_pvalue *v = lt_pm_value(m, kind);

    if (!m->status)
        lt_pm_extend(m, v, item, kind == LT_PDICT ? 2 * n : n);
    return v;
}

lt_pvalue *lt_pm_bad_args(lt_pmachine *m, const char *name)
{
    lt_pm_fail(m, "calls %s with arguments that it does not take", name);
    return m->none;
}

bool lt_pm_is_text(const lt_pvalue *v, const char *want)
{
    return v->kind == LT_PSTR && v->n == strlen(want) && memcmp(v->u.text, want, v->n) == 0;
}
