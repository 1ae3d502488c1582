/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Write beside, sync, rename, sync the folder. Whoever looks at path sees the old file or the new one.
 */
#include "libtensor/io/atomic_file.h"

#include "libtensor/io/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NAME_TRIES = 100, MOST_OPEN = 64 };

/* Names of temporary files, for lt_atomic_unlink_all; those beyond MOST_OPEN are not remembered. */
static _Atomic(char *) open_name[MOST_OPEN];

static void remember(char *temp)
{
    for (int i = 0; i < MOST_OPEN; i++) {
        char *none = NULL;

        if (atomic_compare_exchange_strong(&open_name[i], &none, temp))
            return;
    }
}

static void forget(char *temp)
{
    for (int i = 0; temp && i < MOST_OPEN; i++) {
        char *it = temp;

        if (atomic_compare_exchange_strong(&open_name[i], &it, NULL))
            return;
    }
}

void lt_atomic_unlink_all(void)
{
    for (int i = 0; i < MOST_OPEN; i++) {
        const char *temp = atomic_load(&open_name[i]);

        if (temp)
            unlink(temp);
    }
}

/* "NAME.PID-N.tmp" or "NAME.PID-N.tmp.ENDING", as open_temp calls them; the process, or 0 */
static long owner_of(const char *name)
{
    const char *mark = NULL, *dash, *dot;
    char *end;
    long pid;

    for (const char *p = name; (p = strstr(p, ".tmp")); p++)
        mark = p[4] == '\0' || p[4] == '.' ? p : mark;
    if (!mark || mark - name < 4)
        return 0;
    for (dash = mark - 1; dash > name && *dash >= '0' && *dash <= '9'; dash--)
        ;
    for (dot = dash - 1; *dash == '-' && dot > name && *dot >= '0' && *dot <= '9'; dot--)
        ;
    if (*dash != '-' || *dot != '.' || dot + 1 == dash || dash + 1 == mark)
        return 0;
    pid = strtol(dot + 1, &end, 10);
    return end == dash ? pid : 0;
}

void lt_atomic_sweep(const char *folder)
{
    DIR *dir = opendir(folder);
    const struct dirent *e;

    while (dir && (e = readdir(dir))) {
        const long pid = owner_of(e->d_name);

        if (pid > 0 && kill((pid_t)pid, 0) != 0 && errno == ESRCH)
            unlinkat(dirfd(dir), e->d_name, 0);
    }
    if (dir)
        closedir(dir);
}

static lt_status system_error(const char *path, const char *doing, int error)
{
    return lt_error(error == ENAMETOOLONG ? LT_EINVAL : lt_errno_status(error), "%s: cannot %s: %s", path, doing,
                    strerror(error));
}

/* Not mkstemp: its files are private, ours have the permissions that open(2) gives under the umask. */
static int open_temp(const char *path, const char *ending, char **temp)
{
    static atomic_uint counter;
    const size_t size = strlen(path) + strlen(ending) + 48;
    int fd = -1;

    *temp = malloc(size);
    for (int i = 0; *temp && fd < 0 && i < NAME_TRIES; i++) {
        snprintf(*temp, size, "%s.%ld-%u.tmp%s", path, (long)getpid(), atomic_fetch_add(&counter, 1), ending);
        fd = open(*temp, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd < 0 && errno != EEXIST)
            break;
    }
    if (fd >= 0)
        remember(*temp);
    return fd;
}

/* The file is ours, so who refuses is a file system without permission bits, and then the old file has none either. */
static bool keep_mode(int fd, mode_t mode)
{
    return fchmod(fd, mode & 07777) == 0 || errno == EPERM || errno == ENOSYS || errno == EOPNOTSUPP;
}

static lt_status open_ending(lt_atomic_file *f, const char *path, const char *ending)
{
    struct stat old;
    const bool exists = stat(path, &old) == 0;
    int fd, error;

    memset(f, 0, sizeof(*f));
    if (exists && !S_ISREG(old.st_mode))
        return lt_error(LT_EIO, "%s: cannot write: it exists and is not a regular file", path);
    fd = open_temp(path, ending, &f->temp);
    if (fd >= 0) {
        f->stream = fdopen(fd, "wb");
        f->path = strdup(path);
    }
    if (f->stream && f->path && (!exists || keep_mode(fd, old.st_mode)))
        return LT_OK;
    error = errno;
    if (fd >= 0 && !f->stream) {
        close(fd);
        unlink(f->temp);
    }
    lt_atomic_abort(f);
    return system_error(path, "write", error);
}

lt_status lt_atomic_open(lt_atomic_file *f, const char *path)
{
    return open_ending(f, path, "");
}

lt_status lt_atomic_open_named(lt_atomic_file *f, const char *path)
{
    const char *slash = strrchr(path, '/'), *ending = strrchr(slash ? slash : path, '.');

    return open_ending(f, path, ending ? ending : "");
}

static void release(lt_atomic_file *f)
{
    forget(f->temp);
    free(f->path);
    free(f->temp);
    memset(f, 0, sizeof(*f));
}

void lt_atomic_abort(lt_atomic_file *f)
{
    if (f->stream) {
        fclose(f->stream);
        unlink(f->temp);
    }
    release(f);
}

/* The stream remembers that a write failed but not why: ask the file once more. */
static int write_error(FILE *stream)
{
    if (fflush(stream) == 0 && !ferror(stream))
        return 0;
    errno = 0;
    if (write(fileno(stream), "", 1) == 1 || errno == 0)
        return EIO;
    return errno;
}

static int sync_folder(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *folder = !slash ? strdup(".") : strndup(path, slash == path ? 1 : (size_t)(slash - path));
    const int fd = folder ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    int error = fd < 0 || fsync(fd) != 0 ? errno : 0;

    if (fd >= 0)
        close(fd);
    free(folder);
    return error == EINVAL || error == EACCES ? 0 : error;      /* no such thing there; a folder to write to only */
}

lt_status lt_atomic_commit(lt_atomic_file *f)
{
    lt_status st = LT_OK;
    int error = write_error(f->stream);

    if (!error && fsync(fileno(f->stream)) != 0)
        error = errno;
    if (fclose(f->stream) != 0 && !error)
        error = errno;
    f->stream = NULL;
    if (error)
        st = system_error(f->path, "write", error);
    else if (rename(f->temp, f->path) != 0)
        st = system_error(f->path, "rename the finished file to it", errno);
    if (st)
        unlink(f->temp);
    else if ((error = sync_folder(f->path)) != 0)
        st = system_error(f->path, "sync its folder", error);
    release(f);
    return st;
}

lt_status lt_write_file(const char *path, const void *bytes, size_t n)
{
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    if (n)
        fwrite(bytes, 1, n, f.stream);
    return lt_atomic_commit(&f);
}
