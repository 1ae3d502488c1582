/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the files of the HO3D reader and writer share.
 */
#ifndef DATA_HO3D_INTERNAL_H
#define DATA_HO3D_INTERNAL_H

#include "data/ho3d.h"

#define HO3D_DEPTH_UNIT 0.00012498664727900177      /* metres in a step of the depth images */

typedef struct {
    dataset base;                   /* first: a dataset * is a ho3d * */
    lt_arena *arena;                /* of everything, this struct included */
    const char *models;
    const char **name;              /* base.count of them, "ABF10/0123" */
    bool evaluation;
    const float *xyz, *vertices;    /* ground truth of the evaluation: our axes, MANO order; or NULL */
} ho3d;

#endif
