/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Left hands as right hands: the picture and everything known of it, seen in a mirror, x -> -x.
 *
 * With M = diag(-1, 1, 1): points p -> M p, rotations R -> M R M, columns u -> width - 1 - u. Each function
 * is its own inverse. What M does to an object's pose fits the mirrored model: M (R x + t) = (M R M) (M x) + M t.
 *
 * Source: HFL-Net dataset/dex_ycb_object_test.py, HOISDF data/dexycb.py.
 */
#ifndef DATA_MIRROR_H
#define DATA_MIRROR_H

#include "data/dataset.h"

#ifdef __cplusplus
extern "C" {
#endif

/* mirror_plane - a picture's cells of size bytes, each row from right to left, in place; NULL is fine */
void mirror_plane(void *plane, int width, int height, size_t size);

/* mirror_point, mirror_rotation, mirror_camera - in place; width is the image's */
void mirror_point(float p[3]);
void mirror_rotation(float R[9]);
void mirror_camera(lt_camera *camera, int width);

/* mirror_pose - of an object, in place: what places the mirrored model */
void mirror_pose(double R[9], double t[3]);

/* mirror_model - where `mirrored`, R places the mirrored model: make it place the model itself, R diag(-1, 1, 1), in
 * place. Distances between points of two such poses are those outside of the mirror. */
void mirror_model(double R[9], bool mirrored);

/**
 * mirror_sample - all of s in place, SAMPLE_MIRRORED flipped
 *
 * rgb and depth are turned over where they lie, so they must be the caller's own. joints2d, control2d and
 * the silhouette are moved too. vertices, which are borrowed, must be absent.
 */
void mirror_sample(dataset_sample *s, uint8_t *rgb, float *depth, uint8_t *silhouette);

#ifdef __cplusplus
}
#endif
#endif
