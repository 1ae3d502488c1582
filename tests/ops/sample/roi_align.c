/* SPDX-License-Identifier: Apache-2.0 */
/* roi_align against a plain NumPy transcription of torchvision's definition. */
#include "tests/ops/suite.h"

#include <math.h>

static lt_tensor *build(lt_tensor **in) { return lt_roi_align(in[0], in[1], 4, 3, 0.25); }
static lt_tensor *one(lt_tensor **in) { return lt_roi_align(in[0], in[1], 1, 1, 0.25); }
static lt_tensor *no_scale(lt_tensor **in) { return lt_roi_align(in[0], in[1], 4, 3, 0); }
static lt_tensor *no_size(lt_tensor **in) { return lt_roi_align(in[0], in[1], 0, 3, 1); }

/* Boxes inside, across the border, outside, tiny, and of images that are not there. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    const double B = (double)c->in[0].shape.dim[0];

    if (input == 0) {
        fill_clear_of_zero(c, input, v, n, r);
        return;
    }
    for (int64_t i = 0; i + 5 <= n; i += 5) {
        v[i] = (lt_real)floor(lt_rng_range(r, -0.2 * B, 1.2 * B));
        v[i + 1] = (lt_real)lt_rng_range(r, -20, 40);
        v[i + 2] = (lt_real)lt_rng_range(r, -20, 40);
        v[i + 3] = v[i + 1] + (lt_real)lt_rng_range(r, -2, 60);
        v[i + 4] = v[i + 2] + (lt_real)lt_rng_range(r, -2, 60);
    }
}

static const op_case cases[] = {
    { "boxes", build, .in = { S(2, 3, 9, 8), C(7, 5) }, .fill = fill },
    { "broken", build, .in = { S(2, 2, 6, 6), C(6, 5) }, .fill = fill },
    { "whole", one, .in = { S(1, 1, 20, 20), C(2, 5) }, .fill = fill },
    { "no_boxes", build, .in = { S(2, 3, 9, 8), C(0, 5) }, .fill = fill },
    { "no_images", build, .in = { S(0, 3, 9, 8), C(2, 5) }, .fill = fill },
    { "long", build, .in = { S(2, 37, 16, 16), C(9, 5) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 3, 9, 8), C(7, 4) }, "roi_align: boxes are (7, 4), want (R, 5)" },
    { build, { S(2, 3, 9, 8), C(5) }, "roi_align: boxes is (5), want 2 dimensions" },
    { build, { S(3, 9, 8), C(7, 5) }, "roi_align: map is (3, 9, 8), want 4 dimensions" },
    { build, { S(2, 3, 0, 8), C(7, 5) }, "roi_align: the map is empty" },
    { no_scale, { S(2, 3, 9, 8), C(7, 5) },
      "roi_align: output 4 x 3, scale 0: want sizes of at least 1 and a scale above 0" },
    { no_size, { S(2, 3, 9, 8), C(7, 5) },
      "roi_align: output 0 x 3, scale 1: want sizes of at least 1 and a scale above 0" },
};

static void vary(op_case *c, lt_rng *r)
{
    vary_map(c, r);
    c->in[1].shape = LT_SHAPE(pick(r, 0, 5), 5);
}

const op_suite roi_align_suite = { "roi_align", CASES(cases), BAD(bad), .vary = vary };
