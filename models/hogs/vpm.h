/* SPDX-License-Identifier: Apache-2.0 */
/*
 * V-PM: Gaussians that see the image. What a ViT says of the whole crop, of the pixel that a Gaussian is seen at,
 * and the Gaussian itself become an appearance code Z_v and small changes of place, size and rotation (psi and
 * psi_2: one trunk); from Z_v and the colour of its spherical harmonics comes the colour it has in this image.
 *                                                                                          [Eq. 6 to 11]
 *
 * One vpm is for all hands, one for all objects; its trunk has a row for each subject or object.
 */
#ifndef MODELS_HOGS_VPM_H
#define MODELS_HOGS_VPM_H

#include "libtensor/nn/layers.h"
#include "models/hogs/skin_field.h"

typedef struct {
    bool global, pixel, gaussian;   /* what the trunk reads: F, F(pi), G                              [Table 8] */
    int vit;                        /* numbers of F and of a cell of the map */
    int condition, trunk, appearance;           /* of the visual condition, a hidden layer, Z_v */
    lt_hash_grid_opts grid;
    bool one_blob;                  /* encode places by lt_one_blob instead of the hash grid */
    bool alpha3;                    /* alpha_v for each channel */
} vpm_opts;

typedef struct {
    vpm_opts opts;
    lt_param *table;                /* of the hash grid; NULL with one_blob */
    lt_linear_layer reduce;         /* W_r, b_r: [F; F(pi)] -> condition, no activation */
    set_mlp trunk;                  /* psi, psi_2 */
    lt_linear_layer alpha1, alpha2; /* psi_1: [c_sh; Z_v] - 64 - 1 */
    lt_linear_layer colour;         /* W_c, b_c: Z_v -> 3 */
} vpm;

/* vpm_new - for so many sets; parameters PREFIX.hash.table, .reduce, .trunk.0 .., .alpha1, .alpha2, .colour */
void vpm_new(vpm *m, lt_params *set, const char *prefix, int sets, const vpm_opts *opts);

/* vpm_init - as section "optimisation" has it: tables +-1e-4; the trunk's last layer N(0, 1e-5) and 0, so that it
 * begins by changing nothing */
void vpm_init(const vpm *m, uint64_t seed);

/* vpm_encoding - numbers of vpm_encode;  vpm_encode - places (..., 3) in the box's units, -1 to 1, as features */
int vpm_encoding(const vpm_opts *o);
lt_tensor *vpm_encode(const vpm *m, lt_tensor *places);

/* vpm_encode_by - by a hash grid whose table is this one */
lt_tensor *vpm_encode_by(lt_param *table, const lt_hash_grid_opts *grid, lt_tensor *places);

/* What of a frame's condition does not depend on the Gaussian: of B images */
typedef struct {
    lt_tensor *base;                /* (B, condition): W_F F + b_r */
    lt_tensor *map;                 /* (B, h w, condition): W_P of the map's cells; NULL without F(pi) */
    int h, w;
} vpm_condition;

/* vpm_condition_of - F (B, vit), the class token; map (B, h w, vit), its cells row by row */
vpm_condition vpm_condition_of(const vpm *m, lt_tensor *F, lt_tensor *map, int h, int w);

/* vpm_condition_at - W_r [F; F(pi)] + b_r where a Gaussian is seen: place (B, N, 2), column and row in cells of the
 * map -> (B, N, condition). No gradient to place. */
lt_tensor *vpm_condition_at(const vpm_condition *c, lt_tensor *place);

/* A set's Gaussians as the trunk reads them; no gradient passes but the encoding's. */
typedef struct {
    lt_tensor *encoding;            /* (N, ..): vpm_encode of the centres */
    lt_tensor *covariance;          /* (N, 6): xx xy xz yy yz zz, square metres */
    lt_tensor *sh;                  /* (N, 48) */
    lt_tensor *opacity;             /* (N, 1), 0 to 1 */
} vpm_gaussians;

typedef struct {
    lt_tensor *place;               /* dp (N, 3), metres */
    lt_tensor *scale;               /* ds (N, 3), of the logarithm */
    lt_tensor *rotation;            /* dq (N, 4), for the left of q: its first number is not used, 1 is in its place */
    lt_tensor *appearance;          /* Z_v (N, appearance) */
} vpm_out;

/* vpm_forward - of one image, c of B = 1, and the set in which (1), LT_I32; place (1, N, 2) as above */
vpm_out vpm_forward(const vpm *m, const vpm_condition *c, const vpm_gaussians *g, lt_tensor *place, lt_tensor *which);

/* L_nr: how much the trunk changes Gaussians, of which weight (N) says how much each counts, 0 for a row that is
 * none; NULL: all alike. The mean length of dp, the mean sum of |ds|, that of |dq|'s three numbers */
typedef struct {
    lt_tensor *place, *scale, *rotation;
} vpm_penalties;

vpm_penalties vpm_penalties_of(const vpm_out *out, lt_tensor *weight);

/* vpm_colour - c = (1 - alpha_v) c_sh + alpha_v v of colours (N, 3) and Z_v; v = sigmoid(W_c Z_v + b_c), alpha_v =
 * sigmoid(psi_1([c_sh; Z_v]))                                                                      [Eq. 6, 7] */
lt_tensor *vpm_colour(const vpm *m, lt_tensor *c_sh, lt_tensor *appearance);

#endif
