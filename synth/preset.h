/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What every preset does about its folder: makes it, tells how far it is, and ends it.
 */
#ifndef SYNTH_PRESET_H
#define SYNTH_PRESET_H

#include "synth/render/render.h"
#include "synth/write/manifest.h"

#ifdef __cplusplus
extern "C" {
#endif

/* synth_folders - make n folders within out. LT_EIO, LT_ENOSPC, LT_ENOMEM. */
lt_status synth_folders(const char *out, const char *const *within, size_t n);

/* synth_tell - that done of total of what `counted` names are there; LT_ESTOPPED when it shall go no further */
lt_status synth_tell(const synth_options *o, const char *step, const char *counted, int64_t done, int64_t total);

/* synth_jpeg - the colours of a frame into root/within, and what the manifest says of the file */
lt_status synth_jpeg(const char *root, const char *within, const synth_frame *f, int quality, synth_file *out);

/* What a dataset turned out to be. */
typedef struct {
    const char *counted;            /* "frames": what ... */
    int64_t count;                  /* ... so many went into the figures of */
    const synth_figure *figure;
    int n;
    bool strict;                    /* a figure outside its range is an error */
} synth_result;

/**
 * synth_finish - write stats.json, and the manifest last of all
 *
 *   hand         NULL: no hand model went into it
 *
 * Errors: LT_ENUMERIC where a strict result has a figure outside its range: the folder is then without a manifest;
 * LT_EIO, LT_ENOSPC, LT_ENOMEM.
 */
lt_status synth_finish(synth_manifest *m, const synth_options *o, const lt_hand_model *hand, const synth_result *r);

#ifdef __cplusplus
}
#endif
#endif
