/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where in a file of weights those of a model are: under which dict and what else before their names, in whose words,
 * and which part of the model they are. Nobody lists what programs put before names: what fits most is taken.
 */
#ifndef ESTIMATE_WEIGHT_PLACE_H
#define ESTIMATE_WEIGHT_PLACE_H

#include "estimate/weights/names.h"
#include "libtensor/io/torch/weights_file.h"
#include "models/model.h"

enum { WEIGHT_ALSO = 8 };

typedef struct {
    const weight_family *family;
    const char *prefix;             /* before each name: "state_dict.module.", or "" */
    size_t prefix_length;
    const char *block;              /* of the model, which the names begin below; NULL: the names are whole */
    int named, fit;                 /* arrays that have a parameter's name, and of these the ones that have its shape */
    const char *also[WEIGHT_ALSO];  /* prefixes of other arrays of which as many fit */
    int n_also;                     /* of these; more are not listed */
} weight_place;

/**
 * weight_place_find - the place of which most arrays have the name and the shape of a parameter, the first where
 * several are alike
 *
 * named is 0 where nothing has a parameter's name. What no network needs (weight_passed_over) is not counted.
 * Errors: LT_ENOMEM.
 */
lt_status weight_place_find(lt_arena *arena, const lt_weights_file *file, const model *m, weight_place *out);

/* weight_param - the parameter that an array of the file is at that place, or NULL */
lt_param *weight_param(const weight_place *place, const model *m, const char *name);

/* weight_param_in - a parameter by its name in a block of a model, or NULL */
lt_param *weight_param_in(const model *m, const char *block, const char *name);

/* weight_passed_over - what every file of its kind has besides: counters of batches, and what an optimiser of ours
 * remembers */
bool weight_passed_over(const char *name);

#endif
