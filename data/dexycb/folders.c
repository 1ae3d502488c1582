/* SPDX-License-Identifier: Apache-2.0 */
/* The folders of a DexYCB tree: those of subjects, and of each subject's sequences. */
#include "data/dexycb/internal.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

static int by_name(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* Eight digits, then what the mask says: "########-subject-##" or "########_######". */
static bool matches(const char *name, const char *mask)
{
    for (; *mask; mask++, name++)
        if (*mask == '#' ? !isdigit((unsigned char)*name) : *mask != *name)
            return false;
    return !*name;
}

static lt_status list_folder(lt_arena *arena, const char *path, const char *mask, dexycb_folders *out)
{
    DIR *dir = opendir(path);
    const struct dirent *e;
    int room = 0;

    *out = (dexycb_folders){ 0 };
    if (!dir)
        return lt_error(lt_errno_status(errno), "%s: %s", path, strerror(errno));
    while ((e = readdir(dir)))
        room += matches(e->d_name, mask);
    rewinddir(dir);
    out->name = lt_arena_array(arena, (size_t)room, sizeof(*out->name));
    while (out->name && out->n < room && (e = readdir(dir)))
        if (matches(e->d_name, mask) && !(out->name[out->n++] = lt_arena_strdup(arena, e->d_name)))
            out->name = NULL;
    closedir(dir);
    if (room && !out->name)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    qsort(out->name, (size_t)out->n, sizeof(*out->name), by_name);
    return LT_OK;
}

lt_status dexycb_list_subjects(lt_arena *arena, const char *root, dexycb_folders *out)
{
    return list_folder(arena, root, "########-subject-##", out);
}

lt_status dexycb_list_sequences(lt_arena *arena, const char *root, const char *subject, dexycb_folders *out)
{
    const char *path = lt_arena_printf(arena, "%s/%s", root, subject);

    return path ? list_folder(arena, path, "########_######", out) : lt_error(LT_ENOMEM, "%s: no memory", subject);
}

int dexycb_subject_number(const char *folder)
{
    return atoi(strrchr(folder, '-') + 1) - 1;
}

const char *dexycb_find_subject(const dexycb_folders *subjects, int number)
{
    for (int i = 0; i < subjects->n; i++)
        if (dexycb_subject_number(subjects->name[i]) == number)
            return subjects->name[i];
    return NULL;
}
