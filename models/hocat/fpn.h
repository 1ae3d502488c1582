/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One branch of the decoupled feature pyramid: gated laterals, top-down sums, one smoothing convolution.
 * The hand and the object each have their own.                                    [HOCAT section 3.2]
 */
#ifndef MODELS_HOCAT_FPN_H
#define MODELS_HOCAT_FPN_H

#include "models/backbones/resnet.h"

/* Where squeeze-and-excitation gates stand. */
typedef enum { SE_LATERAL_AND_OUT, SE_OUT, SE_LATERAL, SE_NONE } hocat_se_place;

typedef struct {
    lt_conv_layer top, lateral[RESNET_STAGES - 1], smooth;      /* lateral[0] takes C2 */
    lt_se_layer gate[RESNET_STAGES - 1], gate_out;
    hocat_se_place se;
} hocat_fpn;

void hocat_fpn_new(hocat_fpn *m, lt_params *set, const char *prefix, const int channels[RESNET_STAGES],
                   int out, hocat_se_place se);

/*
 * hocat_fpn_forward - P2 (B, out, H/4, W/4)
 *
 * read: n lists of boxes (R, 5) by which P2 will be pooled, or n = 0. With boxes, only what they read of P2 is
 * computed: the rest of it is undefined, and the mean that its gate needs is found without it.
 */
lt_tensor *hocat_fpn_forward(const hocat_fpn *m, const resnet_out *c, lt_tensor *const *read, int n);

#endif
