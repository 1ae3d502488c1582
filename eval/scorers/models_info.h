/* SPDX-License-Identifier: Apache-2.0 */
/*
 * BOP's models_info.json: how large and how symmetric its models of the YCB objects are.
 *
 * Source: Hodan et al., BOP toolkit, docs/bop_datasets_format.md and misc.get_symmetry_transformations.
 */
#ifndef EVAL_SCORERS_MODELS_INFO_H
#define EVAL_SCORERS_MODELS_INFO_H

#include "assets/ycb/ycb.h"
#include "libtensor/base/arena.h"
#include "libtensor/geometry/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Metres, in the frame of assets/ycb/ycb.h. */
typedef struct {
    double diameter;                /* 0: nothing is known of the model */
    int n_symmetries;
    const lt_pose *symmetry;      /* model to model, the identity left out */
} bop_model;

/* The most symmetries that a model may have, the identity included */
enum { BOP_SYMMETRIES = 2520 };

/**
 * models_info_read - the models by YCB id, their symmetries in arena
 *
 * The file has millimetres, in BOP's frame, whose origin is the centre of the model's box: both are put right. Each
 * discrete symmetry, and none, is followed by each of YCB_TURNS steps of each continuous one. Other ids are passed
 * over.
 *
 * Errors: no JSON; a diameter that is no length, a symmetry that is no rigid motion, an axis without direction, more
 * than BOP_SYMMETRIES; the line names the object.
 */
lt_status models_info_read(lt_arena *arena, const char *path, bop_model out[YCB_COUNT + 1]);

#ifdef __cplusplus
}
#endif
#endif
