/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/tables/claims.h"

#include "eval/tables/runs.h"
#include "libtensor/base/arena.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- what the papers claim ------------------------------------------------------------------------------- */

typedef struct {
    const char *table, *better, *worse, *metric;
    eval_claim_kind kind;
    const char *harder;
    const char *worse_row;
} entry;

static const entry entries[] = {
    { "hocat-5", "full", "dual", "pa_mpjpe_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hocat-5", "dual", "base", "pa_mpjpe_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hocat-5", "full", "dual", "pa_mpvpe_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hocat-5", "dual", "base", "pa_mpvpe_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_depth", "mpjpe_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_aaf", "mpjpe_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_cross_attention", "mpjpe_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_depth", "pa_mpjpe_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_aaf", "pa_mpjpe_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_cross_attention", "pa_mpjpe_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_depth", "adds_below_2cm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_aaf", "adds_below_2cm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_cross_attention", "adds_below_2cm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_depth", "adds_auc", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_aaf", "adds_auc", EVAL_CLAIM_ORDER, NULL, NULL },
    { "unified-8", "full", "no_cross_attention", "adds_auc", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-8", "full", "vpm-fg", "psnr_db", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-8", "full", "vpm-fp", "psnr_db", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-8", "vpm-fg", "no-vpm", "psnr_db", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-8", "vpm-fp", "no-vpm", "psnr_db", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-4", "full", "avatar", "psnr_db", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-4", "avatar", "no-vpm", "psnr_db", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-6", "full", "no-vpm", "psnr_db", EVAL_CLAIM_DROP, "-cj", NULL },
    { "hogs-6", "full", "avatar", "psnr_db", EVAL_CLAIM_DROP, "-cj", NULL },
    { "hogs-5", "full", "initial poses", "mce_mm", EVAL_CLAIM_BASELINE, NULL, NULL },
    { "hogs-5", "full", "mean offset", "mce_mm", EVAL_CLAIM_BASELINE, NULL, NULL },
    { "hogs-8", "full", "no-vpm", "psnr_db", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-8", "no-vpm", "full", "psnr_db", EVAL_CLAIM_ORDER, NULL, "another frame's image" },
    { "hogs-8", "full", "vpm-pg", "psnr_db", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-7", "full", "no-color", "psnr_db", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-7", "full", "no-gpm", "mce_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-7", "full", "gpm-random", "mce_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-7", "full", "gpm-random", "adds_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-7", "full", "no-contact", "psnr_db", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-7", "full", "no-contact", "penetration_mm", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-7", "full", "no-contact", "intersection_cm3", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-7", "full", "no-contact", "contact_share", EVAL_CLAIM_ORDER, NULL, NULL },
    { "hogs-2", "full", "minimum rule", "cd_o_cm2", EVAL_CLAIM_BASELINE, NULL, NULL },
};

static const eval_table *table_of(const char *id)
{
    const eval_table *t;

    for (int i = 0; (t = eval_table_at(i)); i++)
        if (strcmp(t->id, id) == 0)
            return t;
    return NULL;
}

/* What the paper has for a variant, with suffix for the variant of that longer name; NaN where it has nothing */
static double paper_value(const eval_table *t, const char *variant, const char *suffix, const char *key)
{
    const int column = eval_find_key(t, key);
    char name[64];
    int row;

    snprintf(name, sizeof(name), "%s%s", variant, suffix);
    row = eval_find_variant(t, name);
    return row != EVAL_NO_ROW && column != EVAL_NO_ROW && t->row[row].has[column] ? t->row[row].values[column] : NAN;
}

/* How much worse the second is */
static double drop(const metric *m, double easy, double hard)
{
    return m->higher ? easy - hard : hard - easy;
}

static double paper_side(const eval_claim *c, const char *variant)
{
    const double value = paper_value(c->table, variant, "", c->what->key);

    return c->kind == EVAL_CLAIM_DROP
        ? drop(c->what, value, paper_value(c->table, variant, c->harder, c->what->key)) : value;
}

bool eval_claim_at(int i, eval_claim *out)
{
    const entry *e;

    if (i < 0 || (size_t)i >= LT_COUNT(entries))
        return false;
    e = &entries[i];
    *out = (eval_claim){
        .kind = e->kind, .table = table_of(e->table), .better = e->better, .worse = e->worse, .harder = e->harder,
        .worse_row = e->worse_row, .what = metric_find(e->metric),
    };
    snprintf(out->model, sizeof(out->model), "%.*s", (int)strcspn(e->table, "-"), e->table);
    out->paper_better = paper_side(out, e->better);
    out->paper_worse = e->worse_row ? NAN : paper_side(out, e->worse);
    return true;
}

static bool higher_is_better(const eval_claim *c)
{
    return c->kind != EVAL_CLAIM_DROP && c->what->higher;
}

/* ---- runs ------------------------------------------------------------------------------------------------ */

struct eval_claims { eval_runs runs; };

lt_status eval_claims_read(const char *folder, eval_claims **out)
{
    eval_claims *c = lt_alloc(sizeof(*c));
    lt_status st;

    if (!c)
        return lt_error(LT_ENOMEM, "no memory for the claims");
    st = eval_runs_read(folder, &c->runs);
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
    eval_runs_free(&c->runs);
    lt_release(c);
}

/* ---- pairs ----------------------------------------------------------------------------------------------- */

/* What the runs of one setting say of a claim. margin: by how much better is ahead, so above 0 where it held. */
typedef struct {
    int pairs, held;
    double better, worse;           /* means */
    double margin, least, most;
    double squares;                 /* of what margins are from their mean */
} finding;

/* A score that was not finite is null and counts as infinitely bad. */
static double score_of(const cJSON *row, const metric *m)
{
    const double value = eval_number_of(row, m->key);

    return !isnan(value) ? value : m->higher ? -INFINITY : INFINITY;
}

/* Whether a run is of that variant; scores of before the metric was have none of it. */
static bool is_side(const eval_run *r, const eval_claim *claim, const char *variant, const char *suffix)
{
    const size_t n = strlen(variant);

    return strcmp(eval_text_of(r->scores, "model"), claim->model) == 0 && strncmp(r->variant, variant, n) == 0
           && strcmp(r->variant + n, suffix) == 0 && cJSON_HasObjectItem(eval_run_row(r, NULL), claim->what->key);
}

/* The run that differs from r in its variant alone */
static const eval_run *partner(const eval_claims *c, const eval_run *r, const eval_claim *claim, const char *variant,
                               const char *suffix)
{
    for (int i = 0; i < c->runs.n; i++) {
        const eval_run *other = &c->runs.run[i];

        if (other->setting == r->setting && other->seed == r->seed && is_side(other, claim, variant, suffix))
            return other;
    }
    return NULL;
}

/* What a run that is a side of a claim has to say; false: it lacks its harder counterpart. */
static bool side(const eval_claims *c, const eval_claim *claim, const eval_run *r, const char *variant,
                 const char *row, double *out)
{
    const eval_run *hard;

    *out = score_of(eval_run_row(r, row), claim->what);
    if (claim->kind != EVAL_CLAIM_DROP)
        return true;
    hard = partner(c, r, claim, variant, claim->harder);
    if (hard)
        *out = drop(claim->what, *out, score_of(eval_run_row(hard, NULL), claim->what));
    if (isnan(*out))                /* both failed */
        *out = INFINITY;
    return hard;
}

/* What a run's better side is held against; false: there is nothing. */
static bool other_side(const eval_claims *c, const eval_claim *claim, const eval_run *r, double *out)
{
    const cJSON *row = claim->kind == EVAL_CLAIM_BASELINE ? eval_run_row(r, claim->worse) : NULL;
    const eval_run *other;

    if (claim->kind == EVAL_CLAIM_BASELINE) {
        *out = score_of(row, claim->what);
        return cJSON_HasObjectItem(row, claim->what->key);
    }
    other = partner(c, r, claim, claim->worse, "");
    return other && side(c, claim, other, claim->worse, claim->worse_row, out);
}

static void add_pair(finding *f, double better, double worse, bool higher)
{
    const double margin = better == worse ? 0 : higher ? better - worse : worse - better;

    f->least = f->pairs ? fmin(f->least, margin) : margin;
    f->most = f->pairs ? fmax(f->most, margin) : margin;
    f->pairs++;
    f->squares += (margin - f->margin) * (margin - f->margin) * (f->pairs - 1) / f->pairs;
    f->held += margin > 0;
    f->better += (better - f->better) / f->pairs;
    f->worse += (worse - f->worse) / f->pairs;
    f->margin += (margin - f->margin) / f->pairs;
}

static finding find(const eval_claims *c, const eval_claim *claim, int setting)
{
    finding f = { 0 };

    for (int i = 0; i < c->runs.n; i++) {
        const eval_run *r = &c->runs.run[i];
        double better, worse;

        if (r->setting == setting && is_side(r, claim, claim->better, "")
            && side(c, claim, r, claim->better, NULL, &better) && other_side(c, claim, r, &worse))
            add_pair(&f, better, worse, higher_is_better(claim));
    }
    return f;
}

enum { SEEDS = 3 };                     /* that it takes to tell */

/* Paired by seed: a mean margin of more than two standard errors, and no seed that says otherwise */
static const char *verdict(const finding *f)
{
    const double error = f->pairs > 1 ? sqrt(f->squares / (f->pairs - 1) / f->pairs) : INFINITY;

    if (f->pairs < SEEDS)
        return "few seeds";
    if (f->held == f->pairs && f->margin > 2 * error)
        return "holds";
    return f->held == 0 && f->margin < -2 * error ? "does not hold" : "within noise";
}

/* ---- the ledger ------------------------------------------------------------------------------------------ */

static void print_data(FILE *f, const cJSON *scores)
{
    const bool synthetic = eval_flag_of(scores, "synthetic");

    fprintf(f, "%s%s, %s, %.0f samples", eval_text_of(scores, "dataset"), synthetic ? " layout, SYNTHETIC" : "",
            eval_text_of(scores, "split"), eval_number_of(scores, "samples"));
    if (strcmp(eval_text_of(scores, "light"), "fixed") == 0)
        fputs(", fixed light", f);
}

/* a / b, "-" for what the paper does not say */
static void print_paper(FILE *f, const eval_claim *claim)
{
    const double of[] = { claim->paper_better, claim->paper_worse };

    for (int i = 0; i < 2; i++) {
        fputs(i ? " / " : " ", f);
        if (isnan(of[i]))
            fputs("-", f);
        else
            fprintf(f, "%.2f", of[i]);
    }
}

static void print_claim(FILE *f, const eval_claim *claim)
{
    fprintf(f, "| %s | %s before %s", claim->table->cite, claim->better, claim->worse);
    if (claim->kind == EVAL_CLAIM_DROP)
        fprintf(f, " in the loss with %s", claim->harder);
    if (claim->kind == EVAL_CLAIM_BASELINE)
        fputs(" of the same run", f);
    if (claim->worse_row)
        fprintf(f, " with %s", claim->worse_row);
    fprintf(f, " | %s |", claim->what->key);
    print_paper(f, claim);
    fputs(" |", f);
}

static void print_finding(FILE *f, const finding *found, const cJSON *scores)
{
    fprintf(f, " %.2f / %.2f | %+.2f (%+.2f .. %+.2f) | %d of %d, %s | ", found->better, found->worse, found->margin,
            found->least, found->most, found->held, found->pairs, verdict(found));
    print_data(f, scores);
    fputs(" |\n", f);
}

void eval_claims_print(const eval_claims *c, FILE *f)
{
    eval_claim claim;

    fputs("| source | claim | metric | paper | ours | margin (least .. most) | held, of seeds | our data |\n"
          "|---|---|---|--:|--:|--:|--:|---|\n", f);
    for (int k = 0; eval_claim_at(k, &claim); k++) {
        int lines = 0;

        for (int i = 0; i < c->runs.n; i++) {
            const finding found = find(c, &claim, i);

            if (!found.pairs)
                continue;
            print_claim(f, &claim);
            print_finding(f, &found, c->runs.run[i].scores);
            lines++;
        }
        if (!lines) {
            print_claim(f, &claim);
            fputs(" - | - | not tried | - |\n", f);
        }
    }
}

static cJSON *claim_json(const eval_claim *claim)
{
    static const char *const kind[] = {
        [EVAL_CLAIM_ORDER] = "order", [EVAL_CLAIM_DROP] = "drop", [EVAL_CLAIM_BASELINE] = "baseline",
    };
    cJSON *o = cJSON_CreateObject();

    cJSON_AddStringToObject(o, "source", claim->table->cite);
    cJSON_AddStringToObject(o, "model", claim->model);
    cJSON_AddStringToObject(o, "better", claim->better);
    cJSON_AddStringToObject(o, "worse", claim->worse);
    cJSON_AddStringToObject(o, "metric", claim->what->key);
    cJSON_AddBoolToObject(o, "higher_is_better", higher_is_better(claim));
    cJSON_AddNumberToObject(o, "paper_better", claim->paper_better);
    cJSON_AddNumberToObject(o, "paper_worse", claim->paper_worse);
    cJSON_AddStringToObject(o, "kind", kind[claim->kind]);
    if (claim->harder)
        cJSON_AddStringToObject(o, "harder", claim->harder);
    if (claim->worse_row)
        cJSON_AddStringToObject(o, "worse_row", claim->worse_row);
    return o;
}

static cJSON *finding_json(const finding *found, const cJSON *scores)
{
    static const char *const data[] = { "dataset", "synthetic", "split", "samples", "hand", "light" };
    cJSON *o = cJSON_CreateObject();

    for (size_t i = 0; i < LT_COUNT(data); i++)
        cJSON_AddItemToObject(o, data[i], cJSON_Duplicate(cJSON_GetObjectItemCaseSensitive(scores, data[i]), true));
    cJSON_AddNumberToObject(o, "seeds", found->pairs);
    cJSON_AddNumberToObject(o, "held", found->held);
    cJSON_AddStringToObject(o, "verdict", verdict(found));
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
    eval_claim claim;

    for (int k = 0; eval_claim_at(k, &claim); k++) {
        cJSON *o = claim_json(&claim), *found = cJSON_AddArrayToObject(o, "findings");

        for (int i = 0; i < c->runs.n; i++) {
            const finding f = find(c, &claim, i);

            if (f.pairs)
                cJSON_AddItemToArray(found, finding_json(&f, c->runs.run[i].scores));
        }
        cJSON_AddItemToArray(root, o);
    }
    return root;
}
