/* SPDX-License-Identifier: Apache-2.0 */
/* A model from the text of its config group. */
#ifndef TESTS_MODELS_MODEL_OF_H
#define TESTS_MODELS_MODEL_OF_H

#include "libtensor/io/text/json.h"
#include "models/model.h"
#include "tests/suite.h"

#include <cjson/cJSON.h>
#include <string.h>

/* Its parameters, not yet initialised: a set of its own. layer may be NULL for a model without hands. */
static inline lt_params *model_of(const char *name, const char *text, const lt_hand_layer *layer, model *out)
{
    lt_params *set = lt_params_new();
    const model_class *cls;
    cJSON *config;

    check_ok(lt_json_parse("test", text, strlen(text), &config));
    check_ok(model_find(name, &cls));
    check_ok(model_create(cls, "test", config, layer, set, out));
    cJSON_Delete(config);
    return set;
}

/* A config group that cannot be, and what is said of it */
static inline void expect_no_model(const char *name, const char *text, const char *reason)
{
    lt_params *set = lt_params_new();
    const model_class *cls;
    cJSON *config;
    model m;

    check_ok(lt_json_parse("test", text, strlen(text), &config));
    check_ok(model_find(name, &cls));
    check_error(model_create(cls, "test", config, NULL, set, &m), LT_EINVAL, reason);
    cJSON_Delete(config);
    lt_params_free(set);
}

#endif
