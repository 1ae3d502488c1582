/* SPDX-License-Identifier: Apache-2.0 */
/* The parts of HOGS as small graphs with a loss, which two programs look at: values in float, gradients in double.
 * Parameters and inputs are hashed from their names, as in scripts/vectors/hogs.py. */
#ifndef TESTS_MODELS_HOGS_PARTS_H
#define TESTS_MODELS_HOGS_PARTS_H

#include "libtensor/graph/plan.h"
#include "models/model.h"

typedef struct {
    const char *name;               /* of its vectors */
    void (*record)(lt_params *set, model_record *r);    /* sets r's inputs, outputs and loss */
} hogs_part;

extern const hogs_part hogs_parts[];
extern const int n_hogs_parts;

/* hogs_part_fill - the plan's inputs, and all parameters of the set, whose rows take part */
void hogs_part_fill(lt_params *set, const model_record *r, const lt_plan *plan);

#endif
