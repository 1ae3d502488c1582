/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A run of the generator, and how its takes are filmed.
 */
#ifndef SYNTH_FILM_H
#define SYNTH_FILM_H

#include "synth/hogs.h"
#include "synth/stats.h"
#include "synth/write/layout.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    synth_session session;
    const synth_layout_ops *layout;
    uint8_t part[LT_HAND_VERTICES];             /* synth_hand_parts */
    synth_prop *prop, *mirrored;                /* cast.n_objects of them; mirrored NULL: no take has a left hand */
    synth_stats stats;
    synth_hogs hogs;                            /* where the cast has it */
    int64_t done, total;                        /* frames */
} synth_run;

/* synth_report - tell how far the run is; LT_ESTOPPED when it shall go no further */
lt_status synth_report(synth_run *r, const char *step);

/**
 * synth_film_takes - prepare, film, write and record every take of the cast
 *
 * Errors: LT_ENOMEM, LT_EIO, LT_ESTOPPED.
 */
lt_status synth_film_takes(synth_run *r);

#ifdef __cplusplus
}
#endif
#endif
