/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A zip archive of one file, packed while it is written: for text too long to be held in memory.
 */
#ifndef EVAL_SCORERS_ZIP_ENTRY_H
#define EVAL_SCORERS_ZIP_ENTRY_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct zip_entry zip_entry;

/* zip_entry_new - begin an archive at the start of f, which can seek and stays the caller's.
 * The entry is called name, deflated, and dated 1980-01-01 so that the same bytes give the same
 * archive. Errors: LT_ENOMEM. */
lt_status zip_entry_new(FILE *f, const char *name, zip_entry **out);

/* zip_entry_write - n more bytes; a write error of f is sticky and the caller's to find */
void zip_entry_write(zip_entry *z, const void *bytes, size_t n);

/* zip_entry_finish - end the archive and free z. LT_EINVAL when the entry grew past 4 GiB. */
lt_status zip_entry_finish(zip_entry *z);

/* zip_entry_free - give up; what f holds is no archive */
void zip_entry_free(zip_entry *z);

#ifdef __cplusplus
}
#endif
#endif
