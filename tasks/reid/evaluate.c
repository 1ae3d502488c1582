/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/reid/evaluate.h"

#include "estimate/checkpoint/checkpoint.h"
#include "eval/scorers/mot.h"
#include "eval/tables/scores_file.h"
#include "libtensor/io/file.h"
#include "tasks/reid/config.h"
#include "tasks/reid/follow.h"

#include <cjson/cJSON.h>

static const track_method methods[] = { TRACK_DEEPSORT, TRACK_BYTE, TRACK_IOU };

enum { METHODS = sizeof(methods) / sizeof(*methods) };

typedef struct {
    const task_evaluation *e;
    embedder *embedder;
    mot_set set;
    int64_t done, total;            /* frames */
    track_score_table table;
} evaluating;

static bool seen(void *ctx)
{
    evaluating *v = ctx;

    v->done++;
    return !v->e->progress || v->e->progress(v->e->ctx, v->done, v->total);
}

static lt_status write_results(lt_arena *arena, const char *folder, const char *name, const mot_sequence *s,
                               const mot_frame *results)
{
    const char *data = lt_arena_printf(arena, "%s/tracks/%s/data", folder, name);
    const char *path = data ? lt_arena_printf(arena, "%s/%s.txt", data, s->name) : NULL;
    lt_status st = path ? lt_make_dirs(data) : lt_error(LT_ENOMEM, "%s: no memory to write results", s->name);

    return st ? st : mot_write(path, results, s->frames);
}

static lt_status score_sequence(evaluating *v, const mot_sequence *s)
{
    lt_arena *arena = lt_arena_new();
    tracker_options options[METHODS];
    mot_frame *truth, *results[METHODS];
    lt_status st = !arena ? lt_error(LT_ENOMEM, "%s: no memory to score it", s->name)
                   : !s->truth ? lt_error(LT_EIO, "%s: has no gt/gt.txt to score with", s->folder)
                   : mot_read(arena, s->truth, MOT_TRUTH, s->frames, &truth);

    for (int i = 0; i < METHODS; i++)
        options[i] = reid_tracker(v->e->config, methods[i], s->fps);
    if (!st)
        st = follow(arena, s, v->embedder, options, METHODS, seen, v, results);
    for (int i = 0; !st && i < METHODS; i++) {
        track_counts counts;

        st = write_results(arena, v->e->folder, track_method_names[methods[i]], s, results[i]);
        if (!st)
            st = mot_count(s->name, &v->set.looks, truth, results[i], s->frames, &counts);
        if (!st)
            track_counts_add(&v->table.row[i].counts, &counts);
    }
    lt_arena_free(arena);
    return st;
}

static lt_status score_split(evaluating *v)
{
    lt_status st = mot_open(v->e->arena, v->e->config->data->dir, v->e->split, &v->set);
    int n;

    if (st)
        return st;
    n = v->e->limit ? (int)lt_min_i64(v->e->limit, v->set.n) : v->set.n;
    v->table = (track_score_table){ .n = METHODS, .sequences = n, .synthetic = v->set.synthetic };
    for (int i = 0; i < METHODS; i++)
        v->table.row[i].name = track_method_names[methods[i]];
    for (int k = 0; k < n; k++)
        v->total += v->set.sequence[k].frames;
    for (int k = 0; !st && k < n; k++)
        st = score_sequence(v, &v->set.sequence[k]);
    return st;
}

static lt_status open_model(const task_evaluation *e, lt_params *set, model *m, embedder **out)
{
    lt_status st = set ? train_config_model(e->config, NULL, set, m) : lt_error(LT_ENOMEM, "no memory for the model");

    if (!st)
        st = checkpoint_load_model(e->checkpoint, m);
    return st ? st : embedder_new(m, out);
}

lt_status reid_evaluate_run(const task_evaluation *e, cJSON **scores)
{
    evaluating v = { .e = e };
    lt_params *set = lt_params_new();
    model m;
    lt_status st = open_model(e, set, &m, &v.embedder);

    if (!st)
        st = score_split(&v);
    embedder_free(v.embedder);
    lt_params_free(set);
    if (!st)
        st = track_score_page(&v.table, e->folder);
    if (!st)
        st = scores_file_write(e->folder, track_score_json(&v.table));
    if (st)
        return st;
    if (e->tables)
        track_score_print(&v.table, e->tables);
    *scores = track_score_json(&v.table);
    return *scores ? LT_OK : lt_error(LT_ENOMEM, "no memory for the scores");
}
