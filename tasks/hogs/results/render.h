/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Renderings of frames that a trained model has not seen.
 */
#ifndef TASKS_HOGS_RESULTS_RENDER_H
#define TASKS_HOGS_RESULTS_RENDER_H

#include "train/task.h"

/* hogs_render - task.predict. Inputs are folders of datasets, of which the evaluation split is taken, or the training
 * split where that is all. For each frame, in a folder of its sequence: joint.png, hand.png and object.png as they are
 * drawn, overlay.png over the image, and splats.ply: the Gaussians in the camera's frame. No optimiser runs. */
lt_status hogs_render(const task_prediction *p, int64_t *written);

#endif
