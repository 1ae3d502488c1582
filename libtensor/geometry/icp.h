/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Laying one point set on another one without knowing which points correspond: iterated closest points.
 *
 * Points are (n, 3), metres; x is moved onto y. Errors of all functions: LT_EINVAL for a set without points or with a
 * coordinate that is not finite; LT_ENOMEM. The output is touched on success alone.
 */
#ifndef LT_GEOMETRY_ICP_H
#define LT_GEOMETRY_ICP_H

#include "libtensor/geometry/procrustes.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double within;              /* points of x that are farther from all of y have no say */
    int rounds;                 /* at most */
    double tolerance;           /* stop where neither the share of points that have one nor their distance, in parts of
                                 * itself, changes by more */
} lt_icp_opts;

/**
 * lt_icp_similarity - from a start: pair each point of x with the nearest of y, fit scale, rotation and translation to
 * the pairs, and again
 *
 * Fewer than three pairs end it. Source: Besl and McKay 1992; Umeyama 1991; Open3D's point-to-point registration.
 */
LT_API lt_status lt_icp_similarity(int n, const double (*x)[3], int m, const double (*y)[3], const lt_similarity *start,
                                   const lt_icp_opts *opts, lt_similarity *out);

/**
 * lt_icp_best_similarity - the best of 25 such fits, by the mean squared distances both ways between what they leave
 *
 * They start with x's mean on y's: as x is, and with the sizes made equal (root mean square from the mean) and x's
 * principal axes turned onto y's by each of the 24 rotations of a cube. Uses all threads; the same bits on any number
 * of them.
 */
LT_API lt_status lt_icp_best_similarity(int n, const double (*x)[3], int m, const double (*y)[3],
                                        const lt_icp_opts *opts, lt_similarity *out);

/**
 * lt_icp_scale_translation - scale and translation alone, from means and sizes made equal, by pairs both ways
 *
 * 100 rounds at most, until what is left, where y's size is 1, is below 1e-3 or falls by less than 1e-5.
 *
 * Source: zerchen/AlignSDF deep_sdf/metrics/icp_trans_scale.py.
 */
LT_API lt_status lt_icp_scale_translation(int n, const double (*x)[3], int m, const double (*y)[3], lt_similarity *out);

#ifdef __cplusplus
}
#endif
#endif
