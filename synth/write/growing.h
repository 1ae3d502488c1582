/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A file of text that grows in memory while frames are recorded, and is written when they are all there.
 */
#ifndef SYNTH_WRITE_GROWING_H
#define SYNTH_WRITE_GROWING_H

#include "synth/write/manifest.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct { FILE *stream; char *text; size_t size; } synth_growing;

/* synth_growing_open - begin, with nothing in it; synth_growing_fini frees it in any case. what: for the line of
 * LT_ENOMEM */
lt_status synth_growing_open(synth_growing *g, const char *what);
void synth_growing_fini(synth_growing *g);

/* synth_growing_write - what has grown becomes root/within, which the manifest lists; g is empty then */
lt_status synth_growing_write(synth_growing *g, const char *root, const char *within, synth_manifest *manifest);

#ifdef __cplusplus
}
#endif
#endif
