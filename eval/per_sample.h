/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A CSV file with the errors of every sample, for finding the worst ones and for plots.
 */
#ifndef EVAL_PER_SAMPLE_H
#define EVAL_PER_SAMPLE_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"
#include "libtensor/io/atomic_file.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lt_atomic_file file;
    int n_metrics;
} eval_per_sample;

/**
 * eval_per_sample_open - begin the file and write its heading: "sample", then the metrics' names
 *
 * A name should end in its unit: "pa_mpjpe_mm". Lines end in a newline; fields with a comma, a
 * quote or a line break are quoted as in RFC 4180. Ends in eval_per_sample_commit or _abort.
 * Errors: those of lt_atomic_open.
 */
lt_status eval_per_sample_open(eval_per_sample *w, const char *path, int n_metrics,
                               const char *const *metric);

/* eval_per_sample_add - one line; a value that is NaN (not measured) is left empty, infinity is
 * "inf" */
void eval_per_sample_add(eval_per_sample *w, const char *sample, const double *value);

/* eval_per_sample_commit, eval_per_sample_abort - as lt_atomic_commit and lt_atomic_abort */
lt_status eval_per_sample_commit(eval_per_sample *w);
void eval_per_sample_abort(eval_per_sample *w);

#ifdef __cplusplus
}
#endif
#endif
