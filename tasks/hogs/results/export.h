/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Surfaces and Gaussians of a trained model as files.
 */
#ifndef TASKS_HOGS_RESULTS_EXPORT_H
#define TASKS_HOGS_RESULTS_EXPORT_H

#include "train/task.h"

/* hogs_export - task.export. Frames are those with initial poses of the split that training validates on, or of the
 * training split where that is all. Meshes: "frame-0010-hand.ply" .. in the folder, in the camera's frame. Gaussians:
 * of the first frame, or of one set. */
lt_status hogs_export(const task_export *e);

#endif
