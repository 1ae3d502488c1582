/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A run as one HTML page that needs nothing else: no network, no library, no file beside it.
 */
#ifndef EVAL_REPORT_REPORT_H
#define EVAL_REPORT_REPORT_H

#include "estimate/posed/posed.h"
#include "libtensor/base/status.h"

/* Frames of a model of Gaussians, for a view that turns: held as the page will hold them */
typedef struct report_view report_view;

/* report_view_new - without frames; NULL without memory. */
report_view *report_view_new(void);
void report_view_free(report_view *v);

/**
 * report_view_add - one more frame: its Gaussians in 24 bytes each, a picture of the truth beside the rendering
 *
 *   surface  with the surfaces of both parts, by the mean rule at 0.6; a part that has none is left without
 *
 * Errors: LT_ENOMEM, those of the surfaces but for LT_EINVAL.
 */
lt_status report_view_add(report_view *v, const posed_frame *f, bool surface);

/**
 * report_write - the page of a run's folder
 *
 *   run      what palmar train made, and palmar eval scored, or has not yet: what is missing is said on the page
 *   path     written atomically
 *   view     drawn by a script of the page's own with WebGL 2, still pictures where there is none; NULL: no view and
 *            no script
 *
 * Tables with the paper's rows above ours and their protocol, curves, errors of the samples, pictures, machine,
 * configuration, skipped steps. Whatever comes from files is escaped: names and messages are text, never markup.
 * Errors: LT_EIO, LT_EFORMAT: no run is there; a file of it is damaged, but for a torn last line of the log.
 */
lt_status report_write(const char *run, const char *path, const report_view *view);

#endif
