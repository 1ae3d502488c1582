/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Text with one result a line, as benchmarks' toolkits take it; HPE's and BOP's files are read with it.
 */
#ifndef EVAL_SCORERS_RESULTS_FILE_H
#define EVAL_SCORERS_RESULTS_FILE_H

#include "libtensor/base/arena.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const char *header;                 /* what the first line may begin with, if not with a result; NULL: none */
    size_t shortest;                    /* bytes of the shortest line that is a result */
    size_t row_size;                    /* bytes of a row in memory */
    lt_status (*parse)(const char *path, int64_t line, const char *text, void *row);
    int (*order)(const void *a, const void *b);                                             /* as for qsort */
} results_format;

/*
 * results_file_read - all lines of a file but the blank ones, in order
 *
 *   rows, n     n rows of f->row_size bytes, in arena
 *
 * Errors: LT_EIO, LT_ENOMEM; LT_EFORMAT for another header, a NUL byte, and what f->parse refuses.
 */
lt_status results_file_read(lt_arena *arena, const char *path, const results_format *f, void **rows, int64_t *n);

#ifdef __cplusplus
}
#endif
#endif
