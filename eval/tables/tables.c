/* SPDX-License-Identifier: Apache-2.0 */
/* Tables as aligned text, Markdown and JSON: a grid of cells is filled, turned if wide, then
 * printed. */
#include "eval/tables/tables.h"

#include "libtensor/base/arena.h"

#include <assert.h>
#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

/* ---- finding ----------------------------------------------------------------------------- */

const eval_table *eval_table_at(int i)
{
    static const struct { const eval_table *table; const int *n; } papers[] = {
        { eval_hocat_tables, &eval_n_hocat_tables }, { eval_unified_tables, &eval_n_unified_tables },
        { eval_hogs_tables, &eval_n_hogs_tables },
    };

    for (size_t p = 0; i >= 0 && p < LT_COUNT(papers); p++) {
        if (i < *papers[p].n)
            return &papers[p].table[i];
        i -= *papers[p].n;
    }
    return NULL;
}

bool eval_table_of(const eval_table *t, const char *model)
{
    const size_t n = strlen(model);

    return strncmp(t->id, model, n) == 0 && t->id[n] == '-';
}

bool eval_table_by_object(const eval_table *t)
{
    for (int i = 0; i < t->n_columns; i++)
        if (t->column[i].object)
            return true;
    return false;
}

int eval_find_variant(const eval_table *t, const char *variant)
{
    for (int i = 0; i < t->n_rows; i++) {
        const char *own = t->variant ? t->variant[i] : t->row[i].note;

        if (own && strcmp(own, variant) == 0)
            return i;
    }
    return EVAL_NO_ROW;
}

int eval_table_own_row(const eval_table *t, const char *variant)
{
    const int row = eval_find_variant(t, variant);

    return row == EVAL_NO_ROW ? t->n_rows - 1 : row;
}

int eval_find_column(const eval_table *t, const char *name)
{
    for (int i = 0; i < t->n_columns; i++) {
        if (strcmp(t->column[i].name, name) == 0)
            return i;
    }
    return EVAL_NO_ROW;
}

int eval_find_key(const eval_table *t, const char *key)
{
    for (int i = 0; i < t->n_columns; i++) {
        if (!t->column[i].object && strcmp(t->column[i].key, key) == 0)
            return i;
    }
    return EVAL_NO_ROW;
}

const metric *eval_column_metric(const eval_column *c)
{
    const metric *m = metric_find(c->key);

    assert(m);
    return m;
}

int eval_find_object(const eval_table *t, const char *model)
{
    if (strncmp(model, "syn_", 4) == 0)
        model += 4;
    for (int i = 0; i < t->n_columns; i++) {
        if (t->column[i].object && strcmp(t->column[i].object, model) == 0)
            return i;
    }
    return EVAL_NO_ROW;
}

void eval_row_set(const eval_table *t, eval_row *row, const char *name, double value)
{
    const int i = eval_find_column(t, name);

    assert(i != EVAL_NO_ROW);
    row->values[i] = value;
    row->has[i] = true;
}

/* ---- the grid ---------------------------------------------------------------------------- */

/* Cells by rows; the first `heads` columns and the first row are text, the rest numbers. */
typedef struct {
    const char **cell;
    int rows, columns, heads;
    int next;                       /* the next cell to fill */
    bool no_memory;                 /* for a cell */
    lt_arena *arena;
} grid;

static const char *or_dash(const char *text)
{
    return text && *text ? text : "-";
}

static void put(grid *g, const char *text)
{
    g->no_memory |= !text;
    g->cell[g->next++] = text;
}

static bool grid_init(grid *g, int rows, int columns)
{
    *g = (grid){ .rows = rows, .columns = columns, .arena = lt_arena_new() };
    if (g->arena)
        g->cell = lt_arena_array(g->arena, (size_t)rows * (size_t)columns, sizeof(char *));
    return g->cell;
}

static void put_heading(grid *g, const eval_table *t)
{
    put(g, "method");
    put(g, "data");
    if (t->note)
        put(g, t->note);
    g->heads = g->next;
    for (int i = 0; i < t->n_columns; i++) {
        const eval_column *c = &t->column[i];
        const char *unit = eval_column_metric(c)->unit;

        put(g, *unit ? lt_arena_printf(g->arena, "%s (%s)", c->name, unit) : c->name);
    }
}

static const char *number(grid *g, const eval_column *c, bool has, double x, bool signed_)
{
    if (!has)
        return "-";
    if (!isfinite(x))
        return "failed";
    return lt_arena_printf(g->arena, signed_ ? "%+.*f" : "%.*f", c->decimals, x);
}

static void put_row(grid *g, const eval_table *t, const eval_row *r, const char *label,
                    const char *data)
{
    put(g, label);
    put(g, data);
    if (t->note)
        put(g, or_dash(r->note));
    for (int i = 0; i < t->n_columns; i++)
        put(g, number(g, &t->column[i], r->has[i], r->values[i], false));
}

static void put_difference(grid *g, const eval_table *t, const eval_result *ours,
                           const char *label, const char *data)
{
    const eval_row *paper = &t->row[ours->against];

    put(g, lt_arena_printf(g->arena, "%s - %s", label, paper->label));
    put(g, lt_arena_printf(g->arena, "%s - %s", data, t->data));
    if (t->note)
        put(g, "");
    for (int i = 0; i < t->n_columns; i++)
        put(g, number(g, &t->column[i], ours->row.has[i] && paper->has[i],
                      ours->row.values[i] - paper->values[i], true));
}

static const char *paper_label(grid *g, const eval_row *r)
{
    return r->cite && *r->cite ? lt_arena_printf(g->arena, "%s %s", r->label, r->cite) : r->label;
}

static const char *our_label(lt_arena *arena, const eval_result *r, const eval_protocol *p)
{
    return p->synthetic ? lt_arena_printf(arena, "%s (synthetic)", r->row.label) : r->row.label;
}

static const char *our_data(const eval_protocol *p)
{
    return p->synthetic ? "synthetic" : or_dash(p->dataset);
}

/* Whether a difference from the paper's rows means anything. Those on DexYCB name no setup; their lineage has s0. */
static bool same_data(const eval_table *t, const eval_protocol *p)
{
    const size_t n = strlen(t->data);
    const char *split = or_dash(p->split), *more;

    if (p->synthetic || !p->whole || !p->dataset || strncmp(p->dataset, t->data, n) != 0)
        return false;
    more = p->dataset + n;
    return (strcmp(split, "evaluation") == 0 || strcmp(split, "test") == 0)
        && (!*more || (strcmp(t->data, "DexYCB") == 0 && strcmp(more, " s0") == 0));
}

static bool differs(const eval_table *t, const eval_result *r, const eval_protocol *p)
{
    return r->against != EVAL_NO_ROW && same_data(t, p);
}

/* A group's rows, with its number behind the data where there are several */
static void put_group(grid *g, const eval_table *t, const eval_group *group, int number)
{
    const char *data = our_data(group->protocol);

    if (number)
        data = lt_arena_printf(g->arena, "%s [%d]", data, number);
    for (int i = 0; i < group->n; i++) {
        const eval_result *ours = &group->row[i];
        const char *label = our_label(g->arena, ours, group->protocol);

        put_row(g, t, &ours->row, label, data);
        if (differs(t, ours, group->protocol))
            put_difference(g, t, ours, label, data);
    }
}

static bool fill(grid *g, const eval_table *t, const eval_group *groups, int n)
{
    int rows = 1 + t->n_rows;

    for (int k = 0; k < n; k++)
        for (int i = 0; i < groups[k].n; i++)
            rows += 1 + differs(t, &groups[k].row[i], groups[k].protocol);
    if (!grid_init(g, rows, 2 + (t->note != NULL) + t->n_columns))
        return false;
    put_heading(g, t);
    for (int i = 0; i < t->n_rows; i++)
        put_row(g, t, &t->row[i], paper_label(g, &t->row[i]), t->data);
    for (int k = 0; k < n; k++)
        put_group(g, t, &groups[k], n > 1 ? k + 1 : 0);
    return !g->no_memory;
}

static const char *cell(const grid *g, bool turned, int row, int column)
{
    return turned ? g->cell[column * g->columns + row] : g->cell[row * g->columns + column];
}

static int width(const grid *g, bool turned, int column)
{
    const int rows = turned ? g->columns : g->rows;
    int widest = 3;

    for (int r = 0; r < rows; r++)
        widest = (int)lt_max_i64(widest, (int64_t)strlen(cell(g, turned, r, column)));
    return widest;
}

/* The line between heading and rows. */
static void print_rule(FILE *f, eval_format format, const grid *g, bool turned, int columns,
                       int heads)
{
    for (int c = 0; c < columns; c++) {
        const int dashes = width(g, turned, c) - (format == EVAL_MARKDOWN && c >= heads);

        fputs(format == EVAL_MARKDOWN ? (c ? " | " : "| ") : (c ? "  " : ""), f);
        for (int i = 0; i < dashes; i++)
            fputc('-', f);
        if (dashes < width(g, turned, c))
            fputc(':', f);
    }
    fputs(format == EVAL_MARKDOWN ? " |\n" : "\n", f);
}

static void print_grid(FILE *f, eval_format format, const grid *g, bool turned)
{
    const int rows = turned ? g->columns : g->rows, columns = turned ? g->rows : g->columns;
    const int heads = turned ? 1 : g->heads;
    const bool md = format == EVAL_MARKDOWN;

    for (int r = 0; r < rows; r++) {
        for (int c = 0; c < columns; c++) {
            fputs(md ? (c ? " | " : "| ") : (c ? "  " : ""), f);
            fprintf(f, c < heads ? "%-*s" : "%*s", width(g, turned, c), cell(g, turned, r, c));
        }
        fputs(md ? " |\n" : "\n", f);
        if (r == 0)
            print_rule(f, format, g, turned, columns, heads);
    }
}

/* ---- the protocol ------------------------------------------------------------------------ */

static void print_protocol(FILE *f, const eval_protocol *p, int number)
{
    if (number)
        fprintf(f, "Protocol [%d]: ", number);
    else
        fputs("Protocol: ", f);
    if (p->synthetic)
        fprintf(f, "SYNTHETIC data (generated, in the layout of %s)",
                or_dash(p->dataset));
    else
        fprintf(f, "REAL data (%s)", or_dash(p->dataset));
    fprintf(f, "; split %s; %lld samples, %lld failed; alignment: %s; threshold: %s; ",
            or_dash(p->split), (long long)p->samples, (long long)p->failed, or_dash(p->alignment),
            or_dash(p->threshold));
    fprintf(f, "diameter: %s; symmetric classes: %s; from ground truth: %s", or_dash(p->diameter),
            or_dash(p->symmetry), or_dash(p->given));
    if (p->files)
        fprintf(f, "; data: %s", p->files);
    if (p->columns)
        fprintf(f, "; %s", p->columns);
    fputc('\n', f);
}

lt_status eval_table_print_groups(FILE *f, eval_format format, const eval_table *t, const eval_group *groups, int n)
{
    const bool md = format == EVAL_MARKDOWN;
    grid g;

    if (!fill(&g, t, groups, n)) {
        lt_arena_free(g.arena);
        return lt_error(LT_ENOMEM, "table %s: no memory", t->id);
    }
    fprintf(f, md ? "### %s\n\n" : "%s\n\n", t->title);
    print_grid(f, format, &g, t->columns_down);
    fprintf(f, "\nThe paper's rows: on %s", t->data);
    if (t->remark)
        fprintf(f, "; %s", t->remark);
    fprintf(f, ".%s\n", md && n > 0 ? "  " : "");
    for (int k = 0; k < n; k++) {
        print_protocol(f, groups[k].protocol, n > 1 ? k + 1 : 0);
        if (md && k + 1 < n)
            fputc('\n', f);
    }
    fputc('\n', f);
    lt_arena_free(g.arena);
    return LT_OK;
}

lt_status eval_table_print(FILE *f, eval_format format, const eval_table *t,
                           const eval_result *ours, int n, const eval_protocol *protocol)
{
    const eval_group all = { ours, n, protocol };

    return eval_table_print_groups(f, format, t, &all, n > 0);
}

/* ---- JSON -------------------------------------------------------------------------------- */

static cJSON *json_values(const eval_table *t, const eval_row *r, const eval_row *minus)
{
    cJSON *o = cJSON_CreateObject();

    for (int i = 0; i < t->n_columns; i++) {
        const double base = minus ? minus->values[i] : 0;

        if (r->has[i] && (!minus || minus->has[i]))
            cJSON_AddNumberToObject(o, t->column[i].name, r->values[i] - base);
    }
    return o;
}

static cJSON *json_row(const eval_table *t, const eval_row *r, const char *data, bool synthetic)
{
    cJSON *o = cJSON_CreateObject();

    cJSON_AddStringToObject(o, "label", r->label);
    if (r->cite && *r->cite)
        cJSON_AddStringToObject(o, "cite", r->cite);
    if (t->note && r->note && *r->note)
        cJSON_AddStringToObject(o, t->note, r->note);
    cJSON_AddStringToObject(o, "data", data);
    cJSON_AddBoolToObject(o, "synthetic", synthetic);
    cJSON_AddItemToObject(o, "values", json_values(t, r, NULL));
    return o;
}

static cJSON *json_ours(const eval_table *t, const eval_result *r, const eval_protocol *p)
{
    cJSON *o = json_row(t, &r->row, our_data(p), p->synthetic);

    if (r->against != EVAL_NO_ROW)
        cJSON_AddStringToObject(o, "against", t->row[r->against].label);
    if (differs(t, r, p))
        cJSON_AddItemToObject(o, "difference", json_values(t, &r->row, &t->row[r->against]));
    return o;
}

static cJSON *json_columns(const eval_table *t)
{
    cJSON *list = cJSON_CreateArray();

    for (int i = 0; i < t->n_columns; i++) {
        cJSON *o = cJSON_CreateObject();

        cJSON_AddStringToObject(o, "name", t->column[i].name);
        cJSON_AddStringToObject(o, "unit", eval_column_metric(&t->column[i])->unit);
        cJSON_AddStringToObject(o, "key", t->column[i].key);
        cJSON_AddItemToArray(list, o);
    }
    return list;
}

static cJSON *json_protocol(const eval_protocol *p)
{
    cJSON *o = cJSON_CreateObject();

    cJSON_AddStringToObject(o, "dataset", or_dash(p->dataset));
    cJSON_AddBoolToObject(o, "synthetic", p->synthetic);
    cJSON_AddStringToObject(o, "split", or_dash(p->split));
    cJSON_AddNumberToObject(o, "samples", (double)p->samples);
    cJSON_AddNumberToObject(o, "failed", (double)p->failed);
    cJSON_AddStringToObject(o, "alignment", or_dash(p->alignment));
    cJSON_AddStringToObject(o, "threshold", or_dash(p->threshold));
    cJSON_AddStringToObject(o, "diameter", or_dash(p->diameter));
    cJSON_AddStringToObject(o, "symmetric classes", or_dash(p->symmetry));
    cJSON_AddStringToObject(o, "from ground truth", or_dash(p->given));
    if (p->files)
        cJSON_AddStringToObject(o, "data", p->files);
    if (p->columns)
        cJSON_AddStringToObject(o, "columns", p->columns);
    return o;
}

static cJSON *json_paper(const eval_table *t)
{
    cJSON *o = cJSON_CreateObject(), *paper;

    if (!o)
        return NULL;
    cJSON_AddStringToObject(o, "id", t->id);
    cJSON_AddStringToObject(o, "title", t->title);
    cJSON_AddItemToObject(o, "columns", json_columns(t));
    paper = cJSON_AddArrayToObject(o, "paper");
    for (int i = 0; i < t->n_rows; i++)
        cJSON_AddItemToArray(paper, json_row(t, &t->row[i], t->data, false));
    return o;
}

cJSON *eval_table_json(const eval_table *t, const eval_result *ours, int n,
                       const eval_protocol *protocol)
{
    cJSON *o = json_paper(t), *list = cJSON_AddArrayToObject(o, "ours");

    for (int i = 0; i < n; i++)
        cJSON_AddItemToArray(list, json_ours(t, &ours[i], protocol));
    if (n > 0)
        cJSON_AddItemToObject(o, "protocol", json_protocol(protocol));
    return o;
}

cJSON *eval_table_json_groups(const eval_table *t, const eval_group *groups, int n)
{
    cJSON *o = json_paper(t), *list = cJSON_AddArrayToObject(o, "ours"), *protocols;

    for (int k = 0; k < n; k++)
        for (int i = 0; i < groups[k].n; i++) {
            cJSON *row = json_ours(t, &groups[k].row[i], groups[k].protocol);

            cJSON_AddNumberToObject(row, "protocol", k + 1);
            cJSON_AddItemToArray(list, row);
        }
    protocols = cJSON_AddArrayToObject(o, "protocols");
    for (int k = 0; k < n; k++)
        cJSON_AddItemToArray(protocols, json_protocol(groups[k].protocol));
    return o;
}
