/* SPDX-License-Identifier: Apache-2.0 */
/*
 * CSV files of errors, a line for each sample, joint, object or sequence: for finding the worst, and for plots.
 */
#ifndef LT_IO_TEXT_CSV_H
#define LT_IO_TEXT_CSV_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"
#include "libtensor/io/atomic_file.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lt_atomic_file file;
    int n_metrics;
} lt_csv;

/**
 * lt_csv_open - begin the file and write its heading: what a line is about ("sample"), then the metrics' names
 *
 * A name should end in its unit: "pa_mpjpe_mm". Lines end in a newline; fields with a comma, a
 * quote or a line break are quoted as in RFC 4180. Ends in lt_csv_commit or _abort.
 * Errors: those of lt_atomic_open.
 */
lt_status lt_csv_open(lt_csv *w, const char *path, const char *about, int n_metrics, const char *const *metric);

/* lt_csv_add - one line; a value that is NaN (not measured) is left empty, infinity is
 * "inf" */
void lt_csv_add(lt_csv *w, const char *name, const double *value);

/* lt_csv_commit - as lt_atomic_commit */
lt_status lt_csv_commit(lt_csv *w);

/* lt_csv_field - cut the next field, without its quotes, off a line; NULL behind the last */
char *lt_csv_field(char **line);

#ifdef __cplusplus
}
#endif
#endif
