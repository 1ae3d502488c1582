/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Is a dataset what we take it for? Its files are there, its samples can be read, its hand model, posed as the
 * annotation says, meets the annotated joints and falls into the picture, its objects are at the hands, its masks on
 * them.
 */
#ifndef DATA_CHECK_H
#define DATA_CHECK_H

#include "data/dataset.h"
#include "data/slip.h"

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
    slip slip;                      /* what would explain it when rms is above 1 mm or in_view below a half */
} check_hands;

/**
 * check_pose - compare up to n annotated hands with the model
 *
 *   left     false: the right hands; true: the left ones, mirrored, whose middle tip is not looked at
 *
 * Tried as explanations: all of slip_in_points; PCA coefficients read as angles and the other way round, a mean pose
 * that is added or left out, and for left hands the sign of the shape directions, alone and with these; and for hands
 * out of view slip_in_camera. Finger tips are d->tips. Labels of any size are seen where d->any_size is set. Samples
 * that cannot be read are passed over. LT_ENOMEM.
 */
lt_status check_pose(const dataset *d, const lt_hand_model *hand, int64_t n, bool left, check_hands *out);

/* check_hands_good - within 1 mm and in view; also when there were none */
bool check_hands_good(const check_hands *c);

/* What cameras and objects come to. */
typedef struct {
    int64_t samples;                /* looked at */
    int64_t odd_cameras;            /* whose intrinsics are not those of the image */
    const char *odd_camera;         /* the name of the first of these; the dataset's */
    slip camera;                    /* what its intrinsics may be */
    int64_t objects;                /* with a hand beside them */
    double apart;                   /* metres from a wrist to the middle of its object, the median */
    slip object;                    /* what would explain it when they are more than a metre apart */
} check_scene;

/* check_cameras_and_objects - of up to n samples, spread evenly; what cannot be read is passed over. LT_ENOMEM. */
lt_status check_cameras_and_objects(const dataset *d, int64_t n, check_scene *out);

/* Whether masks lie where the hands are. */
typedef struct { int64_t masks, joints, on_mask; } check_masks;

/* check_masks_on_hands - of up to n samples that have a mask and joints. LT_ENOMEM. check_masks_good - half of the
 * joints in the picture are on hand or object, or there were none: if they are not, colours mean something else. */
lt_status check_masks_on_hands(const dataset *d, int64_t n, check_masks *out);
bool check_masks_good(const check_masks *c);

#ifdef __cplusplus
}
#endif
#endif
