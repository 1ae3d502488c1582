/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "eval/report/report.h"
#include "libtensor/io/file.h"
#include "tasks/tasks.h"

#include <stdio.h>

enum { VIEW = 256, VIEW_FRAMES = 12 };

typedef struct {
    const char *run, *out;
    int view;
} report_args;

static const struct argp_option options[] = {
    { "output", 'o', "FILE", 0, "default report.html in the run's folder", 0 },
    { "view", VIEW, "N", 0,
      "of a run of hogs: frames, spread over those that it is validated on, in a view that turns; default 12, 0: no "
      "view", 0 },
    { "threads", 't', "N", 0, "default: the CPUs this process may use", 0 },
    { 0 },
};

static error_t parse(int key, char *arg, struct argp_state *state)
{
    report_args *a = state->input;

    switch (key) {
    case 'o': a->out = arg; break;
    case 't': cli_threads(state, arg); break;
    case VIEW: a->view = cli_number(state, "view", arg, 0, 1000); break;
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
    "and configuration; of a run of hogs also frames to turn, as Gaussians and, the first of them, as surfaces, where "
    "the run's data are still there. The page needs no network and no other file.\n\n"
    "  palmar report runs/tiny\n"
    "  palmar report runs/hogs --view 24", NULL, NULL, NULL,
};

/* ---- the view ---------------------------------------------------------------------------------------------------- */

typedef struct {
    report_view *view;
    int frames;
} viewer;

/* Surfaces take long: the first frame has them. */
static lt_status add_frame(void *ctx, const posed_frame *f)
{
    viewer *v = ctx;

    return report_view_add(v->view, f, v->frames++ == 0);
}

static lt_status draw_frames(cli_checkpoint *c, int n, viewer *v)
{
    const task_posing p = { .arena = c->arena, .config = &c->config, .checkpoint = c->path, .n_frames = n,
                            .visit = add_frame, .ctx = v };

    v->view = report_view_new();
    return v->view ? c->config.task->pose(&p) : lt_error(LT_ENOMEM, "no memory for the view");
}

/* Of a run that has frames to show. Where they are gone the page goes without, and says why here. */
static lt_status open_view(const report_args *a, report_view **out)
{
    cli_checkpoint c;
    viewer v = { 0 };
    lt_status st = cli_checkpoint_find(a->run, &c);

    if (!st && c.config.task->pose) {
        st = draw_frames(&c, a->view, &v);
        if (st && st != LT_ENOMEM)
            fprintf(stderr, "no view of frames: %s\n", lt_last_error());
    }
    if (st) {
        report_view_free(v.view);
        v.view = NULL;
    }
    cli_checkpoint_close(&c);
    *out = v.view;
    return st == LT_ENOMEM ? st : LT_OK;
}

int cmd_report(int argc, char **argv)
{
    report_args a = { .view = VIEW_FRAMES };
    lt_arena *arena = lt_arena_new();
    report_view *view = NULL;
    lt_status st;

    cli_parse("report", &argp, argc, argv, &a);
    if (arena && !a.out)
        a.out = lt_path_join(arena, a.run, "report.html");
    st = a.out ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", a.run);
    if (st == LT_OK && a.view)
        st = open_view(&a, &view);
    if (st == LT_OK)
        st = report_write(a.run, a.out, view);
    if (st == LT_OK)
        printf("%s\n", a.out);
    report_view_free(view);
    lt_arena_free(arena);
    return st ? cli_fail(st) : 0;
}
