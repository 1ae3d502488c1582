/* SPDX-License-Identifier: Apache-2.0 */
/*
 * 3D Gaussians in the files that viewers on the web take; PLY, which has all of their numbers, is in ply.h.
 */
#ifndef LT_IO_MESH_SPLAT_H
#define LT_IO_MESH_SPLAT_H

#include "libtensor/io/mesh/ply.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_splat_rgb - its colour by degree 0 of the harmonics, 0.5 + C0 dc, which may leave 0..1
 * lt_splat_paint - give it that colour */
LT_API void lt_splat_rgb(const lt_splat *s, double rgb[3]);
LT_API void lt_splat_paint(lt_splat *s, const double rgb[3]);

/**
 * lt_splat_write - n Gaussians as .splat, 32 bytes each, the largest and most opaque first, atomically
 *
 * Position and scale as floats, then red, green, blue, opacity and the quaternion w x y z as bytes, 128 q + 128. Of the
 * colours degree 0 alone. Axes are as given. Source: antimatter15/splat, convert.py. Errors: LT_EINVAL for a number
 * that is not finite, or no Gaussian; LT_ENOMEM; those of lt_atomic_commit.
 */
LT_API lt_status lt_splat_write(const char *path, const lt_splat *splat, size_t n);

/**
 * lt_glb_write_splats - n Gaussians as one node of binary glTF with the extension KHR_gaussian_splatting, atomically
 *
 *   degree   of the spherical harmonics that are written, 0 to 3
 *
 * Points with rotations, scales, opacities and harmonics in floats; COLOR_0, linear, is for viewers without the
 * extension. Axes are turned from ours to glTF's (x right, y up, z backward), and harmonics with them. Errors: as
 * above; more than 4 GB. Source: KhronosGroup/glTF, extensions/2.0/Khronos/KHR_gaussian_splatting.
 */
LT_API lt_status lt_glb_write_splats(const char *path, const char *name, const lt_splat *splat, size_t n, int degree);

#ifdef __cplusplus
}
#endif
#endif
