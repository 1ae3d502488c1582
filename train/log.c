/* SPDX-License-Identifier: Apache-2.0 */
#include "train/log.h"

#include "libtensor/base/order.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/events.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- opening ------------------------------------------------------------------------------------------ */

/* Whether a line stays: its number behind prefix is at most step, or it has none (a heading). */
static bool stays(const char *line, const char *prefix, int64_t step)
{
    const size_t n = strlen(prefix);
    char *end;
    long long number;

    if (strncmp(line, prefix, n) != 0)
        return true;
    number = strtoll(line + n, &end, 10);
    return end == line + n || number <= step;
}

/* Keep whole lines up to step; the rest was written after the checkpoint that we go on from. */
static lt_status cut(lt_arena *arena, const char *path, const char *prefix, int64_t step)
{
    size_t n, kept = 0;
    uint8_t *bytes;
    const char *text, *end;
    lt_status st;

    if (access(path, F_OK) != 0)
        return LT_OK;
    st = lt_read_file(arena, path, LT_FILE_MAX, &bytes, &n);
    if (st)
        return st;
    text = (const char *)bytes;
    while ((end = memchr(text + kept, '\n', n - kept)) && stays(text + kept, prefix, step))
        kept = (size_t)(end + 1 - text);
    return kept == n ? LT_OK : lt_write_file(path, bytes, kept);
}

static lt_status open_one(lt_arena *arena, const char *folder, const char *name, const char *prefix,
                          int64_t step, FILE **out)
{
    const char *path = lt_path_join(arena, folder, name);
    lt_status st = path ? lt_check_own(path) : lt_error(LT_ENOMEM, "%s: no memory", name);

    if (!st)
        st = cut(arena, path, prefix, step);
    return st ? st : lt_append_own(path, out);
}

static lt_status open_events(lt_arena *arena, const char *folder, int64_t step, FILE **out)
{
    const char *path = lt_path_join(arena, folder, "tb");
    const lt_status st = path ? lt_make_own_folder(path) : lt_error(LT_ENOMEM, "tb: no memory");

    return st ? st : lt_events_open(arena, path, step, out);
}

lt_status train_log_open(lt_arena *arena, const char *folder, int64_t step, train_log *out)
{
    lt_status st;

    *out = (train_log){ 0 };
    st = open_one(arena, folder, "log.jsonl", "{\"step\":", step, &out->log);
    if (st == LT_OK)
        st = open_one(arena, folder, "metrics.csv", "", step, &out->metrics);
    if (st == LT_OK)
        st = open_events(arena, folder, step, &out->events);
    if (st)
        train_log_close(out);
    return st;
}

void train_log_close(train_log *l)
{
    if (l->log)
        fclose(l->log);
    if (l->metrics)
        fclose(l->metrics);
    if (l->events)
        fclose(l->events);
    l->log = l->metrics = l->events = NULL;
}

/* ---- writing ------------------------------------------------------------------------------------------ */

static void number(FILE *f, const char *key, double x)
{
    char text[LT_JSON_NUMBER];

    fprintf(f, ",\"%s\":%s", key, lt_json_number(x, text));
}

static void parts(FILE *f, const char *const *name, const double *value, int n)
{
    char text[LT_JSON_NUMBER];

    fprintf(f, ",\"parts\":{");
    for (int i = 0; i < n; i++)
        fprintf(f, "%s\"%s\":%s", i ? "," : "", name[i], lt_json_number(value[i], text));
    fprintf(f, "}");
}

/* ---- the same for TensorBoard --------------------------------------------------------------------------- */

enum { MAX_TAG = 80, MAX_SCALARS = MODEL_PORTS + TRAIN_METRICS + TRAIN_COUNTS + 8 };

/* Numbers of one step, under tags "group/name" */
typedef struct {
    const char *group;
    lt_event_scalar list[MAX_SCALARS];
    char tag[MAX_SCALARS][MAX_TAG];
    int n;
} curves;

static void curve(curves *c, const char *name, double value)
{
    snprintf(c->tag[c->n], MAX_TAG, "%s/%s", c->group, name);
    c->list[c->n] = (lt_event_scalar){ c->tag[c->n], value };
    c->n++;
}

static void step_curves(FILE *f, const train_step_record *r)
{
    curves c = { .group = "train" };

    curve(&c, "loss", r->loss);
    for (int i = 0; i < r->n_parts; i++)
        curve(&c, r->part_name[i], r->part[i]);
    curve(&c, "lr", r->lr);
    curve(&c, "grad_norm", r->grad_norm);
    curve(&c, "img_per_s", r->img_per_s);
    for (int i = 0; i < r->n_counts; i++)
        curve(&c, r->count[i].name, (double)r->count[i].n);
    lt_events_scalars(f, r->step, c.list, c.n);
}

static void validation_curves(FILE *f, const train_validation *v)
{
    curves c = { .group = "validation" };

    for (int i = 0; i < v->n_metrics; i++)
        curve(&c, v->metric[i]->key, v->value[i]);
    curve(&c, "loss", v->loss);
    for (int i = 0; i < v->n_parts; i++)
        curve(&c, v->part_name[i], v->part[i]);
    lt_events_scalars(f, v->step, c.list, c.n);
}

/* ---- a step, a validation --------------------------------------------------------------------------------- */

void train_log_step(train_log *l, const train_step_record *r)
{
    fprintf(l->log, "{\"step\":%" PRId64 ",\"epoch\":%" PRId64, r->step, r->epoch);
    number(l->log, "loss", r->loss);
    parts(l->log, r->part_name, r->part, r->n_parts);
    number(l->log, "lr", r->lr);
    number(l->log, "grad_norm", r->grad_norm);
    number(l->log, "img_per_s", r->img_per_s);
    number(l->log, "seconds", r->seconds);
    number(l->log, "ms", r->ms);
    if (r->phase)
        fprintf(l->log, ",\"phase\":\"%s\"", r->phase);
    for (int i = 0; i < r->n_counts; i++)
        fprintf(l->log, ",\"%s\":%" PRId64, r->count[i].name, r->count[i].n);
    if (r->bad) {
        fprintf(l->log, ",\"skipped\":");
        lt_json_print_string(l->log, r->bad);
    }
    fprintf(l->log, "}\n");
    fflush(l->log);
    step_curves(l->events, r);
}

static void csv_heading(FILE *f, const train_validation *v)
{
    fprintf(f, "step,epoch,samples");
    for (int i = 0; i < v->n_metrics; i++)
        fprintf(f, ",%s", v->metric[i]->key);
    fprintf(f, ",loss");
    for (int i = 0; i < v->n_parts; i++)
        fprintf(f, ",%s", v->part_name[i]);
    fprintf(f, "\n");
}

/* An empty field stands for what was not measured. */
static void csv_number(FILE *f, double x)
{
    char text[LT_JSON_NUMBER];

    fprintf(f, ",%s", isfinite(x) ? lt_json_number(x, text) : "");
}

static void csv_line(FILE *f, const train_validation *v)
{
    fprintf(f, "%" PRId64 ",%" PRId64 ",%" PRId64, v->step, v->epoch, v->samples);
    for (int i = 0; i < v->n_metrics; i++)
        csv_number(f, v->value[i]);
    csv_number(f, v->loss);
    for (int i = 0; i < v->n_parts; i++)
        csv_number(f, v->part[i]);
    fprintf(f, "\n");
}

void train_log_validation(train_log *l, const train_validation *v)
{
    fprintf(l->log, "{\"step\":%" PRId64 ",\"epoch\":%" PRId64 ",\"samples\":%" PRId64, v->step, v->epoch,
            v->samples);
    for (int i = 0; i < v->n_metrics; i++)
        number(l->log, v->metric[i]->key, v->value[i]);
    number(l->log, "validation_loss", v->loss);
    parts(l->log, v->part_name, v->part, v->n_parts);
    fprintf(l->log, "}\n");
    fflush(l->log);
    if (fseek(l->metrics, 0, SEEK_END) == 0 && ftell(l->metrics) == 0)
        csv_heading(l->metrics, v);
    csv_line(l->metrics, v);
    fflush(l->metrics);
    validation_curves(l->events, v);
}

lt_status train_log_flush(train_log *l)
{
    FILE *const files[] = { l->log, l->metrics, l->events };
    static const char *const names[] = { "log.jsonl", "metrics.csv", "tb" };

    for (size_t i = 0; i < LT_COUNT(files); i++)
        if (fflush(files[i]) || ferror(files[i]))
            return lt_error(lt_errno_status(errno), "%s: %s", names[i], strerror(errno));
    return LT_OK;
}

/* ---- spikes ------------------------------------------------------------------------------------------- */

double train_log_spike(train_log *l, double norm)
{
    enum { WINDOW = LT_COUNT(l->norm), WARM = 10 };
    const int n = l->n_norms < WINDOW ? l->n_norms : WINDOW;
    double sorted[WINDOW], ratio = 0;

    if (n >= WARM) {
        memcpy(sorted, l->norm, (size_t)n * sizeof(*sorted));
        qsort(sorted, (size_t)n, sizeof(*sorted), lt_ascending);
        ratio = norm / sorted[n / 2];
    }
    l->norm[l->n_norms++ % WINDOW] = norm;
    return ratio > 100 ? ratio : 0;
}
