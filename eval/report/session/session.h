/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What palmar watch saw in a session, as one HTML page that needs nothing else.
 */
#ifndef EVAL_REPORT_SESSION_SESSION_H
#define EVAL_REPORT_SESSION_SESSION_H

#include "libtensor/base/status.h"

/**
 * session_report_write - the page of a recording's folder
 *
 *   root     a recording that was watched: with session.ndjson, and, of a synthetic world, truth.ndjson
 *   path     written atomically
 *
 * Who did what and when, with the truth beside it where it is known, and how often the two agree; what touched what;
 * whose number was seen when; ages of the answers, times of the stages, drops; some sets of frames with what was found
 * drawn over them, of which a script of the page's own shows one at a time. Whatever comes from files is text, never
 * markup.
 *
 * Errors: LT_EFORMAT with file and line: no line of a session, a key with something else in it than belongs there; a
 * torn last line is left out. Those of recording_open; LT_EIO, LT_ENOMEM.
 */
lt_status session_report_write(const char *root, const char *path);

#endif
