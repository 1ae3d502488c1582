/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PointNet++ with one radius a level ("SSG"): some of the points, and what is known of those around each of them, as
 * features. The three levels, the head and the parameters' names are ULIP's.
 *
 * Source: Qi et al. 2017, "PointNet++", section 3; salesforce/ULIP models/pointnet2/pointnet2.py.
 */
#ifndef MODELS_BACKBONES_POINTNET2_H
#define MODELS_BACKBONES_POINTNET2_H

#include "libtensor/nn/layers.h"

enum { POINTNET2_CONVS = 3, POINTNET2_LEVELS = 3 };

typedef struct {
    int points, samples;            /* centres, and points around each; 0: one group of all points, without a centre */
    double radius;
    int width[POINTNET2_CONVS];
} pointnet2_level_opts;

/* ulip_levels - the sizes of ULIP's three */
extern const pointnet2_level_opts ulip_levels[POINTNET2_LEVELS];

/* A set abstraction: parameters PREFIX.mlp_convs.0 .. 2, PREFIX.mlp_bns.0 .. 2 */
typedef struct {
    pointnet2_level_opts opts;
    lt_conv_layer conv[POINTNET2_CONVS];
    lt_batch_norm_layer norm[POINTNET2_CONVS];
} pointnet2_level;

/* pointnet2_level_new - of points with `features` numbers beside their place. first: the first convolution's name,
 * which is "mlp_convs.0" where published weights are to fit it */
void pointnet2_level_new(pointnet2_level *m, lt_params *set, const char *prefix, const char *first, int features,
                         const pointnet2_level_opts *opts);

typedef struct {
    lt_tensor *index;               /* (B, M), LT_I32: which points the centres are; NULL where all are one group */
    lt_tensor *points;              /* (B, M, 3); NULL likewise */
    lt_tensor *features;            /* (B, M, C) */
} pointnet2_out;

/* pointnet2_level_forward - points (B, N, 3), features (B, N, F) or NULL; start (B), LT_I32, or NULL: the first
 * centre, as lt_farthest_point_sampling has it */
pointnet2_out pointnet2_level_forward(const pointnet2_level *m, lt_tensor *points, lt_tensor *features,
                                      lt_tensor *start);

/* The whole encoder: the levels sa1, sa2 and sa3, the last of all points; then 1024 - 512 - 256 */
typedef struct {
    pointnet2_level level[POINTNET2_LEVELS];
    lt_linear_layer fc1, fc2;
    lt_batch_norm_layer bn1, bn2;
    double dropout;
} pointnet2;

/* pointnet2_new - sa1: its sizes, those of ULIP where NULL; prefix "" gives ULIP's own names */
void pointnet2_new(pointnet2 *m, lt_params *set, const char *prefix, const pointnet2_level_opts *sa1, double dropout);

/* pointnet2_forward - points (B, N, 3) in the unit sphere to (B, 256); start as above, for both levels that have one */
lt_tensor *pointnet2_forward(const pointnet2 *m, lt_tensor *points, lt_tensor *start);

#endif
