/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Names that people mistype: "did you mean".
 */
#ifndef LT_IO_TEXT_NEAREST_H
#define LT_IO_TEXT_NEAREST_H

#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_nearest_name - the name in list that was probably meant, or NULL when none is near
 *
 *   list     n names; borrowed, as is the result
 *
 * Nearest by edits (insert, delete, replace, swap neighbours), at most a third of the name's length and
 * at least 2; the first of equals wins.
 */
LT_API const char *lt_nearest_name(const char *name, const char *const *list, size_t n);

/**
 * lt_unknown_name - LT_EINVAL, with what is wrong and the name that was probably meant
 *
 *   list        n names, among which name is not
 *   otherwise   what to say when none is near: "there are: a, b"; NULL: that the first name was meant, n > 0
 *   fmt         what is wrong: `no such model "hokat"`
 *
 * The line is `no such model "hokat"; did you mean "hocat"?`, or `no such model "x"; there are: a, b`.
 */
LT_API lt_status lt_unknown_name(const char *name, const char *const *list, size_t n, const char *otherwise,
                                 const char *fmt, ...) LT_PRINTF(5, 6);

#ifdef __cplusplus
}
#endif
#endif
