/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens a dataset of whichever layout its folder has.
 */
#ifndef DATA_OPEN_H
#define DATA_OPEN_H

#include "data/dataset.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { DATASET_HO3D, DATASET_DEXYCB } dataset_layout;

/* dataset_find_layout - by what is in the folder. Errors: no folder, or neither layout; says what to give. */
lt_status dataset_find_layout(const char *root, dataset_layout *out);

typedef struct {
    const char *root;
    const char *split;              /* "train"; "evaluation", which is DexYCB's test; DexYCB: "val", "test" */
    const char *models;             /* the folder of the YCB models; NULL or "": where the dataset has them */
    const char *setup, *filter;     /* DexYCB's: dexycb_open; NULL: "s0", "valid" */
    const lt_hand_model *hand;      /* the right hand: DexYCB's poses are in its components; not kept */
    const lt_hand_model *left;      /* or NULL: the right one's mirror image */
    bool vertices;                  /* HO3D's evaluation: its vertices as well */
} dataset_options;

/* dataset_open - ho3d_open or dexycb_open. The caller frees *out with dataset_free. */
lt_status dataset_open(const dataset_options *options, dataset **out);

#ifdef __cplusplus
}
#endif
#endif
