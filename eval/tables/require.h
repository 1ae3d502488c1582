/* SPDX-License-Identifier: Apache-2.0 */
/*
 * `palmar eval --require "KEY>=X"`: what a score must come to.
 */
#ifndef EVAL_TABLES_REQUIRE_H
#define EVAL_TABLES_REQUIRE_H

#include "estimate/metric.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const metric *what;
    bool at_least;                  /* else at most */
    double bound;
} eval_requirement;

/**
 * eval_require_read - "KEY>=X" or "KEY<=X", blanks allowed
 *
 *   made     the i-th key of what is scored, NULL past the last
 *
 * Errors: LT_EUSAGE with the key that was probably meant, or with what is not a number.
 */
lt_status eval_require_read(const char *text, const char *(*made)(int i), eval_requirement *out);

/* eval_require - LT_OK when all n are met; else LT_EINVAL, one line with what was found and wanted of each that is not.
 * A score that is not a number meets nothing. */
lt_status eval_require(const eval_requirement *r, int n, double (*score)(const void *ctx, const char *key),
                       const void *ctx);

#ifdef __cplusplus
}
#endif

#endif
