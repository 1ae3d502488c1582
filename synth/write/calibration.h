/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Calibration folders of takes with several cameras.
 */
#ifndef SYNTH_WRITE_CALIBRATION_H
#define SYNTH_WRITE_CALIBRATION_H

#include "synth/render/render.h"
#include "synth/write/manifest.h"

#ifdef __cplusplus
extern "C" {
#endif

/* synth_camera_to_first - x_first = R x + t from camera c's axes to those of camera `first` */
void synth_camera_to_first(const synth_camera *first, const synth_camera *c, double R[9], double t[3]);

/* synth_write_calibration - root/calibration/base/calibration: the cameras' order, the unit of depth, and for
 * each its intrinsics and x_first = T x_camera (OpenCV axes); the files are added to the manifest */
lt_status synth_write_calibration(const char *root, const char *base, const synth_camera *camera, int n,
                                  synth_manifest *manifest);

#ifdef __cplusplus
}
#endif
#endif
