/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/checkpoint/folder.h"

#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char SUFFIX[] = ".safetensors";

const char *checkpoint_name(lt_arena *arena, const char *folder, int64_t step)
{
    return lt_arena_printf(arena, "%s/step-%06" PRId64 "%s", folder, step, SUFFIX);
}

const char *checkpoint_last(lt_arena *arena, const char *path)
{
    if (!lt_is_folder(path))
        return path;
    return lt_arena_printf(arena, "%s/checkpoints/last%s", path, SUFFIX);
}

/* The step that a file name says, -1 when it is not one of ours. */
static int64_t step_of(const char *name)
{
    char *end;
    long long step;

    if (strncmp(name, "step-", 5) != 0 || name[5] < '0' || name[5] > '9')
        return -1;
    step = strtoll(name + 5, &end, 10);
    return strcmp(end, SUFFIX) == 0 ? step : -1;
}

int64_t checkpoint_step(const char *path)
{
    const char *slash = strrchr(path, '/');

    return step_of(slash ? slash + 1 : path);
}

static int newest_first(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;

    return (x < y) - (x > y);
}

static lt_status scan(lt_arena *arena, const char *folder, DIR *dir, int64_t **steps, int *n)
{
    const struct dirent *e;
    size_t room = 0;

    while ((e = readdir(dir))) {
        if (step_of(e->d_name) < 0)
            continue;
        *steps = lt_arena_grow(arena, *steps, (size_t)*n, &room, sizeof(**steps));
        if (!*steps)
            return lt_error(LT_ENOMEM, "%s: no memory", folder);
        (*steps)[(*n)++] = step_of(e->d_name);
    }
    if (*n)
        qsort(*steps, (size_t)*n, sizeof(**steps), newest_first);
    return LT_OK;
}

lt_status checkpoint_list(lt_arena *arena, const char *folder, const char *const **paths, int *n)
{
    DIR *dir = opendir(folder);
    int64_t *steps = NULL;
    const char **list;
    int count = 0;
    lt_status st;

    *n = 0;
    if (!dir)
        return errno == ENOENT ? LT_OK : lt_error(lt_errno_status(errno), "%s: %s", folder, strerror(errno));
    st = scan(arena, folder, dir, &steps, &count);
    closedir(dir);
    if (st)
        return st;
    list = lt_arena_array(arena, (size_t)count, sizeof(*list));
    for (int i = 0; list && i < count; i++)
        list[i] = checkpoint_name(arena, folder, steps[i]);
    if (!list || (count && !list[count - 1]))
        return lt_error(LT_ENOMEM, "%s: no memory", folder);
    *paths = list;
    *n = count;
    return LT_OK;
}

static lt_status copy_file(lt_arena *arena, const char *from, const char *to)
{
    uint8_t *bytes;
    size_t n;
    const lt_status st = lt_read_file(arena, from, LT_FILE_MAX, &bytes, &n);

    return st ? st : lt_write_file(to, bytes, n);
}

static lt_status alias(lt_arena *arena, const char *folder, const char *name, const char *path)
{
    const char *to = lt_path_join(arena, folder, name);
    const char *temp = to ? lt_arena_printf(arena, "%s.link.tmp", to) : NULL;

    if (!temp)
        return lt_error(LT_ENOMEM, "%s/%s: no memory", folder, name);
    unlink(temp);
    if (link(path, temp) != 0)
        return copy_file(arena, path, to);
    if (rename(temp, to) != 0) {
        const int reason = errno;

        unlink(temp);
        return lt_error(LT_EIO, "%s: %s", to, strerror(reason));
    }
    unlink(temp);               /* rename does nothing when both are the same file already */
    return LT_OK;
}

lt_status checkpoint_alias(const char *folder, const char *name, const char *path)
{
    lt_arena *arena = lt_arena_new();
    const lt_status st = arena ? alias(arena, folder, name, path)
                               : lt_error(LT_ENOMEM, "%s/%s: no memory", folder, name);

    lt_arena_free(arena);
    return st;
}

static void remove_leftovers(lt_arena *arena, const char *folder)
{
    DIR *dir = opendir(folder);
    const struct dirent *e;

    while (dir && (e = readdir(dir))) {
        const char *path = lt_ends_with(e->d_name, ".tmp") && strstr(e->d_name, SUFFIX)
            ? lt_path_join(arena, folder, e->d_name) : NULL;

        if (path)
            unlink(path);
    }
    if (dir)
        closedir(dir);
}

lt_status checkpoint_prune(const char *folder, int64_t step, int keep)
{
    lt_arena *arena = lt_arena_new();
    const char *const *paths = NULL;
    int n = 0;
    lt_status st = arena ? checkpoint_list(arena, folder, &paths, &n)
                         : lt_error(LT_ENOMEM, "%s: no memory", folder);

    for (int i = 0; st == LT_OK && i < n; i++)
        if (checkpoint_step(paths[i]) <= step && keep-- <= 0 && unlink(paths[i]) != 0 && errno != ENOENT)
            st = lt_error(lt_errno_status(errno), "%s: %s", paths[i], strerror(errno));
    if (st == LT_OK)
        remove_leftovers(arena, folder);
    lt_arena_free(arena);
    return st;
}
