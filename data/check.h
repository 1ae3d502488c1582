/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Is a dataset what we take it for? Its files are there, its samples can be read, and its hand model, posed as the
 * annotation says, meets the annotated joints and falls into the picture.
 */
#ifndef DATA_CHECK_H
#define DATA_CHECK_H

#include "data/dataset.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { CHECK_LINES = 10 };

/* Files of samples that are not there, over the whole split. */
typedef struct {
    int64_t samples;                /* that lack one */
    const char *first;              /* path of the first; NULL: none */
} check_missing;

/* check_files - look for the files of all samples, on all threads; first lives in arena. LT_ENOMEM. */
lt_status check_files(const dataset *d, lt_arena *arena, check_missing *out);

/* Samples read in full. */
typedef struct {
    int64_t read, bad;
    int n_lines;
    const char *line[CHECK_LINES];  /* what is wrong with the first bad ones */
} check_samples;

/* check_read - read n samples (0: all), evenly spread, with depth, on all threads; lines live in arena. LT_ENOMEM. */
lt_status check_read(const dataset *d, int64_t n, lt_arena *arena, check_samples *out);

/* What the annotated hands come to on a hand model; right and left ones apart. */
typedef struct {
    int64_t hands;                  /* compared; 0: the annotation has no poses */
    double rms_mm;                  /* from the posed joints to the annotated ones, both from the wrist */
    double in_view;                 /* share of the joints that fall into the picture, or a quarter beside it */
    const char *slip;               /* what would explain it when rms is above 1 mm or in_view below a half, as a
                                       half-sentence; NULL: all is well, or nothing explains it */
} check_hands;

/**
 * check_pose - compare up to n annotated hands with the model
 *
 *   left     false: the right hands; true: the left ones, mirrored, whose middle tip is not looked at
 *
 * Tried as explanations: joints in MANO's or InterHand's order, OpenGL axes, millimetres, PCA coefficients read as
 * angles and the other way round, a mean pose that is added or left out, and for left hands the sign of the shape
 * directions. Finger tips are d->tips. Samples that cannot be read are passed over. LT_ENOMEM.
 */
lt_status check_pose(const dataset *d, const lt_hand_model *hand, int64_t n, bool left, check_hands *out);

/* check_hands_good - within 1 mm and in view; also when there were none */
bool check_hands_good(const check_hands *c);

#ifdef __cplusplus
}
#endif
#endif
