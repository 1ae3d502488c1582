/* SPDX-License-Identifier: Apache-2.0 */
/* Points and five kinds of predictions of them, as scripts/vectors/metrics.py makes them. */
#ifndef TESTS_EVAL_PREDICTIONS_H
#define TESTS_EVAL_PREDICTIONS_H

#include "tests/eval/lcg.h"

static inline void make_truth(uint32_t *state, int n, float g[][3])
{
    static const double centre[3] = { .05, .02, -.6 };

    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 3; k++)
            g[i][k] = (float)(lcg(state) * .1 + centre[k]);
    }
}

static inline void predict_point(int kind, const float *g, const double *noise, float *p)
{
    static const double scale[5] = { .002, .01, .005, .005, 0 }, shift[3] = { .01, -.02, .03 };
    const double turned[3] = { -(double)g[1], g[0], g[2] };

    for (int k = 0; k < 3; k++) {
        double x = g[k];

        if (kind == 2)
            x = turned[k] * 1.3;
        else if (kind == 3 && k == 0)
            x = -x;
        x += noise[k] * scale[kind];
        if (kind == 1)
            x += shift[k];
        p[k] = kind == 4 ? 0 : (float)x;
    }
}

static inline void make_predictions(int kind, uint32_t *state, int n, float g[][3], float p[][3])
{
    make_truth(state, n, g);
    for (int i = 0; i < n; i++) {
        double noise[3];

        for (int k = 0; k < 3; k++)
            noise[k] = lcg(state);
        predict_point(kind, g[i], noise, p[i]);
    }
}

#endif
