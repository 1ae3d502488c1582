/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of blobs: an op of the tests' own. */
#ifndef TESTS_TASKS_DRAW_H
#define TESTS_TASKS_DRAW_H

#include "libtensor/graph/graph.h"

enum { DRAW_SIDE = 12, DRAW_PIXELS = DRAW_SIDE * DRAW_SIDE };

/* draw - the sum of the first n rows' blobs, times gain, at each pixel's centre of the unit square.
 *   centre (rows, 2)   n (1) an integer   gain (1)   ->   (DRAW_PIXELS) */
lt_tensor *draw(lt_tensor *centre, lt_tensor *n, lt_tensor *gain);

/* draw_add - the same by hand, added to out, for truth */
void draw_add(const lt_real *centre, int n, lt_real gain, lt_real *out);

#endif
