/* SPDX-License-Identifier: Apache-2.0 */
/* Lines to whoever watches. */
#include "pipeline/internal.h"

#include "libtensor/base/printable.h"

#include <stdarg.h>

void predict_say(const predict_options *o, const char *fmt, ...)
{
    va_list args;

    if (!o->messages)
        return;
    va_start(args, fmt);
    lt_vsay(o->messages, fmt, args);
    va_end(args);
}
