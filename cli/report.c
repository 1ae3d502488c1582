/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "cli/export_shapes.h"
#include "data/recording/recording.h"
#include "eval/report/report.h"
#include "eval/report/session/session.h"
#include "eval/report/sheet.h"
#include "libtensor/io/file.h"
#include "tasks/tasks.h"

#include <stdio.h>

enum { VIEW = 256, FRAMES, SURFACES, VIEW_FRAMES = 12, MAX_RUNS = 32 };

typedef struct {
    const char *run[MAX_RUNS], *out;
    int n_runs, view;
    bool has_view, surfaces;
    cli_shapes shapes;              /* frames alone */
} report_args;

static const struct argp_option options[] = {
    { "output", 'o', "FILE", 0, "default report.html in the run's folder", 0 },
    { "view", VIEW, "N", 0,
      "of a run of hogs: frames, spread over those that it is validated on, in a view that turns; default 12, 0: no "
      "view", 0 },
    { "frames", FRAMES, "N,N-N", 0,
      "of runs of hogs: a sheet of these frames, from 0, of those that the runs are validated on, with a column for "
      "each run", 0 },
    { "surfaces", SURFACES, NULL, 0, "with --frames: the surfaces too, which take seconds each", 0 },
    { "threads", 't', "N", 0, "default: the CPUs this process may use", 0 },
    { 0 },
};

static void check_usage(const report_args *a, struct argp_state *state)
{
    if (!a->n_runs)
        argp_error(state, "want a run's folder");
    if (a->n_runs > 1 && !a->shapes.n_frames)
        argp_error(state, "one run at a time, or several with --frames");
    if (a->shapes.n_frames && !a->out)
        argp_error(state, "--frames: want -o FILE for the sheet");
    if (a->shapes.n_frames && a->has_view)
        argp_error(state, "--view is of a run's page, --frames makes a sheet of runs");
    if (!a->shapes.n_frames && a->surfaces)
        argp_error(state, "--surfaces goes with --frames");
}

static error_t parse(int key, char *arg, struct argp_state *state)
{
    report_args *a = state->input;

    switch (key) {
    case 'o': a->out = arg; break;
    case 't': cli_threads(state, arg); break;
    case VIEW:
        a->has_view = true;
        a->view = cli_number(state, "view", arg, 0, 1000);
        break;
    case FRAMES: cli_shapes_frames(state, &a->shapes, arg); break;
    case SURFACES: a->surfaces = true; break;
    case ARGP_KEY_ARG:
        if (a->n_runs == MAX_RUNS)
            argp_error(state, "at most %d runs", MAX_RUNS);
        a->run[a->n_runs++] = arg;
        break;
    case ARGP_KEY_END: check_usage(a, state); break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static const struct argp argp = {
    options, parse, "RUN\nRUN... --frames=N,N -o FILE\nSESSION",
    "Write one HTML page of a run, or of a session of palmar watch, to look at or to mail.\v"
    "The paper's tables with our rows, where palmar eval has been; curves; errors of the samples; pictures; machine "
    "and configuration; of a run of hogs or splats also frames to turn, as Gaussians and, the first of hogs, as "
    "surfaces, where "
    "the run's data are still there. Of a SESSION, a folder that palmar watch --record wrote: who did what and when, "
    "tracks, ages, times, drops, and sets of frames with what was found. The page needs no network and no other "
    "file.\n\n"
    "  palmar report runs/tiny\n"
    "  palmar report runs/hogs --view 24\n"
    "  palmar report session\n"
    "  palmar report runs/no-vpm runs/full --frames 0,10 -o sheet.html", NULL, NULL, NULL,
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
    lt_status st = cli_checkpoint_find(a->run[0], &c);

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

/* Of a recording that was watched */
static lt_status make_session(const report_args *a)
{
    if (a->has_view)
        return lt_error(LT_EUSAGE, "--view: %s is a recording, and no run of hogs", a->run[0]);
    return session_report_write(a->run[0], a->out);
}

static lt_status make_page(lt_arena *arena, report_args *a)
{
    report_view *view = NULL;
    lt_status st = LT_OK;

    if (!a->out)
        a->out = lt_path_join(arena, a->run[0], "report.html");
    if (!a->out)
        return lt_error(LT_ENOMEM, "%s: no memory", a->run[0]);
    if (recording_probe(a->run[0]))
        return make_session(a);
    if (a->view)
        st = open_view(a, &view);
    if (st == LT_OK)
        st = report_write(a->run[0], a->out, view);
    report_view_free(view);
    return st;
}

/* ---- the sheet --------------------------------------------------------------------------------------------------- */

static lt_status add_cell(void *ctx, const posed_frame *f)
{
    return report_sheet_add(ctx, f);
}

static lt_status add_run(const report_args *a, const char *run, report_sheet *sheet)
{
    cli_checkpoint c;
    lt_status st = cli_checkpoint_find(run, &c);

    if (!st && !c.config.task->pose)
        st = lt_error(LT_EINVAL, "%s: a run of %s, which draws no frames; want runs of hogs or splats", run,
                      c.config.task->name);
    if (!st)
        st = report_sheet_run(sheet, run);
    if (!st)
        st = c.config.task->pose(&(task_posing){ .arena = c.arena, .config = &c.config, .checkpoint = c.path,
                                                 .frame = a->shapes.frame, .n_frames = a->shapes.n_frames,
                                                 .visit = add_cell, .ctx = sheet });
    cli_checkpoint_close(&c);
    return st;
}

static lt_status make_sheet(const report_args *a)
{
    report_sheet *sheet = report_sheet_new(a->shapes.n_frames, a->surfaces);
    lt_status st = sheet ? LT_OK : lt_error(LT_ENOMEM, "no memory for the sheet");

    for (int i = 0; i < a->n_runs && !st; i++)
        st = add_run(a, a->run[i], sheet);
    if (!st)
        st = report_sheet_write(sheet, a->out);
    report_sheet_free(sheet);
    return st;
}

int cmd_report(int argc, char **argv)
{
    report_args a = { .view = VIEW_FRAMES };
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "no memory to begin");

    cli_parse("report", &argp, argc, argv, &a);
    if (st == LT_OK)
        st = a.shapes.n_frames ? make_sheet(&a) : make_page(arena, &a);
    if (st == LT_OK)
        printf("%s\n", a.out);
    lt_arena_free(arena);
    return st ? cli_fail(st) : 0;
}
