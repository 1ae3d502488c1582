/* SPDX-License-Identifier: Apache-2.0 */
/* Lines to whoever watches. */
#include "pipeline/internal.h"

#include <stdarg.h>
#include <stdio.h>

void predict_say(const predict_options *o, const char *fmt, ...)
{
    char line[1024];
    va_list args;

    if (!o->messages)
        return;
    va_start(args, fmt);
    vsnprintf(line, sizeof(line), fmt, args);
    va_end(args);
    for (char *p = line; *p; p++)
        if ((unsigned char)*p < ' ' || *p == 127)
            *p = '?';
    fprintf(o->messages, "%s\n", line);
}
