/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/detect/evaluate.h"

#include "estimate/checkpoint/checkpoint.h"
#include "estimate/detection/found.h"
#include "eval/tables/scores_file.h"
#include "libtensor/io/file.h"
#include "tasks/detect/batch.h"
#include "tasks/detect/breakdown.h"
#include "tasks/detect/results.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

typedef struct {
    const detect_evaluation *e;
    const detection_set *set;
    records records;
    int64_t total, done;
} scoring;

static int64_t total_of(const detect_evaluation *e, const detection_set *set)
{
    return e->limit ? lt_min_i64(e->limit, set->count) : set->count;
}

static lt_status report(scoring *s)
{
    s->done++;
    return !s->e->progress || s->e->progress(NULL, s->done, s->total) ? LT_OK : lt_error(LT_ESTOPPED, "stopped");
}

/* ---- a model ---- */

static lt_status record(const void *ctx, model_record *r)
{
    const model *m = ctx;

    m->cls->record(m, false, r);
    return LT_OK;
}

static double feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch, int first, int part,
                   int n)
{
    (void)ctx;
    return detect_batch_feed(p, r, batch, first, part, n);
}

static lt_status visit(void *ctx, const compiled *c, const void *batch)
{
    scoring *s = ctx;
    const detect_batch *b = batch;
    lt_arena *scratch = lt_arena_new();
    lt_status st = scratch ? LT_OK : lt_error(LT_ENOMEM, "no memory to score");

    for (int i = 0; i < b->count && st == LT_OK; i++) {
        detect_found *found;
        int n;

        if (!b->there[i])
            continue;
        lt_arena_reset(scratch);
        st = detect_found_in(c, s->e->m, i, b->width[i], b->height[i], &detection_rules_scored, scratch, &found, &n);
        if (st == LT_OK)
            st = detect_record(s->set, b->index[i], b->width[i], b->height[i], found, n, &s->records);
        if (st == LT_OK)
            st = report(s);
    }
    lt_arena_free(scratch);
    return st;
}

static void say_skipped(void *ctx, int i, const char *line)
{
    (void)ctx, (void)i;
    fprintf(stderr, "left out: %s\n", line);
}

static lt_status score_model(scoring *s)
{
    const detect_evaluation *e = s->e;
    const csp_seg_config *config = csp_seg_config_of(e->m);
    const detect_feed samples = { .set = s->set, .size = config->image_size, .count = s->total };
    const loader_source source = detect_source(&samples);
    const recipe by = { .ctx = e->m, .record = record, .feed = feed };
    compiled c;
    lt_status st;

    if (config->classes != s->set->classes)
        return lt_error(LT_EINVAL, "%s: has %d classes, the model finds %d", s->set->list, s->set->classes,
                        config->classes);
    st = compiled_new(&by, e->batch, false, &c);
    if (st)
        return st;
    st = compiled_walk(&c, &source, e->threads, 0.05, visit, say_skipped, s, NULL);
    compiled_free(&c);
    return st;
}

/* ---- a file ---- */

/* Where the set does not say how large a picture is, the picture does. */
static lt_status size_of(const detection_set *set, int64_t i, int *width, int *height)
{
    lt_arena *arena = set->image[i].width ? NULL : lt_arena_new();
    detection_sample sample;
    lt_status st = LT_OK;

    *width = set->image[i].width;
    *height = set->image[i].height;
    if (*width)
        return LT_OK;
    st = arena ? detection_read(set, i, arena, &sample) : lt_error(LT_ENOMEM, "no memory to score");
    if (st == LT_OK) {
        *width = sample.rgb.width;
        *height = sample.rgb.height;
    }
    lt_arena_free(arena);
    return st;
}

static lt_status score_file(scoring *s, lt_arena *arena)
{
    detect_result *result;
    lt_status st = detect_results_read(arena, s->e->pred, s->set, &result);

    for (int64_t i = 0; i < s->total && st == LT_OK; i++) {
        int width, height;

        st = size_of(s->set, i, &width, &height);
        if (st == LT_OK)
            st = detect_record(s->set, i, width, height, result[i].found, (int)result[i].n, &s->records);
        if (st == LT_OK)
            st = report(s);
    }
    return st;
}

/* ---- both ---- */

lt_status detect_evaluate(const detect_evaluation *e, detect_scores *out)
{
    lt_arena *arena = lt_arena_new();
    scoring s = { .e = e };
    detection_set *set = NULL;
    lt_status st = arena ? detection_open(arena, e->data, e->split, &set) : lt_error(LT_ENOMEM, "no memory to score");

    if (st == LT_OK) {
        s.set = set;
        s.total = total_of(e, set);
        st = e->m ? score_model(&s) : score_file(&s, arena);
    }
    if (st == LT_OK) {
        records_sort(&s.records);
        *out = (detect_scores){ .images = s.records.n, .synthetic = set->synthetic, .title = set->title };
        st = detect_measure(set, &s.records, out->value);
    }
    if (st == LT_OK && e->folder)
        st = lt_make_dirs(e->folder);
    if (st == LT_OK && e->folder)
        st = scores_file_write(e->folder, detect_scores_json(out));
    if (st == LT_OK && e->folder)
        st = detect_breakdown_write(set, &s.records, out->value, e->folder);
    records_free(&s.records);
    lt_arena_free(arena);
    return st;
}

struct cJSON *detect_scores_json(const detect_scores *s)
{
    cJSON *root = cJSON_CreateObject();

    for (int k = 0; root && k < DETECT_METRICS; k++)
        if (isnan(s->value[k]))
            cJSON_AddNullToObject(root, detect_metrics[k]);
        else
            cJSON_AddNumberToObject(root, detect_metrics[k], s->value[k]);
    cJSON_AddNumberToObject(root, "images", (double)s->images);
    cJSON_AddStringToObject(root, "data", s->title);
    cJSON_AddBoolToObject(root, "synthetic", s->synthetic);
    return root;
}

void detect_scores_print(const detect_scores *s, FILE *f)
{
    fprintf(f, "%s%s, %lld images\n", s->synthetic ? "SYNTHETIC, " : "", s->title, (long long)s->images);
    for (int k = 0; k < DETECT_METRICS; k++)
        fprintf(f, "%-14s %.4f\n", detect_metrics[k], s->value[k]);
}

/* ---- a run -------------------------------------------------------------------------------------------------- */

enum { AT_A_TIME = 8 };

static lt_status score_run(const task_evaluation *e, lt_params *set, detect_scores *out)
{
    model m;
    const detect_evaluation d = {
        .data = e->config->data->dir, .split = e->split, .m = &m, .folder = e->folder, .batch = AT_A_TIME,
        .threads = e->config->data->threads, .limit = (int)e->limit, .progress = e->progress,
    };
    lt_status st = train_config_model(e->config, NULL, set, &m);

    if (st == LT_OK)
        st = checkpoint_load_model(e->checkpoint, &m);
    return st ? st : detect_evaluate(&d, out);
}

lt_status detect_evaluate_run(const task_evaluation *e, cJSON **scores)
{
    lt_params *set = lt_params_new();
    detect_scores s;
    lt_status st = set ? score_run(e, set, &s) : lt_error(LT_ENOMEM, "no memory for the model");

    lt_params_free(set);
    if (st)
        return st;
    if (e->tables)
        detect_scores_print(&s, e->tables);
    *scores = detect_scores_json(&s);
    return *scores ? LT_OK : lt_error(LT_ENOMEM, "no memory for the scores");
}
