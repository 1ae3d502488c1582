/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The file that the HO3D challenge takes: pred.json, [ [joints...], [vertices...] ], one entry
 * per line of evaluation.txt, or pred.zip with that inside.
 *
 * Source: shreyashampali/ho3d README and pred.py; eval/scorers/ho3d/score.h says what joints and
 * vertices are.
 */
#ifndef EVAL_SCORERS_HO3D_SUBMISSION_H
#define EVAL_SCORERS_HO3D_SUBMISSION_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ho3d_submission ho3d_submission;

/**
 * ho3d_submission_open - begin a submission of n_expected samples (11,524 in version 2, 20,137
 * in 3)
 *
 *   path   ends in ".zip" for a packed archive with pred.json, anything else for the JSON itself
 *   out    ends in ho3d_submission_close or _abort
 *
 * Memory does not grow with the samples: vertices, which come last in the file, wait in a
 * temporary file beside path. Nothing appears at path before the close. Errors: LT_EIO,
 * LT_ENOSPC, LT_ENOMEM.
 */
lt_status ho3d_submission_open(const char *path, int64_t n_expected, ho3d_submission **out);

/**
 * ho3d_submission_add - the next sample
 *
 *   joints     (21, 3) MANO order        both metres, OpenGL axes, absolute
 *   vertices   (778, 3)
 *
 * Numbers are written with seven digits: 0.1 um at a metre. Errors: LT_EINVAL, and nothing is
 * added, for a number that is not finite, and for joints or vertices that are all behind the
 * camera (z > 0), which the official script refuses: they are in OpenCV's axes.
 */
lt_status ho3d_submission_add(ho3d_submission *s, const float *joints, const float *vertices);

/* ho3d_submission_close - finish the file and free s. Errors: LT_EINVAL when the number of
 * samples is not the expected one, LT_EIO, LT_ENOSPC; then path is as it was. */
lt_status ho3d_submission_close(ho3d_submission *s);

/* ho3d_submission_abort - free s and leave path as it was; NULL is fine */
void ho3d_submission_abort(ho3d_submission *s);

#ifdef __cplusplus
}
#endif
#endif
