/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How large, how hidden and how many the things in pictures for detectors are, against what was aimed at.
 */
#ifndef SYNTH_DETECT_TALLY_H
#define SYNTH_DETECT_TALLY_H

#include "synth/stats.h"
#include "synth/world/world.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { DETECT_FIGURES = 18 };

/* A thing that is seen in a picture. */
typedef struct {
    int kind;
    bool left, bare, cut;
    double side;                    /* geometric mean of its box's sides, pixels */
    double visible;                 /* share of it */
} detect_sight;

typedef struct {
    lt_arena *arena;
    int64_t n, pictures, empty;
    size_t room;
    detect_sight *sight;
} detect_tally;

/* detect_tally_add - the n things of one more picture; the memory is the arena's. LT_ENOMEM. */
lt_status detect_tally_add(detect_tally *t, const detect_sight *sight, int n);

/* detect_tally_figures - what they come to. LT_ENOMEM. */
lt_status detect_tally_figures(const detect_tally *t, synth_figure out[DETECT_FIGURES]);

#ifdef __cplusplus
}
#endif
#endif
