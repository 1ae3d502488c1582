/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: the members of a JSON object, or the items of a list, one at a time, for files of hundreds of megabytes
 * whose tree would take ten times that. What stands between them is checked here, each value by whoever parses it with
 * lt_json_parse.
 */
#ifndef LT_IO_TEXT_JSON_OBJECT_H
#define LT_IO_TEXT_JSON_OBJECT_H

#include "libtensor/base/arena.h"

/* Where in a text one is, of an object or of a list. */
typedef struct {
    const char *name, *text;        /* name is for error lines */
    size_t n, at;
    bool first;
} lt_json_object;

typedef struct {
    const char *key;                /* NULL: an item of a list */
    const char *value;              /* its text, within the object's */
    size_t n;
} lt_json_member;

/* lt_json_object_open - before the first member of the object that text, n bytes, is; text is borrowed. A UTF-8 byte
 * order mark is skipped. LT_EFORMAT: it is no object. */
lt_status lt_json_object_open(const char *name, const char *text, size_t n, lt_json_object *out);

/**
 * lt_json_object_next - the next member; *more is false behind the last one
 *
 *   arena   owns the key
 *
 * Errors: LT_EFORMAT with line and byte: not JSON, cut short, text behind the object; LT_ENOMEM.
 */
lt_status lt_json_object_next(lt_json_object *o, lt_arena *arena, lt_json_member *out, bool *more);

/* lt_json_list_open, lt_json_list_next - likewise the items of a list */
lt_status lt_json_list_open(const char *name, const char *text, size_t n, lt_json_object *out);
lt_status lt_json_list_next(lt_json_object *o, lt_json_member *out, bool *more);

#endif
