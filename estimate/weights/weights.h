/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Initial weights out of other people's files: by name, through the names that published checkpoints use.
 */
#ifndef ESTIMATE_WEIGHTS_H
#define ESTIMATE_WEIGHTS_H

#include "estimate/weights/place.h"

/* What a file of weights had for a model. Names live as long as the arena and the model. */
typedef struct {
    const char *format, *family;    /* "PyTorch (zip)", "timm" */
    const char *note;               /* what to know about the family's numbers; or NULL */
    const char *taken;              /* what the names begin with that were taken: "state_dict.module.", or "" */
    const char *also[WEIGHT_ALSO];  /* n_also other beginnings, behind which as many arrays fit */
    int n_also;
    int n_loaded;                   /* parameters that got values */
    int n_missing, n_left_over;     /* parameters that did not; arrays that no parameter has the name of */
    const char **missing, **left_over;
} weights_report;

/**
 * weights_init - initial weights by name from a safetensors or .npz file, a checkpoint of PyTorch, or a run's folder
 *
 * An array fits the parameter of its name, or of its name behind the one of the model's blocks that most of the names
 * are of: "conv1.weight" fits "trunk.conv1.weight". What stands before the names, dicts and wrappers, is found by what
 * fits most: see weight_place.h. Names are torchvision's, or translated from those of timm, efficientnet_pytorch and
 * HFL-Net. Counters of batches and what an optimiser remembered are passed over; but where a run of ours kept an
 * average of its weights, that is what is loaded. What a model's twins name (the unified estimator's streams) begins
 * with the same weights, the first layer of one channel with their sum over the channels. Queries, keys and values that
 * a file has in one array are taken apart for a model that has them in three. What a model says of itself that it
 * begins fresh (model_class.fresh) is missing where the file has it in another shape.
 *
 * The model is as it was on any error. Errors: none fits, with some of the names that there are; a shape that differs,
 * naming both; two arrays for one parameter; a number that is not finite; a parameter's array whose elements are not
 * read; those of lt_weights_read.
 */
lt_status weights_init(lt_arena *arena, const char *path, const model *m, weights_report *out);

/* weights_list - up to eight of n names and how many more there are, as one line in the arena; "none" */
const char *weights_list(lt_arena *arena, const char *const *name, int n);

#endif
