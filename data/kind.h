/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a kind of dataset is, HO3D or DexYCB: how it is known, how it is opened, what its samples have. Whoever trains,
 * scores or tests a dataset asks its kind, and names none. The table of kinds is kinds.c; each kind is a folder.
 */
#ifndef DATA_KIND_H
#define DATA_KIND_H

#include "data/dataset.h"

#ifdef __cplusplus
extern "C" {
#endif

struct cJSON;

typedef struct {
    const dataset_kind *kind;       /* NULL: by what is in root */
    const char *root;               /* NULL for a kind that draws its samples */
    const char *split;              /* one of the kind's; "evaluation" is DexYCB's "test" */
    unsigned needs;                 /* of sample_flag: what whoever opens it cannot do without; 0: nothing */
    const char *models;             /* the folder of the YCB models; NULL or "": where the dataset has them */
    const char *setup, *filter;     /* of the kind's setups and filters; NULL: its first */
    const lt_hand_model *hand;      /* the right hand: DexYCB's poses are in its components; not kept */
    const lt_hand_model *left;      /* or NULL: the right one's mirror image */
    bool vertices;                  /* HO3D's evaluation: its vertices as well */
} dataset_options;

struct dataset_kind {
    const char *title;              /* "HO3D" */
    unsigned fields;                /* of sample_flag: what its samples may have */
    const char *const *splits;      /* ends with NULL; the order in which they are tested */
    const char *const *setups, *const *filters;     /* end with NULL, the first is taken where none is asked for;
                                                       NULL: it has none */
    const char *counted;            /* what a split has a number of: "samples", "samples with a hand" */

    /* what training validates on: a split, and the file in root without which it has no truth; NULL: needs none */
    const char *validation, *validation_truth;

    /* whose hand a sample of this name shows: a number of the dataset's own; -1: it does not say. NULL: no sample
     * says */
    int (*subject)(const char *name);

    /* how HFL-Net scores it: ADD-0.1D takes symmetric objects by ADD-S; projections count in pixels of the image, not
     * of the crop */
    bool symmetric_adds, image_pixels;

    /* how its folder, or file, is known: the first kind of the table that takes root has it. NULL: it has neither, and
     * is opened by those who ask for it. looks_like: what root has, "train.txt, as HO3D has it" */
    bool (*probe)(const char *root);
    const char *looks_like;

    lt_status (*open)(const dataset_options *o, dataset **out);

    /* Its own part of a self-test; the rest is check.h's. NULL: it has none.
     * describe: add to root what is known before a split is opened. Errors: a folder cannot be read.
     * absent: why o->split of o->setup cannot be there, a sentence in arena; NULL: it may be. */
    lt_status (*describe)(const dataset_options *o, lt_arena *arena, struct cJSON *root);
    const char *(*absent)(const dataset_options *o, lt_arena *arena);
};

/* dataset_find_kind - by what is in root. Errors: no such folder, or of no kind; the line says what to give. */
lt_status dataset_find_kind(const char *root, const dataset_kind **out);

/**
 * dataset_open - a split of a dataset
 *
 * Errors: dataset_find_kind's; those of the kind; a kind whose samples lack what is needed. The caller frees *out with
 * dataset_free.
 */
lt_status dataset_open(const dataset_options *options, dataset **out);

/* dataset_validation_split - what training validates on in root; NULL: the dataset has no split with truth for it */
const char *dataset_validation_split(const dataset_kind *kind, const char *root);

/* dataset_folder_has - whether some name in the folder root is one that a kind knows; for probe */
bool dataset_folder_has(const char *root, bool (*known)(const char *name));

/* What a text for users may name. */
typedef enum {
    DATASET_TITLES,                 /* "HO3D or DexYCB" */
    DATASET_SETUPS,                 /* "DexYCB: s0, s1, s2 or s3"; kinds without are left out */
    DATASET_FILTERS,
    DATASET_WITH_SETUPS,            /* "DexYCB": titles of the kinds that have setups */
} dataset_list;

enum { DATASET_LIST = 512 };

/* dataset_list_kinds - the kinds of the table in words */
void dataset_list_kinds(dataset_list what, char out[DATASET_LIST]);

#ifdef __cplusplus
}
#endif
#endif
