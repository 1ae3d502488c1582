/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which result file a file is, by how it begins.
 */
#ifndef EVAL_SCORERS_RESULT_KIND_H
#define EVAL_SCORERS_RESULT_KIND_H

#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    RESULT_HO3D,                    /* pred.json, or an archive that may hold it */
    RESULT_HPE,                     /* DexYCB's text of hand joints: many numbers a line */
    RESULT_BOP,                     /* BOP's csv of object poses: seven fields a line, perhaps under their names */
    RESULT_COCO,                    /* a list of objects in JSON: detections */
} result_kind;

/* result_kind_of - by the first kilobytes. Errors: LT_EIO (not a regular file), LT_EFORMAT for none of these; the line
 * says what it is and what is scored. */
lt_status result_kind_of(const char *path, result_kind *out);

/* result_kind_name - "BOP's csv of object poses" */
const char *result_kind_name(result_kind kind);

#ifdef __cplusplus
}
#endif
#endif
