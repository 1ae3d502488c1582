/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reporting: the tables, JSON and files of an evaluation.
 */
#include "tasks/hand_object/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/csv.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

static void set_objects(const evaluation *e, const eval_table *t, const score_set *set, eval_row *row)
{
    for (int k = 0; k < e->n_by_object; k++)
        if (e->by_object[k] == t)
            eval_row_objects(t, &set->shares[k], row);
}

static bool about_dexycb(const eval_table *t)
{
    return strncmp(t->data, "DexYCB", 6) == 0;
}

static bool about_hands(const eval_table *t)
{
    return !eval_table_by_object(t) && (!about_dexycb(t) || eval_find_key(t, "mpjpe_mm") != EVAL_NO_ROW);
}

/* The paper's row that a variant reproduces; none for predictors that see nothing. */
static int against(const evaluation *e, const eval_table *t, int row)
{
    return row == EVALUATE_MODEL ? eval_table_own_row(t, e->o.m->variant) : EVAL_NO_ROW;
}

/* The note column of the model's row: what it sees, or what the paper says of the row that it reproduces. */
static const char *note_of(const evaluation *e, const eval_table *t)
{
    if (t->note && strcmp(t->note, "input") == 0)
        return model_takes_depth(e->o.m) ? "RGB-D" : "RGB";
    return t->row[against(e, t, EVALUATE_MODEL)].note;
}

/* PA-MPJPE as DexYCB's toolkit has it, which is HO3D's but for the last bits: the order of the joints is another. */
static void by_toolkit(evaluate_summary *s, const score_set *set)
{
    double scores[DEXYCB_SCORES];

    dexycb_scorer_scores(set->dexycb, scores);
    for (int i = 0; i < s->n; i++)
        if (strcmp(s->score[i].key, "pa_mpjpe_mm") == 0)
            s->score[i].value = scores[DEXYCB_PA_MEAN];
}

/* A predictor's row of a table; what the table does not ask for is left out. */
static eval_row row_of(const evaluation *e, const eval_table *t, int which)
{
    const score_set *set = &e->set[which];
    evaluate_summary s = evaluation_summary(e, which);
    eval_row row = { .label = set->label, .cite = "", .note = "" };

    if (about_dexycb(t))
        by_toolkit(&s, set);
    set_objects(e, t, set, &row);
    eval_row_fill(t, &row, s.score, s.n);
    if (which == EVALUATE_MODEL)
        row.note = note_of(e, t);
    return row;
}

/* A real dataset's numbers appear only under tables about that dataset. */
static bool belongs(const evaluation *e, const eval_table *t)
{
    return e->o.data->synthetic || strncmp(e->o.data->title, t->data, 4) == 0;
}

static int results_of(const evaluation *e, const eval_table *t, eval_result out[EVALUATE_ROWS])
{
    int n = 0;

    for (int i = 0; belongs(e, t) && i < EVALUATE_ROWS; i++)
        if (e->set[i].label)
            out[n++] = (eval_result){ row_of(e, t, i), against(e, t, i) };
    return n;
}

/* What a model is handed besides pixels. */
static const char *given(const evaluation *e)
{
    static const char *const boxes[] = {
        "hand box, object box, wrist position, object class",
        "hand box, object box, wrist position, object class and surface, which is laid on the depth",
    };
    static const char *const crop[] = {
        "crop around hand and object, middle depth of the object, wrist position, object class",
        "crop around hand and object, middle depth of the object, wrist position, object class and surface, which is "
        "laid on the depth",
    };
    const model *m = e->o.m;

    if (protocol_of(m)->crop != HAND_OBJECT_UNION)
        return boxes[m->depth_fit];
    return m->depth ? crop[m->depth_fit] : "crop around hand and object, wrist position, object class";
}

static eval_protocol table_protocol(const evaluation *e, const eval_table *t)
{
    eval_protocol p = {
        .dataset = e->o.data->title, .synthetic = e->o.data->synthetic, .split = e->o.data->split,
        .whole = e->samples == e->o.data->count, .samples = e->samples,
        .failed = ho3d_scorer_failed(e->set[EVALUATE_MODEL].ho3d), .given = given(e),
    };

    if (eval_table_by_object(t)) {
        p.threshold = "ADD <= 0.1 diameter";
        p.diameter = eval_diameter_name(EVAL_BBOX_DIAG);
        p.symmetry = eval_symmetry_name(t->hfl_symmetry ? EVAL_SYM_HFL : EVAL_SYM_NONE);
        p.alignment = "none";
    } else if (about_hands(t) && about_dexycb(t)) {
        p.alignment = eval_find_key(t, "rigid_pa_mpjpe_mm") != EVAL_NO_ROW
            ? "MPJPE: wrist on wrist; PAMPJPE: similarity per sample, no reflections"
            : "MPJPE: wrist on wrist; PA-MPJPE: similarity per sample, reflections allowed";
    } else if (about_hands(t)) {
        p.alignment = "similarity per sample, reflections allowed; joints and vertices each on their own";
    } else {
        p.alignment = "none";
    }
    if (eval_find_key(t, "adds_auc") != EVAL_NO_ROW) {
        p.threshold = "ADD-S up to 0.1 m, and below 0.02 m";
        p.symmetry = "ADD-S for every class, true to nearest estimated";
    }
    return p;
}

lt_status evaluation_print(const evaluation *e, FILE *f, eval_format format)
{
    lt_status st = LT_OK;
    const eval_table *t;

    for (int i = 0; st == LT_OK && (t = eval_table_at(i)); i++) {
        const eval_protocol p = table_protocol(e, t);
        eval_result ours[EVALUATE_ROWS];
        int n;

        if (!eval_table_of(t, e->o.m->cls->name))
            continue;
        n = results_of(e, t, ours);
        st = eval_table_print(f, format, t, ours, n, n ? &p : NULL);
        fputc('\n', f);
    }
    return st;
}

static cJSON *summary_json(const evaluate_summary *s)
{
    cJSON *o = cJSON_CreateObject();

    cJSON_AddStringToObject(o, "predictor", s->label);
    for (int i = 0; i < s->n; i++)
        cJSON_AddNumberToObject(o, s->score[i].key, s->score[i].value);
    return o;
}

cJSON *evaluation_json(const evaluation *e)
{
    cJSON *root = cJSON_CreateObject(), *rows, *tables;
    const eval_table *t;
    char hash[16];

    cJSON_AddStringToObject(root, "model", e->o.m->cls->name);
    cJSON_AddStringToObject(root, "variant", e->o.m->variant);
    cJSON_AddStringToObject(root, "checkpoint", e->o.checkpoint);
    cJSON_AddNumberToObject(root, "step", (double)e->o.step);
    cJSON_AddStringToObject(root, "dataset", e->o.data->title);
    cJSON_AddStringToObject(root, "data", e->o.data->root);
    dataset_crc32(e->arena, e->o.data->root, hash);
    cJSON_AddStringToObject(root, "data_crc32", hash);
    cJSON_AddBoolToObject(root, "synthetic", e->o.data->synthetic);
    cJSON_AddStringToObject(root, "split", e->o.data->split);
    cJSON_AddNumberToObject(root, "samples", (double)e->samples);
    cJSON_AddNumberToObject(root, "split_samples", (double)e->o.data->count);
    cJSON_AddStringToObject(root, "hand", e->o.hand_name);
    rows = cJSON_AddArrayToObject(root, "rows");
    for (int i = 0; i < EVALUATE_ROWS; i++) {
        const evaluate_summary s = evaluation_summary(e, i);

        if (s.label)
            cJSON_AddItemToArray(rows, summary_json(&s));
    }
    tables = cJSON_AddArrayToObject(root, "tables");
    for (int i = 0; (t = eval_table_at(i)); i++) {
        const eval_protocol p = table_protocol(e, t);
        eval_result ours[EVALUATE_ROWS];
        int n;

        if (!eval_table_of(t, e->o.m->cls->name))
            continue;
        n = results_of(e, t, ours);
        cJSON_AddItemToArray(tables, eval_table_json(t, ours, n, n ? &p : NULL));
    }
    return root;
}

static lt_status write_per_sample(const evaluation *e, const char *path)
{
    static const char *const column[] = {
        "pa_mpjpe_mm", "pa_mpvpe_mm", "mpjpe_mm", "add_mm", "object_rotation_deg",
    };
    lt_csv w;
    lt_status st = lt_csv_open(&w, path, "sample", LT_COUNT(column), column);

    for (int64_t i = 0; st == LT_OK && i < e->samples; i++)
        lt_csv_add(&w, e->names[i], e->per_sample[i]);
    return st ? st : lt_csv_commit(&w);
}

static lt_status write_tables(const evaluation *e, const char *path)
{
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    st = evaluation_print(e, f.stream, EVAL_MARKDOWN);
    if (st == LT_OK)
        return lt_atomic_commit(&f);
    lt_atomic_abort(&f);
    return st;
}

static lt_status write_scores(const evaluation *e, const char *json, const char *text)
{
    cJSON *root = evaluation_json(e);
    double scores[HO3D_SCORES];
    lt_status st = root ? lt_json_write(json, root) : lt_error(LT_ENOMEM, "no memory for %s", json);

    cJSON_Delete(root);
    ho3d_scorer_scores(e->set[EVALUATE_MODEL].ho3d, scores);
    return st ? st : ho3d_write_scores(text, scores);
}

lt_status evaluation_write(const evaluation *e, const char *folder)
{
    static const char *const name[] = { "table.md", "scores.json", "scores.txt", "per-sample.csv" };
    const char *path[LT_COUNT(name)];
    lt_status st = lt_make_dirs(folder);

    for (size_t i = 0; i < LT_COUNT(name); i++) {
        path[i] = lt_arena_printf(e->arena, "%s/%s", folder, name[i]);
        if (!path[i])
            return lt_error(LT_ENOMEM, "no memory to write %s", folder);
    }
    if (st == LT_OK)
        st = write_tables(e, path[0]);
    if (st == LT_OK)
        st = write_scores(e, path[1], path[2]);
    if (st == LT_OK)
        st = write_per_sample(e, path[3]);
    return st ? st : eval_breakdown_write(e->breakdown, folder);
}
