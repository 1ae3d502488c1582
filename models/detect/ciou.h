/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Complete intersection over union of two boxes.
 * Source: Zheng et al. 2020, "Distance-IoU loss", equations 9 to 11.
 */
#ifndef MODELS_DETECT_CIOU_H
#define MODELS_DETECT_CIOU_H

/* x0 y0 x1 y1 */
typedef struct { double v[4]; } ciou_box;

/* ciou - the overlap less the distance of the centres and the difference of the shapes, at most 1; *alpha: the weight
 * of the latter, or NULL */
double ciou(const ciou_box *a, const ciou_box *b, double *alpha);

/* ciou_with - the same with a given alpha, which is constant to the gradient with respect to a: grad (4), or NULL */
double ciou_with(const ciou_box *a, const ciou_box *b, double alpha, double *grad);

#endif
