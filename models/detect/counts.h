/* SPDX-License-Identifier: Apache-2.0 */
/* What a detector's losses are divided by, counted over the parts of a batch. */
#ifndef MODELS_DETECT_COUNTS_H
#define MODELS_DETECT_COUNTS_H

#include "models/detect/assign.h"

/* counts_plan - what a loss keeps and needs: saved[0], and work for each image's sums of `doubles` */
void counts_plan(lt_call *c, int64_t images, int doubles);

typedef struct { double scores, masks; } counts;    /* sum of the assigned scores; cells whose object has a mask */

/* counts_share - lt_op.forward_share of a loss with these inputs; counts_of - at the start of forward, the counts of
 * the whole batch, at least 1 each */
void counts_share(const lt_call *c, int objects, int assigned);
counts counts_of(const lt_call *c, int objects, int assigned);

/* counts_saved - in backward, what forward counted */
counts counts_saved(const lt_call *c);

/* counts_parts - what a part's share is multiplied with */
double counts_parts(const lt_call *c);

#endif
