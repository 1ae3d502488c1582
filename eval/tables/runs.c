/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/tables/runs.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const char *eval_text_of(const cJSON *o, const char *key)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(o, key));

    return text ? text : "";
}

double eval_number_of(const cJSON *o, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(o, key);

    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

bool eval_flag_of(const cJSON *o, const char *key)
{
    return cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(o, key));
}

const cJSON *eval_run_row(const eval_run *r, const char *predictor)
{
    const cJSON *rows = cJSON_GetObjectItemCaseSensitive(r->scores, "rows"), *row;

    if (!predictor)
        return cJSON_GetArrayItem(rows, 0);
    cJSON_ArrayForEach(row, rows)
        if (strcmp(eval_text_of(row, "predictor"), predictor) == 0)
            return row;
    return NULL;
}

bool eval_runs_alike(const eval_run *a, const eval_run *b)
{
    static const char *const keys[] = { "dataset", "data_crc32", "split", "hand" };
    bool alike = eval_number_of(a->scores, "samples") == eval_number_of(b->scores, "samples")
                 && eval_flag_of(a->scores, "synthetic") == eval_flag_of(b->scores, "synthetic");

    for (size_t i = 0; i < LT_COUNT(keys); i++)
        alike = alike && strcmp(eval_text_of(a->scores, keys[i]), eval_text_of(b->scores, keys[i])) == 0;
    return alike;
}

/* What distinguishes the runs of one setting is taken out of the config. */
static lt_status take_apart(const char *path, eval_run *r)
{
    cJSON *model = cJSON_GetObjectItemCaseSensitive(r->config, "model");
    cJSON *train = cJSON_GetObjectItemCaseSensitive(r->config, "train");
    cJSON *data = cJSON_GetObjectItemCaseSensitive(r->config, "data");

    r->variant = eval_text_of(r->scores, "variant");
    r->seed = eval_number_of(train, "seed");
    if (!*r->variant || !cJSON_IsObject(model) || isnan(r->seed))
        return lt_error(LT_EFORMAT, "%s: not the config of a run that was scored; score it again", path);
    cJSON_DeleteItemFromObjectCaseSensitive(model, "variant");
    cJSON_DeleteItemFromObjectCaseSensitive(train, "seed");
    cJSON_DeleteItemFromObjectCaseSensitive(data, "jitter");        /* the variant's name says it: "full-cj" */
    return LT_OK;
}

static int setting_of(const eval_runs *all, const eval_run *r)
{
    for (int i = 0; i < all->n; i++)
        if (eval_runs_alike(&all->run[i], r)
            && strcmp(eval_text_of(all->run[i].scores, "model"), eval_text_of(r->scores, "model")) == 0
            && cJSON_Compare(all->run[i].config, r->config, true))
            return all->run[i].setting;
    return all->n;
}

static lt_status read_run(eval_runs *all, const char *folder, const char *name)
{
    const char *config = lt_arena_printf(all->arena, "%s/%s/config.json", folder, name);
    const char *scores = lt_arena_printf(all->arena, "%s/%s/eval/scores.json", folder, name);
    eval_run *r = &all->run[all->n];
    lt_status st;

    if (!config || !scores)
        return lt_error(LT_ENOMEM, "%s: no memory for the runs", folder);
    if (access(config, R_OK) || access(scores, R_OK))
        return LT_OK;
    *r = (eval_run){ .name = lt_arena_printf(all->arena, "%s", name) };
    if (!r->name)
        return lt_error(LT_ENOMEM, "%s: no memory for the runs", folder);
    st = lt_json_read(scores, &r->scores);
    if (st == LT_OK && !cJSON_HasObjectItem(r->scores, "variant")) {
        cJSON_Delete(r->scores);        /* a detector's or a tracker's, which no table is of */
        return LT_OK;
    }
    if (st == LT_OK)
        st = lt_json_read(config, &r->config);
    if (st == LT_OK)
        st = take_apart(config, r);
    if (st == LT_OK)
        r->setting = setting_of(all, r);
    all->n++;                       /* a half-read one too, so that it is freed */
    return st;
}

static lt_status read_folder(eval_runs *all, const char *folder)
{
    struct dirent **entry;
    const int n = scandir(folder, &entry, NULL, alphasort);
    lt_status st = LT_OK;

    if (n < 0)
        return lt_error(lt_errno_status(errno), "%s: %s", folder, strerror(errno));
    all->run = lt_arena_array(all->arena, (size_t)n, sizeof(*all->run));
    if (!all->run)
        st = lt_error(LT_ENOMEM, "%s: no memory for %d runs", folder, n);
    for (int i = 0; i < n; i++) {
        if (st == LT_OK && entry[i]->d_name[0] != '.')
            st = read_run(all, folder, entry[i]->d_name);
        free(entry[i]);
    }
    free(entry);
    return st;
}

lt_status eval_runs_read(const char *folder, eval_runs *out)
{
    *out = (eval_runs){ .arena = lt_arena_new() };
    if (!out->arena)
        return lt_error(LT_ENOMEM, "no memory for the runs");
    return folder ? read_folder(out, folder) : LT_OK;
}

void eval_runs_free(eval_runs *all)
{
    for (int i = 0; i < all->n; i++) {
        cJSON_Delete(all->run[i].scores);
        cJSON_Delete(all->run[i].config);
    }
    lt_arena_free(all->arena);
    *all = (eval_runs){ .n = 0 };
}
