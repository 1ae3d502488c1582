/* SPDX-License-Identifier: Apache-2.0 */
/* What the pickle reader's opcodes work with: the input, a stack, marks on it, and a memo. */
#include "libtensor/io/pickle/machine.h"

#include <string.h>

enum { FIRST_ROOM = 64 };

#define CUT "; where the file is cut short, copy or download it again"

/* ---- input --------------------------------------------------------------------------------------- */

/* The next n bytes, or NULL and a failure. */
const uint8_t *lt_pm_take(lt_pmachine *m, uint64_t n)
{
    const uint8_t *p = m->bytes + m->pos;

    if (n > m->n - m->pos) {
        lt_pm_fail(m, "ends early, wants %ju bytes more and has %zu" CUT, (uintmax_t)n, m->n - m->pos);
        return NULL;
    }
    m->pos += (size_t)n;
    return p;
}

/* The next n <= 8 bytes as a little-endian number. */
uint64_t lt_pm_take_uint(lt_pmachine *m, int n)
{
    const uint8_t *p = lt_pm_take(m, (uint64_t)n);
    uint64_t x = 0;

    for (int i = 0; p && i < n; i++)
        x |= (uint64_t)p[i] << (8 * i);
    return x;
}

/* Text up to a newline, which is skipped; NULL after a failure. */
const char *lt_pm_take_line(lt_pmachine *m, size_t *n)
{
    const uint8_t *start = m->bytes + m->pos;
    const uint8_t *end = m->pos < m->n ? memchr(start, '\n', m->n - m->pos) : NULL;

    *n = 0;
    if (!end) {
        lt_pm_fail(m, "ends early, in a line of text" CUT);
        return NULL;
    }
    *n = (size_t)(end - start);
    m->pos += *n + 1;
    return (const char *)start;
}

/* A decimal integer that fills the line up to an optional L. */
bool lt_pm_parse_int(const char *text, size_t n, int64_t *out)
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

void lt_pm_push(lt_pmachine *m, lt_pvalue *v)
{
    lt_pvalue **stack = m->status ? NULL : grow(m, m->stack, &m->stack_room, m->n_stack + 1);

    if (!stack)
        return;
    m->stack = stack;
    m->stack[m->n_stack++] = v;
}

/* How low the stack may be popped: to the last mark. */
size_t lt_pm_floor(const lt_pmachine *m)
{
    return m->n_mark ? m->mark[m->n_mark - 1] : 0;
}

lt_pvalue *lt_pm_top(lt_pmachine *m)
{
    if (m->n_stack > lt_pm_floor(m))
        return m->stack[m->n_stack - 1];
    lt_pm_fail(m, "takes from an empty stack");
    return m->none;
}

lt_pvalue *lt_pm_pop(lt_pmachine *m)
{
    lt_pvalue *v = lt_pm_top(m);

    if (!m->status)
        m->n_stack--;
    return v;
}

void lt_pm_mark(lt_pmachine *m)
{
    size_t *mark = grow(m, m->mark, &m->mark_room, m->n_mark + 1);

    if (!mark)
        return;
    m->mark = mark;
    m->mark[m->n_mark++] = m->n_stack;
}

/* Everything above the last mark, which goes; still in the stack's memory until the next push. */
lt_pvalue **lt_pm_pop_mark(lt_pmachine *m, size_t *n)
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
void lt_pm_memo_put(lt_pmachine *m, uint64_t index)
{
    lt_pvalue *v = lt_pm_top(m), **memo;

    if (index > m->op_start / 2 + FIRST_ROOM)
        lt_pm_fail(m, "memo index %ju is beyond any that this file can have", (uintmax_t)index);
    memo = m->status ? NULL : grow(m, m->memo, &m->memo_room, (size_t)index + 1);
    if (!memo)
        return;
    m->memo = memo;
    m->memo[index] = v;
}

void lt_pm_memo_get(lt_pmachine *m, uint64_t index)
{
    if (index >= m->memo_room || !m->memo[index])
        lt_pm_fail(m, "memo index %ju was never stored", (uintmax_t)index);
    else
        lt_pm_push(m, m->memo[index]);
}
