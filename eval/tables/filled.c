/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/tables/filled.h"

#include "eval/tables/runs.h"
#include "libtensor/base/arena.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

/* A table with our rows: groups of the same protocol and data, and of each the first run. */
typedef struct {
    const eval_table *table;
    eval_group *group;
    const eval_run **first;
    int n_groups;
} filled_table;

struct eval_filled {
    eval_runs runs;                 /* whose arena has all */
    filled_table *table;
    int n_tables;
};

/* ---- which run fills which table ------------------------------------------------------------------------- */

/* What `palmar eval` made of the table when it scored the run, or NULL */
static const cJSON *as_scored(const eval_run *r, const eval_table *t)
{
    const cJSON *tables = cJSON_GetObjectItemCaseSensitive(r->scores, "tables"), *one;

    cJSON_ArrayForEach(one, tables)
        if (strcmp(eval_text_of(one, "id"), t->id) == 0)
            return cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(one, "ours")) ? one : NULL;
    return NULL;
}

/* A real dataset's numbers appear only under tables about that dataset: "HO3D", "DexYCB". */
static bool belongs(const eval_run *r, const eval_table *t)
{
    if (t->ablation && !eval_table_of(t, eval_text_of(r->scores, "model")))
        return false;
    return eval_flag_of(r->scores, "synthetic") || strncmp(eval_text_of(r->scores, "dataset"), t->data, 4) == 0;
}

/* ---- rows ------------------------------------------------------------------------------------------------ */

static void set(eval_row *row, int column, const cJSON *value)
{
    row->has[column] = value;
    row->values[column] = cJSON_IsNumber(value) ? value->valuedouble : NAN;
}

/* Of what was scored, by the columns' keys; columns about one object are not among it. */
static eval_row row_by_key(const eval_table *t, const cJSON *scores)
{
    eval_row row = { .label = eval_text_of(scores, "predictor") };

    for (int i = 0; i < t->n_columns; i++) {
        const cJSON *value = cJSON_GetObjectItemCaseSensitive(scores, t->column[i].key);

        if (value && !t->column[i].object)
            set(&row, i, value);
    }
    return row;
}

/* Of the table as it was filled then */
static eval_row row_as_scored(const eval_table *t, const cJSON *ours)
{
    const cJSON *values = cJSON_GetObjectItemCaseSensitive(ours, "values");
    eval_row row = { .label = eval_text_of(ours, "label"), .note = t->note ? eval_text_of(ours, t->note) : "" };

    for (int i = 0; i < t->n_columns; i++) {
        const cJSON *value = cJSON_GetObjectItemCaseSensitive(values, t->column[i].name);

        if (value)
            set(&row, i, value);
    }
    return row;
}

static bool is_filled(const eval_row *row)
{
    for (int i = 0; i < EVAL_COLUMNS; i++)
        if (row->has[i])
            return true;
    return false;
}

static bool same_values(const eval_row *a, const eval_row *b)
{
    for (int i = 0; i < EVAL_COLUMNS; i++)
        if (a->has[i] != b->has[i] || (a->has[i] && a->values[i] != b->values[i]
                                       && !(isnan(a->values[i]) && isnan(b->values[i]))))
            return false;
    return true;
}

/* A predictor that sees no image stands in a group once, unless it came to something else. */
static bool is_there(const eval_group *g, const eval_row *row)
{
    for (int i = 0; i < g->n; i++)
        if (strcmp(g->row[i].row.label, row->label) == 0 && same_values(&g->row[i].row, row))
            return true;
    return false;
}

/* ---- protocols ------------------------------------------------------------------------------------------- */

static const char *text_or_null(const cJSON *o, const char *key)
{
    const char *text = eval_text_of(o, key);

    return *text ? text : NULL;
}

static int64_t count_of(const cJSON *o, const char *key)
{
    const double n = eval_number_of(o, key);

    return n >= 0 && n < 1e15 ? (int64_t)n : 0;
}

/* What the columns that runs fill by key measure: their papers' protocols are not known to be the same. */
static const char *columns_of(lt_arena *arena, const eval_table *t, const eval_row *row)
{
    const char *text = NULL;

    for (int i = 0; i < t->n_columns; i++) {
        const eval_column *c = &t->column[i];

        if (row->has[i])
            text = lt_arena_printf(arena, "%s%s%s: %s [%s]", text ? text : "", text ? "; " : "", c->name,
                                   eval_column_metric(c)->meaning, eval_column_metric(c)->source);
    }
    return text;
}

/* How the run was scored whatever the table: what it was handed, how often it failed */
static const cJSON *any_protocol(const eval_run *r)
{
    const cJSON *tables = cJSON_GetObjectItemCaseSensitive(r->scores, "tables"), *one;

    cJSON_ArrayForEach(one, tables)
        if (cJSON_HasObjectItem(one, "protocol"))
            return cJSON_GetObjectItemCaseSensitive(one, "protocol");
    return NULL;
}

static eval_protocol protocol_of(lt_arena *arena, const eval_run *r, const cJSON *scored)
{
    const cJSON *made = cJSON_GetObjectItemCaseSensitive(scored, "protocol"), *any = any_protocol(r), *s = r->scores;

    return (eval_protocol){
        .dataset = eval_text_of(s, "dataset"), .synthetic = eval_flag_of(s, "synthetic"),
        .split = eval_text_of(s, "split"), .whole = count_of(s, "samples") == count_of(s, "split_samples"),
        .samples = count_of(s, "samples"), .failed = count_of(any, "failed"),
        .alignment = text_or_null(made, "alignment"), .threshold = text_or_null(made, "threshold"),
        .diameter = text_or_null(made, "diameter"), .symmetry = text_or_null(made, "symmetric classes"),
        .given = text_or_null(any, "from ground truth"),
        .files = lt_arena_printf(arena, "%s, crc32 %s", eval_text_of(s, "data"), eval_text_of(s, "data_crc32")),
    };
}

static bool same_text(const char *a, const char *b)
{
    return strcmp(a ? a : "-", b ? b : "-") == 0;
}

static bool same_protocol(const eval_protocol *a, const eval_protocol *b)
{
    return a->failed == b->failed && same_text(a->alignment, b->alignment) && same_text(a->threshold, b->threshold)
           && same_text(a->diameter, b->diameter) && same_text(a->symmetry, b->symmetry)
           && same_text(a->given, b->given) && same_text(a->columns, b->columns);
}

/* ---- filling --------------------------------------------------------------------------------------------- */

static eval_group *group_of(eval_filled *f, filled_table *t, const eval_run *r, const eval_protocol *p)
{
    eval_protocol *own;

    for (int i = 0; i < t->n_groups; i++)
        if (eval_runs_alike(t->first[i], r) && same_protocol(t->group[i].protocol, p))
            return &t->group[i];
    own = lt_arena_alloc(f->runs.arena, sizeof(*own));
    if (!own)
        return NULL;
    *own = *p;
    t->first[t->n_groups] = r;
    t->group[t->n_groups] = (eval_group){ .protocol = own };
    return &t->group[t->n_groups++];
}

static bool add_row(eval_filled *f, eval_group *g, const eval_row *row, int against)
{
    eval_result *rows = lt_arena_array(f->runs.arena, (size_t)g->n + 1, sizeof(*rows));

    if (!rows || !row->label)
        return false;
    if (g->n)
        memcpy(rows, g->row, (size_t)g->n * sizeof(*rows));
    rows[g->n++] = (eval_result){ *row, against };
    g->row = rows;
    return true;
}

/* The model's row is called by its run, and what its variant is where the table has variants. */
static eval_row named(eval_filled *f, const eval_table *t, const eval_run *r, eval_row row)
{
    row.label = lt_arena_printf(f->runs.arena, "%s: %s %s", r->name, eval_text_of(r->scores, "model"), r->variant);
    if (t->ablation && t->note && !t->variant)
        row.note = r->variant;
    return row;
}

static bool add_predictors(eval_filled *f, const eval_table *t, eval_group *g, const cJSON *first, bool scored)
{
    for (const cJSON *one = first; one; one = one->next) {
        const eval_row row = scored ? row_as_scored(t, one) : row_by_key(t, one);

        if (!is_there(g, &row) && !add_row(f, g, &row, EVAL_NO_ROW))
            return false;
    }
    return true;
}

static bool add_model(eval_filled *f, const eval_table *t, eval_group *g, const eval_run *r, const eval_row *row)
{
    const bool reproduces = eval_table_of(t, eval_text_of(r->scores, "model"));
    const eval_row own = named(f, t, r, *row);

    return add_row(f, g, &own, reproduces ? eval_table_own_row(t, r->variant) : EVAL_NO_ROW);
}

/* A run's row of its model, which is the first, or those of the predictors beside it */
static lt_status fill_from(eval_filled *f, filled_table *out, const eval_run *r, bool models)
{
    const eval_table *t = out->table;
    const cJSON *scored = as_scored(r, t), *first;
    eval_row row;
    eval_protocol p;
    eval_group *g;
    bool added;

    first = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(scored ? scored : r->scores, scored ? "ours" : "rows"),
                               0);
    row = scored ? row_as_scored(t, first) : row_by_key(t, first);
    if (!is_filled(&row))
        return LT_OK;
    p = protocol_of(f->runs.arena, r, scored);
    p.columns = scored ? NULL : columns_of(f->runs.arena, t, &row);
    g = p.files ? group_of(f, out, r, &p) : NULL;
    added = g && (models ? add_model(f, t, g, r, &row) : add_predictors(f, t, g, first->next, scored));
    return added ? LT_OK : lt_error(LT_ENOMEM, "table %s: no memory for its rows", t->id);
}

static lt_status fill_table(eval_filled *f, const eval_table *t)
{
    const size_t n = (size_t)f->runs.n;
    filled_table *out = &f->table[f->n_tables];
    lt_status st = LT_OK;

    *out = (filled_table){
        .table = t, .group = lt_arena_array(f->runs.arena, n, sizeof(*out->group)),
        .first = lt_arena_array(f->runs.arena, n, sizeof(*out->first)),
    };
    if (!out->group || !out->first)
        return lt_error(LT_ENOMEM, "table %s: no memory for its rows", t->id);
    for (int i = 0; !st && i < 2 * f->runs.n; i++) {       /* models above predictors */
        const eval_run *r = &f->runs.run[i % f->runs.n];

        if (belongs(r, t))
            st = fill_from(f, out, r, i < f->runs.n);
    }
    f->n_tables += out->n_groups > 0;
    return st;
}

static lt_status fill_all(eval_filled *f, const char *folder)
{
    const eval_table *t;
    lt_status st = LT_OK;
    int n = 0;

    if (!f->runs.n)
        return lt_error(LT_EINVAL, "%s: no scored run in it; want a folder of runs' folders, of which palmar eval "
                        "scored some", folder);
    while (eval_table_at(n))
        n++;
    f->table = lt_arena_array(f->runs.arena, (size_t)n, sizeof(*f->table));
    if (!f->table)
        return lt_error(LT_ENOMEM, "%s: no memory for the tables", folder);
    for (int i = 0; !st && (t = eval_table_at(i)); i++)
        st = fill_table(f, t);
    return st;
}

lt_status eval_filled_read(const char *folder, eval_filled **out)
{
    eval_filled *f = lt_alloc(sizeof(*f));
    lt_status st;

    if (!f)
        return lt_error(LT_ENOMEM, "%s: no memory for the tables", folder);
    *f = (eval_filled){ .n_tables = 0 };
    st = eval_runs_read(folder, &f->runs);
    if (!st)
        st = fill_all(f, folder);
    if (st) {
        eval_filled_free(f);
        return st;
    }
    *out = f;
    return LT_OK;
}

void eval_filled_free(eval_filled *f)
{
    if (!f)
        return;
    eval_runs_free(&f->runs);
    lt_release(f);
}

/* ---- telling --------------------------------------------------------------------------------------------- */

lt_status eval_filled_print(const eval_filled *f, FILE *out, eval_format format)
{
    lt_status st = LT_OK;

    for (int i = 0; !st && i < f->n_tables; i++)
        st = eval_table_print_groups(out, format, f->table[i].table, f->table[i].group, f->table[i].n_groups);
    return st;
}

cJSON *eval_filled_json(const eval_filled *f)
{
    cJSON *list = cJSON_CreateArray();

    for (int i = 0; i < f->n_tables; i++)
        cJSON_AddItemToArray(list, eval_table_json_groups(f->table[i].table, f->table[i].group, f->table[i].n_groups));
    return list;
}
