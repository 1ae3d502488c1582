/* SPDX-License-Identifier: Apache-2.0 */
/* From scores to rows of the papers' tables. */
#include "eval/tables/rows.h"

#include <math.h>

void eval_row_ho3d(eval_row *row, const double scores[HO3D_SCORES])
{
    row->values[0] = 10 * scores[HO3D_XYZ_PA_MEAN];
    row->values[1] = 10 * scores[HO3D_MESH_PA_MEAN];
    row->values[2] = 100 * scores[HO3D_F_AL_5];
    row->values[3] = 100 * scores[HO3D_F_AL_15];
    for (int i = 0; i < 4; i++)
        row->has[i] = true;
}

void eval_row_dexycb(eval_row *row, const double scores[DEXYCB_SCORES], eval_procrustes_kind kind)
{
    row->values[0] = scores[DEXYCB_RELATIVE_MEAN];
    row->values[1] = scores[kind == EVAL_RIGID ? DEXYCB_RIGID_MEAN : DEXYCB_PA_MEAN];
    row->has[0] = row->has[1] = true;
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
