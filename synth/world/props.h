/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The 21 objects, each for both hands.
 */
#ifndef SYNTH_WORLD_PROPS_H
#define SYNTH_WORLD_PROPS_H

#include "synth/world/grip.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lt_arena *arena[YCB_COUNT];
    synth_prop_pair pair[YCB_COUNT];            /* by YCB number less one */
} synth_props;

/* synth_props_init - make them, on all threads; synth_props_fini frees them in any case. LT_ENOMEM. */
lt_status synth_props_init(synth_props *p);

/* synth_props_init_some - the n objects with these YCB numbers alone; the others are empty */
lt_status synth_props_init_some(synth_props *p, const int *number, int n);
void synth_props_fini(synth_props *p);

#ifdef __cplusplus
}
#endif
#endif
