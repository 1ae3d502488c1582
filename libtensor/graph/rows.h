/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parameters whose rows (dimension 0) come and go, such as one parameter for the places of all points of all scenes.
 * A step reads and moves some ranges of rows and leaves all others alone: it says which ones first (lt_param_touch),
 * reads them with lt_rows (libtensor/ops/ops.h), and its gradients, their clearing and their norms are of those rows
 * only. What has as many rows as the parameter (gradients, an optimiser's moments and clocks) goes along when rows are
 * added, moved or taken out.
 */
#ifndef LT_GRAPH_ROWS_H
#define LT_GRAPH_ROWS_H

#include "libtensor/base/status.h"
#include "libtensor/graph/param.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int64_t first, n;
} lt_row_range;

/* Where a row comes from. */
typedef struct {
    int64_t from;                   /* the row that it was; -1: none, zeros everywhere */
    bool fresh;                     /* another row made from that one: values and clocks are copied, while its gradient,
                                     * its moments and whatever else does not keep begin at 0 */
} lt_row_source;

/* An array with as many rows as a parameter. */
typedef struct lt_row_array {
    lt_real *data;                  /* (rows, width); others may have moved it since it was last looked at */
    int64_t width;                  /* numbers in a row */
    bool keeps;                     /* a fresh row has the values of the one it was made from, else zeros */
    lt_real *moved;                 /* lt_param_gather's, while it works */
    struct lt_row_array *next;
} lt_row_array;

/* LT_ROWS_STEP - the step in which capacities grow, so that plans, which are compiled for a capacity, are seldom
 * compiled again; lt_rows_capacity - n rounded up to it */
enum { LT_ROWS_STEP = 1024 };
static inline int64_t lt_rows_capacity(int64_t n) { return (n + LT_ROWS_STEP - 1) / LT_ROWS_STEP * LT_ROWS_STEP; }

/* lt_param_width - numbers in a row of p */
static inline int64_t lt_param_width(const lt_param *p) { return lt_param_numel(p) / p->shape.dim[0]; }

/**
 * lt_params_add_rows - as lt_params_add, a weight of shape (rows, ...) of which each step moves some rows
 *
 * In a training plan only lt_rows may read it. lt_optim_step moves the rows that are touched, each with the clock of
 * its own steps. Errors: as lt_params_add; a shape without dimensions.
 */
LT_API lt_param *lt_params_add_rows(lt_params *set, const char *prefix, const char *name, lt_shape shape);

/**
 * lt_param_touch - rows first .. first + n - 1 take part in the step to come
 *
 * Their gradient is cleared where they did not take part yet; ranges may overlap. Call it before lt_run: gradients of
 * other rows are neither written nor read. Errors: LT_EINVAL for rows outside of p, or a parameter that has none;
 * LT_ENOMEM.
 */
LT_API lt_status lt_param_touch(lt_param *p, int64_t first, int64_t n);

/* lt_params_untouch - no row of any parameter of the set takes part: the beginning of a step */
LT_API void lt_params_untouch(lt_params *set);

/* lt_param_touched - the *n ranges that take part, from the lowest row up, apart from each other; borrowed until the
 * next change. lt_param_is_touched - whether this row is in one. */
LT_API const lt_row_range *lt_param_touched(const lt_param *p, int *n);
LT_API bool lt_param_is_touched(const lt_param *p, int64_t row);

/**
 * lt_param_gather - let the parameter have `rows` rows, row i of them made from from[i]
 *
 * The same happens to its gradient and to every array attached to it; made from touched rows, rows are touched. Order,
 * copies and gaps are free. With as many rows as before everything stays in its place in memory, and plans go on with
 * it; else those compiled with the parameter are no longer run (lt_run says so): record and compile again.
 *
 * Errors, which change nothing: LT_EINVAL for a source that is no row, for no rows, for a parameter that has no rows;
 * LT_ENOMEM.
 */
LT_API lt_status lt_param_gather(lt_param *p, int64_t rows, const lt_row_source *from);

/* lt_param_resize - the same, with rows in their order: zeros come at the end, or the last ones go */
LT_API lt_status lt_param_resize(lt_param *p, int64_t rows);

/* lt_param_attach - give the array, whose width and keeps are set, zeros for all rows of p, which from now on go where
 * the rows of p go; lt_param_detach - free them. The array is the caller's, and detached before the set is freed.
 * Errors: LT_ENOMEM. */
LT_API lt_status lt_param_attach(lt_param *p, lt_row_array *a);
LT_API void lt_param_detach(lt_param *p, lt_row_array *a);

#ifdef __cplusplus
}
#endif
#endif
