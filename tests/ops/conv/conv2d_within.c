/* SPDX-License-Identifier: Apache-2.0 */
/* conv2d_within and box_region together: what roi_align reads of a convolution is as if all were there. */
#include "tests/ops/suite.h"

enum { IN, WEIGHT, BIAS, BOXES, MORE, OTHER_BOXES };

static lt_tensor *pooled(lt_tensor **in, int pad)
{
    lt_tensor *x = in[IN], *boxes[] = { in[BOXES], in[OTHER_BOXES] };
    const int64_t less = lt_dim(in[WEIGHT], 2) - 1 - 2 * pad;
    lt_tensor *region = lt_box_region(boxes, 2, lt_dim(x, 0), lt_dim(x, 2) - less, lt_dim(x, 3) - less, 0.25, 0);
    lt_tensor *y = lt_conv2d_within(x, in[WEIGHT], in[BIAS], &(lt_conv_opts){ .pad = pad }, region);

    return lt_add(lt_roi_align(lt_leaky_relu(y, 0.1), in[BOXES], 4, 3, 0.25), in[MORE]);
}

static lt_tensor *square(lt_tensor **in) { return pooled(in, 1); }
static lt_tensor *unpadded(lt_tensor **in) { return pooled(in, 0); }
static lt_tensor *same(lt_tensor **in) { return lt_conv2d_within(in[0], in[1], NULL, NULL, in[2]); }
static lt_tensor *region(lt_tensor **in) { return lt_box_region(in, 1, 2, 8, 9, 0.25, 0); }
static lt_tensor *nowhere(lt_tensor **in) { return lt_box_region(in, 1, 2, 0, 9, 0.25, 0); }

static const op_case cases[] = {
    { "square", square, .in = { S(2, 3, 9, 8), S(5, 3, 3, 3), S(5), C(7, 5), S(7, 5, 4, 3), C(1, 5) } },
    { "pointwise", unpadded, .in = { S(2, 3, 9, 8), S(5, 3, 1, 1), S(5), C(7, 5), S(7, 5, 4, 3), C(1, 5) } },
    { "shrinking", unpadded, .in = { S(2, 3, 9, 8), S(5, 3, 3, 3), S(5), C(7, 5), S(7, 5, 4, 3), C(1, 5) } },
    { "winograd", square, .in = { S(2, 32, 20, 17), S(32, 32, 3, 3), S(32), C(2, 5), S(2, 32, 4, 3), C(1, 5) } },
    { "no_boxes", square, .in = { S(2, 3, 9, 8), S(5, 3, 3, 3), S(5), C(0, 5), S(0, 5, 4, 3), C(1, 5) } },
};

static const op_bad_case bad[] = {
    { same, { C(2, 3, 9, 8), C(5, 3, 1, 1), C(2, 5) }, "conv2d_within: region is (2, 5), want (2, 4)" },
    { region, { C(7, 4) }, "box_region: boxes are (7, 4), want (R, 5)" },
    { region, { C(5) }, "box_region: boxes is (5), want 2 dimensions" },
    { nowhere, { C(7, 5) },
      "box_region: 2 maps of 0 x 9, scale 0.25, margin 0: want none below 0, and sizes and a scale above 0" },
};

const op_suite conv2d_within_suite = { "conv2d_within", CASES(cases), BAD(bad), .value_tol = 4e-6, .grad_tol = 4e-6 };
