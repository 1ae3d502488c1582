/* SPDX-License-Identifier: Apache-2.0 */
/*
 * `palmar info --data`: what a dataset has, and whether it is sound.
 */
#ifndef CLI_INFO_DATA_H
#define CLI_INFO_DATA_H

#include "libtensor/base/status.h"

struct cJSON;

typedef struct {
    const char *root;
    const char *setup;              /* DexYCB: whose splits are tested; NULL: s0 */
    const char *hand, *left;        /* hand models; NULL: as cli_hand_open has them */
    int samples;                    /* of each split that are read; 0: all */
} info_data_options;

/**
 * info_data - add to root: layout, splits and their counts, missing and unreadable files, the self-test, notes
 *
 * Errors: the dataset cannot be opened; or, after all of it was looked at, that something is wrong with it: the
 * line says what, and root has the rest.
 */
lt_status info_data(const info_data_options *o, struct cJSON *root);

#endif
