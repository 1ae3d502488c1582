/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "eval/report/report.h"
#include "libtensor/io/file.h"

#include <stdio.h>

typedef struct {
    const char *run, *out;
} report_args;

static const struct argp_option options[] = {
    { "output", 'o', "FILE", 0, "default report.html in the run's folder", 0 },
    { 0 },
};

static error_t parse(int key, char *arg, struct argp_state *state)
{
    report_args *a = state->input;

    switch (key) {
    case 'o': a->out = arg; break;
    case ARGP_KEY_ARG:
        if (a->run)
            argp_error(state, "one run at a time");
        a->run = arg;
        break;
    case ARGP_KEY_END:
        if (!a->run)
            argp_error(state, "want a run's folder");
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static const struct argp argp = {
    options, parse, "RUN",
    "Write one HTML page of a run, to look at or to mail.\v"
    "The paper's tables with our rows, where palmar eval has been; curves; errors of the samples; pictures; machine "
    "and configuration. The page needs no network and no other file.\n\n  palmar report runs/tiny", NULL, NULL, NULL,
};

int cmd_report(int argc, char **argv)
{
    report_args a = { .run = NULL };
    lt_arena *arena = lt_arena_new();
    lt_status st;

    cli_parse("report", &argp, argc, argv, &a);
    if (arena && !a.out)
        a.out = lt_path_join(arena, a.run, "report.html");
    st = a.out ? report_write(a.run, a.out) : lt_error(LT_ENOMEM, "%s: no memory", a.run);
    if (st == LT_OK)
        printf("%s\n", a.out);
    lt_arena_free(arena);
    return st ? cli_fail(st) : 0;
}
