/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Linear assignment: which row goes with which column, so that what the pairs cost is least in all.
 *
 * Source: Crouse 2016, "On implementing 2D rectangular assignment algorithms", the shortest augmenting path.
 */
#ifndef VISION_ASSIGNMENT_H
#define VISION_ASSIGNMENT_H

#include "libtensor/base/arena.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * assignment_solve - the cheapest min(rows, cols) pairs
 *
 *   scratch      where working memory comes from; nothing that outlives the call is left in it
 *   cost         (rows, cols) finite
 *   column       (rows) out: the column of each row, -1 for a row that is left over
 *
 * The time grows as min^2 * max of the two sizes. Errors: LT_ENOMEM.
 */
lt_status assignment_solve(lt_arena *scratch, const double *cost, int rows, int cols, int *column);

#ifdef __cplusplus
}
#endif
#endif
