/* SPDX-License-Identifier: Apache-2.0 */
/* A very small untrained model on the embedded hand, for tests of what is done with a model. */
#ifndef TESTS_ESTIMATE_TINY_MODEL_H
#define TESTS_ESTIMATE_TINY_MODEL_H

#include "assets/hand/hand.h"
#include "tests/models/model_of.h"

typedef struct {
    lt_arena *arena;
    lt_hand_model *hand;
    lt_hand_layer *layer;
    lt_params *params;
    model m;
} tiny_model;

static const char tiny_hocat[] = "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], \"roi\": 8, "
                                 "\"depth\": 1, \"heads\": 2, \"mlp_ratio\": 1}";
static const char tiny_unified[] __attribute__((unused)) =
    "{\"image_size\": 64, \"width\": 8, \"layers\": 1, \"heads\": 2, \"points\": 2}";

static inline void tiny_model_of(tiny_model *t, const char *name, const char *text)
{
    t->arena = lt_arena_new();
    ck_assert_int_eq(synth_hand_new(t->arena, SYNTH_HAND_MANO_LIKE, &t->hand), LT_OK);
    ck_assert_int_eq(lt_hand_layer_new(t->arena, t->hand, lt_hand_tips_ho3d, &t->layer), LT_OK);
    t->params = model_of(name, text, t->layer, &t->m);
    t->m.cls->init(&t->m, 1);
}

static inline void tiny_model_init(tiny_model *t)
{
    tiny_model_of(t, "hocat", tiny_hocat);
}

static inline void tiny_model_fini(tiny_model *t)
{
    lt_params_free(t->params);
    lt_arena_free(t->arena);
}

#endif
