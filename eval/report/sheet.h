/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs beside each other: the same frames as each of them draws them, in one HTML page that needs nothing else.
 */
#ifndef EVAL_REPORT_SHEET_H
#define EVAL_REPORT_SHEET_H

#include "estimate/posed/posed.h"

typedef struct report_sheet report_sheet;

/* report_sheet_new - of n_frames frames, with their surfaces or without; NULL without memory */
report_sheet *report_sheet_new(int n_frames, bool surfaces);
void report_sheet_free(report_sheet *s);

/* report_sheet_run - one more column, of a run's folder: named as the paper's tables name its variant. Errors: no
 * config.json.  report_sheet_add - the last run's next frame; n_frames of them, as the first run has them. Errors:
 * another frame or another picture than the first run has there (but for jittered colours); LT_ENOMEM; surfaces'. */
lt_status report_sheet_run(report_sheet *s, const char *run);
lt_status report_sheet_add(report_sheet *s, const posed_frame *f);

/* report_sheet_write - truth, then each run, a line for each frame; below each its PSNR. Atomically. */
lt_status report_sheet_write(const report_sheet *s, const char *path);

#endif
