/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The ops. Each is one file in this folder: shape rule, forward, backward. All of them record into the
 * graph of their inputs; the returned tensors belong to that graph. Shapes that do not fit are
 * remembered by the graph and reported by lt_compile with the layer's name and the caller's line.
 */
#ifndef LT_OPS_OPS_H
#define LT_OPS_OPS_H

#include "libtensor/geometry/skin/skin.h"
#include "libtensor/graph/graph.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- element-wise ---------------------------------------------------------------------------------- */

/* lt_add, lt_sub, lt_mul - with NumPy's broadcasting: dimensions are matched from the last one, and 1
 * stretches. Errors: dimensions that differ and are not 1. */
LT_API lt_tensor *lt_add(lt_tensor *a, lt_tensor *b);
LT_API lt_tensor *lt_sub(lt_tensor *a, lt_tensor *b);
LT_API lt_tensor *lt_mul(lt_tensor *a, lt_tensor *b);

/* lt_scale - s * x for a number known while recording */
LT_API lt_tensor *lt_scale(lt_tensor *x, double s);

/* lt_leaky_relu - x where x > 0, slope * x elsewhere; the gradient at 0 takes the slope. lt_relu has
 * slope 0. Source: Maas et al. 2013, section 2. */
LT_API lt_tensor *lt_leaky_relu(lt_tensor *x, double slope);
LT_API lt_tensor *lt_relu(lt_tensor *x);

/* lt_sigmoid - 1 / (1 + exp(-x));  lt_tanh;  lt_silu - x * sigmoid(x);
 * lt_elu - x where x > 0, exp(x) - 1 elsewhere;  lt_gelu - x (1 + erf(x / sqrt 2)) / 2, exact;
 * lt_quick_gelu - x * sigmoid(1.702 x), as CLIP has it */
LT_API lt_tensor *lt_sigmoid(lt_tensor *x);
LT_API lt_tensor *lt_tanh(lt_tensor *x);
LT_API lt_tensor *lt_silu(lt_tensor *x);
LT_API lt_tensor *lt_elu(lt_tensor *x);
LT_API lt_tensor *lt_gelu(lt_tensor *x);
LT_API lt_tensor *lt_quick_gelu(lt_tensor *x);

/* lt_dropout - zero each value with probability p and scale the rest by 1 / (1 - p); in plans without
 * backward it is nothing. The draws depend on lt_plan_set_step, not on threads. Errors: p not in [0, 1). */
LT_API lt_tensor *lt_dropout(lt_tensor *x, double p);

/* lt_stochastic_depth - the same, but whole samples (dimension 0) are zeroed: a block left out.
 * Source: Huang et al. 2016, "Deep networks with stochastic depth". */
LT_API lt_tensor *lt_stochastic_depth(lt_tensor *x, double p);

/* ---- shape ----------------------------------------------------------------------------------------- */

/* lt_reshape - the same values under another shape, no copy. Errors: another number of elements. */
LT_API lt_tensor *lt_reshape(lt_tensor *x, lt_shape shape);

/* lt_permute - dimension i of the result is dimension order[i] of x. Errors: order is no permutation. */
LT_API lt_tensor *lt_permute(lt_tensor *x, const int *order);

/* lt_concat - n tensors (at most LT_MAX_IN) one after another along axis; other dimensions must agree */
LT_API lt_tensor *lt_concat(lt_tensor *const *x, int n, int axis);

/* lt_slice - elements start .. start + length - 1 along axis. Errors: not inside x. */
LT_API lt_tensor *lt_slice(lt_tensor *x, int axis, int64_t start, int64_t length);

/**
 * lt_rows - n rows of x from a place that is data
 *
 *   x        (N, ...)                a parameter that is stepped by rows (libtensor/graph/rows.h), or any other tensor
 *   first    () or (1), LT_I32       the first row: an input, set before each run
 *   returns  (n, ...)                x[first] ... x[first + n - 1]; zeros for rows that x does not have
 *
 * The gradient reaches these rows of x alone; of a parameter that is stepped by rows, those of them that are touched
 * (lt_param_touch). Errors: x without dimensions; first not one LT_I32; n not in 0 .. N.
 */
LT_API lt_tensor *lt_rows(lt_tensor *x, lt_tensor *first, int64_t n);

/* lt_detach - the same values, no copy; no gradient passes */
LT_API lt_tensor *lt_detach(lt_tensor *x);

/* lt_sample_index - the number of each sample of x (B, ...): 0, 1 ... B - 1, as (B, 1); no gradient */
LT_API lt_tensor *lt_sample_index(lt_tensor *x);

/* ---- products -------------------------------------------------------------------------------------- */

/**
 * lt_linear - y = x w^T + b over the last dimension
 *
 *   x  (..., K)      w  (N, K)      b  (N) or NULL      returns (..., N)
 *
 * Errors: sizes that differ.
 */
LT_API lt_tensor *lt_linear(lt_tensor *x, lt_tensor *w, lt_tensor *b);

/* lt_matmul - (B, M, K) times (B, K, N), or without B */
LT_API lt_tensor *lt_matmul(lt_tensor *a, lt_tensor *b);

/**
 * lt_attention - softmax(q k^T / sqrt(d)) v, head by head
 *
 *   q  (B, T, C)      k, v  (B, S, C)      returns (B, T, C); d = C / heads
 *
 * Channels h*d .. h*d + d - 1 belong to head h. The scores are never stored whole: a block of rows at a
 * time, and backward makes them again from the row maxima and sums.
 * Errors: shapes that differ, heads that do not divide C. Source: Vaswani et al. 2017, section 3.2.
 */
LT_API lt_tensor *lt_attention(lt_tensor *q, lt_tensor *k, lt_tensor *v, int heads);

/**
 * lt_deformable_attention - each query sums samples of a map at a few places of its own
 *
 *   value      (B, h * w, C)                  the map, projected; C / heads channels belong to a head
 *   offset     (B, T, heads * points * 2)     by head, point, (x, y), in cells
 *   logit      (B, T, heads * points)         become weights by a softmax over a head's points
 *   reference  (T, 2)                         column and row from which a query's offsets count; a cell's
 *                                             centre is a whole number
 *   returns    (B, T, C)
 *
 * Samples are bilinear and 0 outside the map. Gradients reach value, offset and logit; reference is a constant.
 * Errors: shapes that do not fit h x w, heads that do not divide, more than 16 points a head.
 * Source: Zhu et al. 2021, "Deformable DETR", equation 2, on one scale, without its projections.
 */
LT_API lt_tensor *lt_deformable_attention(lt_tensor *value, lt_tensor *offset, lt_tensor *logit,
                                          lt_tensor *reference, int heads, int h, int w);

/* lt_cell_places - the reference of queries that are the cells of the map: (h * w, 2) of column and row */
LT_API lt_tensor *lt_cell_places(lt_graph *g, int h, int w);

typedef struct {
    int stride, pad, dilation, groups;          /* 0 means 1, and for pad 0 */
    bool only_h;                                /* stride, pad and dilation are along H alone, for windows of k x 1 */
} lt_conv_opts;

/**
 * lt_conv2d - cross-correlation with zero padding
 *
 *   x  (B, C, H, W)      w  (O, C / groups, kh, kw)      b  (O) or NULL
 *   returns  (B, O, H', W'), H' = (H + 2 pad - dilation (kh - 1) - 1) / stride + 1, rounded down
 *
 * opts NULL: stride 1, no padding, dilation 1, one group. With only_h W' is what stride 1 without padding leaves.
 * Errors: channels that do not fit the weight, groups that do not divide, a window larger than the map.
 */
LT_API lt_tensor *lt_conv2d(lt_tensor *x, lt_tensor *w, lt_tensor *b, const lt_conv_opts *opts);

/**
 * lt_conv2d_within - the same, computed only in one rectangle of each image's result
 *
 * region (B, 4) as lt_box_region makes it. What lies outside is undefined, and of no influence: whatever reads the
 * result, as lt_roi_align does, must send no gradient there. Strides and groups other than 1 compute everything.
 * Errors: as lt_conv2d; a region of another shape.
 */
LT_API lt_tensor *lt_conv2d_within(lt_tensor *x, lt_tensor *w, lt_tensor *b, const lt_conv_opts *opts,
                                   lt_tensor *region);

/**
 * lt_conv_transpose2d - the transpose of a convolution: each value spreads a window
 *
 *   x  (B, C, H, W)      w  (C, O, kh, kw)      b  (O) or NULL
 *   returns  (B, O, H', W'), H' = (H - 1) stride - 2 pad + kh
 *
 * Errors: channels that do not fit the weight, a map of which nothing is left.
 */
LT_API lt_tensor *lt_conv_transpose2d(lt_tensor *x, lt_tensor *w, lt_tensor *b, int stride, int pad);

/* ---- maps (B, C, H, W) ------------------------------------------------------------------------------ */

/* lt_max_pool2d - the largest of k x k, padded with nothing; ceil_mode keeps a last partial window */
LT_API lt_tensor *lt_max_pool2d(lt_tensor *x, int k, int stride, int pad, bool ceil_mode);

/* lt_global_avg_pool - the mean over H, W: (B, C) */
LT_API lt_tensor *lt_global_avg_pool(lt_tensor *x);

/* lt_upsample_nearest - each cell becomes factor x factor equal ones */
LT_API lt_tensor *lt_upsample_nearest(lt_tensor *x, int factor);

/* lt_resize_bilinear - to (h, w), half-pixel centres (align_corners false), no antialiasing: the source
 * of i is (i + 0.5) * H / h - 0.5, clamped at 0; neighbours clamped to the border */
LT_API lt_tensor *lt_resize_bilinear(lt_tensor *x, int64_t h, int64_t w);

/**
 * lt_roi_align - pool a fixed grid of bilinear samples out of each box
 *
 *   x        (B, C, H, W)            feature map
 *   boxes    (R, 5)                  image index, then x0 y0 x1 y1 in pixels of the input image
 *   returns  (R, C, out_h, out_w)
 *
 * scale turns image pixels into feature pixels: 0.25 for a stride-4 map. Samples outside the map by
 * more than a pixel are 0. The gradient reaches x; boxes are constants. A box whose index is outside
 * [0, B), or with a corner that is not finite, pools zeros. Samples per bin and axis: the bin's size
 * rounded up (sampling_ratio -1), at most 64.
 * Errors: boxes not (R, 5), an empty map, sizes below 1, scale not above 0.
 * Source: He et al. 2017, "Mask R-CNN", section 3; no half-pixel shift (aligned=False elsewhere).
 */
LT_API lt_tensor *lt_roi_align(lt_tensor *x, lt_tensor *boxes, int out_h, int out_w, double scale);

/**
 * lt_box_region - the rectangle of each image's map that lt_roi_align reads for any of the boxes
 *
 *   boxes    n times (R, 5), as above        returns  (B, 4): rows y0 to y1, columns x0 to x1, ends exclusive
 *
 * For maps (B, C, H, W) and that scale; margin more cells on every side, within the map. Empty (all 0) where
 * an image has no box. No gradient. Errors: boxes not (R, 5), sizes below 1.
 */
LT_API lt_tensor *lt_box_region(lt_tensor *const *boxes, int n, int64_t B, int64_t H, int64_t W, double scale,
                                int margin);

/**
 * lt_window_means - the means of a map over what the nine taps of a padded 3 x 3 convolution see of it
 *
 *   x  (B, C, h, w)      returns  (B, C, 3, 3)
 *
 * of the map resized to H x W as lt_resize_bilinear would; (1, 1) is the mean over all of it.
 * Errors: an empty map, H or W below 2.
 */
LT_API lt_tensor *lt_window_means(lt_tensor *x, int64_t H, int64_t W);

/**
 * lt_grid_sample - bilinear samples of a map, 0 outside it
 *
 *   x  (B, C, H, W)      grid  (B, h, w, 2)  column and row of each sample      returns  (B, C, h, w)
 *
 * -1 and 1 are the outer edges of the map (align_corners false). Gradients reach x and the grid.
 * Errors: a grid of another batch or without pairs, an empty map.
 * Source: Jaderberg et al. 2015, "Spatial transformer networks", section 3.3.
 */
LT_API lt_tensor *lt_grid_sample(lt_tensor *x, lt_tensor *grid);

/* lt_soft_argmax2d - the expected place of heat maps that sum to 1: (B, J, H, W) -> (B, J, 2),
 * u = sum h * (col + 0.5) / W, v likewise, in [0, 1] */
LT_API lt_tensor *lt_soft_argmax2d(lt_tensor *heat);

/**
 * lt_sample_rows - bilinear samples of a map whose cells are rows, 0 outside it
 *
 *   map      (B, h * w, C)
 *   place    (B, N, 2)       column and row; a cell's centre is a whole number
 *   returns  (B, N, C)
 *
 * The gradient reaches the map; places are constants. Errors: shapes that do not fit h x w.
 */
LT_API lt_tensor *lt_sample_rows(lt_tensor *map, lt_tensor *place, int h, int w);

/* ---- points in space (B, N, 3); indices are LT_I32 -------------------------------------------------------- */

/**
 * lt_farthest_point_sampling - n points that cover all of them: each is the one farthest from those before it
 *
 *   start    (B), LT_I32     the first one; NULL, and another than 0 .. N - 1, count as 0
 *   returns  (B, n), LT_I32  of points that are equally far the one with the lower index
 *
 * No gradient. A point that is not finite is never chosen but as the start; where all have been chosen, the first goes
 * on. Errors: points not (B, N, 3), none of them; a start that does not fit; n below 1.
 * Source: Qi et al. 2017, "PointNet++", section 3.2.
 */
LT_API lt_tensor *lt_farthest_point_sampling(lt_tensor *points, lt_tensor *start, int64_t n);

/**
 * lt_ball_query - for each centre (B, M, 3) the first n points within a radius
 *
 * Returns (B, M, n), LT_I32, ascending; fewer than n are followed by the first again; -1 everywhere where none is. A
 * point at the radius is within. No gradient.
 * Errors: points or centres not (B, N, 3), of other batches; n below 1, a radius not above 0. Source: as above.
 */
LT_API lt_tensor *lt_ball_query(lt_tensor *points, lt_tensor *centres, double radius, int64_t n);

/**
 * lt_nearest - how far each of `points` (B, N, 3) is from the nearest of `others` (B, M, 3)
 *
 * Returns (B, N); lt_result(.., 1) is which one that is, (B, N), LT_I32, the first of equals. Gradients reach both, but
 * where the distance is 0. Others that are not finite do not count; infinite where none is left.
 * Errors: shapes other than these, of other batches.
 */
LT_API lt_tensor *lt_nearest(lt_tensor *points, lt_tensor *others);

/* lt_unit_sphere - points (B, N, 3) about their mean, the farthest at distance 1, of the first count (B), LT_I32, or
 * NULL: of all. No gradient. Where all of them are in one place they are not divided. Errors: other shapes. */
LT_API lt_tensor *lt_unit_sphere(lt_tensor *points, lt_tensor *count);

/* lt_gather - rows of x (B, N, ...) by index (B, ...), LT_I32, each set's from its own: (B, ..., ...). Zeros for
 * rows that x does not have. Errors: an index of another batch or type; more than LT_MAX_RANK dimensions. */
LT_API lt_tensor *lt_gather(lt_tensor *x, lt_tensor *index);

/**
 * lt_group - what is known of the points around each centre, as maps
 *
 *   x        (B, C, N)              of points
 *   centre   (B, C, M) or NULL      of centres, taken off
 *   index    (B, M, K), LT_I32      which points are around them
 *   returns  (B, C, M, K)           x[b, c, index[b, m, k]] - centre[b, c, m]; x counts as 0 where it has no such point
 *
 * Errors: shapes that do not fit.
 */
LT_API lt_tensor *lt_group(lt_tensor *x, lt_tensor *centre, lt_tensor *index);

/* Links of a graph's nodes, in sets: node `to` is told by `from` in `subset`, to be weighed by `value`. */
typedef struct { int subset, from, to; double value; } lt_link;

typedef struct {
    int nodes, subsets, n;          /* at most 128 nodes, and 4 subsets */
    const lt_link *link;
} lt_adjacency;

/**
 * lt_aggregate - what each node of a graph is told by those it is linked with
 *
 *   x        (B, K * C, T, V)       of V nodes at T moments; channel k * C + c is told by the links of subset k
 *   mask     (K, V, V)              multiplies the values of links, by subset, from, to; of no meaning elsewhere
 *   of       the links, which must outlive the plans
 *   returns  (B, C, T, V)           sums over all links that end at a node
 *
 * Gradients reach x, and of the mask what links have. Errors: shapes that do not fit.
 * Source: Yan et al. 2018, "Spatial temporal graph convolutional networks for skeleton-based action recognition",
 * equation 10.
 */
LT_API lt_tensor *lt_aggregate(lt_tensor *x, lt_tensor *mask, const lt_adjacency *of);

typedef struct {
    int levels;                     /* grids; base and finest: cells along a side of the first and the last */
    int base, finest;
    int log2_size;                  /* a grid with more than 2^log2_size corners has them hashed */
} lt_hash_grid_opts;

/**
 * lt_hash_grid - features of places from grids of many resolutions
 *
 *   x        (..., 3)               places in [0, 1], cut off there
 *   table    (entries, F)           lt_hash_grid_entries(opts) of them, grid after grid
 *   returns  (..., levels * F)      of each grid the trilinear mean of its cell's corners
 *
 * The gradient reaches the table; x is a constant. Errors: shapes that do not fit; opts out of range.
 * Source: Mueller et al. 2022, "Instant neural graphics primitives with a multiresolution hash encoding", section 3.
 */
LT_API lt_tensor *lt_hash_grid(lt_tensor *x, lt_tensor *table, const lt_hash_grid_opts *opts);
LT_API int64_t lt_hash_grid_entries(const lt_hash_grid_opts *opts);

/* lt_one_blob - each number of x (..., D) in [0, 1] as a bump over `bins` bins: (..., D * bins). Errors: bins not in 2
 * .. 1024. Source: Mueller et al. 2019, "Neural importance sampling"; the quartic kernel of NVlabs/tiny-cuda-nn. */
LT_API lt_tensor *lt_one_blob(lt_tensor *x, int bins);

/* ---- normalisation ----------------------------------------------------------------------------------- */

/* lt_softmax - over the last dimension; a row with NaN, +inf or nothing but -inf becomes NaN */
LT_API lt_tensor *lt_softmax(lt_tensor *x);

/* lt_layer_norm - over the last dimension, biased variance; weight, bias (C) */
LT_API lt_tensor *lt_layer_norm(lt_tensor *x, lt_tensor *weight, lt_tensor *bias, double eps);

/* lt_l2_normalise - x / (|x| + eps) with the length |x| over dimension 1 at each position of x (B, C, ...); no gradient
 * where it is 0. Errors: fewer than two dimensions, eps not above 0. */
LT_API lt_tensor *lt_l2_normalise(lt_tensor *x, double eps);

/**
 * lt_batch_norm - y = (x - mean) / sqrt(var + eps) * weight + bias, per channel
 *
 *   x  (B, C, ...)      weight, bias, running_mean, running_var  (C)
 *
 * A training plan uses the batch's mean and biased variance, and adds the mean and the unbiased variance
 * into the grad of the running statistics; the optimiser's step moves them afterwards. Other plans, and a training plan
 * where no gradient comes back to it (a frozen teacher, what lt_detach is behind), use the running statistics, fold
 * into a convolution before it, and run as one scale and shift elsewhere.
 * Source: Ioffe and Szegedy 2015, algorithm 1.
 */
LT_API lt_tensor *lt_batch_norm(lt_tensor *x, lt_tensor *weight, lt_tensor *bias,
                                lt_tensor *running_mean, lt_tensor *running_var, double eps);

/* lt_channel_affine - y = scale[c] * x + shift[c] over dimension 1 */
LT_API lt_tensor *lt_channel_affine(lt_tensor *x, lt_tensor *scale, lt_tensor *shift);

/* ---- geometry ---------------------------------------------------------------------------------------- */

/* lt_rot6d - (..., 6) -> (..., 3, 3): two vectors made orthonormal become the first two columns, their
 * cross product the third. Source: Zhou et al. 2019, "On the continuity of rotation representations". */
LT_API lt_tensor *lt_rot6d(lt_tensor *x);

/**
 * lt_skin - linear blend skinning: rotations (B, J, 3, 3) and shape (B, S) -> vertices (B, V, 3)
 *
 * The layer's points (B, n_points, 3) are lt_result(vertices, 1). Both relative to the root joint, metres.
 * layer must outlive the plans. Gradients reach rotations (as free matrices) and shape.
 * Source: Loper et al. 2015, "SMPL", equations 2 to 10.
 */
LT_API lt_tensor *lt_skin(const lt_skin_layer *layer, lt_tensor *rotations, lt_tensor *shape);

/* ---- losses ------------------------------------------------------------------------------------------ */

/**
 * lt_mse_loss, lt_l1_loss - the mean of (a - b)^2, of |a - b|, over all elements: one number
 *
 * weight (B), or NULL, weighs the samples of dimension 0; the mean is then over the weights' sum, and 0
 * when that is 0. It gets no gradient. L1 has gradient 0 where a = b. Errors: shapes that differ.
 */
LT_API lt_tensor *lt_mse_loss(lt_tensor *a, lt_tensor *b, lt_tensor *weight);
LT_API lt_tensor *lt_l1_loss(lt_tensor *a, lt_tensor *b, lt_tensor *weight);

/**
 * lt_cross_entropy - the mean over rows of -sum_c target_c log softmax(logits)_c: one number
 *
 *   logits, target  (B, ..., C)      target: what the softmax should be; a class is a 1 in its place
 *
 * weight as above. Errors: shapes that differ, fewer than two dimensions, no class.
 */
LT_API lt_tensor *lt_cross_entropy(lt_tensor *logits, lt_tensor *target, lt_tensor *weight);

/* lt_smooth_l1_loss - the mean of d^2 / 2 where |d| < 1 and |d| - 1/2 elsewhere, d = a - b; the rest as lt_mse_loss.
 * Source: Girshick 2015, "Fast R-CNN", equation 3. */
LT_API lt_tensor *lt_smooth_l1_loss(lt_tensor *a, lt_tensor *b, lt_tensor *weight);

/**
 * lt_ssim_loss - 1 - the mean structural similarity of two pictures (C, H, W), values about 0 .. 1: one number
 *
 * Windows of 11 x 11 pixels, a Gaussian of deviation 1.5, around every pixel, with zeros around the picture; K1 0.01,
 * K2 0.03, biased variances. The gradient reaches a; b is a constant. A picture without pixels gives 0. Errors: shapes
 * that differ, or are not of three dimensions. Source: Wang et al. 2004, "Image quality assessment: from error
 * visibility to structural similarity", section III-B; as a loss in Kerbl et al. 2023, equation 7.
 */
LT_API lt_tensor *lt_ssim_loss(lt_tensor *a, lt_tensor *b);

/* lt_max - the largest along the last dimension; the first of equals gets the gradient. Errors: it is empty. */
LT_API lt_tensor *lt_max(lt_tensor *x);

/* lt_sum - of all elements: one number */
LT_API lt_tensor *lt_sum(lt_tensor *x);

/* ---- splats ---------------------------------------------------------------------------------------- */

/* What is drawn: N Gaussians in a camera's frame (x right, y down, z forward, metres), each with a covariance M M^T. */
typedef struct {
    lt_tensor *centre;      /* (N, 3) */
    lt_tensor *axes;        /* (N, 3, 3) M: an axis in each column, as long as one deviation */
    lt_tensor *opacity;     /* (N) in [0, 1] */
    lt_tensor *colour;      /* (N, 3) */
    lt_tensor *camera;      /* (4) fx, fy, cx, cy in pixels; pixel (column, row) is sampled at just that place */
    lt_tensor *offset;      /* (N, 2) added to places on the screen, in pixels; or NULL. Zeros whose gradient is wanted
                             * tell how far each Gaussian's place matters: what density control looks at. */
    lt_tensor *first;       /* () LT_I32: rows below it are the first set, the others the second; NULL without sets */
} lt_splat_in;

typedef struct {
    int64_t width, height;  /* of the image, 1 to 16384 */
    double near_z;          /* Gaussians are not drawn from here to the camera, and behind it; 0.2 m is usual */
    bool white;             /* the background: black, or white. On white the other set of a set's image is white too. */
    bool sets;              /* the images of both sets as well, under the occlusion of all */
    bool opacity;           /* that of the image, where there are no sets, which bring theirs along */
    bool depth;             /* the sum of weight times z */
} lt_splat_opts;

/**
 * lt_splat_raster - Gaussians as images
 *
 *   returns         (C, H, W)   red, green, blue; with sets those of the first, and of the second, then the opacity of
 *                               all, of the first and of the second; without sets the opacity, if asked for; depth last
 *   lt_result(, 1)  (N)         three deviations along the longer axis on the screen, in whole pixels; 0: not drawn
 *   lt_result(, 2)  ()          how often a Gaussian meets a tile of 16 x 16 pixels, of all Gaussians and tiles
 *
 * From near to far by z, and by row where it is the same: with T the light that is left, a Gaussian that covers alpha =
 * min(0.99, opacity exp(-sigma)) of a pixel gives alpha T of its colour and leaves (1 - alpha) T; not where alpha is
 * below 1/255, and a pixel is finished before less than 1e-4 would be left. sigma is half the squared distance on the
 * screen under J M M^T J^T + 0.3, with the projection's derivative J at the centre, held within 1.3 half images.
 *
 * The gradient reaches centre, axes, opacity, colour and offset, exactly but where alpha is held at 0.99, which it
 * passes as if it were not; the other results have none. A Gaussian that holds a number that is not finite, or stands
 * too near, is not drawn and gets no gradient; one of no size is a dot of the screen's own blur. Images of no Gaussian
 * are the background. Any number of instances is drawn; memory is for 8 a Gaussian and one a tile, and where there are
 * more, lists are made several times, with the same bits.
 *
 * Errors: shapes that do not belong together, sets without `first`, an image without pixels, near_z not above 0.
 * Source: Zwicker et al. 2001, "EWA volume splatting"; Kerbl et al. 2023, "3D Gaussian splatting for real-time radiance
 * field rendering"; the exact extent of an ellipse in tiles as in Hanson et al. 2025, "Speedy-Splat".
 */
LT_API lt_tensor *lt_splat_raster(const lt_splat_in *in, const lt_splat_opts *opts);

/* Calls remember their place in the source; see LT_HERE. */
#define lt_add(...) LT_HERE(lt_add(__VA_ARGS__))
#define lt_sub(...) LT_HERE(lt_sub(__VA_ARGS__))
#define lt_mul(...) LT_HERE(lt_mul(__VA_ARGS__))
#define lt_scale(...) LT_HERE(lt_scale(__VA_ARGS__))
#define lt_leaky_relu(...) LT_HERE(lt_leaky_relu(__VA_ARGS__))
#define lt_relu(...) LT_HERE(lt_relu(__VA_ARGS__))
#define lt_sigmoid(...) LT_HERE(lt_sigmoid(__VA_ARGS__))
#define lt_tanh(...) LT_HERE(lt_tanh(__VA_ARGS__))
#define lt_silu(...) LT_HERE(lt_silu(__VA_ARGS__))
#define lt_elu(...) LT_HERE(lt_elu(__VA_ARGS__))
#define lt_gelu(...) LT_HERE(lt_gelu(__VA_ARGS__))
#define lt_quick_gelu(...) LT_HERE(lt_quick_gelu(__VA_ARGS__))
#define lt_dropout(...) LT_HERE(lt_dropout(__VA_ARGS__))
#define lt_stochastic_depth(...) LT_HERE(lt_stochastic_depth(__VA_ARGS__))
#define lt_reshape(...) LT_HERE(lt_reshape(__VA_ARGS__))
#define lt_permute(...) LT_HERE(lt_permute(__VA_ARGS__))
#define lt_concat(...) LT_HERE(lt_concat(__VA_ARGS__))
#define lt_slice(...) LT_HERE(lt_slice(__VA_ARGS__))
#define lt_rows(...) LT_HERE(lt_rows(__VA_ARGS__))
#define lt_detach(...) LT_HERE(lt_detach(__VA_ARGS__))
#define lt_sample_index(...) LT_HERE(lt_sample_index(__VA_ARGS__))
#define lt_linear(...) LT_HERE(lt_linear(__VA_ARGS__))
#define lt_matmul(...) LT_HERE(lt_matmul(__VA_ARGS__))
#define lt_attention(...) LT_HERE(lt_attention(__VA_ARGS__))
#define lt_deformable_attention(...) LT_HERE(lt_deformable_attention(__VA_ARGS__))
#define lt_conv2d(...) LT_HERE(lt_conv2d(__VA_ARGS__))
#define lt_conv2d_within(...) LT_HERE(lt_conv2d_within(__VA_ARGS__))
#define lt_conv_transpose2d(...) LT_HERE(lt_conv_transpose2d(__VA_ARGS__))
#define lt_max_pool2d(...) LT_HERE(lt_max_pool2d(__VA_ARGS__))
#define lt_global_avg_pool(...) LT_HERE(lt_global_avg_pool(__VA_ARGS__))
#define lt_upsample_nearest(...) LT_HERE(lt_upsample_nearest(__VA_ARGS__))
#define lt_resize_bilinear(...) LT_HERE(lt_resize_bilinear(__VA_ARGS__))
#define lt_roi_align(...) LT_HERE(lt_roi_align(__VA_ARGS__))
#define lt_box_region(...) LT_HERE(lt_box_region(__VA_ARGS__))
#define lt_window_means(...) LT_HERE(lt_window_means(__VA_ARGS__))
#define lt_grid_sample(...) LT_HERE(lt_grid_sample(__VA_ARGS__))
#define lt_soft_argmax2d(...) LT_HERE(lt_soft_argmax2d(__VA_ARGS__))
#define lt_softmax(...) LT_HERE(lt_softmax(__VA_ARGS__))
#define lt_layer_norm(...) LT_HERE(lt_layer_norm(__VA_ARGS__))
#define lt_l2_normalise(...) LT_HERE(lt_l2_normalise(__VA_ARGS__))
#define lt_batch_norm(...) LT_HERE(lt_batch_norm(__VA_ARGS__))
#define lt_channel_affine(...) LT_HERE(lt_channel_affine(__VA_ARGS__))
#define lt_rot6d(...) LT_HERE(lt_rot6d(__VA_ARGS__))
#define lt_skin(...) LT_HERE(lt_skin(__VA_ARGS__))
#define lt_mse_loss(...) LT_HERE(lt_mse_loss(__VA_ARGS__))
#define lt_l1_loss(...) LT_HERE(lt_l1_loss(__VA_ARGS__))
#define lt_cross_entropy(...) LT_HERE(lt_cross_entropy(__VA_ARGS__))
#define lt_sum(...) LT_HERE(lt_sum(__VA_ARGS__))
#define lt_ssim_loss(...) LT_HERE(lt_ssim_loss(__VA_ARGS__))
#define lt_smooth_l1_loss(...) LT_HERE(lt_smooth_l1_loss(__VA_ARGS__))
#define lt_max(...) LT_HERE(lt_max(__VA_ARGS__))
#define lt_sample_rows(...) LT_HERE(lt_sample_rows(__VA_ARGS__))
#define lt_farthest_point_sampling(...) LT_HERE(lt_farthest_point_sampling(__VA_ARGS__))
#define lt_ball_query(...) LT_HERE(lt_ball_query(__VA_ARGS__))
#define lt_nearest(...) LT_HERE(lt_nearest(__VA_ARGS__))
#define lt_unit_sphere(...) LT_HERE(lt_unit_sphere(__VA_ARGS__))
#define lt_gather(...) LT_HERE(lt_gather(__VA_ARGS__))
#define lt_group(...) LT_HERE(lt_group(__VA_ARGS__))
#define lt_aggregate(...) LT_HERE(lt_aggregate(__VA_ARGS__))
#define lt_hash_grid(...) LT_HERE(lt_hash_grid(__VA_ARGS__))
#define lt_one_blob(...) LT_HERE(lt_one_blob(__VA_ARGS__))
#define lt_splat_raster(...) LT_HERE(lt_splat_raster(__VA_ARGS__))

#ifdef __cplusplus
}
#endif
#endif
