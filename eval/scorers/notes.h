/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is to be said beside a file's scores: what of it was passed over, counted as a miss, or looks like a slip.
 */
#ifndef EVAL_SCORERS_NOTES_H
#define EVAL_SCORERS_NOTES_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { EVAL_NOTES = 8, EVAL_NOTE_TEXT = 480 };

typedef struct {
    int n;
    struct { const char *code; char text[EVAL_NOTE_TEXT]; } note[EVAL_NOTES];      /* code: docs/formats.md, Notes */
} eval_notes;

/* eval_note - one more, printable; what is beyond EVAL_NOTES, or notes is NULL, is dropped */
void eval_note(eval_notes *notes, const char *code, const char *fmt, ...) LT_PRINTF(3, 4);

#ifdef __cplusplus
}
#endif
#endif
