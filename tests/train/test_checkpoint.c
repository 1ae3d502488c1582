/* SPDX-License-Identifier: Apache-2.0 */
/* Weights out of a checkpoint, to predict with: the average of them where the run kept one. */
#include "data/synth/hand.h"
#include "libtensor/base/parallel.h"
#include "train/checkpoint.h"
#include "train/config.h"

#include <check.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

static const char text[] = "{ \"model\": { \"name\": \"hocat\", \"image_size\": 64, \"width\": 8, "
                           "\"blocks\": [1, 1, 1, 1], \"roi\": 8, \"depth\": 1, \"heads\": 2 } }";
static const char path[] = "/tmp/test_checkpoint.safetensors";

START_TEST(weights_or_their_average)
{
    const lt_optim_opts opts = { .kind = LT_ADAM, .ema_decay = _i ? 0.9 : 0 };
    const checkpoint_state state = { .step = 7, .best_mm = INFINITY };
    lt_arena *arena = lt_arena_new();
    lt_params *set = lt_params_new();
    lt_hand_model *hand;
    lt_hand_layer *layer;
    lt_optim *optim;
    train_config c;
    lt_param *w;
    model m;

    lt_set_threads(1);
    ck_assert_int_eq(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand), LT_OK);
    ck_assert_int_eq(lt_hand_layer_new(arena, hand, lt_hand_tips_ho3d, &layer), LT_OK);
    ck_assert_int_eq(train_config_parse(arena, "tiny", text, NULL, 0, &c), LT_OK);
    ck_assert_int_eq(train_config_model(&c, layer, set, &m), LT_OK);
    w = lt_params_find(set, "trunk.conv1.weight");
    ck_assert(lt_param_need_grad(w));
    w->data[0] = 1;
    optim = lt_optim_new(set, &opts);           /* the average begins at 1 */
    w->data[0] = 2;
    ck_assert_int_eq(checkpoint_save(path, &m, optim, "{}", &state), LT_OK);
    w->data[0] = 3;
    ck_assert_int_eq(checkpoint_load_model(path, &m), LT_OK);
    ck_assert_float_eq(w->data[0], _i ? 1 : 2);
    w->data[0] = NAN;
    ck_assert_int_eq(checkpoint_save(path, &m, optim, "{}", &state), LT_ENUMERIC);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "\"trunk.conv1.weight\" is not finite at 0"));
    unlink(path);
    lt_optim_free(optim);
    train_config_fini(&c);
    lt_params_free(set);
    lt_arena_free(arena);
}
END_TEST

int main(void)
{
    Suite *s = suite_create("checkpoint");
    TCase *c = tcase_create("all");
    SRunner *r;
    int failed;

    tcase_set_timeout(c, 0);
    tcase_add_loop_test(c, weights_or_their_average, 0, 2);
    suite_add_tcase(s, c);
    r = srunner_create(s);
    srunner_run_all(r, CK_NORMAL);
    failed = srunner_ntests_failed(r);
    srunner_free(r);
    return failed != 0;
}
