/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/report/session/session.h"

#include "eval/report/session/internal.h"
#include "libtensor/io/atomic_file.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* As the paper's table of stages has them */
static const char *const stages[SESSION_STAGES] = {
    "detection", "tracking", "association between cameras", "whole bodies", "contact", "hand and object",
    "poses", "filters", "action and interaction",
};

/* ---- numbers ---- */

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static void put_cell(FILE *f, double x, const char *format)
{
    fputs("<td class=n>", f);
    if (isfinite(x))
        fprintf(f, format, x);
    fputs("</td>", f);
}

/* The value that a share of all is at most */
static double share_of(const double *sorted, int n, double share)
{
    const int k = (int)ceil(share * n) - 1;

    return n ? sorted[k < 0 ? 0 : k] : NAN;
}

static lt_status put_series(FILE *f, const history *h, const char *name, const report_series *s)
{
    double *sorted = lt_arena_array(h->arena, (size_t)s->n, sizeof(*sorted)), sum = 0;

    if (!sorted)
        return lt_error(LT_ENOMEM, "no memory for the page");
    for (int i = 0; i < s->n; i++) {
        sorted[i] = s->y[i];
        sum += s->y[i];
    }
    qsort(sorted, (size_t)s->n, sizeof(*sorted), by_size);
    fputs("<tr><td>", f);
    html_text(f, name);
    fputs("</td>", f);
    put_cell(f, share_of(sorted, s->n, 0.5), "%.1f");
    put_cell(f, share_of(sorted, s->n, 0.95), "%.1f");
    put_cell(f, s->n ? sorted[s->n - 1] : NAN, "%.1f");
    put_cell(f, s->n ? sum / s->n : NAN, "%.1f");
    fputs("</tr>\n", f);
    return LT_OK;
}

/* Whether the stage ever took a time */
static bool has_any(const report_series *s)
{
    for (int i = 0; i < s->n; i++)
        if (s->y[i] > 0)
            return true;
    return false;
}

static lt_status put_times(FILE *f, history *h)
{
    lt_status st;

    fputs("<h2>Ages and times</h2>\n<p>Milliseconds; the age of an answer is from the reference camera's frame to the "
          "line.</p>\n<div class=wide><table>\n<tr><th></th><th class=n>half are below</th><th class=n>95 % are "
          "below</th><th class=n>most</th><th class=n>mean</th></tr>\n", f);
    st = put_series(f, h, "age", &h->age);
    if (!st)
        st = put_series(f, h, "between a set's frames", &h->pair);
    for (int k = 0; k < SESSION_STAGES && !st; k++) {
        const char *name = lt_arena_printf(h->arena, "S%d %s", k + 1, stages[k]);

        st = name ? put_series(f, h, name, &h->stage[k]) : lt_error(LT_ENOMEM, "no memory for the page");
    }
    fputs("</table></div>\n", f);
    if (st)
        return st;
    h->age.name = "age, ms";
    h->pair.name = "between a set's frames, ms";
    if (h->age.n) {
        svg_curve(f, &h->age, "seconds");
        svg_histogram(f, "ages", h->age.y, h->age.n, "ms");
    }
    if (h->pair.n)
        svg_curve(f, &h->pair, "seconds");
    for (int k = 0; k < SESSION_STAGES; k++)
        if (has_any(&h->stage[k])) {
            h->stage[k].name = lt_arena_printf(h->arena, "S%d, ms", k + 1);
            if (!h->stage[k].name)
                return lt_error(LT_ENOMEM, "no memory for the page");
            svg_curve(f, &h->stage[k], "seconds");
        }
    return LT_OK;
}

/* ---- frames ---- */

static int64_t frames_of(const recording *r, int camera)
{
    int64_t n = 0;

    for (int64_t i = 0; i < r->n_frames; i++)
        n += r->frame[i].camera == camera;
    return n;
}

static lt_status put_drops(FILE *f, history *h)
{
    fputs("<h2>Cameras</h2>\n<div class=wide><table>\n<tr><th>camera</th><th>role</th><th class=n>pixels</th>"
          "<th class=n>frames recorded</th><th class=n>dropped</th></tr>\n", f);
    for (int c = 0; c < h->r.rig.n; c++) {
        const recording_camera *k = &h->r.rig.camera[c];
        const report_series *s = &h->drops[c];

        fputs("<tr><td>", f);
        html_text(f, k->name);
        fprintf(f, "</td><td>%s</td><td class=n>%d x %d</td><td class=n>%" PRId64 "</td>", recording_role_name(k->role),
                k->width, k->height, frames_of(&h->r, c));
        put_cell(f, s->n ? s->y[s->n - 1] : NAN, "%.0f");
        fputs("</tr>\n", f);
    }
    fputs("</table></div>\n", f);
    for (int c = 0; c < h->r.rig.n; c++)
        if (h->drops[c].n) {
            h->drops[c].name = lt_arena_printf(h->arena, "dropped, %s", h->r.rig.camera[c].name);
            if (!h->drops[c].name)
                return lt_error(LT_ENOMEM, "no memory for the page");
            svg_curve(f, &h->drops[c], "seconds");
        }
    return LT_OK;
}

/* ---- the whole ---- */

static void put_fact(FILE *f, const char *name, double x, const char *format)
{
    if (!isfinite(x))
        return;
    fprintf(f, "<tr><td>%s</td>", name);
    put_cell(f, x, format);
    fputs("</tr>\n", f);
}

static void put_sum(FILE *f, const history *h)
{
    const session_sum *s = &h->sum;

    fprintf(f, "<p>%d camera%s, %" PRId64 " sets of frames in %.1f s%s%s</p>\n", h->r.rig.n, h->r.rig.n == 1 ? "" : "s",
            h->n, h->n ? h->time[h->n - 1] : 0.0, h->has_truth ? ", with the truth" : "",
            h->r.rig.synthetic ? " <span class=label>synthetic data</span>" : "");
    if (!h->has_sum) {
        fputs("<p>The session has no summary: it was cut short.</p>\n", f);
        return;
    }
    fputs("<div class=wide><table>\n", f);
    put_fact(f, "frames that came", s->captured, "%.0f");
    put_fact(f, "taken into sets", s->taken, "%.0f");
    put_fact(f, "dropped", s->dropped, "%.0f");
    put_fact(f, "sets a second", s->fps, "%.2f");
    put_fact(f, "age, half are below, ms", s->age_p50, "%.1f");
    put_fact(f, "age, 95 % are below, ms", s->age_p95, "%.1f");
    put_fact(f, "memory at first, MB", s->rss_first, "%.0f");
    put_fact(f, "memory at last, MB", s->rss_last, "%.0f");
    if (*s->crc) {
        fputs("<tr><td>checksum of the lines</td><td class=n>", f);
        html_text(f, s->crc);
        fputs("</td></tr>\n", f);
    }
    fputs("</table></div>\n", f);
}

static lt_status put_page(FILE *f, history *h, const char *nonce)
{
    lt_status st;

    html_begin(f, h->r.root, nonce);
    put_sum(f, h);
    timeline_put(f, h);
    st = agreement_put(f, h);
    if (!st)
        st = pictures_put(f, h, nonce);
    if (!st)
        st = put_times(f, h);
    if (!st)
        st = put_drops(f, h);
    fputs("</body></html>\n", f);
    return st;
}

lt_status session_report_write(const char *root, const char *path)
{
    history *h = lt_alloc(sizeof(*h));
    lt_arena *arena = lt_arena_new();
    html_nonce nonce;
    lt_atomic_file f;
    lt_status st = h && arena ? html_draw_nonce(nonce) : lt_error(LT_ENOMEM, "%s: no memory", root);

    if (!st)
        st = history_read(arena, root, h);
    if (!st)
        st = lt_atomic_open(&f, path);
    if (!st) {
        st = put_page(f.stream, h, nonce);
        if (st)
            lt_atomic_abort(&f);
        else
            st = lt_atomic_commit(&f);
    }
    lt_arena_free(arena);
    lt_release(h);
    return st;
}
