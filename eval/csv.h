/* SPDX-License-Identifier: Apache-2.0 */
/*
 * CSV files of errors, a line for each sample, joint, object or sequence: for finding the worst, and for plots.
 */
#ifndef EVAL_CSV_H
#define EVAL_CSV_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"
#include "libtensor/io/atomic_file.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lt_atomic_file file;
    int n_metrics;
} eval_csv;

/**
 * eval_csv_open - begin the file and write its heading: what a line is about ("sample"), then the metrics' names
 *
 * A name should end in its unit: "pa_mpjpe_mm". Lines end in a newline; fields with a comma, a
 * quote or a line break are quoted as in RFC 4180. Ends in eval_csv_commit or _abort.
 * Errors: those of lt_atomic_open.
 */
lt_status eval_csv_open(eval_csv *w, const char *path, const char *about, int n_metrics, const char *const *metric);

/* eval_csv_add - one line; a value that is NaN (not measured) is left empty, infinity is
 * "inf" */
void eval_csv_add(eval_csv *w, const char *name, const double *value);

/* eval_csv_commit - as lt_atomic_commit */
lt_status eval_csv_commit(eval_csv *w);

/* eval_csv_field - cut the next field, without its quotes, off a line; NULL behind the last */
char *eval_csv_field(char **line);

#ifdef __cplusplus
}
#endif
#endif
