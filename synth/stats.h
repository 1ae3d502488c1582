/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How much of the hands and objects of a dataset is hidden, against what was aimed at.
 */
#ifndef SYNTH_STATS_H
#define SYNTH_STATS_H

#include "synth/take/annotate.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const char *name;               /* "joints hidden, mean share" */
    double value, lo, hi;           /* found, and the range aimed at */
} synth_figure;

enum { SYNTH_FIGURES = 24 };        /* at most */

typedef struct {
    lt_arena *arena;
    int64_t n;
    size_t room;
    synth_visibility *frame;
    synth_figure more[SYNTH_FIGURES / 2];       /* of a preset's own */
    int n_more;
} synth_stats;

/* synth_stats_add - one frame more; the memory is the arena's. LT_ENOMEM. */
lt_status synth_stats_add(synth_stats *s, const synth_visibility *frame);

/* synth_stats_figures - what the frames come to, and how many figures that is; a figure without frames is NaN */
int synth_stats_figures(const synth_stats *s, synth_figure out[SYNTH_FIGURES]);

/* synth_figure_within - whether it is in its range; NaN is not */
static inline bool synth_figure_within(const synth_figure *f)
{
    return f->value >= f->lo && f->value <= f->hi;
}

/* synth_figures_write - root/stats.json of n figures, that `count` of what `counted` names went into: each with its
 * range and whether it is within. Being outside is no error: the few sequences of a small dataset may well be. */
lt_status synth_figures_write(const char *root, const char *counted, int64_t count, const synth_figure *figure, int n);

#ifdef __cplusplus
}
#endif
#endif
