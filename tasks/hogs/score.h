/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What one frame's drawing and pose are worth.
 */
#ifndef TASKS_HOGS_SCORE_H
#define TASKS_HOGS_SCORE_H

#include "estimate/compiled.h"
#include "eval/metrics/contact.h"
#include "tasks/hogs/frames.h"

/* In the order of hogs_score_keys; NaN where it was not measured */
typedef enum {
    HOGS_PSNR, HOGS_SSIM, HOGS_LPIPS_RAW01, HOGS_LPIPS_SYM, HOGS_PSNR_FG, HOGS_OCE, HOGS_MCE, HOGS_ADDS,
    HOGS_PENETRATION, HOGS_INTERSECTION, HOGS_CONTACT,
    HOGS_CD_H, HOGS_F_H_1, HOGS_F_H_5, HOGS_CD_O, HOGS_CD_O_NOROT, HOGS_F_O_5, HOGS_F_O_10, HOGS_CD_O_VERTICES,
    HOGS_F_O_10_PERCENT, HOGS_CD_POSE, HOGS_SCORES,
} hogs_score;

extern const char *const hogs_score_keys[];     /* HOGS_SCORES of them, then NULL */

/* hogs_score_images - PSNR, SSIM and PSNR of the foreground of the frame drawn (12, H, W), cut to [0, 1], against the
 * target. LT_ENOMEM. */
lt_status hogs_score_images(const hogs *m, const hogs_frame *f, const lt_real *drawn, double out[HOGS_SCORES]);

/* hogs_score_pose - OCE, MCE, ADD-S of an object's pose in millimetres; nothing where the truth is not known */
lt_status hogs_score_pose(const dataset *d, const hogs_frame *f, const float R[9], const float t[3],
                          double out[HOGS_SCORES]);

/* What it takes to see how hands touch a dataset's objects */
typedef struct {
    const dataset *data;
    const lt_hand_model *hand;
    eval_contact_object **object;   /* of the dataset's */
    int32_t face[EVAL_CLOSED_HAND_FACES][3];
} hogs_touch;

/* hogs_touch_open - in the arena. Errors: those of eval_contact_object_new.
 * hogs_score_contact - penetration, mm, intersection, cm3, and contact of the hand, as its initial pose has it, with
 * the object in a pose. Errors: those of eval_contact. */
lt_status hogs_touch_open(lt_arena *arena, const dataset *d, const lt_hand_model *hand, hogs_touch *out);
lt_status hogs_score_contact(const hogs_touch *touch, const hogs *m, const hogs_frame *f, const float R[9],
                             const float t[3], double out[HOGS_SCORES]);

/* hogs_score_frame - both, of what a graph that draws has made of a frame */
lt_status hogs_score_frame(const model *m, const dataset *d, const hogs_frame *f, const compiled *c,
                           double out[HOGS_SCORES]);

/* hogs_score_clear - nothing is measured */
void hogs_score_clear(double out[HOGS_SCORES]);

/* Means over frames, of what was measured */
typedef struct {
    double sum[HOGS_SCORES];
    int64_t n[HOGS_SCORES];
} hogs_means;

void hogs_means_add(hogs_means *m, const double frame[HOGS_SCORES]);
double hogs_means_of(const hogs_means *m, hogs_score which);

#endif
