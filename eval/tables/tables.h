/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The papers' tables with our rows under theirs.
 *
 * A table is static data: columns, and the rows as printed in the paper. The printer puts our
 * rows beneath them, then what separates each from the row it reproduces, then one line with
 * the protocol. Every row says on which data its numbers were made, so that a synthetic number
 * cannot pass for a real one.
 */
#ifndef EVAL_TABLES_TABLES_H
#define EVAL_TABLES_TABLES_H

#include "estimate/metric.h"
#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

struct cJSON;

enum { EVAL_COLUMNS = 24, EVAL_NO_ROW = -1 };

typedef struct {
    const char *key;                /* of the dictionary, which has the unit and the better direction */
    const char *name;               /* as the paper calls it */
    int decimals;                   /* as the paper prints it */
    const char *object;             /* model folder of a column about one object, else NULL */
} eval_column;

/* A value without has prints "-"; one that is not a number prints "failed". */
typedef struct {
    const char *label;
    const char *cite;               /* the paper's number for it, "[7]"; "" for none */
    const char *note;               /* value of the table's note column; "" for none */
    double values[EVAL_COLUMNS];
    bool has[EVAL_COLUMNS];
} eval_row;

typedef struct {
    const char *id;                 /* "hocat-1" */
    const char *title;              /* "HOCAT, Table 1: hand pose" */
    const char *cite;               /* what claims call it, "HOCAT, Table 5"; NULL: they have none of it */
    const char *data;               /* what the paper's rows were made on: "HO3D v2" */
    const char *note;               /* heading of the note column, or NULL */
    const char *remark;             /* one line under the table, or NULL */
    const eval_column *column;
    int n_columns;
    const eval_row *row;
    const char *const *variant;     /* (n_rows) which of ours each row is about, or NULL; NULL: those of the notes */
    int n_rows;
    bool hfl_symmetry;              /* shares of objects: HFL's symmetric ones by ADD-S */
    bool ablation;                  /* its rows are variants of one model */
    bool columns_down;              /* wide tables are printed with a line per column */
} eval_table;

/* One of our rows: a trained model, or a predictor that sees no image and stands for
 * reference. */
typedef struct {
    eval_row row;
    int against;                    /* row that it reproduces, from which it differs where the data are the same */
} eval_result;

/* How our rows were made. Text that is NULL prints "-". */
typedef struct {
    const char *dataset;            /* "HO3D v2", "DexYCB s0": the layout, when synthetic */
    bool synthetic;
    const char *split;
    bool whole;                     /* all of its samples */
    int64_t samples, failed;        /* failed: predictions that were not finite */
    const char *alignment;          /* "similarity per sample, reflections allowed" */
    const char *threshold;          /* "ADD <= 0.1 diameter" */
    const char *diameter;           /* eval_diameter_name */
    const char *symmetry;           /* "hfl: ADD-S, estimated to nearest true" */
    const char *given;              /* inputs that are ground truth: "hand box, object box, wrist" */
    const char *files, *columns;    /* which data of that name, and what was measured; NULL: not said */
} eval_protocol;

/* Rows of ours that were made in one way on the same data */
typedef struct {
    const eval_result *row;
    int n;
    const eval_protocol *protocol;
} eval_group;

/* eval_table_at - the i-th of all tables, NULL past the last */
const eval_table *eval_table_at(int i);

/* eval_table_of - whether it is a table of the paper on that model ("hocat" has "hocat-1" ...);
 * eval_table_by_object - whether a column is about one object; eval_table_own_row - the row that a
 * variant reproduces: the one whose note it is, or the paper's own, which stands last */
bool eval_table_of(const eval_table *t, const char *model);
bool eval_table_by_object(const eval_table *t);
int eval_table_own_row(const eval_table *t, const char *variant);

/* eval_find_variant - the row that is about a variant; EVAL_NO_ROW for none */
int eval_find_variant(const eval_table *t, const char *variant);

/* eval_find_column - index by name; eval_find_key - by what is measured, of a column that is about all objects;
 * EVAL_NO_ROW for none */
int eval_find_column(const eval_table *t, const char *name);
int eval_find_key(const eval_table *t, const char *key);

/* eval_column_metric - what a column measures */
const metric *eval_column_metric(const eval_column *c);

/* eval_find_object - the column about the object of that model folder, with or without "syn_"
 * before it */
int eval_find_object(const eval_table *t, const char *model);

/* eval_row_set - value for the column called name, which must exist, in the table's unit */
void eval_row_set(const eval_table *t, eval_row *row, const char *name, double value);

typedef enum { EVAL_TEXT, EVAL_MARKDOWN } eval_format;

/**
 * eval_table_print - title, the paper's rows, ours, differences, protocol
 *
 *   ours      (n) rows; n may be 0, then protocol may be NULL and only the paper's table is printed
 *
 * Our rows and their differences carry "synthetic" in label and data column when the protocol
 * says so. A difference is ours minus the paper's. Errors: LT_ENOMEM.
 */
lt_status eval_table_print(FILE *f, eval_format format, const eval_table *t,
                           const eval_result *ours, int n, const eval_protocol *protocol);

/* eval_table_print_groups - the same with rows that were made in several ways: each has a number, which its protocol
 * has, too */
lt_status eval_table_print_groups(FILE *f, eval_format format, const eval_table *t, const eval_group *groups, int n);

/* eval_table_json - the same as a value that the caller frees with cJSON_Delete; NULL without
 * memory */
struct cJSON *eval_table_json(const eval_table *t, const eval_result *ours, int n,
                              const eval_protocol *protocol);

/* eval_table_json_groups - likewise: "protocols", and in each row of "ours" the number of its own, from 1 */
struct cJSON *eval_table_json_groups(const eval_table *t, const eval_group *groups, int n);

/* The tables of each paper; eval_table_at runs through all. */
extern const eval_table eval_hocat_tables[], eval_unified_tables[], eval_hogs_tables[];
extern const int eval_n_hocat_tables, eval_n_unified_tables, eval_n_hogs_tables;

#ifdef __cplusplus
}
#endif
#endif
