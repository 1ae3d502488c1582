/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A trained model opened to be used, by what its checkpoint says of it: the model, its hand, its weights. Nothing is
 * printed, and keys that only training needs are not looked at.
 */
#ifndef ESTIMATE_TRAINED_H
#define ESTIMATE_TRAINED_H

#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/hand/model.h"
#include "models/model.h"

typedef struct {
    lt_arena *arena;                /* of all but the parameters */
    const char *path;               /* the checkpoint file */
    lt_hand_model *hand;            /* of a hand-object model, as is what poses it; else NULL */
    lt_hand_layer *layer;
    lt_params *params;
    model m;
    bool bilinear;                  /* its crops are sampled between pixels: data.bilinear */
    const char *names;              /* of a detector's classes, with commas between: data.names; "": it does not say */
    const char *body;               /* of a body model: data.body, as run_body_open takes it; "" of others */
} trained;

/**
 * trained_open - a checkpoint file, or the last one of a run's folder
 *
 *   task   what the model is to be trained for: "hand-object"
 *   hand   as hands_open takes it; NULL: what the run was trained with
 *
 * trained_close frees it, also after a failure. Errors: those of reading; LT_EFORMAT: no checkpoint, or one whose
 * configuration names no model; LT_EINVAL: a model that is trained for something else, keys or weights that do not fit
 * it; LT_ENOMEM.
 */
lt_status trained_open(const char *path, const char *task, const char *hand, trained *out);
void trained_close(trained *t);

#endif
