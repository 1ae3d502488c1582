/* SPDX-License-Identifier: Apache-2.0 */
/*
 * LPIPS of two pictures: the network, with weights that somebody gave, and a graph of it.
 */
#ifndef EVAL_METRICS_LPIPS_SCORE_H
#define EVAL_METRICS_LPIPS_SCORE_H

#include "eval/metrics/image.h"
#include "models/backbones/lpips.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct eval_lpips eval_lpips;

/* Borrowed. The network may go when eval_lpips_new has returned only where there are files. */
typedef struct {
    const lpips *network;           /* where no file says otherwise; NULL: one with a random trunk */
    const char *const *file;        /* (n_files) of weights: all in one, or AlexNet's and the channels' apart */
    int n_files;
    int height, width;              /* of the largest picture */
} eval_lpips_options;

/* What a picture is at distance, times 1000: of values in [0, 1] as they are, and mapped to [-1, 1] */
typedef struct { double raw01, sym; } eval_lpips_scores;

/* eval_lpips_takes - whether the network takes pictures of that size */
bool eval_lpips_takes(int height, int width);

/* eval_lpips_new - for pictures up to a size that it takes. Errors: LT_ENOMEM; those of weights_init. */
lt_status eval_lpips_new(const eval_lpips_options *o, eval_lpips **out);
void eval_lpips_free(eval_lpips *s);

/* eval_lpips_name - "lpips", or "lpips (random trunk)" where weights are missing: no LPIPS, and nothing to compare */
const char *eval_lpips_name(const eval_lpips *s);

/* eval_lpips_score - of two pictures of three channels, values in [0, 1] */
eval_lpips_scores eval_lpips_score(const eval_lpips *s, const eval_pictures *p);

#ifdef __cplusplus
}
#endif
#endif
