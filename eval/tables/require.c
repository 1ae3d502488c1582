/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/tables/require.h"

#include "libtensor/base/common.h"
#include "libtensor/io/text/nearest.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { KEYS = 128, LINE = 1024 };

static const char *skip_blanks(const char *text)
{
    return text + strspn(text, " \t");
}

static bool is_made(const char *key, const char *(*made)(int i))
{
    for (int i = 0; made(i); i++)
        if (strcmp(made(i), key) == 0)
            return true;
    return false;
}

/* The key that begins with what was typed, or else has it: people leave out the unit, and write names as papers do. */
static const char *longer_key(const char *typed, const char *(*made)(int i))
{
    char text[64];
    size_t n = 0;

    for (; typed[n] && n + 1 < sizeof(text); n++)
        text[n] = (char)(typed[n] == '-' ? '_' : tolower((unsigned char)typed[n]));
    text[n] = 0;
    for (int i = 0; made(i); i++)
        if (strncmp(made(i), text, n) == 0)
            return made(i);
    for (int i = 0; made(i); i++)
        if (strstr(made(i), text))
            return made(i);
    return NULL;
}

/* A key that is not scored: mistyped, or of what another task is about. */
static lt_status unknown(const char *key, const char *(*made)(int i))
{
    const char *const wrong = metric_find(key) ? "is not scored here" : "no such key";
    const char *const longer = longer_key(key, made);
    const char *keys[KEYS];
    size_t n = 0;

    if (longer)
        return lt_error(LT_EUSAGE, "--require %s: %s; did you mean \"%s\"?", key, wrong, longer);
    for (; n < KEYS && made((int)n); n++)
        keys[n] = made((int)n);
    lt_unknown_name(key, keys, n, "docs/formats.md lists those that are", "--require %s: %s", key, wrong);
    return LT_EUSAGE;
}

lt_status eval_require_read(const char *text, const char *(*made)(int i), eval_requirement *out)
{
    const char *sign = strpbrk(text, "<>"), *begin = skip_blanks(text);
    char key[64], *end;
    size_t n = sign ? (size_t)(sign - begin) : 0;

    while (n > 0 && strchr(" \t", begin[n - 1]))
        n--;
    if (!sign || sign[1] != '=' || n == 0 || n >= sizeof(key))
        return lt_error(LT_EUSAGE, "--require: found \"%s\", want KEY>=X or KEY<=X, as \"pa_mpjpe_mm<=12\"", text);
    memcpy(key, begin, n);
    key[n] = 0;
    out->at_least = *sign == '>';
    out->bound = strtod(sign + 2, &end);
    if (end == sign + 2 || *skip_blanks(end) || !isfinite(out->bound))
        return lt_error(LT_EUSAGE, "--require: found \"%s\", want a number behind %.2s", text, sign);
    out->what = metric_find(key);
    return out->what && is_made(key, made) ? LT_OK : unknown(key, made);
}

/* As many decimals as tell the two apart, two at least */
static int decimals(double found, double bound)
{
    int n = 2;

    while (n < 9 && fabs(found - bound) < 0.5 * pow(10, -n))
        n++;
    return n;
}

static bool holds(const eval_requirement *r, double found)
{
    return r->at_least ? found >= r->bound : found <= r->bound;
}

static int say(const eval_requirement *r, double found, char *line, size_t room)
{
    const char *unit = r->what->unit, *gap = *unit ? " " : "", *at = r->at_least ? "at least" : "at most";
    const int n = decimals(found, r->bound);

    if (isnan(found))
        return snprintf(line, room, "%s could not be measured, want %s %.*f", r->what->name, at, n, r->bound);
    return snprintf(line, room, "%s is %.*f%s%s, want %s %.*f", r->what->name, n, found, gap, unit, at, n, r->bound);
}

lt_status eval_require(const eval_requirement *r, int n, double (*score)(const void *ctx, const char *key),
                       const void *ctx)
{
    char line[LINE] = "";
    size_t used = 0;

    for (int i = 0; i < n; i++) {
        const double found = score(ctx, r[i].what->key);

        if (holds(&r[i], found) || used + 3 > sizeof(line))
            continue;
        if (used)
            used += (size_t)snprintf(line + used, sizeof(line) - used, "; ");
        used += (size_t)say(&r[i], found, line + used, sizeof(line) - used);
    }
    return used ? lt_error(LT_EINVAL, "%s", line) : LT_OK;
}
