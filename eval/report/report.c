/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/report/report.h"

#include "estimate/metric.h"
#include "eval/report/internal.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MAX_CURVES = 64, MAX_SKIPPED = 50 };

/* What is known of a run */
typedef struct {
    lt_arena *arena;
    const char *run;
    const report_view *view;
    html_nonce nonce;               /* of this page's script; "": there is none */
    cJSON *config, *env;
    report_series curve[MAX_CURVES];
    int n_curves;
    const char *skipped[MAX_SKIPPED];
    int n_skipped, n_steps;
    double last_step;
} report;

/* ---- reading --------------------------------------------------------------------------------------------------- */

/* A file of the run as text, NULL when it is not there */
static lt_status read_text(const report *r, const char *name, const char **text, size_t *n)
{
    const char *path = lt_path_join(r->arena, r->run, name);
    uint8_t *bytes;
    lt_status st;

    *text = NULL;
    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", name);
    if (access(path, F_OK) != 0)
        return LT_OK;
    st = lt_read_file(r->arena, path, LT_FILE_MAX, &bytes, n);
    if (st == LT_OK)
        *text = (const char *)bytes;
    return st;
}

static bool put_point(lt_arena *arena, report_series *s, double x, double y)
{
    double *xs = lt_arena_grow(arena, s->x, (size_t)s->n, &s->x_room, sizeof(*xs));
    double *ys = lt_arena_grow(arena, s->y, (size_t)s->n, &s->y_room, sizeof(*ys));

    if (!xs || !ys)
        return false;
    s->x = xs;
    s->y = ys;
    s->x[s->n] = x;
    s->y[s->n++] = y;
    return true;
}

static lt_status add_point(report *r, const char *group, const char *name, double x, double y)
{
    const char *full = lt_arena_printf(r->arena, "%s%s%s", group, *group ? " " : "", name);
    report_series *s = NULL;

    for (int i = 0; full && i < r->n_curves && !s; i++)
        s = strcmp(r->curve[i].name, full) == 0 ? &r->curve[i] : NULL;
    if (!isfinite(y) || (!s && r->n_curves == MAX_CURVES))
        return LT_OK;
    if (full && !s) {
        s = &r->curve[r->n_curves++];
        *s = (report_series){ .name = full };
    }
    return s && put_point(r->arena, s, x, y) ? LT_OK : lt_error(LT_ENOMEM, "no memory for the curves");
}

/* Every number of an object is a point of a curve, but for those that count steps. */
static lt_status add_points(report *r, const char *group, const cJSON *object, double step)
{
    static const char *const counts[] = { "step", "epoch", "samples", "seconds" };
    const cJSON *item;
    lt_status st = LT_OK;

    cJSON_ArrayForEach(item, object) {
        bool is_count = false;

        for (size_t i = 0; i < LT_COUNT(counts); i++)
            is_count |= strcmp(item->string, counts[i]) == 0;
        if (st == LT_OK && cJSON_IsNumber(item) && !is_count)
            st = add_point(r, group, item->string, step, item->valuedouble);
    }
    return st;
}

/* Only validations measure. */
static bool has_metric(const cJSON *line)
{
    const cJSON *item;

    cJSON_ArrayForEach(item, line)
        if (metric_find(item->string ? item->string : ""))
            return true;
    return false;
}

/* A line of log.jsonl: a step, or a validation */
static lt_status take_line(report *r, const cJSON *line)
{
    const cJSON *step = cJSON_GetObjectItemCaseSensitive(line, "step");
    const cJSON *skipped = cJSON_GetObjectItemCaseSensitive(line, "skipped");
    const char *group = has_metric(line) ? "validation" : "";
    lt_status st;

    if (!cJSON_IsNumber(step))
        return LT_OK;
    r->n_steps += !*group;
    r->last_step = fmax(r->last_step, step->valuedouble);
    if (cJSON_IsString(skipped) && r->n_skipped < MAX_SKIPPED)
        r->skipped[r->n_skipped++] = lt_arena_printf(r->arena, "step %.0f: %s", step->valuedouble,
                                                     skipped->valuestring);
    st = add_points(r, group, line, step->valuedouble);
    return st ? st : add_points(r, group, cJSON_GetObjectItemCaseSensitive(line, "parts"), step->valuedouble);
}

/* The last line may be torn: the run was killed in it. */
static lt_status read_log(report *r)
{
    const char *text, *end;
    size_t n = 0;
    int number = 1;
    lt_status st = read_text(r, "log.jsonl", &text, &n);

    for (; st == LT_OK && text && (end = memchr(text, '\n', n));
         n -= (size_t)(end + 1 - text), text = end + 1, number++) {
        cJSON *line;

        st = lt_json_parse("not an object", text, (size_t)(end - text), &line);
        if (st)
            return lt_error(st, "%s/log.jsonl: line %d: not valid JSON", r->run, number);
        st = take_line(r, line);
        cJSON_Delete(line);
    }
    return st;
}

static lt_status read_json(const report *r, const char *name, cJSON **out)
{
    const char *path = lt_path_join(r->arena, r->run, name);

    return path ? lt_json_read(path, out) : lt_error(LT_ENOMEM, "%s: no memory", name);
}

/* ---- the page ---------------------------------------------------------------------------------------------------- */

static const char *text_of(const cJSON *object, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);

    return cJSON_IsString(item) ? item->valuestring : "";
}

static bool is_set(const cJSON *object, const char *key)
{
    return cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(object, key));
}

static void put_heading(FILE *f, const report *r)
{
    const cJSON *model = cJSON_GetObjectItemCaseSensitive(r->config, "model");

    html_begin(f, r->run, r->nonce);
    fputs("<p>", f);
    html_text(f, text_of(model, "name"));
    fputs(" ", f);
    html_text(f, text_of(model, "variant"));
    fputs(", trained on ", f);
    html_text(f, text_of(r->env, "data"));
    if (is_set(r->env, "synthetic_data"))
        fputs(" <span class=label>synthetic data</span>", f);
    if (is_set(r->env, "synthetic_hand"))
        fputs(" <span class=label>synthetic hand</span>", f);
    fputs("</p>\n", f);
}

/* The step that the tables are of, where they say so and the run has gone on since. */
static void put_age(FILE *f, const report *r)
{
    cJSON *scores = NULL;
    const cJSON *step;

    if (read_json(r, "eval/scores.json", &scores))
        return;
    step = cJSON_GetObjectItemCaseSensitive(scores, "step");
    if (cJSON_IsNumber(step) && step->valuedouble < r->last_step)
        fprintf(f, "<p>Scored at step %.0f; the run has gone on to step %.0f.</p>\n", step->valuedouble, r->last_step);
    cJSON_Delete(scores);
}

/* Whether what was scored are detections */
static bool detects(const report *r)
{
    const char *path = lt_path_join(r->arena, r->run, "eval/confusion.csv");

    return path && access(path, F_OK) == 0;
}

static lt_status put_tables(FILE *f, const report *r)
{
    const char *text;
    size_t n;
    const lt_status st = read_text(r, "eval/table.md", &text, &n);

    fprintf(f, "<h2>%s</h2>\n", detects(r) ? "Scores" : "The paper's tables, and ours");
    if (st || !text) {
        fputs("<p>Not scored yet: palmar eval does it.</p>\n", f);
        return st;
    }
    put_age(f, r);
    html_markdown(f, text);
    return LT_OK;
}

static void put_curves(FILE *f, const report *r)
{
    fputs("<h2>Curves</h2>\n", f);
    if (!r->n_curves)
        fputs("<p>No steps yet.</p>\n", f);
    for (int i = 0; i < r->n_curves; i++)
        svg_curve(f, &r->curve[i], "step");
    if (r->n_skipped)
        fputs("<h3>Skipped steps</h3>\n<ul>\n", f);
    for (int i = 0; i < r->n_skipped; i++) {
        fputs("<li>", f);
        html_text(f, r->skipped[i] ? r->skipped[i] : "");
        fputs("</li>\n", f);
    }
    if (r->n_skipped)
        fputs("</ul>\n", f);
}

static lt_status put_errors(FILE *f, const report *r)
{
    static const html_error_table tables[] = {
        { "eval/per-joint.csv", "Joints", 21, false },
        { "eval/per-object.csv", "Objects", 21, false },
        { "eval/per-sequence.csv", "Sequences", 10, false },
        { "eval/per-sample.csv", "Samples", 20, true },
        { "eval/per-image.csv", "Images", 20, false },
    };
    lt_status st = LT_OK;

    for (size_t i = 0; !st && i < LT_COUNT(tables); i++) {
        const char *text;
        size_t n;

        st = read_text(r, tables[i].file, &text, &n);
        if (!st && text)
            st = html_errors(f, r->arena, &tables[i], (char *)text);
    }
    return st;
}

/* Of a detector */
static lt_status put_detection(FILE *f, const report *r)
{
    const char *text;
    size_t n;
    lt_status st = read_text(r, "eval/curves.json", &text, &n);

    if (!st && text)
        st = html_curves(f, r->arena, "eval/curves.json", text, n);
    st = st ? st : read_text(r, "eval/confusion.csv", &text, &n);
    return st || !text ? st : html_confusion(f, r->arena, (char *)text);
}

static lt_status put_pictures(FILE *f, const report *r)
{
    const char *png;
    size_t n;
    const lt_status st = read_text(r, "eval/pictures.png", &png, &n);

    if (st || !png)
        return st;
    if (detects(r))
        fputs("<h2>The worst pictures</h2>\n<p>White: what is there and was found; red: what was missed. Green: found "
              "and right; orange: found, and another thing or nothing is there.</p>\n", f);
    else
        fputs("<h2>Pictures</h2>\n<p>The truth beside what was seen.</p>\n", f);
    html_picture(f, (const uint8_t *)png, n, "samples, the truth beside what was seen");
    return LT_OK;
}

/* ---- how it was made --------------------------------------------------------------------------------------------- */

static double speed_halfway(const report *r)
{
    for (int i = 0; i < r->n_curves; i++)
        if (strcmp(r->curve[i].name, "img_per_s") == 0 && r->curve[i].n)
            return r->curve[i].y[r->curve[i].n / 2];
    return 0;
}

static void put_json(FILE *f, const cJSON *value)
{
    char *text = cJSON_Print(value);

    fputs("<pre>", f);
    html_text(f, text ? text : "");
    fputs("</pre>\n", f);
    cJSON_free(text);
}

static void put_making(FILE *f, const report *r)
{
    fprintf(f, "<h2>How it was made</h2>\n<p>%d steps in the log, %.4g images a second halfway through.</p>\n",
            r->n_steps, speed_halfway(r));
    put_json(f, r->env);
    fputs("<h2>Configuration</h2>\n", f);
    put_json(f, r->config);
    fputs("</body></html>\n", f);
}

static lt_status put_page(FILE *f, const report *r)
{
    lt_status st;

    put_heading(f, r);
    st = put_tables(f, r);
    if (r->view)
        view_put(f, r->view, r->nonce);
    put_curves(f, r);
    if (st == LT_OK)
        st = put_detection(f, r);
    if (st == LT_OK)
        st = put_errors(f, r);
    if (st == LT_OK)
        st = put_pictures(f, r);
    put_making(f, r);
    return st;
}

static lt_status read_run(report *r)
{
    lt_status st = read_json(r, "config.json", &r->config);

    if (st == LT_OK)
        st = read_json(r, "env.json", &r->env);
    return st ? st : read_log(r);
}

lt_status report_write(const char *run, const char *path, const report_view *view)
{
    report *r = lt_alloc(sizeof(*r));
    lt_atomic_file f;
    lt_status st;

    if (!r || !(r->arena = lt_arena_new())) {
        lt_release(r);
        return lt_error(LT_ENOMEM, "%s: no memory", run);
    }
    r->run = run;
    r->view = view;
    st = view ? html_draw_nonce(r->nonce) : LT_OK;
    if (st == LT_OK)
        st = read_run(r);
    if (st == LT_OK)
        st = lt_atomic_open(&f, path);
    if (st == LT_OK) {
        st = put_page(f.stream, r);
        if (st)
            lt_atomic_abort(&f);
        else
            st = lt_atomic_commit(&f);
    }
    cJSON_Delete(r->config);
    cJSON_Delete(r->env);
    lt_arena_free(r->arena);
    lt_release(r);
    return st;
}
