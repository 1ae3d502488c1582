/* SPDX-License-Identifier: Apache-2.0 */
/* The kinds of datasets that are known by their folders. A new one is its own folder, an include and a line here. */
#include "data/dexycb/dexycb.h"
#include "data/ho3d/ho3d.h"
#include "data/kind.h"

#include "libtensor/io/file.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const dataset_kind *const kinds[] = {
    &ho3d_kind,
    &dexycb_kind,
};

/* ---- by the folder ---- */

bool dataset_folder_has(const char *root, bool (*known)(const char *name))
{
    DIR *dir = opendir(root);
    const struct dirent *e;
    bool found = false;

    while (dir && !found && (e = readdir(dir)))
        found = known(e->d_name);
    if (dir)
        closedir(dir);
    return found;
}

/* What the folder has not: "neither A, nor B". */
static lt_status of_no_kind(const char *root)
{
    char list[1024];
    int n = 0;

    for (size_t i = 0; i < LT_COUNT(kinds); i++)
        n += snprintf(list + n, sizeof(list) - (size_t)n, "%s%s", i == 0 ? "" : i == 1 ? ", nor " : " nor ",
                      kinds[i]->looks_like);
    return lt_error(LT_EIO, "%s: neither %s", root, list);
}

lt_status dataset_find_kind(const char *root, const dataset_kind **out)
{
    DIR *dir;

    for (size_t i = 0; i < LT_COUNT(kinds); i++)
        if (kinds[i]->probe(root)) {
            *out = kinds[i];
            return LT_OK;
        }
    dir = opendir(root);
    if (!dir)
        return lt_error(lt_errno_status(errno), "%s: %s; give the folder of a dataset, or make a synthetic one with "
                        "`palmar synth`", root, strerror(errno));
    closedir(dir);
    return of_no_kind(root);
}

/* ---- opening ---- */

/* The first field that is needed and that the kind has not, in words; NULL: it has all. */
static const char *lacking(const dataset_kind *kind, unsigned needs)
{
    static const struct { unsigned flag; const char *words; } field[] = {
        { SAMPLE_HAND_POSE, "hand poses" }, { SAMPLE_JOINTS, "hand joints" }, { SAMPLE_ROOT, "places of wrists" },
        { SAMPLE_HAND_BOX, "boxes of hands" }, { SAMPLE_OBJECT, "object poses" },
        { SAMPLE_VERTICES, "hand vertices" }, { SAMPLE_DEPTH, "depth" }, { SAMPLE_SEGMENTS, "masks" },
    };

    for (size_t i = 0; i < LT_COUNT(field); i++)
        if (needs & field[i].flag & ~kind->fields)
            return field[i].words;
    return NULL;
}

lt_status dataset_open(const dataset_options *o, dataset **out)
{
    dataset_options full = *o;
    const char *missing;
    lt_status st = LT_OK;

    if (!full.kind)
        st = dataset_find_kind(o->root, &full.kind);
    if (st)
        return st;
    missing = lacking(full.kind, o->needs);
    if (missing)
        return lt_error(LT_EINVAL, "%s: %s has no %s, which are needed here", o->root ? o->root : "data",
                        full.kind->title, missing);
    full.models = o->models && *o->models ? o->models : NULL;
    full.setup = o->setup || !full.kind->setups ? o->setup : full.kind->setups[0];
    full.filter = o->filter || !full.kind->filters ? o->filter : full.kind->filters[0];
    return full.kind->open(&full, out);
}

const char *dataset_validation_split(const dataset_kind *kind, const char *root)
{
    char path[4096];

    if (!kind->validation_truth)
        return kind->validation;
    snprintf(path, sizeof(path), "%s/%s", root, kind->validation_truth);
    return access(path, R_OK) == 0 ? kind->validation : NULL;
}

/* ---- in words ---- */

/* Takes the place of printf's next characters in out; what does not fit is cut. */
static void add(char out[DATASET_LIST], const char *before, const char *text)
{
    const size_t n = strlen(out);

    snprintf(out + n, DATASET_LIST - n, "%s%s", before, text);
}

/* "a, b or c", behind what is there. */
static void add_choices(char out[DATASET_LIST], const char *const *choice)
{
    for (int i = 0; choice[i]; i++)
        add(out, i == 0 ? "" : choice[i + 1] ? ", " : " or ", choice[i]);
}

void dataset_list_kinds(dataset_list what, char out[DATASET_LIST])
{
    const char *title[LT_COUNT(kinds) + 1] = { NULL };
    int n = 0;

    *out = '\0';
    for (size_t i = 0; i < LT_COUNT(kinds); i++) {
        const char *const *choice = what == DATASET_FILTERS ? kinds[i]->filters : kinds[i]->setups;
        if (what == DATASET_TITLES || (what == DATASET_WITH_SETUPS && choice))
            title[n++] = kinds[i]->title;
        else if (what != DATASET_WITH_SETUPS && choice) {
            add(out, *out ? "; " : "", kinds[i]->title);
            add(out, ": ", "");
            add_choices(out, choice);
        }
    }
    add_choices(out, title);
}
