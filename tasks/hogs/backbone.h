/* SPDX-License-Identifier: Apache-2.0 */
/* Where G-PM's point backbone begins. */
#ifndef TASKS_HOGS_BACKBONE_H
#define TASKS_HOGS_BACKBONE_H

#include "libtensor/base/status.h"
#include "libtensor/graph/param.h"

/* hogs_load_backbone - the first level of PointNet++ from ULIP's file, or a run of points-cpu or points-full; its first
 * convolution, whose inputs are others here, stays as it is. Errors: those of lt_weights_read; a weight that the file
 * has not, or of another shape. */
lt_status hogs_load_backbone(lt_params *set, const char *path);

#endif
