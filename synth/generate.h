/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a synthetic hand-object dataset in HO3D's or DexYCB's layout, so that everything runs on a machine that
 * has no dataset: the readers of the real ones read it.
 *
 * The same options give the same files, byte for byte, on any number of threads.
 */
#ifndef SYNTH_GENERATE_H
#define SYNTH_GENERATE_H

#include "libtensor/base/status.h"
#include "synth/stats.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    SYNTH_TINY,                     /* 2 subjects, 3 objects, 6 sequences of 16 frames */
    SYNTH_SMALL,                    /* 4, 6, 48 of 48 */
    SYNTH_DEMO,                     /* 3, 4, 1,660 of 2: as many grasps as a few minutes can make */
    SYNTH_PRETRAIN,                 /* 8, 7, 246 of 48, each frame of a grasp of its own: for first weights */
    SYNTH_DEFAULT,                  /* 10, 10, 200 of 70 */
    SYNTH_HOGS,                     /* 2, 4, 24 of 83 and 8 of 50 at 320 x 240; light and initial poses written down */
    SYNTH_DETECT,                   /* 5,000 single pictures, 320 x 320, for detectors: detect/ */
    SYNTH_TRACK,                    /* 20 films of 300 frames, 512 x 288, for trackers: track/ */
    SYNTH_ACTIONS,                  /* 2,000 clips of skeletons: actions/ */
    SYNTH_BODY,                     /* 10,000 pictures of persons, 192 x 256: body/ */
    SYNTH_TURNTABLE,                /* 60 photos of one still object, 400 x 400, with their cameras: turntable/ */
    SYNTH_WORLD,                    /* persons at a table, four cameras with depth, as a recording: workplace/ */
} synth_preset;

typedef enum { SYNTH_HO3D, SYNTH_DEXYCB } synth_layout;

typedef struct {
    synth_preset preset;
    synth_layout layout;
    const char *out;                /* a folder that does not exist yet or is empty */
    uint64_t seed;
    int frames;                     /* in all, dealt evenly to the sequences; 0: the preset's; SYNTH_WORLD: moments */
    int clips;                      /* SYNTH_ACTIONS: in all; 0: 2,000 */
    double difficulty;              /* SYNTH_ACTIONS, SYNTH_WORLD: in [0, 1] */
    int cameras;                    /* SYNTH_WORLD: 1 to 4; 0: 4 */
    double seconds;                 /* SYNTH_WORLD: how long it is; 0: 20 */
    bool coco, bop;                 /* SYNTH_WORLD: the same frames as COCO, as BOP have them too */
    double near;                    /* SYNTH_DETECT: in [0, 1]: share of pictures of a hand from near by */
    bool png;                       /* HO3D: lossless images, as v2 has them; off: JPEG, as v3 */
    bool still_light;               /* SYNTH_HOGS: the same light in all frames; off: global and local light vary */
    bool jitter;                    /* SYNTH_HOGS: each frame's channels are multiplied by 0.7 to 1.3 */
    bool alias_ycb;                 /* name the objects as the real ones; off: "syn_" before each name */
    /* told how far it is, on the caller's thread, every few frames; false: stop. May be NULL. */
    bool (*progress)(void *ctx, const char *step, int64_t done, int64_t total);
    void *progress_ctx;
} synth_options;

/* The difficulty of SYNTH_ACTIONS where none is named: the baseline is right in 70 % of the windows */
#define SYNTH_DIFFICULTY 0.21

/* synth_parse_preset - by synth_preset_name; synth_parse_layout - "ho3d", "dexycb" */
lt_status synth_parse_preset(const char *name, synth_preset *out);
const char *synth_preset_name(synth_preset preset);
lt_status synth_parse_layout(const char *name, synth_layout *out);

/**
 * synth_generate - write the dataset
 *
 * HO3D's layout: train/, evaluation/, train.txt, evaluation.txt, the two ground-truth files. DexYCB's: a folder for
 * each subject, calibration/, synthetic.json; cameras on a ring, right and left hands, things on the table. Both:
 * models/, stats.json (occlusion and contact figures) and manifest.json (options and the CRC-32 of every file;
 * written last, so a folder without it is unfinished). SYNTH_HOGS: hogs.h's files, in HO3D's layout alone.
 * SYNTH_DETECT: as COCO has it, detect/detect.h. SYNTH_TRACK: as MOTChallenge has it, track/track.h. SYNTH_ACTIONS:
 * actions/actions.h. SYNTH_BODY: body/set.h. SYNTH_TURNTABLE: as nerfstudio has it, turntable/turntable.h.
 * SYNTH_WORLD: a recording, workplace/workplace.h.
 *
 *   figures      (*n) the figures of stats.json with what is aimed at; both NULL: not wanted
 *
 * Errors: the folder has files in it, the disk is full, no memory; LT_ESTOPPED when progress
 * said so.
 */
lt_status synth_generate(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n);

#ifdef __cplusplus
}
#endif
#endif
