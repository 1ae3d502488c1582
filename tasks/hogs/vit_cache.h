/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a ViT that does not learn sees of each frame: looked at once, and kept as far as memory is given for it. Always
 * by the same plan, one frame at a time, so that it makes no difference what is kept.
 */
#ifndef TASKS_HOGS_VIT_CACHE_H
#define TASKS_HOGS_VIT_CACHE_H

#include "libtensor/graph/plan.h"
#include "models/hogs/hogs.h"

typedef struct {
    const hogs *m;
    lt_graph *g;
    lt_plan *plan;                  /* NULL: not begun */
    lt_tensor *image;
    vit_out seen;
    int64_t room;                   /* frames that may still be kept */
    int64_t frames;
    lt_real **kept;                 /* (frames) the feature, then the patches; NULL: not kept */
} vit_cache;

/* vit_cache_bytes - of a frame that is kept */
size_t vit_cache_bytes(const hogs *m);

/* vit_cache_new - for so many frames, in so many bytes at most; m outlives it. LT_ENOMEM.  vit_cache_free - also of
 * zeros */
lt_status vit_cache_new(const hogs *m, int64_t frames, size_t bytes, vit_cache *out);
void vit_cache_free(vit_cache *c);

/* vit_cache_begin - with the weights as they are from now on; once is enough. Errors: those of lt_compile.
 * vit_cache_look - then, of a frame whose crop (3, S, S) is always the same: feature (C), patches (map^2, C) */
lt_status vit_cache_begin(vit_cache *c);
void vit_cache_look(vit_cache *c, int64_t frame, const float *image, lt_real *feature, lt_real *patches);

#endif
