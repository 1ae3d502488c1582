/* SPDX-License-Identifier: Apache-2.0 */
/* Frames by name: "ABF12/0123", ".../train/ABF12/rgb/0123.jpg", "20200709-subject-01/.../labels_000012.npz". */
#include "data/poses/internal.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int by_name(const void *a, const void *b)
{
    return strcmp(((const frame_name *)a)->name, ((const frame_name *)b)->name);
}

lt_status frame_names_make(lt_arena *arena, const dataset *d, frame_names *out)
{
    *out = (frame_names){ NULL, 0 };
    if (!d || !d->count)
        return LT_OK;
    out->frame = lt_arena_array(arena, (size_t)d->count, sizeof(*out->frame));
    if (!out->frame)
        return lt_error(LT_ENOMEM, "%s: no memory for the names of %lld frames", d->root, (long long)d->count);
    for (int64_t i = 0; i < d->count; i++)
        out->frame[out->n++] = (frame_name){ dataset_name(d, i), i };
    qsort(out->frame, out->n, sizeof(*out->frame), by_name);
    return LT_OK;
}

static int64_t find(const frame_names *names, const char *name)
{
    const frame_name want = { name, 0 }, *found;

    found = names->n ? bsearch(&want, names->frame, names->n, sizeof(want), by_name) : NULL;
    return found ? found->index : -1;
}

/* Without ".jpg"; what stands behind the last dot of "film.mp4#12" or of a folder's name is none. */
static void drop_ending(char *path)
{
    char *dot = strrchr(path, '.');

    if (dot && dot > path && dot[-1] != '/' && !strpbrk(dot, "/#"))
        *dot = '\0';
}

/* "836212060125/color_000012" to "836212060125/000012", as DexYCB's files begin. */
static void drop_kind(char *path)
{
    char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path, *bar = strrchr(base, '_');

    if (bar && bar > base && isdigit((unsigned char)bar[1]))
        memmove(base, bar + 1, strlen(bar + 1) + 1);
}

/* "ABF12/rgb/0123" to "ABF12/0123", as HO3D's folders are. */
static void drop_folder(char *path)
{
    char *last = strrchr(path, '/'), *before;

    if (!last || last == path)
        return;
    *last = '\0';
    before = strrchr(path, '/');
    if (before)
        memmove(before + 1, last + 1, strlen(last + 1) + 1);
    else
        *last = '/';
}

/* With fewer and fewer of the folders that stand before it. */
static int64_t find_end(const frame_names *names, const char *path)
{
    int64_t index = find(names, path);

    for (const char *slash; index < 0 && (slash = strchr(path, '/')) != NULL; path = slash + 1)
        index = find(names, slash + 1);
    return index;
}

int64_t frame_names_find(const frame_names *names, const char *path)
{
    int64_t index = find_end(names, path);
    char text[4096];

    if (index >= 0 || strlen(path) >= sizeof(text))
        return index;
    snprintf(text, sizeof(text), "%s", path);
    drop_ending(text);
    index = find_end(names, text);
    if (index < 0) {
        drop_kind(text);
        index = find_end(names, text);
    }
    if (index < 0) {
        drop_folder(text);
        index = find_end(names, text);
    }
    return index;
}
