/* SPDX-License-Identifier: Apache-2.0 */
#include "train/progress.h"

#include "libtensor/base/clock.h"
#include "libtensor/base/printable.h"
#include "libtensor/io/file.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

static const double TERMINAL_SECONDS = 0.1, PLAIN_SECONDS = 10;

void progress_init(train_progress *p, FILE *f, bool quiet)
{
    const char *plain = getenv("NO_COLOR");

    *p = (train_progress){ .f = f, .quiet = quiet, .terminal = lt_is_terminal(fileno(f)), .last = -1e9 };
    p->colour = p->terminal && !(plain && *plain);
    p->log = open_memstream(&p->said, &p->said_bytes);
}

/* ---- the line ----------------------------------------------------------------------------------------- */

typedef struct {
    char text[512];
    size_t n;
} line;

static void add(line *l, const char *fmt, ...) LT_PRINTF(2, 3);

static void add(line *l, const char *fmt, ...)
{
    va_list args;
    int n;

    va_start(args, fmt);
    n = vsnprintf(l->text + l->n, sizeof(l->text) - l->n, fmt, args);
    va_end(args);
    if (n > 0)
        l->n = (size_t)lt_min_i64((int64_t)l->n + n, (int64_t)sizeof(l->text) - 1);
}

static void add_duration(line *l, double seconds)
{
    const int64_t s = seconds > 0 && seconds < 1e9 ? (int64_t)seconds : 0;

    if (s >= 86400)
        add(l, "%" PRId64 "d%02" PRId64 "h", s / 86400, s / 3600 % 24);
    else if (s >= 3600)
        add(l, "%" PRId64 "h%02" PRId64 "m", s / 3600, s / 60 % 60);
    else
        add(l, "%" PRId64 "m%02" PRId64 "s", s / 60, s % 60);
}

/* The losses' many parts last, where a narrow terminal ends the line. */
static void compose(line *l, const train_step_record *r, const train_progress_state *s)
{
    add(l, "epoch %" PRId64 "/%" PRId64 "  step %" PRId64 "/%" PRId64 "  loss %.4g  lr %.2g  %.1f img/s  ETA ",
        r->epoch + 1, s->epochs, s->step_of_epoch, s->steps_of_epoch, r->loss, r->lr, r->img_per_s);
    add_duration(l, s->eta_seconds);
    add(l, "  skipped %" PRId64, s->skipped);
    for (int i = 0; i < r->n_parts; i++)
        add(l, "%s%s %.3g", i ? " " : "  (", r->part_name[i], r->part[i]);
    add(l, "%s", r->n_parts ? ")" : "");
}

static int columns(FILE *f)
{
    struct winsize w;

    return ioctl(fileno(f), TIOCGWINSZ, &w) == 0 && w.ws_col > 0 ? w.ws_col : 80;
}

void progress_step(train_progress *p, const train_step_record *r, const train_progress_state *s, bool now)
{
    const double t = lt_clock();
    line l = { .n = 0 };

    if (p->quiet || (!now && t - p->last < (p->terminal ? TERMINAL_SECONDS : PLAIN_SECONDS)))
        return;
    p->last = t;
    compose(&l, r, s);
    if (p->terminal)
        fprintf(p->f, "\r\033[K%.*s", columns(p->f) - 1, l.text);
    else
        fprintf(p->f, "%s\n", l.text);
    p->drawn = p->terminal;
    fflush(p->f);
}

/* ---- lines of their own ------------------------------------------------------------------------------- */

static void end_line(train_progress *p)
{
    if (p->drawn)
        fputc('\n', p->f);
    p->drawn = false;
    fflush(p->f);
}

/* A log that cannot be written is no reason to stop a run. */
static void keep(train_progress *p, const char *kind, const char *fmt, va_list args)
{
    const time_t now = time(NULL);
    struct tm at;
    char when[32];

    if (!p->log || !localtime_r(&now, &at))
        return;
    strftime(when, sizeof(when), "%Y-%m-%d %H:%M:%S", &at);
    fprintf(p->log, "%s  %s", when, kind);
    lt_vsay(p->log, fmt, args);
    fflush(p->log);
}

static void show(train_progress *p, bool warning, const char *fmt, va_list args)
{
    end_line(p);
    if (warning)
        fputs(p->colour ? "\033[33mwarning:\033[0m " : "warning: ", p->f);
    lt_vsay(p->f, fmt, args);
}

static void tell(train_progress *p, bool warning, const char *fmt, va_list args)
{
    va_list again;

    va_copy(again, args);
    keep(p, warning ? "warning: " : "", fmt, again);
    va_end(again);
    if (warning || !p->quiet)
        show(p, warning, fmt, args);
}

void progress_note(train_progress *p, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    tell(p, false, fmt, args);
    va_end(args);
}

void progress_warn(train_progress *p, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    tell(p, true, fmt, args);
    va_end(args);
}

/* ---- the run's own copy ------------------------------------------------------------------------------- */

static void close_log(train_progress *p)
{
    if (p->log)
        fclose(p->log);
    free(p->said);
    p->log = NULL;
    p->said = NULL;
}

lt_status progress_keep(train_progress *p, const char *path)
{
    FILE *f;
    const lt_status st = lt_append_own(path, &f);

    if (st)
        return st;
    if (p->said)
        fwrite(p->said, 1, p->said_bytes, f);
    fflush(f);
    close_log(p);
    p->log = f;
    return LT_OK;
}

void progress_log(train_progress *p, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    keep(p, "", fmt, args);
    va_end(args);
}

void progress_fini(train_progress *p)
{
    end_line(p);
    close_log(p);
}
