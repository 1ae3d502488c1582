/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/base/status.h"

#include "libtensor/base/printable.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

enum { LINE_MAX_BYTES = 1024 };

static _Thread_local char last_error[LINE_MAX_BYTES];
static _Thread_local lt_status last_status;

lt_status lt_verror(lt_status status, const char *fmt, va_list args)
{
    char line[LINE_MAX_BYTES];      /* the arguments may point into last_error */

    vsnprintf(line, sizeof(line), fmt, args);
    lt_printable(line);
    memcpy(last_error, line, sizeof(line));
    return last_status = status;
}

lt_status lt_error(lt_status status, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    lt_verror(status, fmt, args);
    va_end(args);
    return status;
}

lt_status lt_errno_status(int error)
{
    switch (error) {
    case ENOSPC: case EDQUOT: case EFBIG:
        return LT_ENOSPC;
    case ENOMEM: case EMFILE: case ENFILE:
        return LT_ENOMEM;
    default:
        return LT_EIO;
    }
}

lt_status lt_decoder_status(int error)
{
    return error == ENOMEM ? LT_ENOMEM : LT_EFORMAT;
}

lt_status lt_error_prefix(lt_status status, const char *fmt, ...)
{
    char prefix[LINE_MAX_BYTES / 2];
    va_list args;

    va_start(args, fmt);
    vsnprintf(prefix, sizeof(prefix), fmt, args);
    va_end(args);
    return lt_error(status, "%s: %s", prefix, last_error);
}

const char *lt_last_error(void)
{
    return last_error;
}

lt_status lt_last_status(void)
{
    return last_status;
}

void lt_outcome_keep(lt_outcome *o, lt_status st)
{
    o->status = st;
    snprintf(o->line, sizeof(o->line), "%s", st ? last_error : "");
}

lt_status lt_outcome_tell(const lt_outcome *o)
{
    return o->status ? lt_error(o->status, "%s", o->line) : LT_OK;
}
