/* SPDX-License-Identifier: Apache-2.0 */
/* palmar-gradcheck: every op's gradient against central differences in double. */
#include "libtensor/base/parallel.h"
#include "tests/models/model_gradient.h"
#include "tests/ops/gradient.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SHAPES = 20 };               /* random ones, besides the listed */

static const char usage[] =
    "Usage: palmar gradcheck --all | --op NAME | --model hogs [--json]\n"
    "  or:  palmar gradcheck --list\n"
    "Compare the gradients of ops, or of a whole model's parts, with central differences, in double precision.\n\n"
    "      --all                  all ops\n"
    "      --json                 a list with an object for each op or part instead of lines\n"
    "      --list                 the names of the ops\n"
    "      --model hogs           from images and poses to each part of HOGS\n"
    "      --op NAME              this one\n"
    "      --help                 Give this help list\n\n"
    "The exit code is 1 when a gradient is wrong.\n";

static const op_suite *find(const char *name)
{
    for (int i = 0; i < n_op_suites; i++)
        if (strcmp(op_suites[i]->name, name) == 0)
            return op_suites[i];
    return NULL;
}

static int list(void)
{
    for (int i = 0; i < n_op_suites; i++)
        puts(op_suites[i]->name);
    return 0;
}

static void print_json(const op_suite *s, const gradient_report *r, bool ok, bool first)
{
    printf("%s\n  {\"op\": \"%s\", \"error\": %.3g, \"probes\": %ld, \"ok\": %s}", first ? "[" : ",", s->name,
           r->worst > 1e300 ? 1e300 : r->worst, r->probes, ok ? "true" : "false");
}

static void print_line(const op_suite *s, const gradient_report *r, bool ok)
{
    printf("%-20s %.1e  %6ld probes  %s%s\n", s->name, r->worst, r->probes, ok ? "ok" : "FAILS at ",
           ok ? "" : r->where);
}

static bool check(const op_suite *s, bool json, bool first)
{
    gradient_report r = { .worst = 0 };
    bool ok;

    if (!gradient_check_op(s, SHAPES, &r)) {
        r.worst = 1e300;
        snprintf(r.where, sizeof(r.where), "%s", lt_last_error());
    }
    ok = r.worst <= GRADIENT_BOUND;
    if (json)
        print_json(s, &r, ok, first);
    else
        print_line(s, &r, ok);
    fflush(stdout);
    return ok;
}

static int check_these(const op_suite *only, bool json)
{
    bool ok = true;
    int done = 0;

    for (int i = 0; i < n_op_suites; i++)
        if (!only || op_suites[i] == only)
            ok &= check(op_suites[i], json, done++ == 0);
    if (json)
        puts("\n]");
    return ok ? 0 : 1;
}

/* ---- a whole model ---------------------------------------------------------------------------------------------- */

static void print_part(const model_gradient *g, bool good, bool json, bool first)
{
    if (json)
        printf("%s\n  {\"model\": \"hogs\", \"chain\": \"%s\", \"block\": \"%s\", \"error\": %.3g, \"ok\": %s}",
               first ? "[" : ",", g->through, g->block, fmin(g->error, 1e300), good ? "true" : "false");
    else
        printf("%-36s %-12s %.1e  %s\n", g->through, g->block, g->error, good ? "ok" : "FAILS");
    fflush(stdout);
}

static int check_model(bool json)
{
    model_gradient of[MODEL_GRADIENT_PARTS];
    bool ok = true;

    for (int chain = 0; chain < MODEL_GRADIENT_CHAINS; chain++) {
        const int n = model_gradients(chain, of);

        if (!n)
            fprintf(stderr, "palmar-gradcheck: %s\n", lt_last_error());
        ok = ok && n;
        for (int i = 0; i < n; i++) {
            const bool good = of[i].error <= GRADIENT_BOUND;

            ok = ok && good;
            print_part(&of[i], good, json, chain == 0 && i == 0);
        }
    }
    if (json)
        puts("\n]");
    return ok ? 0 : 1;
}

/* The code to end with: 4 where what was found did not reach anybody. */
static int told(int code)
{
    if (fflush(stdout) == 0 && !ferror(stdout))
        return code;
    fprintf(stderr, "palmar-gradcheck: cannot write to standard output: %s\n", strerror(errno));
    return 4;
}

int main(int argc, char **argv)
{
    const op_suite *only = NULL;
    bool all = false, whole = false, json = false;

    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--list") == 0)
            return told(list());
        if (strcmp(argv[i], "--help") == 0) {
            fputs(usage, stdout);
            return told(0);
        }
        if (strcmp(argv[i], "--all") == 0) {
            all = true;
        } else if (strcmp(argv[i], "--json") == 0) {
            json = true;
        } else if (strcmp(argv[i], "--model") == 0 && i + 1 < argc) {
            whole = strcmp(argv[++i], "hogs") == 0;
            if (!whole) {
                fprintf(stderr, "palmar-gradcheck: --model: found \"%s\", want hogs\n", argv[i]);
                return 2;
            }
        } else if (strcmp(argv[i], "--op") == 0 && i + 1 < argc) {
            only = find(argv[++i]);
            if (!only) {
                fprintf(stderr, "palmar-gradcheck: no op \"%s\"; --list names them\n", argv[i]);
                return 2;
            }
        } else {
            fputs(usage, stderr);
            return 2;
        }
    }
    if (whole)
        return told(check_model(json));
    if (!all && !only) {
        fputs(usage, stderr);
        return 2;
    }
    lt_set_threads(1);                  /* the graphs are too small to share */
    return told(check_these(only, json));
}
