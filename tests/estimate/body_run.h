/* SPDX-License-Identifier: Apache-2.0 */
/* A network for whole bodies that has learnt nothing, as a checkpoint, for tests of what is done with one. */
#ifndef TESTS_ESTIMATE_BODY_RUN_H
#define TESTS_ESTIMATE_BODY_RUN_H

#include "estimate/checkpoint/checkpoint.h"
#include "libtensor/optim/optim.h"
#include "tests/models/model_of.h"

#include <math.h>

/* body: its data.body; damage: of all weights of the shape's layer */
static inline void write_body_run(const char *path, const char *body, float damage)
{
    const checkpoint_state state = { .step = 1, .best = INFINITY };
    char config[512];
    model m;
    lt_params *set = model_of("osx", "{}", NULL, &m);
    lt_optim *optim;
    lt_param *w;

    snprintf(config, sizeof(config), "{\"model\": {\"name\": \"osx\"}, \"data\": {\"body\": \"%s\"}}", body);
    m.cls->init(&m, 1);
    w = lt_params_find(set, "body_regressor.shape_out.0.weight");
    ck_assert_ptr_nonnull(w);
    for (int64_t i = 0; damage > 0 && i < lt_param_numel(w); i++)
        w->data[i] = damage;
    optim = lt_optim_new(set, &(lt_optim_opts){ .kind = LT_SGD });
    check_ok(checkpoint_save(path, &m, optim, config, &state, NULL));
    lt_optim_free(optim);
    lt_params_free(set);
}

#endif
