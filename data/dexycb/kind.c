/* SPDX-License-Identifier: Apache-2.0 */
/* DexYCB as one of the kinds of datasets, and what its self-test has of its own: the official lists. */
#include "data/dexycb/dexycb.h"
#include "data/kind.h"

#include <cjson/cJSON.h>
#include <string.h>

static const char *const splits[] = { "train", "val", "test", NULL };
const char *const dexycb_setups[] = { "s0", "s1", "s2", "s3", NULL };

static bool is_part(const char *name)
{
    return !strcmp(name, "calibration") || strstr(name, "-subject-");
}

static bool probe(const char *root)
{
    return dataset_folder_has(root, is_part);
}

static lt_status open_split(const dataset_options *o, dataset **out)
{
    dexycb_options dexycb = { .root = o->root, .setup = o->setup, .split = o->split, .models = o->models,
                              .hand = o->hand, .left = o->left };
    const lt_status st = dexycb_parse_filter(o->filter, &dexycb.filter);

    return st ? st : dexycb_open(&dexycb, out);
}

/* Each subject's folder, and how many sequences are in it. */
static lt_status list_subjects(const dataset_options *o, lt_arena *arena, cJSON *root)
{
    cJSON *list = cJSON_AddObjectToObject(root, "subjects");
    dexycb_folders subjects, sequences;
    lt_status st = dexycb_list_subjects(arena, o->root, &subjects);

    for (int i = 0; !st && i < subjects.n; i++) {
        st = dexycb_list_sequences(arena, o->root, subjects.name[i], &sequences);
        if (!st)
            cJSON_AddNumberToObject(list, subjects.name[i], sequences.n);
    }
    return st;
}

/* All frames of each setup's splits; a split may be empty where subjects were left out. */
static void list_setups(const dataset_options *o, cJSON *root)
{
    cJSON *lists = cJSON_AddObjectToObject(root, "frames of the official lists");

    for (int i = 0; dexycb_setups[i]; i++) {
        cJSON *list = cJSON_AddObjectToObject(lists, dexycb_setups[i]);
        for (int k = 0; splits[k]; k++) {
            const dexycb_options all = { .root = o->root, .setup = dexycb_setups[i], .split = splits[k],
                                         .filter = DEXYCB_EVERY, .hand = o->hand, .no_objects = true };
            dataset *d = NULL;
            const int64_t frames = dexycb_open(&all, &d) ? 0 : d->count;
            cJSON_AddNumberToObject(list, splits[k], (double)frames);
            dataset_free(d);
        }
    }
}

static lt_status describe(const dataset_options *o, lt_arena *arena, cJSON *root)
{
    const lt_status st = list_subjects(o, arena, root);

    list_setups(o, root);
    return st;
}

/* A split whose subjects were all left out. Where no subject is there, or the setup is none, opening says so. */
static const char *absent(const dataset_options *o, lt_arena *arena)
{
    const char *setup = o->setup ? o->setup : dexycb_setups[0];
    dexycb_folders subjects;
    dexycb_split split;

    if (dexycb_split_parse(setup, o->split, &split) || dexycb_list_subjects(arena, o->root, &subjects) || !subjects.n)
        return NULL;
    for (int i = 0; i < subjects.n; i++)
        if (dexycb_has_subject(split, dexycb_subject_number(subjects.name[i])))
            return NULL;
    return lt_arena_printf(arena, "no subject of this split of %s is there", setup);
}

/* "20200709-subject-01/..." */
static int subject(const char *name)
{
    return dexycb_subject_number(name);
}

const dataset_kind dexycb_kind = {
    .title = "DexYCB", .splits = splits, .setups = dexycb_setups, .filters = dexycb_filters,
    .counted = "samples with a hand",
    .fields = SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT | SAMPLE_HAND_BOX | SAMPLE_OBJECT | SAMPLE_DEPTH |
              SAMPLE_SEGMENTS,
    .validation = "val",
    .symmetric_adds = true, .image_pixels = true,
    .subject = subject, .probe = probe, .looks_like = "folders like 20200709-subject-01, as DexYCB has them",
    .open = open_split, .describe = describe, .absent = absent,
};
