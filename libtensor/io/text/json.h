/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Small JSON files, over cJSON: limits, errors with a place, numbers that no locale can bend.
 */
#ifndef LT_IO_TEXT_JSON_H
#define LT_IO_TEXT_JSON_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

struct cJSON;

enum { LT_JSON_DEPTH = 64, LT_JSON_NUMBER = 32 };
#define LT_JSON_MAX ((size_t)64 << 20)      /* bytes of text; label files beyond it are read as streams */

/**
 * lt_json_read - parse a file of at most LT_JSON_MAX bytes
 *
 *   out      the caller frees it with cJSON_Delete
 *
 * RFC 8259 and the NaN, Infinity and -Infinity that Python writes; a UTF-8 byte order mark is skipped.
 * Errors: LT_EFORMAT with "path:line:column: reason": syntax, text after the value, nesting beyond
 * LT_JSON_DEPTH, "\u0000". LT_EIO, LT_ENOMEM.
 */
LT_API lt_status lt_json_read(const char *path, struct cJSON **out);

/* lt_json_parse - the same from n bytes in memory; name is for the error line */
LT_API lt_status lt_json_parse(const char *name, const char *text, size_t n, struct cJSON **out);

/* lt_json_write - an indented file with a last newline, atomically; numbers as lt_json_number */
LT_API lt_status lt_json_write(const char *path, const struct cJSON *value);

/* lt_json_print - the same to a stream, on one line and without a newline: for log.jsonl, --json */
LT_API void lt_json_print(FILE *f, const struct cJSON *value);

/* lt_json_number - the shortest decimal that reads back as x, "null" for NaN and infinities; returns
 * out, so that it can stand in an argument list */
LT_API const char *lt_json_number(double x, char out[LT_JSON_NUMBER]);

/* lt_json_print_string - text in quotes, escaped; bytes that are no UTF-8 become U+FFFD */
LT_API void lt_json_print_string(FILE *f, const char *text);

/* lt_json_watch_memory - let cJSON's allocations be watched from here on: reading then tells a lack of memory from bad
 * JSON, and lt_json_write refuses a tree in which something was left out for it. The first lt_json_parse does it. */
LT_API void lt_json_watch_memory(void);

/* lt_json_lacked_memory - whether an allocation of cJSON on this thread failed since this was asked last */
LT_API bool lt_json_lacked_memory(void);

#ifdef __cplusplus
}
#endif
#endif
