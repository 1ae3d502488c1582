/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which of DexYCB's subjects, sequences and cameras each split has. Numbers count from 0: the subjects by
 * their folders' names, a subject's sequences in the order of theirs, cameras as meta.yml lists them.
 *
 * Source: NVlabs/dex-ycb-toolkit dex_ycb_toolkit/dex_ycb.py.
 */
#ifndef DATA_DEXYCB_SPLIT_H
#define DATA_DEXYCB_SPLIT_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { DEXYCB_SUBJECTS = 10, DEXYCB_SEQUENCES = 100, DEXYCB_CAMERAS = 8 };

typedef struct {
    int setup;                      /* 0 .. 3: all seen; unseen subjects, views, objects */
    enum { DEXYCB_TRAIN, DEXYCB_VAL, DEXYCB_TEST } part;
} dexycb_split;

/* dexycb_split_parse - "s0" .. "s3" and "train", "val", "test"; "evaluation" is the test split's other name */
lt_status dexycb_split_parse(const char *setup, const char *part, dexycb_split *out);

/* dexycb_split_name - "train", "val", "test" */
const char *dexycb_split_name(dexycb_split s);

/* The three conditions of a split; a sample is in it when all three hold. s0's sequences depend on nothing
 * else, its subjects do not matter in training. */
bool dexycb_has_subject(dexycb_split s, int subject);
bool dexycb_has_sequence(dexycb_split s, int sequence);
bool dexycb_has_camera(dexycb_split s, int camera);

#ifdef __cplusplus
}
#endif
#endif
