/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How the generator's takes become the files of a dataset: one of these for each layout that is written.
 */
#ifndef SYNTH_WRITE_LAYOUT_H
#define SYNTH_WRITE_LAYOUT_H

#include "synth/cast.h"
#include "synth/take/picture.h"
#include "synth/take/stage.h"
#include "synth/write/manifest.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A run, as far as a layout has to do with it. */
typedef struct {
    const synth_options *opt;
    lt_arena *arena;                /* lives as long as the run */
    synth_cast cast;
    lt_hand_model *hand;
    const synth_subject *subject;   /* (cast.n_subjects) */
    synth_manifest manifest;
    void *state;                    /* the layout's own */
} synth_session;

/* A frame that was filmed and annotated. */
typedef struct {
    const synth_take *take;
    const synth_stage *stage;
    void *own;                      /* the layout's, of the take */
    int camera, k;                  /* k: the frame's number among those kept */
    synth_picture picture;
    uint8_t *rgb, *label;           /* picture's planes, where they may be changed */
    float *depth;
} synth_shot;

typedef struct {
    const char *name;               /* as --layout takes it */
    const char *title, *title_png;  /* in the manifest, and where images are lossless; NULL: they never are */
    const char *axes;
    lt_status (*plan)(const synth_options *o, synth_cast *out);
    /* before the first take; makes state */
    lt_status (*open)(synth_session *s);
    /* the cameras of a take where the layout has its own, false: they are chosen to see it well */
    bool (*cameras)(const synth_session *s, const synth_take *take, synth_camera *out);
    double depth_unit;              /* metres in a step of its depth images */
    /* *own: what write, record and end_take find in the take's shots; from the arena. Several takes may have begun. */
    lt_status (*begin_take)(const synth_session *s, const synth_take *take, const synth_stage *stage, lt_arena *arena,
                            void **own);
    /* name and write one frame; called for several at once. files: SYNTH_FRAME_FILES places, *n are used */
    lt_status (*write)(const synth_session *s, synth_shot *shot, int quality, synth_file *files, int *n);
    /* each frame in its turn, after it was written */
    lt_status (*record)(synth_session *s, const synth_shot *shot);
    /* after the take's last frame was recorded, before the next take's first one is; last: that frame */
    lt_status (*end_take)(synth_session *s, const synth_shot *last);
    lt_status (*close)(synth_session *s);
    /* leaves nothing half-written; also after a failed open */
    void (*abort)(synth_session *s);
} synth_layout_ops;

extern const synth_layout_ops synth_layout_ho3d, synth_layout_dexycb;

#ifdef __cplusplus
}
#endif
#endif
