/* SPDX-License-Identifier: Apache-2.0 */
/* What the rasteriser's two directions share. */
#ifndef LT_OPS_SPLAT_RASTER_H
#define LT_OPS_SPLAT_RASTER_H

#include "libtensor/kernels/splat/lists.h"
#include "libtensor/ops/common.h"

enum {
    RASTER_CENTRE, RASTER_AXES, RASTER_OPACITY, RASTER_COLOUR, RASTER_CAMERA, RASTER_OFFSET, RASTER_FIRST, RASTER_IN
};
enum { RASTER_IMAGE, RASTER_RADIUS, RASTER_INSTANCES };
enum { RASTER_BLOCK = 256 };            /* Gaussians that a task projects */

typedef struct {
    lt_splat_opts o;
} raster_attr;

/* Channels of the image; -1 for those that it has not. Sets stand side by side. */
typedef struct {
    int colour, set_colour, opacity, set_opacity, depth, n;
} raster_channels;

/* From forward to backward */
typedef struct {
    lt_splat_lists lists;
    lt_splat_seen *seen;                /* (n) */
    lt_real (*state)[LT_SPLAT_PLANES][LT_SPLAT_CELLS];      /* of each tile */
} raster_frame;

static inline const lt_splat_opts *raster_opts(const lt_call *c)
{
    return &((const raster_attr *)c->attr)->o;
}

raster_channels raster_channels_of(const lt_splat_opts *o);
lt_splat_view raster_view(const lt_call *c);
lt_splat_cloud raster_cloud(const lt_call *c);

/* raster_tile - the entries of a tile that stand in the lists */
lt_splat_tile raster_tile(const lt_call *c, const raster_frame *f, int64_t tile);

/* raster_start_light - 1 where a tile's pixels are on the image; the others are finished */
void raster_start_light(lt_real light[LT_SPLAT_CELLS], const lt_splat_opts *o, const lt_splat_tile *t);

void raster_forward(const lt_call *c);
void raster_backward(const lt_call *c);

/* raster_frame_bytes, raster_grad_bytes - what forward leaves behind, and what backward works in */
size_t raster_frame_bytes(const lt_call *c);
size_t raster_grad_bytes(const lt_call *c);

#endif
