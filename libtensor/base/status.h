/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Errors of the world outside: files, options, memory. A function that can meet one returns an
 * lt_status and leaves one line for people in lt_last_error().
 */
#ifndef LT_BASE_STATUS_H
#define LT_BASE_STATUS_H

#include "libtensor/base/common.h"

#include <stdarg.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LT_OK = 0,
    LT_EINVAL,          /* an argument or option that cannot be */
    LT_EIO,             /* the system refused: open, read, write, rename */
    LT_EFORMAT,         /* a file is not what it should be */
    LT_ESHAPE,          /* tensors that do not fit together */
    LT_ENOMEM,          /* no memory */
    LT_ENOSPC,          /* no room on the disk */
    LT_ENUMERIC,        /* not a number, or infinite, too many times in a row */
    LT_ESTOPPED,        /* asked to stop by a signal, after saving */
    LT_EUSAGE,          /* the words of a command are wrong, not what they name */
} lt_status;

/**
 * lt_error - remember one line that says what went wrong, and return the status
 *
 * The line should say who, what, found against expected, and where, without a full stop:
 *
 *     return lt_error(LT_EFORMAT, "%s: ends early, header promises %zu bytes", path, n);
 *
 * The text is kept per thread, cut at 1023 bytes; what could steer a terminal is replaced by '?'.
 */
LT_API lt_status lt_error(lt_status status, const char *fmt, ...) LT_PRINTF(2, 3);
LT_API lt_status lt_verror(lt_status status, const char *fmt, va_list args);

/* lt_errno_status - what an errno is to us: LT_ENOSPC where the disk or a quota is full, LT_ENOMEM without memory or
 * descriptors, else LT_EIO */
LT_API lt_status lt_errno_status(int error);

/* lt_decoder_status - why a library that decodes failed, which has several names for memory that it did not get: error
 * is errno, which was 0 before; LT_ENOMEM or LT_EFORMAT */
LT_API lt_status lt_decoder_status(int error);

/* lt_error_prefix - put "prefix: " before the remembered line; returns status, for use in a return */
LT_API lt_status lt_error_prefix(lt_status status, const char *fmt, ...) LT_PRINTF(2, 3);

/* lt_last_error - the last line remembered on this thread; "" when there is none. Valid until the
 * next lt_error on this thread. */
LT_API const char *lt_last_error(void);

/* lt_last_status - the status that the last line was remembered with, for what returns NULL instead of one */
LT_API lt_status lt_last_status(void);

/* What a piece of work came to, carried from the thread that did it to the one that tells of it: lt_last_error is of a
 * thread alone. */
typedef struct {
    lt_status status;
    char line[1024];
} lt_outcome;

/* lt_outcome_keep - st, and where it is an error the line of this thread */
LT_API void lt_outcome_keep(lt_outcome *o, lt_status st);

/* lt_outcome_tell - the status, and where it is an error its line as one of this thread; for use in a return */
LT_API lt_status lt_outcome_tell(const lt_outcome *o);

#ifdef __cplusplus
}
#endif
#endif
