/* SPDX-License-Identifier: Apache-2.0 */
/* ssim_loss against convolutions of torch, pictures smaller and larger than its window. */
#include "tests/ops/suite.h"

static lt_tensor *ssim_loss(lt_tensor **in) { return lt_ssim_loss(in[0], in[1]); }

static const op_case cases[] = {
    { "picture", ssim_loss, .in = { S(3, 17, 14), C(3, 17, 14) }, .fill = fill_positive },
    { "small", ssim_loss, .in = { S(1, 4, 7), C(1, 4, 7) }, .fill = fill_positive },
    { "large", ssim_loss, .in = { S(2, 61, 130), C(2, 61, 130) }, .fill = fill_positive, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { ssim_loss, { S(2, 3), S(2, 3) }, "ssim_loss: a is (2, 3), want 3 dimensions" },
    { ssim_loss, { S(3, 4, 5), S(3, 4, 4) }, "ssim_loss: b is (3, 4, 4), want (3, 4, 5)" },
};

const op_suite ssim_loss_suite = { "ssim_loss", CASES(cases), BAD(bad) };
