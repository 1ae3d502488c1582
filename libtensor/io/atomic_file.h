/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Files that are either all there or not touched: written beside, synced, then renamed.
 */
#ifndef LT_IO_ATOMIC_FILE_H
#define LT_IO_ATOMIC_FILE_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A file being written. Write to stream; all else belongs to the functions below. */
typedef struct {
    FILE *stream;
    char *path, *temp;              /* the name to be, and the name until then, in the same folder */
} lt_atomic_file;

/**
 * lt_atomic_open - begin to write what will be path
 *
 *   f        filled on success; ends in lt_atomic_commit or lt_atomic_abort, exactly one of them
 *
 * The data goes to "path.PROCESS-NUMBER.tmp" in the same folder, which must exist (lt_make_dirs). A file that
 * is already at path keeps its contents until the commit, and its permission bits after it, where there are any.
 *
 * Errors: LT_EIO (no such folder, not writable, path is a folder), LT_EINVAL (a name that is too long), LT_ENOSPC,
 * LT_ENOMEM.
 */
LT_API lt_status lt_atomic_open(lt_atomic_file *f, const char *path);

/* lt_atomic_open_named - the same for a library that writes a file by its name and judges by its ending: f->temp, which
 * ends as path does, "path.PROCESS-NUMBER.tmp.mp4". Nothing is written to the stream. */
LT_API lt_status lt_atomic_open_named(lt_atomic_file *f, const char *path);

/**
 * lt_atomic_commit - flush, sync to the disk, rename to path, sync the folder if it may be read
 *
 * Write errors of the stream are sticky and are found here, so a writer need not check every fprintf.
 * When anything up to the rename fails, the temporary file is removed and path is as it was.
 *
 * Errors: LT_ENOSPC (disk or quota full), LT_EIO; the line names path.
 */
LT_API lt_status lt_atomic_commit(lt_atomic_file *f);

/* lt_atomic_abort - close and remove the temporary file; path is as it was; fine after a failed open */
LT_API void lt_atomic_abort(lt_atomic_file *f);

/* lt_atomic_unlink_all - remove the temporary files that are open; for a handler of a signal that ends the process */
LT_API void lt_atomic_unlink_all(void);

/* lt_atomic_sweep - remove from a folder what processes that are no more, killed ones, left half written there */
LT_API void lt_atomic_sweep(const char *folder);

/* lt_write_file - n bytes as the whole of path, atomically; errors as lt_atomic_open and _commit */
LT_API lt_status lt_write_file(const char *path, const void *bytes, size_t n);

#ifdef __cplusplus
}
#endif
#endif
