/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Surfaces of frames, one after the other, as one animated GLB.
 */
#ifndef TASKS_HOGS_RESULTS_ANIMATION_H
#define TASKS_HOGS_RESULTS_ANIMATION_H

#include "estimate/posed/posed.h"
#include "libtensor/base/arena.h"

enum { HOGS_ANIMATION_FPS = 10 };

/* A hand bends, so each frame has a surface of its own, shown for a tenth of a second; an object is rigid, so the first
 * frame that it is in gives the surface, and each frame its pose. */
typedef struct {
    lt_arena *arena;
    lt_opacity_rule rule;
    double iso;
    struct hogs_actor *actor;       /* (n): a node of the file */
    int n, frames;
    size_t room;
} hogs_animation;

/* hogs_animation_add - task_posing.visit, ctx a hogs_animation: one more frame. Errors: those of the surfaces, but that
 * a part may have none.  hogs_animation_write - the file. Errors: no frame has a surface; those of lt_glb_write. */
lt_status hogs_animation_add(void *ctx, const posed_frame *f);
lt_status hogs_animation_write(const hogs_animation *a, const char *path);

#endif
