/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a synthetic dataset consists of and was made from: manifest.json, written last.
 */
#ifndef SYNTH_WRITE_MANIFEST_H
#define SYNTH_WRITE_MANIFEST_H

#include "libtensor/base/arena.h"
#include "synth/generate.h"
#include "synth/write/file.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lt_arena *arena;
    const char *layout, *axes;      /* what it says of them */
    int width, height;              /* of the pictures */
    int64_t n;
    size_t room;
    synth_file *file;
} synth_manifest;

/* synth_manifest_add - n files more; the memory is the arena's. LT_ENOMEM. */
lt_status synth_manifest_add(synth_manifest *m, const synth_file *file, int n);

/* synth_manifest_file - root/within, which is there */
lt_status synth_manifest_file(synth_manifest *m, const char *root, const char *within);

/* synth_manifest_text - write root/within, a file of text in a folder that is there, and add it */
lt_status synth_manifest_text(synth_manifest *m, const char *root, const char *within, const char *text);

/* synth_manifest_write - root/manifest.json: that the data are synthetic, the options, a checksum of the
 * hand model where there is one, and the CRC-32 of every file added */
lt_status synth_manifest_write(const synth_manifest *m, const synth_options *options,
                               const lt_hand_model *hand);

#ifdef __cplusplus
}
#endif
#endif
