/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/scorers/notes.h"

#include "libtensor/base/printable.h"

#include <stdarg.h>
#include <stdio.h>

void eval_note(eval_notes *notes, const char *code, const char *fmt, ...)
{
    va_list args;

    if (!notes || notes->n == EVAL_NOTES)
        return;
    va_start(args, fmt);
    vsnprintf(notes->note[notes->n].text, EVAL_NOTE_TEXT, fmt, args);
    va_end(args);
    lt_printable(notes->note[notes->n].text);
    notes->note[notes->n++].code = code;
}
