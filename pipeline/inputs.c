/* SPDX-License-Identifier: Apache-2.0 */
/* Images and folders named by the user, as a list of files with a name of its own for each result. */
#include "pipeline/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/natural.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static const char *const extensions[] = {
    "png", "jpg", "jpeg", "bmp", "tif", "tiff", "webp", "ppm", "pgm", "jp2",
};

static const char *const film_extensions[] = { "mp4", "avi", "mov", "mkv", "webm", "m4v" };

static bool is_film_name(const char *name)
{
    const char *dot = strrchr(name, '.');

    for (size_t i = 0; dot && i < LT_COUNT(film_extensions); i++)
        if (!strcasecmp(dot + 1, film_extensions[i]))
            return true;
    return false;
}

/* Of an image that is worth a look: not hidden, and not an overlay of an earlier run. */
static bool is_image_name(const char *name)
{
    static const char ours[] = ".overlay.png";
    const char *dot = strrchr(name, '.');
    const size_t n = strlen(name), end = sizeof(ours) - 1;

    if (n >= end && !strcmp(name + n - end, ours))
        return false;
    for (size_t i = 0; dot && name[0] != '.' && i < LT_COUNT(extensions); i++)
        if (!strcasecmp(dot + 1, extensions[i]))
            return true;
    return false;
}

/* ---- paths ---------------------------------------------------------------------------------------------- */

typedef struct {
    char **path;
    size_t n, room;
} paths;

static lt_status add_path(lt_arena *arena, paths *p, char *path)
{
    char **longer = lt_arena_grow(arena, p->path, p->n, &p->room, sizeof(*longer));

    if (!longer || !path)
        return lt_error(LT_ENOMEM, "no memory for a list of %zu images", p->n);
    p->path = longer;
    p->path[p->n++] = path;
    return LT_OK;
}

static int by_number(const void *a, const void *b)
{
    return lt_natural_order(*(char *const *)a, *(char *const *)b);
}

static lt_status add_folder(lt_arena *arena, const char *folder, paths *all)
{
    const size_t first = all->n;
    const struct dirent *entry;
    lt_status st = LT_OK;
    DIR *dir = opendir(folder);

    if (!dir)
        return lt_error(lt_errno_status(errno), "%s: %s", folder, strerror(errno));
    while (!st && (entry = readdir(dir)))
        if (is_image_name(entry->d_name))
            st = add_path(arena, all, lt_path_join(arena, folder, entry->d_name));
    closedir(dir);
    if (st)
        return st;
    if (all->n == first)
        return lt_error(LT_EFORMAT, "%s: no images in this folder", folder);
    qsort(all->path + first, all->n - first, sizeof(*all->path), by_number);
    return LT_OK;
}

/* The shell lists frame*.jpg by letters, frame10 before frame2; what stands in another order was put there by hand. */
static bool listed_by_shell(char *const *path, size_t n)
{
    for (size_t i = 1; i < n; i++)
        if (strcmp(path[i - 1], path[i]) >= 0)
            return false;
    return true;
}

static bool in_order(char *const *path, size_t n)
{
    for (size_t i = 1; i < n; i++)
        if (lt_natural_order(path[i - 1], path[i]) > 0)
            return false;
    return true;
}

/* n files that were named one by one, a film's frames: in the order in which their folder would give them. */
static void sort_frames(const predict_options *o, char **path, size_t n)
{
    if (!listed_by_shell(path, n) || in_order(path, n))
        return;
    qsort(path, n, sizeof(*path), by_number);
    predict_say(o, "%s: the first of %zu frames, which are taken in the order of the numbers in their names", path[0],
                n);
}

static lt_status add_input(lt_arena *arena, const char *input, paths *all)
{
    struct stat s;

    if (stat(input, &s))
        return lt_error(lt_errno_status(errno), "%s: %s", input, strerror(errno));
    if (S_ISDIR(s.st_mode))
        return add_folder(arena, input, all);
    return add_path(arena, all, lt_arena_strdup(arena, input));
}

/* ---- names ---------------------------------------------------------------------------------------------- */

static char *stem_of(lt_arena *arena, const char *path)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    char *stem = lt_arena_strdup(arena, base), *dot = stem ? strrchr(stem, '.') : NULL;

    if (dot && dot != stem)
        *dot = '\0';
    return stem;
}

/* Names given so far, sorted, so that a lookup is a search. */
typedef struct { const char *name; } taken_name;

static bool is_taken(const taken_name *sorted, size_t n, const char *name, size_t *place)
{
    size_t lo = 0, hi = n;

    while (lo < hi) {
        const size_t mid = lo + (hi - lo) / 2;

        if (strcmp(sorted[mid].name, name) < 0)
            lo = mid + 1;
        else
            hi = mid;
    }
    *place = lo;
    return lo < n && !strcmp(sorted[lo].name, name);
}

/* stem, or stem-2, stem-3 ... whichever is free first; NULL without memory. */
static const char *take_name(lt_arena *arena, taken_name *sorted, size_t n, const char *stem)
{
    const char *name = stem;
    size_t place;

    for (int k = 2; name && is_taken(sorted, n, name, &place); k++)
        name = lt_arena_printf(arena, "%s-%d", stem, k);
    if (!name)
        return NULL;
    memmove(sorted + place + 1, sorted + place, (n - place) * sizeof(*sorted));
    sorted[place].name = name;
    return name;
}

static lt_status give_names(lt_arena *arena, const paths *all, predict_list *out)
{
    taken_name *sorted = lt_arena_array(arena, all->n + 1, sizeof(*sorted));

    out->input = lt_arena_array(arena, all->n, sizeof(*out->input));
    if (!sorted || !out->input)
        return lt_error(LT_ENOMEM, "no memory for the names of %zu images", all->n);
    for (size_t i = 0; i < all->n; i++) {
        const char *stem = stem_of(arena, all->path[i]);
        const char *name = stem ? take_name(arena, sorted, i, stem) : NULL;

        if (!name)
            return lt_error(LT_ENOMEM, "no memory for the names of %zu images", all->n);
        out->input[i] = (predict_input){ .path = all->path[i], .name = name, .film = is_film_name(all->path[i]) };
    }
    out->n = (int)all->n;
    return LT_OK;
}

/* The frame's number behind a film's name and a dash, as predict_film names its results */
static bool is_frame_of(const char *film, const char *name)
{
    const size_t n = strlen(film);
    const char *number = name + n + 1;

    if (strncmp(name, film, n) != 0 || name[n] != '-')
        return false;
    return strlen(number) >= PREDICT_FRAME_DIGITS && !number[strspn(number, "0123456789")];
}

static lt_status check_frames(const predict_list *list)
{
    for (int f = 0; f < list->n; f++)
        for (int i = 0; i < list->n && list->input[f].film; i++)
            if (is_frame_of(list->input[f].name, list->input[i].name))
                return lt_error(LT_EINVAL, "%s and a frame of %s would have the same results, %s.json; predict one at "
                                "a time, each to its own --out", list->input[i].path, list->input[f].path,
                                list->input[i].name);
    return LT_OK;
}

/* ---- depth ---------------------------------------------------------------------------------------------- */

/* The one depth image, or in a folder the one that is called as the image is. */
static lt_status depth_of(lt_arena *arena, const char *depth, bool folder, predict_input *in)
{
    const char *stem = stem_of(arena, in->path), *file = lt_arena_printf(arena, "%s.png", in->name);

    in->depth = !folder || in->film ? depth : file ? lt_path_join(arena, depth, file) : NULL;
    if (!stem || !in->depth)
        return lt_error(LT_ENOMEM, "%s: no memory", in->path);
    if (folder && strcmp(stem, in->name) != 0)
        return lt_error(LT_EINVAL, "%s: a second image of this name, and depth goes by names; predict one folder at a "
                        "time", in->path);
    return LT_OK;
}

static lt_status find_depth(lt_arena *arena, const predict_options *o, predict_list *list)
{
    lt_status st = LT_OK;
    struct stat s;

    if (!o->m)
        return lt_error(LT_EUSAGE, "%s: there is no model of hands, and nothing else takes depth", o->depth);
    if (!model_takes_depth(o->m))
        return lt_error(LT_EUSAGE, "%s: %s %s was trained without depth and takes none", o->depth, o->m->cls->name,
                        o->m->variant);
    if (stat(o->depth, &s))
        return lt_error(lt_errno_status(errno), "%s: %s", o->depth, strerror(errno));
    if (!S_ISDIR(s.st_mode) && list->n > 1)
        return lt_error(LT_EUSAGE, "%s: one depth image for %d images; want a folder with a NAME.png for each",
                        o->depth, list->n);
    if (!S_ISDIR(s.st_mode) && list->n && list->input[0].film)
        return lt_error(LT_EUSAGE, "%s: one depth image for a film; want a folder with NAME-000001.png and so on",
                        o->depth);
    for (int i = 0; i < list->n && !st; i++)
        st = depth_of(arena, o->depth, S_ISDIR(s.st_mode), &list->input[i]);
    return st;
}

/* What comes through standard input is a film. */
static lt_status list_pipe(lt_arena *arena, predict_list *out)
{
    predict_input *in = lt_arena_alloc(arena, sizeof(*in));

    if (!in)
        return lt_error(LT_ENOMEM, "no memory for standard input");
    *in = (predict_input){ .path = "stdin", .name = "stdin", .film = true, .pipe = true };
    *out = (predict_list){ .input = in, .n = 1 };
    return LT_OK;
}

lt_status predict_list_inputs(lt_arena *arena, const predict_options *o, predict_list *out)
{
    paths all = { 0 };
    bool folders = false;
    lt_status st = LT_OK;

    if (o->pipe)
        return list_pipe(arena, out);
    *out = (predict_list){ 0 };
    for (int i = 0; i < o->n_inputs && st != LT_ENOMEM; i++) {
        folders = folders || lt_is_folder(o->inputs[i]);
        st = add_input(arena, o->inputs[i], &all);
        if (st && st != LT_ENOMEM) {
            predict_say(o, "skipped: %s", lt_last_error());
            out->skipped++;
        }
    }
    if (o->fps > 0 && !folders)
        sort_frames(o, all.path, all.n);
    st = st == LT_ENOMEM ? st : give_names(arena, &all, out);
    st = st ? st : check_frames(out);
    return st || !o->depth ? st : find_depth(arena, o, out);
}
