/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The text of a file of points, from a file of its own or out of a zip archive.
 */
#ifndef DATA_HO3D_POINTS_TEXT_H
#define DATA_HO3D_POINTS_TEXT_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

typedef struct points_text points_text;

/* points_text_open - a text, or of an archive its pred.json, wherever it lies, else its only JSON file. Errors:
 * LT_EIO, LT_ENOMEM; LT_EFORMAT for an archive that is damaged, has no such file or several, and for other kinds of
 * files. */
lt_status points_text_open(const char *path, points_text **out);

/* points_text_read - up to room bytes; *n is 0 at the end. A byte order mark is left out. */
lt_status points_text_read(points_text *t, char *bytes, size_t room, size_t *n);

/* points_text_note - which file of an archive is read, where it is not pred.json at the top; else NULL */
const char *points_text_note(const points_text *t);

void points_text_close(points_text *t);             /* NULL is fine */

#endif
