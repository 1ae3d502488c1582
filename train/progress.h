/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tells people how far a run is: a line that is drawn over on a terminal, a plain line every ten seconds
 * elsewhere. What it notes is kept in the run's folder as well, for whoever was not looking.
 */
#ifndef TRAIN_PROGRESS_H
#define TRAIN_PROGRESS_H

#include "train/log.h"

typedef struct {
    FILE *f;
    bool quiet;                     /* notes of trouble only */
    bool terminal, colour;
    bool drawn;                     /* a line without its end stands there */
    double last;                    /* when the last one was drawn, seconds */
    FILE *log;                      /* all notes with their time: memory, then a file; NULL: kept nowhere */
    char *said;                     /* that memory; the struct must not move */
    size_t said_bytes;
} train_progress;

/* What the line needs beside the step's own record. */
typedef struct {
    int64_t epochs, step_of_epoch, steps_of_epoch;
    double eta_seconds;
    int64_t skipped;
} train_progress_state;

/* progress_init - f is stderr but in tests; colour only on a terminal and without NO_COLOR. End with progress_fini. */
void progress_init(train_progress *p, FILE *f, bool quiet);

/* progress_step - draw when it is time; now: drawn whatever the time, as at the end */
void progress_step(train_progress *p, const train_step_record *r, const train_progress_state *s, bool now);

/* progress_note - a line of its own, not when quiet; progress_warn - also when quiet */
void progress_note(train_progress *p, const char *fmt, ...) LT_PRINTF(2, 3);
void progress_warn(train_progress *p, const char *fmt, ...) LT_PRINTF(2, 3);

/* progress_keep - append what was noted so far to the file at path, and then every note. LT_EIO */
lt_status progress_keep(train_progress *p, const char *path);

/* progress_log - a note for that file alone */
void progress_log(train_progress *p, const char *fmt, ...) LT_PRINTF(2, 3);

/* progress_fini - finish the line that stands there */
void progress_fini(train_progress *p);

#endif
