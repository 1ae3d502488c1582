/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Gaussians as an image: what its steps hand to each other.
 *
 * A Gaussian has a centre and three axes in the camera's frame, its covariance is M M^T of the axes' matrix M, and it
 * is seen as an ellipse on the screen [Zwicker et al. 2001, "EWA volume splatting"; Kerbl et al. 2023, "3D Gaussian
 * splatting"]. Exponents are powers of two in here, so that alpha is 2^(top - distance).
 */
#ifndef LT_KERNELS_SPLAT_TYPES_H
#define LT_KERNELS_SPLAT_TYPES_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_SPLAT_TILE = 16, LT_SPLAT_CELLS = LT_SPLAT_TILE * LT_SPLAT_TILE };

/* A pinhole camera; pixel (column, row) is sampled at just that place. Nothing at z <= near is seen. */
typedef struct {
    lt_real fx, fy, cx, cy, near_z;
    int64_t width, height;
} lt_splat_view;

/* n Gaussians as they are given: centre (n, 3), axes (n, 3, 3) by rows with an axis in each column, opacity (n),
 * colour (n, 3), offset (n, 2) in pixels or NULL */
typedef struct {
    int64_t n;
    const lt_real *centre, *axes, *opacity, *colour, *offset;
} lt_splat_cloud;

/* Their gradients, each of which may be NULL */
typedef struct {
    lt_real *centre, *axes, *opacity, *colour, *offset;
} lt_splat_cloud_grad;

/* A Gaussian on the screen: 64 bytes, a line of the caches. With (dx, dy) = (u - column, v - row):
 *   alpha = 2^(top - xx dx^2 - xy dx dy - yy dy^2)
 * Its ellipse is what has alpha >= 1/255. t rows below v it has the columns u + lean t -+ wide sqrt(tall^2 - t^2), and
 * s columns beside u the rows v + slant s -+ high sqrt(broad^2 - s^2). tall = 0: it is not drawn. */
typedef struct {
    lt_real u, v, xx, xy, yy, top;
    lt_real colour[3], z;
    lt_real tall, lean, wide, broad, slant, high;
} lt_splat_seen;

/* One Gaussian in one tile. Instances are numbered by depth, and a Gaussian's follow each other. */
typedef struct {
    uint32_t gaussian, instance;
} lt_splat_entry;

/* Planes of a tile's state, LT_SPLAT_CELLS each: the light that is left, less than 0 once a pixel is finished, and the
 * sums of both sets. Without sets all goes to the first, whose share is 1 - |light|. */
enum { LT_SPLAT_LIGHT, LT_SPLAT_SET, LT_SPLAT_SHARE = 3, LT_SPLAT_OTHER = 5, LT_SPLAT_DEPTH = 9, LT_SPLAT_PLANES = 10 };

/* What is drawn in a tile: n entries, near to far */
typedef struct {
    const lt_splat_seen *seen;
    const lt_splat_entry *entry;
    int64_t n;
    lt_real x0, y0;             /* column and row of its first pixel */
    uint32_t first;             /* Gaussians below it are of the first set, the others of the second */
    bool sets, depth;           /* which sums are wanted */
} lt_splat_tile;

/* Planes of a tile's gradients: what a pixel's weight gives each set, by colour and by itself, and by depth; then what
 * lies behind what was drawn, the sum over the rest of the list of weight times that, background and all. */
enum { LT_SPLAT_GRAD_OTHER = 4, LT_SPLAT_GRAD_DEPTH = 8, LT_SPLAT_GRAD_REST, LT_SPLAT_GRAD_PLANES };

/* Sums over an instance's pixels of t = the gradient of log(alpha), of its moments by (dx, dy), and of what colour and
 * depth get */
enum {
    LT_SPLAT_T, LT_SPLAT_TX, LT_SPLAT_TY, LT_SPLAT_TXX, LT_SPLAT_TXY, LT_SPLAT_TYY, LT_SPLAT_TCOLOUR,
    LT_SPLAT_TZ = 9, LT_SPLAT_SUMS, LT_SPLAT_SLOPES = 16
};

/* A Gaussian as a ray meets it, in any frame: `white` takes a difference from its centre to where alpha is
 * 2^(top - squared length) */
typedef struct {
    lt_real centre[3], white[9], top;
} lt_splat_round;

/* What the segments from one place, the eye, to a group of points may meet: n numbers of Gaussians, in any order. eye:
 * of each Gaussian, what white makes of the eye less the centre. */
typedef struct {
    const lt_splat_round *gaussian;
    const lt_real (*eye)[3];
    const uint32_t *number;
    int64_t n;
} lt_splat_rays;

typedef struct {
    /* project: Gaussians [at, at + n) on the screen, and three deviations along the longer axis of each, in whole
     * pixels. What is not finite, too near or of opacity below 1/255 is not drawn.
     * project_grad: of Gaussians gaussian[0 .. n), all different, from the sums of their instances; adds to *to. */
    void (*project)(lt_splat_seen *out, lt_real *radius, const lt_splat_cloud *g, const lt_splat_view *view, int64_t at,
                    int64_t n);
    void (*project_grad)(const lt_splat_cloud_grad *to, const lt_splat_cloud *g, const lt_splat_view *view,
                         const uint32_t *gaussian, const lt_real (*sums)[LT_SPLAT_SLOPES], int64_t n);

    /* blend: draw on a tile's state (LT_SPLAT_PLANES, LT_SPLAT_CELLS) until no light is left;
     * blend_grad: the same from the light at its start, with gradients (LT_SPLAT_GRAD_PLANES, LT_SPLAT_CELLS), whose
     * rest is taken along; slopes[instance] becomes its sums, by halves over columns. */
    void (*blend)(lt_real *state, const lt_splat_tile *t);
    void (*blend_grad)(lt_real (*slopes)[LT_SPLAT_SLOPES], lt_real *light, lt_real *grad, const lt_splat_tile *t);

    /* dim: light[i], i < n, times what is left of it on the segment to point i: 1 - alpha of each Gaussian where the
     * segment meets it best, but of those with alpha below 1/255, or that the eye has behind it. x has planes ld apart;
     * n is a multiple of LT_POINTS. */
    void (*dim)(lt_real *light, const lt_real *x, int64_t ld, int64_t n, const lt_splat_rays *rays);
} lt_splat_kernels;

#ifdef __cplusplus
}
#endif
#endif
