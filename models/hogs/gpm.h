/* SPDX-License-Identifier: Apache-2.0 */
/*
 * G-PM: the object's pose refined by its Gaussians. The first level of PointNet++ takes some of them with what
 * surrounds them; each becomes a token with what the image shows there; an encoder and two heads give every token's
 * idea of how far the pose is off, whose mean is the answer.
 *
 * Source: the paper's section on G-PM; salesforce/ULIP models/pointnet2 for the level.
 */
#ifndef MODELS_HOGS_GPM_H
#define MODELS_HOGS_GPM_H

#include "models/backbones/pointnet2.h"
#include "models/hogs/vpm.h"

enum { GPM_LAYERS = 3, GPM_COLOUR = 48, GPM_HEAD = 3 };

typedef struct {
    int encoding, condition;        /* numbers of a place's encoding and of V-PM's visual condition */
    pointnet2_level_opts level;
    int width;                      /* that tokens are projected to; 0: as wide as they are */
    int layers, heads, ffn;
    double dropout;
    bool metric_radius;             /* group in metres, not in the unit sphere */
} gpm_opts;

/* An encoder layer as PyTorch has it, norms behind the sums. Names self_attn.q, .k, .v, .out, linear1, linear2, norm1,
 * norm2 */
typedef struct {
    lt_linear_layer q, k, v, out, linear1, linear2;
    lt_layer_norm_layer norm1, norm2;
} gpm_layer;

typedef struct {
    gpm_opts opts;
    lt_linear_layer embed1, embed2; /* a colour as GPM_COLOUR numbers: 3 - 64 - 48 */
    pointnet2_level level;          /* sa1, whose first convolution is "input" */
    lt_linear_layer project;        /* no parameters without opts.width */
    gpm_layer layer[GPM_LAYERS];
    lt_layer_norm_layer norm;       /* of what each layer gives the heads */
    lt_linear_layer translation[GPM_HEAD], rotation[GPM_HEAD];
} gpm;

/* gpm_token - how wide a token is before it is projected: 435 in the paper */
int gpm_token(const gpm_opts *o);

/* gpm_new - parameters PREFIX.embed1 .., PREFIX.sa1 with ULIP's names but for its first convolution, PREFIX.project,
 * PREFIX.encoder.0 .., PREFIX.norm, PREFIX.translation.0 .., PREFIX.rotation.0 ..; or without a prefix, "" */
void gpm_new(gpm *m, lt_params *set, const char *prefix, const gpm_opts *opts);

/* gpm_init - the encoder Xavier uniform, the heads' last layers N(0, 1e-5) and 0, the rest PyTorch's defaults */
void gpm_init(const gpm *m, uint64_t seed);

/* P of an object's Gaussians, of B frames. Nothing here gets a gradient. */
typedef struct {
    lt_tensor *points;              /* (B, P, 3): posed centres, metres in the camera frame */
    lt_tensor *count;               /* (B), LT_I32: how many of them there are, the others repeat some; NULL: all */
    lt_tensor *encoding;            /* (B, P, encoding): vpm_encode of the canonical centres */
    lt_tensor *covariance;          /* (B, P, 6), square metres */
    lt_tensor *colour;              /* (B, P, 3): as in the image, behind V-PM */
    lt_tensor *opacity;             /* (B, P, 1), 0 to 1 */
    lt_tensor *place;               /* (B, P, 2): where they are seen, in cells of the condition's map */
    lt_tensor *rgb;                 /* (B, P, 3): of the image there */
    lt_tensor *root;                /* (B, 3): the hand's root under the initial pose, metres */
    lt_tensor *start;               /* (B), LT_I32: the first centre; NULL: the first point */
    const vpm_condition *condition;
} gpm_in;

typedef struct {
    int layers;
    lt_tensor *translation[GPM_LAYERS];     /* (B, M, 3): each token's Delta T behind each layer, metres */
    lt_tensor *rotation[GPM_LAYERS];        /* (B, M, 9): Delta R, row by row */
    lt_tensor *delta_T;                     /* (B, 3): the last layer's, their mean over tokens */
    lt_tensor *delta_R;                     /* (B, 3, 3) */
} gpm_out;

gpm_out gpm_forward(const gpm *m, const gpm_in *in);

/* gpm_tokens, gpm_encode - the two halves of it: (B, M, token), and what comes of such tokens */
lt_tensor *gpm_tokens(const gpm *m, const gpm_in *in);
gpm_out gpm_encode(const gpm *m, lt_tensor *tokens);

#endif
