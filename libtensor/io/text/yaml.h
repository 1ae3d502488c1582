/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Small YAML files, over libyaml's events: one document of maps, lists and scalars, as datasets hold their
 * calibration in. Scalars keep their text; whoever reads one says what it must be.
 */
#ifndef LT_IO_TEXT_YAML_H
#define LT_IO_TEXT_YAML_H

#include "libtensor/base/arena.h"
#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_YAML_DEPTH = 16, LT_YAML_NODES = 16384 };
#define LT_YAML_MAX ((size_t)1 << 20)       /* bytes of a file */

typedef enum { LT_YAML_SCALAR, LT_YAML_LIST, LT_YAML_MAP } lt_yaml_kind;

/* A value; children are linked in the order of the file. */
typedef struct lt_yaml {
    const char *path;                       /* of the file, for error lines */
    const char *key;                        /* of a value in a map; "" elsewhere */
    const char *text;                       /* of a scalar, without its quotes; "" for others */
    const struct lt_yaml *first, *next;     /* child; sibling */
    int n;                                  /* children */
    int line;                               /* where it begins, from 1 */
    lt_yaml_kind kind;
} lt_yaml;

/**
 * lt_yaml_read - parse a file of at most LT_YAML_MAX bytes
 *
 *   out      owned by the arena; touched only on success
 *
 * Block and flow style, quotes, comments, one "---". The tags that Python writes for plain values
 * (!!python/tuple, !!str, !!int, !!float, ...) say nothing, nor do OpenCV's "%YAML:1.0" and !!opencv-matrix.
 * Errors: LT_EFORMAT with "path:line: reason":
 * syntax, text that is not UTF-8, anchors, aliases, merge keys, other tags, %TAG lines, a second document, a key that
 * is no scalar or comes twice, a NUL character, nesting beyond LT_YAML_DEPTH, more than LT_YAML_NODES values. LT_EIO,
 * LT_ENOMEM.
 */
LT_API lt_status lt_yaml_read(lt_arena *arena, const char *path, const lt_yaml **out);

/* lt_yaml_parse - the same from n bytes in memory; name is for the error line, and must outlive the values */
LT_API lt_status lt_yaml_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                               const lt_yaml **out);

/* lt_yaml_get - the value of key in a map; errors: v is no map, no such key; the line names both */
LT_API lt_status lt_yaml_get(const lt_yaml *v, const char *key, const lt_yaml **out);

/* lt_yaml_list - v is a list (of n, where n >= 0), or an error line */
LT_API lt_status lt_yaml_list(const lt_yaml *v, int n);

/* lt_yaml_text - the text of a scalar, borrowed */
LT_API lt_status lt_yaml_text(const lt_yaml *v, const char **out);

/* lt_yaml_int - a whole number from lo to hi */
LT_API lt_status lt_yaml_int(const lt_yaml *v, int lo, int hi, int *out);

/* lt_yaml_numbers - a list of exactly n finite numbers, or for n = 1 a scalar as well */
LT_API lt_status lt_yaml_numbers(const lt_yaml *v, double *out, int n);

#ifdef __cplusplus
}
#endif
#endif
