/* SPDX-License-Identifier: Apache-2.0 */
/* Weights out of a checkpoint, to predict with: the average of them where the run kept one; and the table of layers
 * that read 8-bit integers. */
#define _GNU_SOURCE                     /* memmem */
#include <config.h>
#include "assets/hand/hand.h"
#include "estimate/checkpoint/checkpoint.h"
#include "estimate/int8/table.h"
#include "libtensor/base/parallel.h"
#include "libtensor/graph/rows.h"
#include "libtensor/io/file.h"
#include "tasks/tasks.h"
#include "tests/suite.h"
#include "train/config.h"

#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char text[] = "{ \"model\": { \"name\": \"hocat\", \"image_size\": 64, \"width\": 8, "
                           "\"blocks\": [1, 1, 1, 1], \"roi\": 8, \"depth\": 1, \"heads\": 2 } }";
static const char path[] = "/tmp/test_checkpoint.safetensors", int8_path[] = "/tmp/test_checkpoint.int8.safetensors";

typedef struct {
    lt_arena *arena;
    lt_params *set;
    train_config c;
    model m;
} small_model;

static void small_model_init(small_model *s)
{
    lt_hand_model *hand;
    lt_hand_layer *layer;

    *s = (small_model){ .arena = lt_arena_new(), .set = lt_params_new() };
    ck_assert_int_eq(synth_hand_new(s->arena, SYNTH_HAND_MANO_LIKE, &hand), LT_OK);
    ck_assert_int_eq(lt_hand_layer_new(s->arena, hand, lt_hand_tips_ho3d, &layer), LT_OK);
    ck_assert_int_eq(train_config_parse(s->arena, tasks, "tiny", text, NULL, 0, &s->c), LT_OK);
    ck_assert_int_eq(train_config_model(&s->c, layer, s->set, &s->m), LT_OK);
    ck_assert_int_eq(train_config_init(&s->c, &s->m), LT_OK);
}

static void small_model_fini(small_model *s)
{
    train_config_fini(&s->c);
    lt_params_free(s->set);
    lt_arena_free(s->arena);
}

START_TEST(weights_or_their_average)
{
    const lt_optim_opts opts = { .kind = LT_ADAM, .ema_decay = _i ? 0.9 : 0 };
    const checkpoint_state state = { .step = 7, .best = INFINITY };
    small_model s;
    lt_optim *optim;
    lt_param *w;

    lt_set_threads(1);
    small_model_init(&s);
    w = lt_params_find(s.set, "trunk.conv1.weight");
    ck_assert(lt_param_need_grad(w));
    w->data[0] = 1;
    optim = lt_optim_new(s.set, &opts);           /* the average begins at 1 */
    w->data[0] = 2;
    ck_assert_int_eq(checkpoint_save(path, &s.m, optim, "{}", &state, NULL), LT_OK);
    w->data[0] = 3;
    ck_assert_int_eq(checkpoint_load_model(path, &s.m), LT_OK);
    ck_assert_float_eq(w->data[0], _i ? 1 : 2);
    w->data[0] = NAN;
    ck_assert_int_eq(checkpoint_save(path, &s.m, optim, "{}", &state, NULL), LT_ENUMERIC);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "\"trunk.conv1.weight\" is not finite at 0"));
    unlink(path);
    lt_optim_free(optim);
    small_model_fini(&s);
}
END_TEST

/* Points that have grown, and groups of which one has stepped less: the other run loads them, has as many, and goes
 * on. */
START_TEST(groups_and_rows_come_back)
{
    static const char *const points[] = { "points", NULL };
    static const lt_optim_group groups[] = {
        { .name = "points", .prefix = points, .kind = LT_ADAM, .schedule = { .lr = 0.1 } },
        { .name = "networks", .kind = LT_ADAMW, .schedule = { .lr = 0.1 } },
    };
    const checkpoint_state state = { .step = 3, .optim_steps = 3, .best = INFINITY };
    const lt_optim_average average = { .decay = 0.9, .tau = 3 };
    checkpoint_state found;
    small_model s[2];
    lt_optim *optim[2];
    lt_param *p[2], *w[2];

    for (int k = 0; k < 2; k++) {
        small_model_init(&s[k]);
        p[k] = lt_params_add_rows(s[k].set, "", "points", LT_SHAPE(4, 2));
        w[k] = lt_params_find(s[k].set, "trunk.conv1.weight");
        ck_assert(lt_param_need_grad(p[k]) && lt_param_need_grad(w[k]));
        optim[k] = lt_optim_new_groups(s[k].set, groups, 2, &average);
    }
    check_ok(lt_param_resize(p[0], 6));
    for (int step = 0; step < 6; step++)
        for (int k = 0; k < (step < 3 ? 1 : 2); k++) {
            if (step == 3 && k == 0) {
                check_ok(checkpoint_save(path, &s[0].m, optim[0], "{}", &state, NULL));
                check_ok(checkpoint_load(path, &s[1].m, optim[1], &found, NULL));
                ck_assert_int_eq(lt_optim_steps(optim[1]), 3);
            }
            lt_params_untouch(s[k].set);
            check_ok(lt_param_touch(p[k], step % 3 * 2, 2));
            for (int i = 0; i < 12; i++)
                p[k]->grad[i] = w[k]->grad[i] = (lt_real)sin(i + step);
            lt_optim_groups_norm(optim[k], 3);
            lt_optim_step_groups(optim[k], &(lt_optim_now){ .groups = step == 1 ? 1 : 3 });
        }
    ck_assert_mem_eq(p[0]->data, p[1]->data, 12 * sizeof(lt_real));
    ck_assert_mem_eq(w[0]->data, w[1]->data, (size_t)lt_param_numel(w[0]) * sizeof(lt_real));
    ck_assert_int_eq(lt_optim_state_count(optim[0]), lt_optim_state_count(optim[1]));
    for (int i = 0; i < lt_optim_state_count(optim[0]); i++) {
        const lt_optim_state a = lt_optim_state_at(optim[0], i), b = lt_optim_state_at(optim[1], i);

        ck_assert_mem_eq(a.data, b.data, (size_t)lt_shape_numel(&a.shape) * sizeof(lt_real));
    }
    unlink(path);
    for (int k = 0; k < 2; k++) {
        lt_optim_free(optim[k]);
        small_model_fini(&s[k]);
    }
}
END_TEST

static const lt_int8_layer layers[] = { { "trunk.conv1", { 0.013f, true } },
                                        { "trunk.layer1.0.conv1", { 1e-3f, false } } };
static const lt_int8_table table = { layers, LT_COUNT(layers) };

/* Loaded by whatever loads a checkpoint, with the metadata of the one that it was made from. */
START_TEST(table_in_a_checkpoint)
{
    const checkpoint_state state = { .step = 7, .best = INFINITY };
    checkpoint_state found;
    checkpoint_head head;
    lt_optim *optim;
    small_model s;
    int tips[5];

    small_model_init(&s);
    ck_assert(lt_param_need_grad(lt_params_find(s.set, "trunk.conv1.weight")));
    optim = lt_optim_new(s.set, &(lt_optim_opts){ .kind = LT_ADAM });
    ck_assert_int_eq(checkpoint_save(path, &s.m, optim, "{\"a\": 1}", &state, NULL), LT_OK);
    s.m.int8 = &table;
    ck_assert_int_eq(checkpoint_save_inference(int8_path, path, &s.m, false), LT_OK);
    ck_assert_int_eq(checkpoint_load_model(path, &s.m), LT_OK);
    ck_assert_ptr_null(s.m.int8);
    ck_assert_int_eq(checkpoint_load_model(int8_path, &s.m), LT_OK);
    ck_assert_int_eq(s.m.int8->n, table.n);
    for (int i = 0; i < table.n; i++) {
        const lt_int8_range *r = lt_int8_find(s.m.int8, layers[i].layer);

        ck_assert(r && r->scale == layers[i].range.scale && r->has_negative == layers[i].range.has_negative);
    }
    ck_assert_int_eq(checkpoint_head_read(s.arena, int8_path, &head), LT_OK);
    ck_assert_str_eq(head.config, "{\"a\": 1}");
    ck_assert_int_eq(head.step, 7);
    lt_hand_layer_tips(s.m.hand, tips);
    ck_assert_mem_eq(head.tips, tips, sizeof(head.tips));
    s.m.int8 = NULL;
    /* the table that it had is not kept */
    ck_assert_int_eq(checkpoint_save_inference(path, int8_path, &s.m, false), LT_OK);
    ck_assert_int_eq(checkpoint_load_model(path, &s.m), LT_OK);
    ck_assert_ptr_null(s.m.int8);
    ck_assert_int_eq(checkpoint_load(path, &s.m, optim, &found, NULL), LT_EINVAL);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "it is of another model or optimiser"));
    unlink(path), unlink(int8_path);
    lt_optim_free(optim);
    small_model_fini(&s);
}
END_TEST

/* Whoever gets the weights learns what the data were called, and not where they lay. */
START_TEST(data_without_its_place)
{
    const checkpoint_state state = { .step = 7, .best = INFINITY };
    checkpoint_head head;
    small_model s;

    small_model_init(&s);
    ck_assert_int_eq(checkpoint_save(path, &s.m, NULL, "{\"data\": {\"dir\": \"/home/me/small\", \"blur\": 0.3}}",
                                     &state, NULL), LT_OK);
    ck_assert_int_eq(checkpoint_save_inference(int8_path, path, &s.m, false), LT_OK);
    ck_assert_int_eq(checkpoint_head_read(s.arena, int8_path, &head), LT_OK);
    ck_assert_str_eq(head.config, "{\"data\": {\"dir\": \"small\", \"blur\": 0.3}}");
    unlink(path), unlink(int8_path);
    small_model_fini(&s);
}
END_TEST

/* Half of the bytes, and weights to eleven bits; one that does not fit is named, and what was there stays. */
START_TEST(half_precision)
{
    const checkpoint_state state = { .step = 7, .best = INFINITY };
    lt_optim *optim;
    struct stat whole, half;
    small_model s;
    lt_param *p;
    lt_real was;

    small_model_init(&s);
    optim = lt_optim_new(s.set, &(lt_optim_opts){ .kind = LT_ADAM });
    p = lt_params_find(s.set, "trunk.conv1.weight");
    was = p->data[3];
    ck_assert_int_eq(checkpoint_save(path, &s.m, optim, "{}", &state, NULL), LT_OK);
    ck_assert_int_eq(checkpoint_save_inference(int8_path, path, &s.m, false), LT_OK);
    ck_assert_int_eq(stat(int8_path, &whole), 0);
    ck_assert_int_eq(checkpoint_save_inference(int8_path, path, &s.m, true), LT_OK);
    ck_assert_int_eq(stat(int8_path, &half), 0);
    ck_assert_msg((double)half.st_size < 0.75 * (double)whole.st_size, "%ld of %ld", (long)half.st_size,
                  (long)whole.st_size);
    ck_assert_int_eq(checkpoint_load_model(int8_path, &s.m), LT_OK);
    ck_assert_double_eq_tol((double)p->data[3], (double)was, fabs((double)was) / 2048);
    p->data[3] = 70000;
    check_error(checkpoint_save_inference(int8_path, path, &s.m, true), LT_ENUMERIC,
                "not written, for \"trunk.conv1.weight\" is 70000 at 3, and half precision ends at 65504");
    ck_assert_int_eq(checkpoint_load_model(int8_path, &s.m), LT_OK);
    unlink(path), unlink(int8_path);
    lt_optim_free(optim);
    small_model_fini(&s);
}
END_TEST

/* A small file whose configuration speaks of a large model is refused before that takes memory. */
START_TEST(shapes_before_memory)
{
    static const char large[] = "{ \"model\": { \"name\": \"hocat\", \"image_size\": 1024, \"width\": 256, "
                                "\"blocks\": [8, 36, 36, 8], \"roi\": 8, \"depth\": 1, \"heads\": 2 } }";
    const checkpoint_state state = { .step = 7, .best = INFINITY };
    lt_params *set = lt_params_new();
    train_config c;
    lt_optim *optim;
    small_model s;
    model m;

    small_model_init(&s);
    optim = lt_optim_new(s.set, &(lt_optim_opts){ .kind = LT_ADAM });
    ck_assert_int_eq(checkpoint_save(path, &s.m, optim, large, &state, NULL), LT_OK);
    ck_assert_int_eq(train_config_parse(s.arena, tasks, "large", large, NULL, 0, &c), LT_OK);
    ck_assert_int_eq(train_config_model(&c, s.m.hand, set, &m), LT_OK);
    check_error(checkpoint_load_model(path, &m), LT_EINVAL,
                "\"trunk.conv1.weight\" is (8, 3, 7, 7), the model's \"trunk.conv1.weight\" is (256, 3, 7, 7)");
    ck_assert_int_eq(checkpoint_check(path, &m), LT_EINVAL);
    ck_assert_ptr_null(lt_params_first(set)->data);
    ck_assert_uint_lt(lt_arena_bytes(lt_params_arena(set)), 4 << 20);
    lt_params_free(set);
    set = lt_params_new();
    train_config_fini(&c);
    ck_assert_int_eq(train_config_model(&s.c, s.m.hand, set, &m), LT_OK);        /* the one that it is of gets it */
    ck_assert_int_eq(checkpoint_load_model(path, &m), LT_OK);
    ck_assert_mem_eq(lt_params_first(set)->data, lt_params_first(s.set)->data,
                     (size_t)lt_param_numel(lt_params_first(set)) * sizeof(lt_real));
    unlink(path);
    lt_params_free(set);
    lt_optim_free(optim);
    small_model_fini(&s);
}
END_TEST

/* A later version's is refused by its number, whatever else it has; what is no checkpoint of ours, by its kind. */
START_TEST(of_others)
{
    static const struct {
        const char *version, *reason;
        lt_status status;
    } versions[] = {
        { "0.1.1", "written by palmar 0.1.1, and this is 0.1.0", LT_EINVAL }, { "0.2.0", "0.2.0", LT_EINVAL },
        { "1.0.0", "1.0.0", LT_EINVAL }, { "0.0.9", "is damaged: its check sum", LT_EFORMAT },
        { "0.1.x", "\"version\" is no version", LT_EFORMAT },
    };
    static const struct {
        const char *bytes;
        size_t n;
        const char *reason;
    } files[] = {
        { "PK\3\4\x14\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x0a\0\0\0a/data.pkl", 40,
          "a checkpoint of PyTorch, want one of palmar train; palmar train --init " },
        { "\x89PNG\r\n\x1a\n", 8, "a PNG image, want a checkpoint of palmar train" },
        { "\2\0\0\0\0\0\0\0{}", 10, "has weights, but is no checkpoint of palmar train; palmar train --init" },
    };
    const checkpoint_state state = { .step = 7, .best = INFINITY };
    static const char ours[] = "\"version\":\"" PACKAGE_VERSION;
    checkpoint_head head;
    lt_optim *optim;
    small_model s;
    uint8_t *bytes, *at;
    size_t n;

    small_model_init(&s);
    optim = lt_optim_new(s.set, &(lt_optim_opts){ .kind = LT_ADAM });
    ck_assert_int_eq(checkpoint_save(path, &s.m, optim, "{}", &state, NULL), LT_OK);
    ck_assert_int_eq(lt_read_file(s.arena, path, LT_FILE_MAX, &bytes, &n), LT_OK);
    at = memmem(bytes, n, ours, sizeof(ours) - 1);
    ck_assert_ptr_nonnull(at);
    for (size_t i = 0; i < LT_COUNT(versions); i++) {
        memcpy(at + sizeof(ours) - 1 - 5, versions[i].version, 5);
        put_file(path, bytes, n);
        check_error(checkpoint_head_read(s.arena, path, &head), versions[i].status, versions[i].reason);
    }
    for (size_t i = 0; i < LT_COUNT(files); i++) {
        put_file(path, files[i].bytes, files[i].n);
        check_error(checkpoint_load_model(path, &s.m), LT_EFORMAT, files[i].reason);
    }
    unlink(path);
    lt_optim_free(optim);
    small_model_fini(&s);
}
END_TEST

static const struct { const char *text, *want; } damaged[] = {
    { "{", "here: int8:1:1: " },
    { "[]", "here: int8: want a list \"layers\"" },
    { "{\"layers\": {}}", "here: int8: want a list \"layers\"" },
    { "{\"layers\": [{\"name\": \"trunk.conv1\", \"signed\": true}]}", "here: int8: layer 0: want a \"name\"" },
    { "{\"layers\": [{\"name\": \"trunk.conv1\", \"scale\": \"1\", \"signed\": true}]}",
      "here: int8: layer 0: want a" },
    { "{\"layers\": [{\"name\": \"trunk.conv1\", \"scale\": 1, \"signed\": 1}]}",
      "here: int8: layer 0: want a \"name\"" },
    { "{\"layers\": [{\"name\": \"trunk.conv1\", \"scale\": 0, \"signed\": true}]}",
      "here: int8: the scale of layer \"trunk.conv1\" is 0, want a finite number above 0" },
    { "{\"layers\": [{\"name\": \"trunk.conv1\", \"scale\": -2, \"signed\": true}]}", "is -2, want" },
    { "{\"layers\": [{\"name\": \"trunk.conv1\", \"scale\": NaN, \"signed\": true}]}", "\"trunk.conv1\" is " },
    { "{\"layers\": [{\"name\": \"trunk.conv1\", \"scale\": 1e39, \"signed\": true}]}", "is 1e+39, want" },
    { "{\"layers\": [{\"name\": \"trunk.conv1\", \"scale\": 1e-39, \"signed\": true}]}", "is 1e-39, want" },
    { "{\"layers\": [{\"name\": \"trunk.conv\", \"scale\": 1, \"signed\": true}]}",
      "here: int8: the model has no layer \"trunk.conv\"" },
    { "{\"layers\": [{\"name\": \"\", \"scale\": 1, \"signed\": true}]}", "here: int8: the model has no layer \"\"" },
    { "{\"layers\": [{\"name\": \"trunk.conv1\", \"scale\": 1, \"signed\": true},"
      "{\"name\": \"trunk.conv1\", \"scale\": 1, \"signed\": true}]}",
      "here: int8: layer \"trunk.conv1\" is there twice" },
};

START_TEST(damaged_table)
{
    const lt_int8_table *out = &table;
    small_model s;

    small_model_init(&s);
    ck_assert_int_eq(int8_table_parse(s.arena, "here", damaged[_i].text, s.set, &out), LT_EFORMAT);
    ck_assert_msg(strstr(lt_last_error(), damaged[_i].want) != NULL, "%s", lt_last_error());
    ck_assert_ptr_eq(out, &table);
    small_model_fini(&s);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_set_timeout(c, 0);
    tcase_add_loop_test(c, weights_or_their_average, 0, 2);
    tcase_add_test(c, groups_and_rows_come_back);
    tcase_add_test(c, table_in_a_checkpoint);
    tcase_add_test(c, data_without_its_place);
    tcase_add_test(c, half_precision);
    tcase_add_test(c, shapes_before_memory);
    tcase_add_test(c, of_others);
    tcase_add_loop_test(c, damaged_table, 0, LT_COUNT(damaged));
}

int main(void)
{
    return run_suite("checkpoint", add_tests);
}
