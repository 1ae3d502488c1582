/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Whole files, folders and paths.
 */
#ifndef LT_IO_FILE_H
#define LT_IO_FILE_H

#include "libtensor/base/arena.h"
#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LT_FILE_MAX ((size_t)8 << 30)       /* bytes; no reader takes a larger file */

/**
 * lt_read_file - all bytes of a regular file
 *
 *   max_bytes    a larger file is refused before anything is allocated; LT_FILE_MAX when in doubt
 *   bytes, n     owned by arena; a NUL that n does not count follows the last byte
 *
 * Folders, pipes, sockets and devices are refused: they have no size to check.
 * Errors: LT_EIO (cannot open, not a regular file, changed while being read), LT_EFORMAT (too large),
 * LT_ENOMEM. The line names path.
 */
LT_API lt_status lt_read_file(lt_arena *arena, const char *path, size_t max_bytes, uint8_t **bytes,
                              size_t *n);

/* A file's bytes, and the memory that holds them; a reader may use it as scratch too. */
typedef struct {
    lt_arena *memory;
    uint8_t *bytes;
    size_t n;
} lt_file;

/* lt_file_load - lt_read_file into memory of the file's own; lt_file_free after it, also after an error */
LT_API lt_status lt_file_load(lt_file *f, const char *path, size_t max_bytes);
LT_API void lt_file_free(lt_file *f);

/* lt_is_folder - whether path is a folder, or a link to one; false also where that cannot be found out */
LT_API bool lt_is_folder(const char *path);

/* lt_make_dirs - make folder path and those above it; one that is there already is fine */
LT_API lt_status lt_make_dirs(const char *path);

/* lt_check_own - whether what stands at path is itself there: no link to another place, no pipe, socket or device;
 * LT_EIO. Nothing may stand there. For what is written inside a folder that somebody else may have prepared. */
LT_API lt_status lt_check_own(const char *path);

/* lt_make_own_folder - lt_make_dirs, where path itself may be no link. lt_append_own - a stream behind the end of a
 * regular file, made if need be, that is no link. Errors: LT_EIO, LT_ENOSPC, LT_ENOMEM. */
LT_API lt_status lt_make_own_folder(const char *path);
LT_API lt_status lt_append_own(const char *path, FILE **out);

/* lt_path_join - "folder/name" in the arena; name alone when folder is "" or name is absolute; NULL
 * when there is no memory */
LT_API char *lt_path_join(lt_arena *arena, const char *folder, const char *name);

/* lt_is_terminal - whether fd is a terminal that can draw a line again: TERM=dumb cannot */
LT_API bool lt_is_terminal(int fd);

/* lt_ends_with - of a path or name: whether it has this ending */
LT_API bool lt_ends_with(const char *text, const char *end);

/* lt_path_folder - what stands before the last '/' of path, "." when there is none; in the arena */
LT_API char *lt_path_folder(lt_arena *arena, const char *path);

/* lt_path_whole - the path from the root, which says the same in any folder; what is not there stays as it is. In the
 * arena, NULL without memory */
LT_API char *lt_path_whole(lt_arena *arena, const char *path);

/**
 * lt_path_is_inside - may a name that was read from a file be joined to a trusted folder?
 *
 * False for empty and absolute names, drive letters, backslashes and any ".." part. Says nothing about
 * symbolic links.
 */
LT_API bool lt_path_is_inside(const char *name);

/**
 * lt_program_folder - where the running program lies, into out; false where the system does not say
 * lt_installed      - where the folder is that configure named, into out: with the program, if both were moved
 *                     together, as a package that is unpacked elsewhere is; else as it was named
 */
LT_API bool lt_program_folder(char *out, size_t n);
LT_API void lt_installed(const char *folder, char *out, size_t n);

#ifdef __cplusplus
}
#endif
#endif
