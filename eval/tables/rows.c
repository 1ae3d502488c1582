/* SPDX-License-Identifier: Apache-2.0 */
/* From scores to rows of the papers' tables. */
#include "eval/tables/rows.h"

#include <math.h>

void eval_row_fill(const eval_table *t, eval_row *row, const eval_score *scores, int n)
{
    for (int i = 0; i < n; i++) {
        const int column = eval_find_key(t, scores[i].key);

        if (column == EVAL_NO_ROW || scores[i].missing)
            continue;
        row->values[column] = scores[i].value;
        row->has[column] = true;
    }
}

void eval_object_shares_add(const eval_table *t, eval_object_shares *s, const char *model,
                            double error, double diameter)
{
    const int i = eval_find_object(t, model);

    if (i == EVAL_NO_ROW)
        s->outside++;
    else
        eval_share_add(&s->column[i], error <= .1 * diameter);
}

void eval_row_objects(const eval_table *t, const eval_object_shares *s, eval_row *row)
{
    double percent[EVAL_COLUMNS], average;

    for (int i = 0; i < t->n_columns; i++) {
        percent[i] = 100 * eval_share_value(&s->column[i]);
        if (!isnan(percent[i]))
            eval_row_set(t, row, t->column[i].name, percent[i]);
    }
    average = eval_class_mean(t->n_columns, percent);
    if (!isnan(average))
        eval_row_set(t, row, "average", average);
}
