/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ops on the parameters of Gaussians, N of them, on their way to the screen: V-PM's changes, articulation, colour, and
 * what holds neighbours together. A transform is (3, 4): [A | t], x -> A x + t, and A any matrix.
 *
 * A row of zeros, as a set that grows has behind its last Gaussian, gives finite results everywhere, and no gradient
 * where nothing is asked of it.
 */
#ifndef LT_OPS_SPLAT_GAUSSIANS_H
#define LT_OPS_SPLAT_GAUSSIANS_H

#include "libtensor/graph/op.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_blend_transforms - a skinning field: weights (N, B), transforms (B, 3, 4) -> (N, 3, 4)
 *
 * The sum over b of weights[n, b] transforms[b]. Gradients reach both; bones that do not learn are an input of the
 * graph, or behind lt_detach.
 * Source: Loper et al. 2015, "SMPL", equation 2, with weights of points that are no vertices.
 */
LT_API lt_tensor *lt_blend_transforms(lt_tensor *weights, lt_tensor *transforms);

/**
 * lt_transform_points - points (N, 3) under transforms (N, 3, 4), or (1, 3, 4) for all of them -> (N, 3): A x + t
 * lt_transform_back - A^T x: a direction that the transforms brought here, as it was before them
 *
 * Gradients reach both.
 */
LT_API lt_tensor *lt_transform_points(lt_tensor *points, lt_tensor *transforms);
LT_API lt_tensor *lt_transform_back(lt_tensor *points, lt_tensor *transforms);

/**
 * lt_splat_axes - the axes of Gaussians under transforms: M = A R(q) diag(exp s)
 *
 *   log_scale   (N, 3) s             quaternion  (N, 4) q = (w, x, y, z) of any length but 0, which is no rotation
 *   transforms  (N, 3, 4) or (1, 3, 4)           returns (N, 3, 3), an axis in each column
 *
 * M M^T is the covariance, exactly also where A is no rotation. Gradients reach all three.
 * Source: Kerbl et al. 2023, "3D Gaussian splatting", equation 6, and its gradient in appendix A.
 */
LT_API lt_tensor *lt_splat_axes(lt_tensor *log_scale, lt_tensor *quaternion, lt_tensor *transforms);

/* lt_splat_covariance - axes (N, 3, 3) -> (N, 6): xx, xy, xz, yy, yz, zz of M M^T */
LT_API lt_tensor *lt_splat_covariance(lt_tensor *axes);

/**
 * lt_quaternion_turn - quaternions q (N, 4) turned a little: (1, d1, d2, d3) q, Hamilton's product, not normalised
 *
 *   delta (N, 4): its first number is not read and gets no gradient
 */
LT_API lt_tensor *lt_quaternion_turn(lt_tensor *q, lt_tensor *delta);

/**
 * lt_sh_colour - colour seen from a direction, by spherical harmonics: max(0, 1/2 + sum of b_k(d) sh_k)
 *
 *   sh         (N, 16, 3)            direction  (N, 3) of any length; of length 0 only b_0 counts
 *   degree     () or (1) LT_I32      0 to 3, cut off there: coefficients of a higher one count nothing, and get no
 *                                    gradient
 *   returns    (N, 3)                no gradient where it is 0
 *
 * Gradients reach sh and direction. Source: Kerbl et al. 2023; the signs of the basis are those of its files.
 */
LT_API lt_tensor *lt_sh_colour(lt_tensor *sh, lt_tensor *direction, lt_tensor *degree);

/**
 * lt_nearest_rotation - the rotation R nearest to each matrix X (..., 3, 3): X = R P, its polar projection
 *
 *   otherwise   the shape of X: what it becomes, without gradient, where det X is not above 0 or X is not finite
 *
 * The gradient reaches X.
 */
LT_API lt_tensor *lt_nearest_rotation(lt_tensor *X, lt_tensor *otherwise);

/**
 * lt_isometry_loss - how much distances to neighbours change: the mean of | |a_i - a_j| - |b_i - b_j| |: one number
 *
 *   a, b        (N, D) before and after          neighbours  (N, K) LT_I32: j of the pairs of row i
 *
 * A j outside [0, N), as padded rows have, is no pair; the mean is over those there are, and 0 without any. Gradients
 * reach a and b; where two coincide that pair gives none. Source: Prokudin et al. 2023, "Dynamic point fields", in the
 * form of Qian et al. 2024, "3DGS-Avatar".
 */
LT_API lt_tensor *lt_isometry_loss(lt_tensor *a, lt_tensor *b, lt_tensor *neighbours);

/* Calls remember their place in the source; see LT_HERE. */
#define lt_blend_transforms(...) LT_HERE(lt_blend_transforms(__VA_ARGS__))
#define lt_transform_points(...) LT_HERE(lt_transform_points(__VA_ARGS__))
#define lt_transform_back(...) LT_HERE(lt_transform_back(__VA_ARGS__))
#define lt_splat_axes(...) LT_HERE(lt_splat_axes(__VA_ARGS__))
#define lt_splat_covariance(...) LT_HERE(lt_splat_covariance(__VA_ARGS__))
#define lt_quaternion_turn(...) LT_HERE(lt_quaternion_turn(__VA_ARGS__))
#define lt_sh_colour(...) LT_HERE(lt_sh_colour(__VA_ARGS__))
#define lt_nearest_rotation(...) LT_HERE(lt_nearest_rotation(__VA_ARGS__))
#define lt_isometry_loss(...) LT_HERE(lt_isometry_loss(__VA_ARGS__))

#ifdef __cplusplus
}
#endif
#endif
