/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A run as one HTML page that needs nothing else: no network, no script, no file beside it.
 */
#ifndef EVAL_REPORT_REPORT_H
#define EVAL_REPORT_REPORT_H

#include "libtensor/base/status.h"

/**
 * report_write - the page of a run's folder
 *
 *   run      what palmar train made, and palmar eval scored, or has not yet: what is missing is said on the page
 *   path     written atomically
 *
 * Tables with the paper's rows above ours and their protocol, curves, errors of the samples, pictures, machine,
 * configuration, skipped steps. Whatever comes from files is escaped: names and messages are text, never markup.
 * Errors: LT_EIO, LT_EFORMAT: no run is there; a file of it is damaged, but for a torn last line of the log.
 */
lt_status report_write(const char *run, const char *path);

#endif
