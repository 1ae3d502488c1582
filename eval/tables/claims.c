/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/tables/claims.h"

#include "libtensor/base/arena.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const eval_claim claims[] = {
    { "HOCAT, Table 5", "hocat", "full", "dual", "pa_mpjpe_mm", 9.1, 10.1 },
    { "HOCAT, Table 5", "hocat", "dual", "base", "pa_mpjpe_mm", 10.1, 11.0 },
    { "HOCAT, Table 5", "hocat", "full", "dual", "pa_mpvpe_mm", 9.0, 10.0 },
    { "HOCAT, Table 5", "hocat", "dual", "base", "pa_mpvpe_mm", 10.0, 10.9 },
    { "Unified, Table 8", "unified", "full", "no_depth", "mpjpe_mm", 11.70, 12.60 },
    { "Unified, Table 8", "unified", "full", "no_aaf", "mpjpe_mm", 11.70, 12.20 },
    { "Unified, Table 8", "unified", "full", "no_cross_attention", "mpjpe_mm", 11.70, 12.10 },
    { "Unified, Table 8", "unified", "full", "no_depth", "pa_mpjpe_mm", 4.48, 4.80 },
    { "Unified, Table 8", "unified", "full", "no_aaf", "pa_mpjpe_mm", 4.48, 4.54 },
    { "Unified, Table 8", "unified", "full", "no_cross_attention", "pa_mpjpe_mm", 4.48, 4.50 },
    { "Unified, Table 8", "unified", "full", "no_depth", "adds_below_2cm", 0.83, 0.77 },
    { "Unified, Table 8", "unified", "full", "no_aaf", "adds_below_2cm", 0.83, 0.79 },
    { "Unified, Table 8", "unified", "full", "no_cross_attention", "adds_below_2cm", 0.83, 0.76 },
    { "Unified, Table 8", "unified", "full", "no_depth", "adds_auc", 0.86, 0.76 },
    { "Unified, Table 8", "unified", "full", "no_aaf", "adds_auc", 0.86, 0.83 },
    { "Unified, Table 8", "unified", "full", "no_cross_attention", "adds_auc", 0.86, 0.83 },
};

static bool higher_is_better(const eval_claim *c) { return c->paper_better > c->paper_worse; }

const eval_claim *eval_claim_at(int i)
{
    return i >= 0 && (size_t)i < LT_COUNT(claims) ? &claims[i] : NULL;
}

/* ---- runs ------------------------------------------------------------------------------------------------ */

typedef struct {
    cJSON *scores, *config;         /* config: without variant and seed, which stand below */
    const char *variant;            /* borrowed from scores */
    double seed;
    int setting;                    /* the first run with the same config and samples */
} scored_run;

struct eval_claims {
    lt_arena *arena;
    scored_run *run;
    int n_runs;
};

static const char *text_of(const cJSON *o, const char *key)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(o, key));

    return text ? text : "";
}

static double number_of(const cJSON *o, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(o, key);

    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static bool same_samples(const cJSON *a, const cJSON *b)
{
    static const char *const keys[] = { "model", "dataset", "data_crc32", "split", "hand" };
    bool same = number_of(a, "samples") == number_of(b, "samples")
                && cJSON_IsTrue(cJSON_GetObjectItem(a, "synthetic"))
                   == cJSON_IsTrue(cJSON_GetObjectItem(b, "synthetic"));

    for (size_t i = 0; i < LT_COUNT(keys); i++)
        same = same && strcmp(text_of(a, keys[i]), text_of(b, keys[i])) == 0;
    return same;
}

/* What distinguishes the runs of one setting is taken out of the config. */
static lt_status take_apart(const char *path, scored_run *r)
{
    cJSON *model = cJSON_GetObjectItemCaseSensitive(r->config, "model");
    cJSON *train = cJSON_GetObjectItemCaseSensitive(r->config, "train");

    r->variant = text_of(r->scores, "variant");
    r->seed = number_of(train, "seed");
    if (!*r->variant || !cJSON_IsObject(model) || isnan(r->seed))
        return lt_error(LT_EFORMAT, "%s: not the config of a run that was scored; score it again", path);
    cJSON_DeleteItemFromObjectCaseSensitive(model, "variant");
    cJSON_DeleteItemFromObjectCaseSensitive(train, "seed");
    return LT_OK;
}

static int setting_of(const eval_claims *c, const scored_run *r)
{
    for (int i = 0; i < c->n_runs; i++)
        if (same_samples(c->run[i].scores, r->scores) && cJSON_Compare(c->run[i].config, r->config, true))
            return c->run[i].setting;
    return c->n_runs;
}

static lt_status read_run(eval_claims *c, const char *folder, const char *name)
{
    const char *config = lt_arena_printf(c->arena, "%s/%s/config.json", folder, name);
    const char *scores = lt_arena_printf(c->arena, "%s/%s/eval/scores.json", folder, name);
    scored_run *r = &c->run[c->n_runs];
    lt_status st;

    if (!config || !scores)
        return lt_error(LT_ENOMEM, "%s: no memory for the runs", folder);
    if (access(config, R_OK) || access(scores, R_OK))
        return LT_OK;
    *r = (scored_run){ 0 };
    st = lt_json_read(scores, &r->scores);
    if (st == LT_OK)
        st = lt_json_read(config, &r->config);
    if (st == LT_OK)
        st = take_apart(config, r);
    if (st == LT_OK)
        r->setting = setting_of(c, r);
    c->n_runs++;                    /* a half-read one too, so that it is freed */
    return st;
}

static lt_status read_folder(eval_claims *c, const char *folder)
{
    struct dirent **entry;
    const int n = scandir(folder, &entry, NULL, alphasort);
    lt_status st = LT_OK;

    if (n < 0)
        return lt_error(lt_errno_status(errno), "%s: %s", folder, strerror(errno));
    c->run = lt_arena_array(c->arena, (size_t)n, sizeof(*c->run));
    if (!c->run)
        st = lt_error(LT_ENOMEM, "%s: no memory for %d runs", folder, n);
    for (int i = 0; i < n; i++) {
        if (st == LT_OK && entry[i]->d_name[0] != '.')
            st = read_run(c, folder, entry[i]->d_name);
        free(entry[i]);
    }
    free(entry);
    return st;
}

lt_status eval_claims_read(const char *folder, eval_claims **out)
{
    lt_arena *arena = lt_arena_new();
    eval_claims *c = arena ? lt_arena_alloc(arena, sizeof(*c)) : NULL;
    lt_status st;

    if (!c) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "no memory for the claims");
    }
    c->arena = arena;
    st = folder ? read_folder(c, folder) : LT_OK;
    if (st) {
        eval_claims_free(c);
        return st;
    }
    *out = c;
    return LT_OK;
}

void eval_claims_free(eval_claims *c)
{
    if (!c)
        return;
    for (int i = 0; i < c->n_runs; i++) {
        cJSON_Delete(c->run[i].scores);
        cJSON_Delete(c->run[i].config);
    }
    lt_arena_free(c->arena);
}

/* ---- pairs ----------------------------------------------------------------------------------------------- */

/* What the runs of one setting say of a claim. margin: by how much better is ahead, so above 0 where it held. */
typedef struct {
    int pairs, held;
    double better, worse;           /* means */
    double margin, least, most;
} finding;

/* The model's row is the first. */
static const cJSON *model_row(const scored_run *r)
{
    return cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(r->scores, "rows"), 0);
}

/* A score that was not finite is null and counts as infinitely bad. */
static double score_of(const scored_run *r, const eval_claim *claim)
{
    const double value = number_of(model_row(r), claim->metric);

    return !isnan(value) ? value : higher_is_better(claim) ? -INFINITY : INFINITY;
}

/* The scored run of that variant on one side of a claim; scores of before the metric was have none of it. */
static bool is_side(const scored_run *r, const eval_claim *claim, const char *variant)
{
    return strcmp(text_of(r->scores, "model"), claim->model) == 0 && strcmp(r->variant, variant) == 0
           && cJSON_HasObjectItem(model_row(r), claim->metric);
}

static const scored_run *partner(const eval_claims *c, const scored_run *better, const eval_claim *claim)
{
    for (int i = 0; i < c->n_runs; i++) {
        const scored_run *r = &c->run[i];

        if (r->setting == better->setting && r->seed == better->seed && is_side(r, claim, claim->worse))
            return r;
    }
    return NULL;
}

static void add_pair(finding *f, double better, double worse, bool higher)
{
    const double margin = better == worse ? 0 : higher ? better - worse : worse - better;

    f->least = f->pairs ? fmin(f->least, margin) : margin;
    f->most = f->pairs ? fmax(f->most, margin) : margin;
    f->pairs++;
    f->held += margin > 0;
    f->better += (better - f->better) / f->pairs;
    f->worse += (worse - f->worse) / f->pairs;
    f->margin += (margin - f->margin) / f->pairs;
}

static finding find(const eval_claims *c, const eval_claim *claim, int setting)
{
    finding f = { 0 };

    for (int i = 0; i < c->n_runs; i++) {
        const scored_run *r = &c->run[i], *other;

        if (r->setting != setting || !is_side(r, claim, claim->better))
            continue;
        other = partner(c, r, claim);
        if (other)
            add_pair(&f, score_of(r, claim), score_of(other, claim), higher_is_better(claim));
    }
    return f;
}

/* ---- the ledger ------------------------------------------------------------------------------------------ */

static void print_data(FILE *f, const cJSON *scores)
{
    const bool synthetic = cJSON_IsTrue(cJSON_GetObjectItem(scores, "synthetic"));

    fprintf(f, "%s%s, %s, %.0f samples", text_of(scores, "dataset"), synthetic ? " layout, SYNTHETIC" : "",
            text_of(scores, "split"), number_of(scores, "samples"));
}

static void print_claim(FILE *f, const eval_claim *claim)
{
    fprintf(f, "| %s | %s before %s | %s | %.2f / %.2f |", claim->source, claim->better, claim->worse, claim->metric,
            claim->paper_better, claim->paper_worse);
}

static void print_finding(FILE *f, const finding *found, const cJSON *scores)
{
    fprintf(f, " %.2f / %.2f | %+.2f (%+.2f .. %+.2f) | %d of %d | ", found->better, found->worse, found->margin,
            found->least, found->most, found->held, found->pairs);
    print_data(f, scores);
    fputs(" |\n", f);
}

void eval_claims_print(const eval_claims *c, FILE *f)
{
    fputs("| source | claim | metric | paper | ours | margin (least .. most) | held, of seeds | our data |\n"
          "|---|---|---|--:|--:|--:|--:|---|\n", f);
    for (int k = 0; eval_claim_at(k); k++) {
        const eval_claim *claim = eval_claim_at(k);
        int lines = 0;

        for (int i = 0; i < c->n_runs; i++) {
            const finding found = find(c, claim, i);

            if (!found.pairs)
                continue;
            print_claim(f, claim);
            print_finding(f, &found, c->run[i].scores);
            lines++;
        }
        if (!lines) {
            print_claim(f, claim);
            fputs(" - | - | not tried | - |\n", f);
        }
    }
}

static cJSON *claim_json(const eval_claim *claim)
{
    cJSON *o = cJSON_CreateObject();

    cJSON_AddStringToObject(o, "source", claim->source);
    cJSON_AddStringToObject(o, "model", claim->model);
    cJSON_AddStringToObject(o, "better", claim->better);
    cJSON_AddStringToObject(o, "worse", claim->worse);
    cJSON_AddStringToObject(o, "metric", claim->metric);
    cJSON_AddBoolToObject(o, "higher_is_better", higher_is_better(claim));
    cJSON_AddNumberToObject(o, "paper_better", claim->paper_better);
    cJSON_AddNumberToObject(o, "paper_worse", claim->paper_worse);
    return o;
}

static cJSON *finding_json(const finding *found, const cJSON *scores)
{
    static const char *const data[] = { "dataset", "synthetic", "split", "samples", "hand" };
    cJSON *o = cJSON_CreateObject();

    for (size_t i = 0; i < LT_COUNT(data); i++)
        cJSON_AddItemToObject(o, data[i], cJSON_Duplicate(cJSON_GetObjectItemCaseSensitive(scores, data[i]), true));
    cJSON_AddNumberToObject(o, "seeds", found->pairs);
    cJSON_AddNumberToObject(o, "held", found->held);
    cJSON_AddNumberToObject(o, "mean_better", found->better);
    cJSON_AddNumberToObject(o, "mean_worse", found->worse);
    cJSON_AddNumberToObject(o, "mean_margin", found->margin);
    cJSON_AddNumberToObject(o, "least_margin", found->least);
    cJSON_AddNumberToObject(o, "most_margin", found->most);
    return o;
}

cJSON *eval_claims_json(const eval_claims *c)
{
    cJSON *root = cJSON_CreateArray();

    for (int k = 0; eval_claim_at(k); k++) {
        cJSON *claim = claim_json(eval_claim_at(k)), *found = cJSON_AddArrayToObject(claim, "findings");

        for (int i = 0; i < c->n_runs; i++) {
            const finding f = find(c, eval_claim_at(k), i);

            if (f.pairs)
                cJSON_AddItemToArray(found, finding_json(&f, c->run[i].scores));
        }
        cJSON_AddItemToArray(root, claim);
    }
    return root;
}
