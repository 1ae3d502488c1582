/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Whole files, folders and paths.
 */
#include "libtensor/io/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

static lt_status read_all(int fd, const char *path, uint8_t *bytes, size_t n)
{
    size_t done = 0;

    while (done < n) {
        const ssize_t got = read(fd, bytes + done, n - done);

        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return lt_error(lt_errno_status(errno), "%s: %s", path, strerror(errno));
        if (got == 0)
            return lt_error(LT_EIO, "%s: became shorter while being read", path);
        done += (size_t)got;
    }
    return LT_OK;
}

static lt_status check_size(const char *path, const struct stat *info, size_t max_bytes)
{
    if (!S_ISREG(info->st_mode))
        return lt_error(LT_EIO, "%s: not a regular file", path);
    if ((uintmax_t)info->st_size > max_bytes)
        return lt_error(LT_EFORMAT, "%s: %jd bytes, more than the %zu that are read", path,
                        (intmax_t)info->st_size, max_bytes);
    return LT_OK;
}

lt_status lt_read_file(lt_arena *arena, const char *path, size_t max_bytes, uint8_t **bytes, size_t *n)
{
    /* O_NONBLOCK: opening a pipe must not wait for somebody to write into it */
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat info;
    void *data;
    lt_status st;

    if (fd < 0 || fstat(fd, &info) != 0) {
        st = lt_error(lt_errno_status(errno), "%s: %s", path, strerror(errno));
        goto done;
    }
    st = check_size(path, &info, max_bytes);
    if (st)
        goto done;
    st = lt_arena_try(arena, (size_t)info.st_size + 1, &data);
    if (st) {
        st = lt_error_prefix(st, "%s", path);
        goto done;
    }
    st = read_all(fd, path, data, (size_t)info.st_size);
    if (st)
        goto done;
    *bytes = data;
    *n = (size_t)info.st_size;
done:
    if (fd >= 0)
        close(fd);
    return st;
}

lt_status lt_file_load(lt_file *f, const char *path, size_t max_bytes)
{
    *f = (lt_file){ .memory = lt_arena_new() };
    return f->memory ? lt_read_file(f->memory, path, max_bytes, &f->bytes, &f->n)
                     : lt_error(LT_ENOMEM, "%s: no memory", path);
}

void lt_file_free(lt_file *f)
{
    lt_arena_free(f->memory);
}

bool lt_is_folder(const char *path)
{
    struct stat info;

    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

static lt_status make_dir(const char *path)
{
    int error;

    if (mkdir(path, 0777) == 0)
        return LT_OK;
    error = errno;
    if (lt_is_folder(path))                /* EEXIST, but also EROFS or EACCES high up in the path */
        return LT_OK;
    if (error == EEXIST)
        error = ENOTDIR;
    return lt_error(lt_errno_status(error), "%s: cannot make folder: %s", path, strerror(error));
}

lt_status lt_make_dirs(const char *path)
{
    char part[4096];
    const size_t n = strlen(path);

    if (n == 0 || n >= sizeof(part))
        return lt_error(LT_EINVAL, "folder name of %zu bytes, want 1 to %zu", n, sizeof(part) - 1);
    memcpy(part, path, n + 1);
    for (size_t i = 1; i < n; i++) {
        lt_status st;

        if (part[i] != '/')
            continue;
        part[i] = '\0';
        st = make_dir(part);
        part[i] = '/';
        if (st)
            return st;
    }
    return make_dir(part);
}

lt_status lt_check_own(const char *path)
{
    struct stat info;

    if (lstat(path, &info) != 0 || S_ISREG(info.st_mode) || S_ISDIR(info.st_mode))
        return LT_OK;
    return lt_error(LT_EIO, "%s: %s, want a file or folder that is there itself; remove it", path,
                    S_ISLNK(info.st_mode) ? "a link to another place" : "a pipe, socket or device");
}

lt_status lt_make_own_folder(const char *path)
{
    const lt_status st = lt_check_own(path);

    return st ? st : lt_make_dirs(path);
}

/* O_NONBLOCK: a pipe must not wait for a reader */
lt_status lt_append_own(const char *path, FILE **out)
{
    const int fd = open(path, O_WRONLY | O_APPEND | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
    struct stat info;
    lt_status st;

    if (fd < 0) {
        const int error = errno;

        st = lt_check_own(path);
        return st ? st : lt_error(lt_errno_status(error), "%s: %s", path, strerror(error));
    }
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        close(fd);
        return lt_error(LT_EIO, "%s: not a regular file", path);
    }
    *out = fdopen(fd, "ab");
    if (*out)
        return LT_OK;
    st = lt_error(lt_errno_status(errno), "%s: %s", path, strerror(errno));
    close(fd);
    return st;
}

char *lt_path_join(lt_arena *arena, const char *folder, const char *name)
{
    const size_t n = strlen(folder);

    if (n == 0 || name[0] == '/')
        return lt_arena_strdup(arena, name);
    return lt_arena_printf(arena, "%s%s%s", folder, folder[n - 1] == '/' ? "" : "/", name);
}

bool lt_ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), m = strlen(end);

    return n >= m && strcmp(text + n - m, end) == 0;
}

char *lt_path_folder(lt_arena *arena, const char *path)
{
    const char *slash = strrchr(path, '/');

    if (!slash)
        return lt_arena_strdup(arena, ".");
    if (slash == path)
        return lt_arena_strdup(arena, "/");
    return lt_arena_printf(arena, "%.*s", (int)(slash - path), path);
}

char *lt_path_whole(lt_arena *arena, const char *path)
{
    char *whole = realpath(path, NULL);
    char *kept = lt_arena_strdup(arena, whole ? whole : path);

    free(whole);
    return kept;
}

bool lt_path_is_inside(const char *name)
{
    const char *p = name;

    if (name[0] == '\0' || name[0] == '/' || strchr(name, '\\') || name[1] == ':')
        return false;
    while (*p) {
        const size_t n = strcspn(p, "/");

        if (n == 2 && p[0] == '.' && p[1] == '.')
            return false;
        p += n;
        p += *p == '/';
    }
    return true;
}

bool lt_is_terminal(int fd)
{
    const char *term = getenv("TERM");

    return isatty(fd) && term && strcmp(term, "dumb") != 0;
}

/* ---- what was installed ------------------------------------------------------------------------------------------ */

bool lt_program_folder(char *out, size_t n)
{
    const ssize_t length = readlink("/proc/self/exe", out, n - 1);
    char *slash;

    out[length > 0 ? length : 0] = '\0';
    slash = strrchr(out, '/');
    if (slash)
        *slash = '\0';
    return slash != NULL;
}

/* How much of two paths is the same folders */
static size_t common_folders(const char *a, const char *b)
{
    size_t same = 0;

    for (size_t i = 0; a[i] && a[i] == b[i]; i++)
        if (a[i] == '/')
            same = i + 1;
    return same;
}

void lt_installed(const char *folder, char *out, size_t n)
{
    static const char programs[] = PALMAR_BINDIR;
    const size_t common = common_folders(programs, folder), rest = strlen(programs + common);
    size_t length;

    if (lt_program_folder(out, n)) {
        length = strlen(out);
        if (common && length > rest && out[length - rest - 1] == '/'
            && strcmp(out + length - rest, programs + common) == 0 && length - rest + strlen(folder + common) < n) {
            strcpy(out + length - rest, folder + common);
            if (lt_is_folder(out))
                return;
        }
    }
    snprintf(out, n, "%s", folder);
}
