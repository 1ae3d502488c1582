/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/body/evaluate.h"

#include "estimate/checkpoint/checkpoint.h"
#include "eval/tables/scores_file.h"
#include "libtensor/io/file.h"
#include "tasks/body/batch.h"
#include "tasks/body/mean_pose.h"
#include "tasks/body/sheet.h"
#include "tasks/body/truth.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

enum { BATCH = 8 };

typedef struct {
    const task_evaluation *e;
    body_graph graph;
    model m;
    run_body body;
    body_set set;
    body_feed feed;
    mean_pose *mean;
    body_scores scores;
    body_sheet sheet;
    double (*vertices)[3], (*true_vertices)[3];
} evaluating;

/* ---- a sample ---- */

static void add(const body_errors *e, body_errors *sum)
{
    for (int k = 0; k < BODY_METRICS; k++)
        sum->mm[k] += e->mm[k];
}

/* Every so many samples become pictures. */
static bool is_shown(const evaluating *v)
{
    const int64_t every = lt_max_i64(1, v->feed.count / SHEET_MOST);

    return v->scores.images % every == 0;
}

static lt_status show(evaluating *v, const compiled *c, const body_batch *b, int i, double error_mm)
{
    const body_row *row = &v->set.row[b->index[i]];
    float nodes[BODY_NODES][2];

    body_graph_project(c, i, nodes);
    return body_sheet_add(&v->sheet, b->image + (size_t)i * BODY_PICTURE_FLOATS, row->nodes_2d,
                          (const float (*)[2])nodes, v->set.name[b->index[i]], error_mm);
}

static lt_status score(evaluating *v, const compiled *c, const body_batch *b, int i)
{
    const lt_real *x = compiled_output(c, "vertices") + (size_t)i * BODY_VERTICES * 3;
    double nodes[BODY_NODES][3], true_nodes[BODY_NODES][3];
    body_errors mine, mean;
    lt_status st = LT_OK;

    body_graph_nodes(c, i, nodes);
    for (int k = 0; k < BODY_VERTICES * 3; k++)
        v->vertices[0][k] = x[k];
    body_truth(v->body.model, &v->set.row[b->index[i]], v->true_vertices, true_nodes);
    body_errors_of(nodes, true_nodes, v->vertices, v->true_vertices, &mine);
    body_errors_of(v->mean->nodes, true_nodes, v->mean->vertices, v->true_vertices, &mean);
    if (is_shown(v))
        st = show(v, c, b, i, mine.mm[BODY_MPJPE]);
    add(&mine, &v->scores.model);
    add(&mean, &v->scores.mean_pose);
    v->scores.images++;
    return st;
}

static lt_status visit(void *ctx, const compiled *c, const void *batch)
{
    evaluating *v = ctx;
    const body_batch *b = batch;
    lt_status st = LT_OK;

    for (int i = 0; !st && i < b->count; i++)
        if (b->weight[i] > 0)
            st = score(v, c, b, i);
    if (!st && v->e->progress && !v->e->progress(v->e->ctx, v->scores.images, v->feed.count))
        st = lt_error(LT_ESTOPPED, "stopped");
    return st;
}

static void say_skipped(void *ctx, int i, const char *line)
{
    (void)ctx, (void)i;
    fprintf(stderr, "left out: %s\n", line);
}

static lt_status score_all(evaluating *v)
{
    const train_data_config *d = v->e->config->data;
    const loader_source source = body_source(&v->feed);
    const recipe by = body_batch_recipe(&v->graph, false);
    compiled c;
    lt_status st = compiled_new(&by, BATCH, false, &c);

    if (st)
        return st;
    st = compiled_walk(&c, &source, d->threads, d->tolerate, visit, say_skipped, v, NULL);
    compiled_free(&c);
    for (int k = 0; k < BODY_METRICS; k++) {
        v->scores.model.mm[k] /= (double)v->scores.images;
        v->scores.mean_pose.mm[k] /= (double)v->scores.images;
    }
    return st;
}

/* ---- the whole ---- */

static lt_status open_data(evaluating *v)
{
    const char *dir = v->e->config->data->dir;
    lt_arena *arena = v->e->arena;
    lt_skin_layer *layer;
    body_set train;
    lt_status st = run_body_open(arena, body_data_of(v->e->config)->body, &v->body);

    if (!st)
        st = run_body_layer(arena, v->body.model, &layer);
    if (!st)
        st = body_set_open(arena, dir, v->e->split, &v->set);
    if (!st)
        st = body_truth_check(&v->body, &v->set);
    if (!st)
        st = body_set_open(arena, dir, "train", &train);
    if (!st)
        st = mean_pose_of(arena, v->body.model, &train, &v->mean);
    if (st)
        return st;
    v->vertices = lt_arena_array(arena, BODY_VERTICES, sizeof(*v->vertices));
    v->true_vertices = lt_arena_array(arena, BODY_VERTICES, sizeof(*v->true_vertices));
    v->graph = (body_graph){ .model = &v->m, .layer = layer };
    v->feed = (body_feed){ .set = &v->set, .count = v->e->limit ? lt_min_i64(v->e->limit, v->set.n) : v->set.n };
    v->scores.subjects = v->set.subjects;
    v->scores.synthetic = v->set.synthetic;
    v->sheet.arena = arena;
    return v->vertices && v->true_vertices ? LT_OK : lt_error(LT_ENOMEM, "no memory to score");
}

/* A model that is no better than a pose that sees no picture has learnt nothing that the mean does not say. */
static void compare_with_mean(const body_scores *s)
{
    if (!(s->model.mm[BODY_MPJPE] < s->mean_pose.mm[BODY_MPJPE]))
        fprintf(stderr, "the model is no better than the mean pose of training: joints %.1f mm, the mean pose's %.1f; "
                "train for longer, or on more\n", s->model.mm[BODY_MPJPE], s->mean_pose.mm[BODY_MPJPE]);
}

static lt_status write_files(evaluating *v)
{
    const char *pictures = lt_path_join(v->e->arena, v->e->folder, "pictures.png");
    lt_status st = pictures ? scores_file_write(v->e->folder, body_scores_json(&v->scores))
                            : lt_error(LT_ENOMEM, "no memory for the scores");

    return st ? st : body_sheet_write(&v->sheet, pictures);
}

lt_status body_evaluate_run(const task_evaluation *e, cJSON **scores)
{
    evaluating v = { .e = e };
    lt_params *set = lt_params_new();
    lt_status st = set ? train_config_model(e->config, NULL, set, &v.m)
                       : lt_error(LT_ENOMEM, "no memory for the model");

    if (!st)
        st = checkpoint_load_model(e->checkpoint, &v.m);
    if (!st)
        st = open_data(&v);
    if (!st)
        st = score_all(&v);
    lt_params_free(set);
    if (!st && !v.scores.images)
        st = lt_error(LT_EFORMAT, "%s: no picture of %s can be read", v.set.root, e->split);
    if (!st)
        st = write_files(&v);
    if (st)
        return st;
    if (e->tables)
        body_scores_print(&v.scores, e->tables);
    compare_with_mean(&v.scores);
    *scores = body_scores_json(&v.scores);
    return *scores ? LT_OK : lt_error(LT_ENOMEM, "no memory for the scores");
}
