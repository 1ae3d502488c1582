/* SPDX-License-Identifier: Apache-2.0 */
/* The JSON, tables and files of an evaluation. */
#include "tasks/hogs/results/evaluate.h"

#include "eval/tables/rows.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/write.h"
#include "libtensor/io/text/csv.h"
#include "libtensor/io/text/json.h"
#include "tasks/hogs/results/surfaces.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

static const struct { const char *name, *label; } rows[HOGS_ROWS] = {
    [HOGS_ROW_MODEL] = { "model", "ours" }, [HOGS_ROW_INITIAL] = { "initial", "initial poses" },
    [HOGS_ROW_MEAN] = { "mean", "mean offset" }, [HOGS_ROW_SWAP] = { "swap", "another frame's image" },
    [HOGS_ROW_NO_ROTATION] = { "no_rotation", "no rotation" }, [HOGS_ROW_MINIMUM] = { "minimum", "minimum rule" },
};

const char *hogs_row_name(hogs_row row)
{
    return rows[row].name;
}

const char *hogs_row_label(hogs_row row)
{
    return rows[row].label;
}

/* "full", or with jittered colours "full-cj" */
static const char *variant_of(const hogs_evaluation *e)
{
    return lt_arena_printf(e->arena, "%s%s", e->run.m->variant, hogs_data_of(e->run.config)->jitter ? "-cj" : "");
}

/* ---- JSON ------------------------------------------------------------------------------------------------ */

static void add_scores(cJSON *o, const hogs_means *m)
{
    for (int i = 0; i < HOGS_SCORES; i++)
        if (m->n[i])
            cJSON_AddNumberToObject(o, hogs_score_keys[i], hogs_means_of(m, (hogs_score)i));
}

/* Whether the generator let light vary, by its manifest */
static void add_light(const hogs_evaluation *e, cJSON *root)
{
    const char *path = lt_path_join(e->arena, e->run.train->root, "manifest.json");
    const cJSON *light;
    cJSON *manifest;

    if (!e->run.train->synthetic || !path || lt_json_read(path, &manifest))
        return;
    light = cJSON_GetObjectItemCaseSensitive(manifest, "light");
    if (cJSON_IsString(light))
        cJSON_AddStringToObject(root, "light", light->valuestring);
    cJSON_Delete(manifest);
}

static void add_data(const hogs_evaluation *e, cJSON *root)
{
    const dataset *d = e->run.train;
    char hash[16];

    cJSON_AddStringToObject(root, "dataset", d->title);
    cJSON_AddStringToObject(root, "data", d->root);
    dataset_crc32(e->arena, d->root, hash);
    cJSON_AddStringToObject(root, "data_crc32", hash);
    cJSON_AddBoolToObject(root, "synthetic", d->synthetic);
    cJSON_AddStringToObject(root, "split", d->split);
    cJSON_AddNumberToObject(root, "samples", (double)e->samples);
    cJSON_AddNumberToObject(root, "split_samples", (double)d->count);
    cJSON_AddNumberToObject(root, "mesh_samples", e->meshes);
    cJSON_AddNumberToObject(root, "sequence_samples", e->held_frames);
    cJSON_AddStringToObject(root, "hand", e->run.hands.name);
    cJSON_AddStringToObject(root, "poses", initial_poses_how(e->run.train_poses));
    add_light(e, root);
}

static const char *points_of(const hogs *m)
{
    return m->is->random_points || !*m->config.point_backbone ? "random" : m->config.point_backbone;
}

static bool is_of_surfaces(const eval_table *t)
{
    return eval_find_key(t, "cd_o_cm2") != EVAL_NO_ROW;
}

static bool is_of_sequences(const eval_table *t)
{
    return eval_find_key(t, "cd_o_vertices_cm2") != EVAL_NO_ROW;
}

/* HOLD's */
static eval_protocol protocol_of_sequences(const hogs_evaluation *e)
{
    return (eval_protocol){
        .dataset = e->run.train->title, .synthetic = e->run.train->synthetic, .split = e->run.train->split,
        .whole = e->held_frames == e->run.train->count, .samples = e->held_frames,
        .alignment = "CD_o, F_o: similarity; CD_pose: none, from the wrist",
        .given = lt_arena_printf(e->arena, "masks, initial poses (%s); vertices of meshes, rule mean, iso %g; CD_o and "
                                 "F_o of the first frame of each of %d sequences, CD_pose of up to %d frames of each; "
                                 "means of sequences; %d surfaces missing", initial_poses_how(e->run.train_poses),
                                 POSED_ISO, e->sequences, e->o->meshes, e->no_surface),
    };
}

/* Surfaces are made of a few frames, for they take long. */
static eval_protocol protocol_of_surfaces(const hogs_evaluation *e)
{
    return (eval_protocol){
        .dataset = e->run.train->title, .synthetic = e->run.train->synthetic, .split = e->run.train->split,
        .whole = e->meshes == e->run.train->count, .samples = e->meshes,
        .alignment = "hand: none, from its wrist; object: similarity",
        .given = lt_arena_printf(e->arena, "masks, initial poses (%s); meshes of %d frames of each object, rule mean, "
                                 "iso %g (minimum rule: iso %g); %d surfaces missing; 30,000 samples",
                                 initial_poses_how(e->run.train_poses), e->o->meshes, POSED_ISO, HOGS_ISO_MIN,
                                 e->no_surface),
    };
}

static eval_protocol protocol_of(const hogs_evaluation *e, const eval_table *t)
{
    const hogs *m = hogs_of(e->run.m);

    if (is_of_surfaces(t))
        return protocol_of_surfaces(e);
    if (is_of_sequences(t))
        return protocol_of_sequences(e);
    return (eval_protocol){
        .dataset = e->run.train->title, .synthetic = e->run.train->synthetic, .split = e->run.train->split,
        .whole = e->samples == e->run.train->count, .samples = e->samples, .alignment = "none",
        .given = lt_arena_printf(e->arena, "masks, initial poses (%s); %s; ssim valid; point backbone: %s",
                                 initial_poses_how(e->run.train_poses), eval_lpips_name(e->judge), points_of(m)),
    };
}

static int results_of(const hogs_evaluation *e, const eval_table *t, eval_result out[HOGS_ROWS])
{
    static const bool of_surfaces[HOGS_ROWS] = { [HOGS_ROW_NO_ROTATION] = true, [HOGS_ROW_MINIMUM] = true };
    int n = 0;

    for (int row = 0; row < HOGS_ROWS; row++) {
        eval_score score[HOGS_SCORES];
        eval_result r = { .row = { .label = rows[row].label, .cite = "", .note = "" }, .against = EVAL_NO_ROW };
        int scores = 0;

        if (!e->has[row] || (of_surfaces[row] && eval_find_variant(t, rows[row].label) == EVAL_NO_ROW))
            continue;
        for (int i = 0; i < HOGS_SCORES; i++)
            if (e->means[row].n[i])
                score[scores++] = (eval_score){ .key = hogs_score_keys[i],
                                                .value = hogs_means_of(&e->means[row], (hogs_score)i) };
        if (row == HOGS_ROW_MODEL || of_surfaces[row])
            r.against = eval_find_variant(t, row == HOGS_ROW_MODEL ? variant_of(e) : rows[row].label);
        if (row == HOGS_ROW_MINIMUM && strcmp(variant_of(e), "no-vpm") != 0)
            r.against = EVAL_NO_ROW;                    /* GOF, adapted, is without V-PM */
        if (r.against != EVAL_NO_ROW)
            r.row.note = t->row[r.against].note;
        eval_row_fill(t, &r.row, score, scores);
        for (int c = 0; c < t->n_columns; c++)
            if (r.row.has[c]) {
                out[n++] = r;
                break;
            }
    }
    return n;
}

/* Surfaces where there are any, renderings and poses; ablations that this variant is no row of */
static bool is_filled(const hogs_evaluation *e, const eval_table *t)
{
    return eval_table_of(t, "hogs") && (e->meshes > 0 || !is_of_surfaces(t))
        && (e->held_frames > 0 || !is_of_sequences(t))
        && (!t->ablation || eval_find_variant(t, variant_of(e)) != EVAL_NO_ROW);
}

cJSON *hogs_evaluation_json(const hogs_evaluation *e)
{
    const hogs *m = hogs_of(e->run.m);
    cJSON *root = cJSON_CreateObject(), *all, *tables;
    const eval_table *t;

    cJSON_AddStringToObject(root, "model", e->run.m->cls->name);
    cJSON_AddStringToObject(root, "variant", variant_of(e));
    cJSON_AddStringToObject(root, "checkpoint", e->o->checkpoint);
    cJSON_AddNumberToObject(root, "step", (double)e->o->step);
    add_data(e, root);
    cJSON_AddStringToObject(root, "lpips", eval_lpips_name(e->judge));
    cJSON_AddStringToObject(root, "point_backbone", points_of(m));
    add_scores(cJSON_AddObjectToObject(root, "scores"), &e->means[HOGS_ROW_MODEL]);
    all = cJSON_AddObjectToObject(root, "rows");
    for (int row = 0; row < HOGS_ROWS; row++) {
        cJSON *o = e->has[row] ? cJSON_AddObjectToObject(all, rows[row].name) : NULL;

        cJSON_AddStringToObject(o, "predictor", rows[row].label);
        if (o)
            add_scores(o, &e->means[row]);
    }
    tables = cJSON_AddArrayToObject(root, "tables");
    for (int i = 0; (t = eval_table_at(i)); i++) {
        const eval_protocol p = protocol_of(e, t);
        eval_result ours[HOGS_ROWS];

        if (is_filled(e, t))
            cJSON_AddItemToArray(tables, eval_table_json(t, ours, results_of(e, t, ours), &p));
    }
    return root;
}

/* ---- tables ---------------------------------------------------------------------------------------------- */

lt_status hogs_evaluation_print(const hogs_evaluation *e, FILE *f, eval_format format)
{
    const eval_table *t;
    lt_status st = LT_OK;

    for (int i = 0; !st && (t = eval_table_at(i)); i++) {
        const eval_protocol p = protocol_of(e, t);
        eval_result ours[HOGS_ROWS];

        if (!is_filled(e, t))
            continue;
        st = eval_table_print(f, format, t, ours, results_of(e, t, ours), &p);
        fputc('\n', f);
    }
    return st;
}

/* ---- files ----------------------------------------------------------------------------------------------- */

static lt_status write_tables(const hogs_evaluation *e, const char *path)
{
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    st = hogs_evaluation_print(e, f.stream, EVAL_MARKDOWN);
    if (!st)
        return lt_atomic_commit(&f);
    lt_atomic_abort(&f);
    return st;
}

static lt_status write_per_sample(const hogs_evaluation *e, const char *path)
{
    lt_csv w;
    const lt_status st = lt_csv_open(&w, path, "sample", HOGS_SCORES, hogs_score_keys);

    for (int64_t i = 0; !st && i < e->samples; i++)
        lt_csv_add(&w, e->name[i], e->per_sample[i]);
    return st ? st : lt_csv_commit(&w);
}

lt_status hogs_evaluation_write(const hogs_evaluation *e, const cJSON *scores)
{
    static const char *const name[] = { "scores.json", "table.md", "per-sample.csv", "pictures.png" };
    const hogs *m = hogs_of(e->run.m);
    const char *path[LT_COUNT(name)];
    lt_status st = LT_OK;

    for (size_t i = 0; i < LT_COUNT(name); i++) {
        path[i] = lt_path_join(e->arena, e->o->folder, name[i]);
        if (!path[i])
            return lt_error(LT_ENOMEM, "no memory to write %s", e->o->folder);
    }
    st = lt_json_write(path[0], scores);
    if (!st)
        st = write_tables(e, path[1]);
    if (!st)
        st = write_per_sample(e, path[2]);
    if (!st && e->pictures)
        st = lt_png_write(path[3], &(lt_image){ HOGS_PANELS * m->config.width, e->pictures * m->config.height, 3, 8,
                                                e->picture });
    return st;
}
