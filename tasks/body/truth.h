/* SPDX-License-Identifier: Apache-2.0 */
/* The true body in a picture, posed by what is known of it. */
#ifndef TASKS_BODY_TRUTH_H
#define TASKS_BODY_TRUTH_H

#include "assets/run_body.h"
#include "data/body/set.h"

/* body_truth - vertices (BODY_VERTICES, 3) and nodes in the camera, metres */
void body_truth(const body_model *m, const body_row *row, double (*vertices)[3], double nodes[BODY_NODES][3]);

/* body_truth_check - LT_EINVAL where the pictures' poses were made with another body: a posed one's nodes are
 * elsewhere. LT_ENOMEM */
lt_status body_truth_check(const run_body *b, const body_set *set);

#endif
