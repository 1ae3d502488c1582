/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A world's frames and what is true of them as other programs read them, beside the recording:
 *
 *   coco/annotations/instances_train.json, coco/train/front_000001.jpg     persons, hands, objects (write/coco.h)
 *   bop/train_synt/000001/      the first camera: poses of objects (write/bop.h), rgb/, depth/, mask/, mask_visib/
 *   bop/models/, bop/dataset_info.md
 *
 * Masks are of what is seen, and amodal: of what would be if nothing stood before it.
 */
#ifndef SYNTH_WORKPLACE_EXPORT_H
#define SYNTH_WORKPLACE_EXPORT_H

#include "synth/workplace/scene.h"
#include "synth/write/bop.h"
#include "synth/write/coco.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { EXPORT_FILES = 3 + 2 * WORKPLACE_OBJECTS };

typedef struct {
    const synth_options *opt;       /* coco, bop, out */
    const recording_rig *rig;
    synth_coco list;
    synth_bop_scene scene[RECORDING_CAMERAS];
} workplace_export;

/* What is exported of a camera's frame; made by whichever thread films it. */
typedef struct {
    synth_coco_image image;
    synth_bop_image poses;
    synth_file file[EXPORT_FILES];
    int n_files;
} export_view;

/* export_open - make folders, and begin files; export_fini frees e in any case. What the options do not ask for is
 * left out by all of these. LT_EIO, LT_ENOSPC, LT_ENOMEM. */
lt_status export_open(workplace_export *e, const synth_options *options, const recording_rig *rig);
void export_fini(workplace_export *e);

/**
 * export_shoot - a frame of camera c, whose picture the recording holds; on any thread
 *
 *   kept     the arena that the view's text lives in, until export_add; scratch: for what is needed meanwhile
 *   seen     by thing (synth_world_look)
 *   depth    in steps of WORKPLACE_DEPTH_STEP
 *
 * Errors: LT_EIO, LT_ENOSPC, LT_ENOMEM.
 */
lt_status export_shoot(const workplace_export *e, lt_arena *kept, lt_arena *scratch, const workplace_scene *scene,
                       int c, const synth_seen *seen, const uint16_t *depth, export_view *out);

/* export_add - frames in the order in which files shall have them. LT_ENOMEM. */
lt_status export_add(workplace_export *e, int c, const export_view *view, synth_manifest *manifest);

/* export_close - write what belongs to all frames */
lt_status export_close(workplace_export *e, const workplace_script *script, synth_manifest *manifest);

#ifdef __cplusplus
}
#endif
#endif
