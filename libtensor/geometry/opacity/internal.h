/* SPDX-License-Identifier: Apache-2.0 */
/* A field as it is made and asked: its views, and what each of them may see in a tile. */
#ifndef LT_GEOMETRY_OPACITY_INTERNAL_H
#define LT_GEOMETRY_OPACITY_INTERNAL_H

#include "libtensor/geometry/opacity/opacity.h"

#include "libtensor/kernels/splat_types.h"

/* Tiles along a side of a view. They are a matter of speed: a tile's list has all that can be met in it. */
enum { OPACITY_SIDE = 32, OPACITY_TILES = OPACITY_SIDE * OPACITY_SIDE };

typedef struct {
    double eye[3], axes[9];         /* from the middle; rows are right, down, forward */
    lt_real (*met)[3];              /* (n) the eye from each Gaussian, as lt_splat_rays has it */
    uint32_t *number;               /* of Gaussians, tile by tile, ascending */
    int64_t first[OPACITY_TILES + 1];
} opacity_view;

struct lt_opacity_field {
    int64_t n;
    double middle[3], reach;        /* all is within reach of the middle, and well before the views */
    lt_splat_round *gaussian;       /* (n) from the middle */
    opacity_view view[LT_OPACITY_VIEWS];
};

/* opacity_tile - of a place from the middle, before the view */
int opacity_tile(const opacity_view *v, const double x[3]);

/* opacity_look - sort the Gaussians into the tiles of the field's view k. covariance (n, 9) as it counts. LT_ENOMEM */
lt_status opacity_look(lt_opacity_field *f, int k, const lt_gaussian *g, const double (*covariance)[9],
                       lt_arena *arena);

#endif
