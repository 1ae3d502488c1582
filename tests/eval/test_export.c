/* SPDX-License-Identifier: Apache-2.0 */
/* Every model as an ONNX file that is read back and compared, and as weights; ops without an ONNX form. */
#include "assets/hand/hand.h"
#include "eval/export/export.h"
#include "libtensor/graph/internal.h"
#include "libtensor/graph/plan.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/file.h"
#include "libtensor/io/onnx/onnx.h"
#include "libtensor/io/text/json.h"
#include "libtensor/ops/ops.h"
#include "tests/suite.h"

#include <cjson/cJSON.h>
#include <math.h>

/* Small sizes of each model: its group of a config. A model that is not named here has its own defaults. */
static const struct {
    const char *model, *config;
} sizes[] = {
    { "hocat", "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], \"roi\": 8, \"depth\": 2, \"heads\": 2, "
               "\"mlp_ratio\": 1, \"head_init\": \"default\", \"identity_pose\": true}" },
    { "hocat", "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], \"roi\": 8, \"depth\": 1, \"heads\": 4, "
               "\"mlp_ratio\": 2, \"imagenet_norm\": true, \"head_init\": \"default\", \"identity_pose\": true, "
               "\"se_place\": \"none\"}" },
    { "resnet50", "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 2, 1, 1], \"classes\": 10}" },
    { "efficientnet_b0", "{\"image_size\": 64, \"classes\": 10}" },
    { "unified", "{\"image_size\": 96, \"width\": 8, \"layers\": 1, \"heads\": 2, \"points\": 2}" },
};

typedef struct {
    lt_arena *arena;
    lt_hand_layer *layer;
    lt_params *params;
    model m;
} built;

/* Random running statistics too, so that a batch norm that is dropped or misread is seen */
static void randomise(lt_params *set)
{
    lt_rng rng = lt_rng_make(3, 0);

    for (lt_param *p = lt_params_first(set); p; p = p->next)
        for (int64_t i = 0; p->shape.rank == 1 && i < lt_param_numel(p); i++)
            p->data[i] = (lt_real)(p->data[i] + lt_rng_range(&rng, 0, 0.3));
}

static void build(built *b, const model_class *cls, const char *config, const char *variant)
{
    lt_hand_model *hand;
    cJSON *root;

    b->arena = lt_arena_new();
    b->params = lt_params_new();
    check_ok(synth_hand_new(b->arena, SYNTH_HAND_MANO_LIKE, &hand));
    check_ok(lt_hand_layer_new(b->arena, hand, lt_hand_tips_ho3d, &b->layer));
    check_ok(lt_json_parse("test", config, strlen(config), &root));
    if (cls->variants[1])
        cJSON_AddStringToObject(root, "variant", variant);
    check_ok(model_create(cls, "test", root, b->layer, b->params, &b->m));
    cls->init(&b->m, 7);
    randomise(b->params);
    cJSON_Delete(root);
}

static void destroy(built *b)
{
    lt_params_free(b->params);
    lt_arena_free(b->arena);
}

/* Networks on points choose and collect these by index, LPIPS is one op, and Gaussians are drawn, not multiplied: none
 * has an ONNX form here. */
static bool without_onnx(const model_class *cls)
{
    static const char *const names[] = { "pointnet2", "gpm", "lpips", "points", "hogs", "splats" };

    for (size_t i = 0; i < LT_COUNT(names); i++)
        if (strcmp(cls->name, names[i]) == 0)
            return true;
    return false;
}

/* Larger by numbers alone than the first, and as large as they are published: OSX's s, b and l of up to 327 million */
static bool is_more_of_the_same(const model_class *cls, int variant)
{
    return strcmp(cls->name, "osx") == 0 && variant > 0;
}

/* Call fn with every variant of every model but those, at each of its small sizes. */
static void for_every_model(void (*fn)(const model *m))
{
    for (int c = 0; model_classes[c]; c++) {
        int found = without_onnx(model_classes[c]);

        for (size_t i = 0; i <= LT_COUNT(sizes); i++) {
            const char *config = i < LT_COUNT(sizes) ? sizes[i].config : "{}";

            if (i < LT_COUNT(sizes) ? strcmp(sizes[i].model, model_classes[c]->name) != 0 : found)
                continue;
            found++;
            for (int v = 0; model_classes[c]->variants[v]; v++) {
                built b;

                if (is_more_of_the_same(model_classes[c], v))
                    continue;
                build(&b, model_classes[c], config, model_classes[c]->variants[v]);
                fn(&b.m);
                destroy(&b);
            }
        }
    }
}

/* ---- every model ------------------------------------------------------------------------------------------ */

static void check_onnx(const model *m)
{
    export_report r;

    for (int batch = 0; batch < 4; batch += 3) {
        const export_options o = { .m = m, .hand_name = "a \"hand\"\xff", .batch = batch };

        check_ok(export_onnx(&o, in_folder("model.onnx"), &r));
        ck_assert_int_gt(r.n_outputs, 0);
        ck_assert_int_eq(r.any_batch, batch == 0);
        for (int i = 0; i < r.n_outputs; i++)
            ck_assert_msg(r.output[i].relative <= 2e-5, "%s %s batch %d: %s differs by %g", m->cls->name, m->variant,
                          batch, r.output[i].name, r.output[i].relative);
    }
}

START_TEST(every_model_is_what_its_file_is)
{
    for_every_model(check_onnx);
}
END_TEST

/* ---- every op ----------------------------------------------------------------------------------------------- */

static void check_ops(const model *m)
{
    model_record r = { .g = lt_graph_new(), .batch = 2, .whole_maps = true };

    m->cls->record(m, false, &r);
    check_ok(lt_graph_status(r.g));
    for (int i = 0; i < r.g->n_nodes; i++)
        ck_assert_msg(r.g->node[i]->op->onnx, "%s %s uses \"%s\", which has no ONNX form: give its lt_op an onnx "
                      "function", m->cls->name, m->variant, r.g->node[i]->op->name);
    lt_graph_free(r.g);
}

START_TEST(every_op_has_an_onnx_form)
{
    for_every_model(check_ops);
}
END_TEST

/* docs/onnx.md has a row for each op of a shipped model. */
static char *page;

static void check_row(const model *m)
{
    model_record r = { .g = lt_graph_new(), .batch = 2, .whole_maps = true };

    m->cls->record(m, false, &r);
    for (int i = 0; i < r.g->n_nodes; i++) {
        char row[80];

        snprintf(row, sizeof(row), "\n| `%s` |", r.g->node[i]->op->name);
        ck_assert_msg(strstr(page, row), "docs/onnx.md has no row for \"%s\"", r.g->node[i]->op->name);
    }
    lt_graph_free(r.g);
}

START_TEST(every_op_is_in_the_table)
{
    lt_arena *arena = lt_arena_new();
    char path[512];
    size_t n;

    snprintf(path, sizeof(path), "%s/docs/onnx.md", getenv("srcdir") ? getenv("srcdir") : "..");
    check_ok(lt_read_file(arena, path, 1 << 20, (uint8_t **)(void *)&page, &n));
    for_every_model(check_row);
    lt_arena_free(arena);
}
END_TEST

/* ---- what the file says of itself ----------------------------------------------------------------------------- */

static const char *meta(const lt_onnx_model *m, const char *key)
{
    for (int i = 0; i < m->n_meta; i++)
        if (strcmp(m->meta[i].key, key) == 0)
            return m->meta[i].value;
    return "";
}

static void export_tiny(built *b, const char *path, int batch)
{
    export_report r;
    const model_class *cls;

    check_ok(model_find("hocat", &cls));
    build(b, cls, sizes[0].config, "full");
    check_ok(export_onnx(&(export_options){ .m = &b->m, .hand_name = "MANO_RIGHT.pkl", .batch = batch }, path, &r));
}

START_TEST(a_file_carries_its_preprocessing)
{
    lt_onnx_model m;
    cJSON *config;
    built b;

    export_tiny(&b, in_folder("meta.onnx"), 0);
    check_ok(lt_onnx_read(b.arena, in_folder("meta.onnx"), &m));
    ck_assert_str_eq(m.producer, "palmar");
    ck_assert_int_eq(m.opset, 17);
    ck_assert_str_eq(meta(&m, "model"), "hocat");
    ck_assert_str_eq(meta(&m, "image.size"), "64");
    ck_assert_str_eq(meta(&m, "image.color"), "RGB");
    ck_assert_str_eq(meta(&m, "image.mean"), "0, 0, 0");
    ck_assert_str_eq(meta(&m, "hand"), "MANO_RIGHT.pkl");
    ck_assert_ptr_nonnull(strstr(meta(&m, "joints"), "wrist, thumb_cmc"));
    check_ok(lt_json_parse("config", meta(&m, "config"), strlen(meta(&m, "config")), &config));
    ck_assert_int_eq(cJSON_GetObjectItem(config, "roi")->valueint, 8);
    cJSON_Delete(config);
    ck_assert_int_eq(m.n_inputs, 3);
    ck_assert_str_eq(m.input[0].name, "image");
    ck_assert_int_eq(m.input[0].shape.dim[0], -1);
    ck_assert_int_eq(m.input[0].shape.dim[3], 64);
    ck_assert_int_eq(m.n_outputs, 9);
    destroy(&b);
}
END_TEST

START_TEST(a_fixed_batch_is_fixed)
{
    lt_onnx_model m;
    built b;

    export_tiny(&b, in_folder("two.onnx"), 2);
    check_ok(lt_onnx_read(b.arena, in_folder("two.onnx"), &m));
    for (int i = 0; i < m.n_inputs; i++)
        ck_assert_int_eq(m.input[i].shape.dim[0], 2);
    destroy(&b);
}
END_TEST

START_TEST(the_same_model_gives_the_same_bytes)
{
    uint8_t *a, *c;
    size_t n, k;
    built b;

    export_tiny(&b, in_folder("a.onnx"), 0);
    destroy(&b);
    export_tiny(&b, in_folder("b.onnx"), 0);
    check_ok(lt_read_file(b.arena, in_folder("a.onnx"), LT_FILE_MAX, &a, &n));
    check_ok(lt_read_file(b.arena, in_folder("b.onnx"), LT_FILE_MAX, &c, &k));
    ck_assert_uint_eq(n, k);
    ck_assert_int_eq(memcmp(a, c, n), 0);
    destroy(&b);
}
END_TEST

/* ---- what must not be written ------------------------------------------------------------------------------------ */

static lt_status like_first(lt_call *c)
{
    c->out->shape = c->in[0]->shape;
    return LT_OK;
}

static void negate(const lt_call *c)
{
    for (int64_t i = 0; i < lt_numel(c->out); i++)
        ((lt_real *)c->out->data)[i] = -((const lt_real *)c->in[0]->data)[i];
}

/* What a mistaken mapping says: it is off by a thousandth */
static void wrong_onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_is(w, n->outs[0], LT_ONNX(w, "Mul", lt_onnx_of(w, n->in[0]), lt_onnx_number(w, -1.001)));
}

static void silent_onnx(lt_onnx *w, const lt_node *n)
{
    LT_ONNX(w, "Relu", lt_onnx_of(w, n->in[0]));
}

static const lt_op mute_op = { .name = "mute", .infer = like_first, .forward = negate };
static const lt_op wrong_op = { .name = "wrong", .infer = like_first, .forward = negate, .onnx = wrong_onnx };
static const lt_op silent_op = { .name = "silent", .infer = like_first, .forward = negate, .onnx = silent_onnx };
static const lt_op *used;

static void record_used(const model *m, bool losses, model_record *r)
{
    lt_tensor *x = model_input(r, "x", LT_SHAPE(r->batch, 3)), *y = lt_apply(used, NULL, 0, &x, 1);

    (void)m;
    (void)losses;
    model_port_add(&r->outputs, "y", lt_output(y, "y"));
}

/* A constant of the batch's size: what a graph for any batch cannot have */
static void record_constant(const model *m, bool losses, model_record *r)
{
    const lt_real one[8] = { 1, 2, 3, 4, 5, 6, 7, 8 };
    lt_tensor *x = model_input(r, "x", LT_SHAPE(r->batch, 1));

    (void)m;
    (void)losses;
    model_port_add(&r->outputs, "y", lt_output(lt_add(x, lt_constant(r->g, LT_F32, LT_SHAPE(r->batch, 1), one)), "y"));
}

static const lt_config_key no_keys[] = { { .name = NULL } };

static lt_status export_with(void (*record)(const model *, bool, model_record *), int batch, export_report *r)
{
    const model_class cls = { .name = "test", .paper = "", .keys = no_keys, .record = record };
    const model m = { .cls = &cls, .variant = "full", .self = r };

    return export_onnx(&(export_options){ .m = &m, .batch = batch }, in_folder("kept.onnx"), r);
}

START_TEST(a_file_that_answers_differently_is_not_left)
{
    lt_arena *arena = lt_arena_new();
    export_report r;
    uint8_t *bytes;
    size_t n;

    put_file(in_folder("kept.onnx"), "before", 6);
    used = &wrong_op;
    check_error(export_with(record_used, 0, &r), LT_ENUMERIC, "output \"y\" differs from the model's by 1.0e-03");
    ck_assert_int_eq(r.n_outputs, 1);
    ck_assert_double_eq_tol(r.output[0].relative, 1e-3, 1e-6);
    used = &mute_op;
    check_error(export_with(record_used, 0, &r), LT_EINVAL, "no ONNX form of \"mute\"");
    used = &silent_op;
    check_error(export_with(record_used, 0, &r), LT_EINVAL, "silent: its onnx function does not say what result 0 is");
    check_ok(lt_read_file(arena, in_folder("kept.onnx"), 100, &bytes, &n));
    ck_assert_str_eq((const char *)bytes, "before");
    lt_arena_free(arena);
}
END_TEST

/* A third of a picture, beside 2000 for a while: how it is rounded there, to a thousandth of itself or so, is up to
 * whether the norm is folded into the convolution. What follows may be off by a thousandth in the file. */
static void record_rounded(const model *m, bool losses, model_record *r)
{
    const lt_real third = (lt_real)(1. / 3), far = 2000, one = 1, none = 0;
    lt_tensor *x = model_input(r, "image", LT_SHAPE(r->batch, 1, 8, 8)), *y;
    lt_tensor *w = lt_constant(r->g, LT_F32, LT_SHAPE(1, 1, 1, 1), &third);
    lt_tensor *ones = lt_constant(r->g, LT_F32, LT_SHAPE(1), &one);
    lt_tensor *zeros = lt_constant(r->g, LT_F32, LT_SHAPE(1), &none);
    lt_tensor *offset = lt_constant(r->g, LT_F32, LT_SHAPE(1), &far);

    (void)m;
    (void)losses;
    y = lt_batch_norm(lt_conv2d(x, w, NULL, NULL), ones, offset, zeros, ones, 0.1);
    y = lt_sub(lt_relu(y), offset);
    y = lt_apply(used, NULL, 0, &y, 1);
    model_port_add(&r->outputs, "y", lt_output(y, "y"));
}

START_TEST(a_file_is_held_against_the_models_own_rounding)
{
    export_report r;

    used = &wrong_op;
    check_ok(export_with(record_rounded, 0, &r));
    ck_assert_double_gt(r.output[0].relative, 5e-4);
    ck_assert_double_gt(r.output[0].rounding, r.output[0].relative / EXPORT_ROUNDINGS);
}
END_TEST

/* White noise would show a trained network what it has never seen. */
START_TEST(maps_are_drawn_as_pictures_are)
{
    lt_arena *arena = lt_arena_new();
    double step = 0, lo = 1, hi = 0;
    const lt_array *x;
    export_options o;
    export_report r;
    lt_npz npz;
    built b;

    build(&b, model_classes[0], sizes[0].config, "full");
    o = (export_options){ .m = &b.m, .samples = lt_arena_strdup(arena, in_folder("samples.npz")) };
    check_ok(export_onnx(&o, in_folder("model.onnx"), &r));
    check_ok(lt_npz_read(arena, in_folder("samples.npz"), &npz));
    x = lt_npz_find(&npz, "image");
    for (size_t i = 1; i < lt_array_count(x); i++) {
        step += fabs(lt_array_get(x, i) - lt_array_get(x, i - 1)) / (double)lt_array_count(x);
        lo = fmin(lo, lt_array_get(x, i));
        hi = fmax(hi, lt_array_get(x, i));
    }
    ck_assert(lo >= 0 && hi <= 1 && hi - lo > 0.6);
    ck_assert_double_lt(step, 0.05);            /* white noise: 1 / 3 */
    destroy(&b);
    lt_arena_free(arena);
}
END_TEST

START_TEST(a_constant_of_the_batch_wants_a_fixed_batch)
{
    export_report r;

    check_error(export_with(record_constant, 0, &r), LT_EINVAL, "depends on the batch; give the batch a fixed size");
    check_ok(export_with(record_constant, 4, &r));
    ck_assert_double_eq(r.output[0].absolute, 0);
}
END_TEST

/* ---- weights alone ----------------------------------------------------------------------------------------------- */

START_TEST(weights_are_written_bit_by_bit)
{
    const model_class *cls;
    export_report r;
    lt_safetensors s;
    built b;

    check_ok(model_find("resnet50", &cls));
    build(&b, cls, sizes[2].config, "full");
    check_ok(export_weights(&(export_options){ .m = &b.m }, in_folder("w.safetensors"), &r));
    check_ok(lt_safetensors_read(b.arena, in_folder("w.safetensors"), &s));
    ck_assert_str_eq(lt_safetensors_meta(&s, "format"), "palmar-weights");
    ck_assert_str_eq(lt_safetensors_meta(&s, "model"), "resnet50");
    for (const lt_param *p = lt_params_first(b.params); p; p = p->next) {
        const lt_array *a = lt_safetensors_find(&s, p->name);

        ck_assert_msg(a, "%s is missing", p->name);
        ck_assert_int_eq(memcmp(a->data, p->data, (size_t)lt_param_numel(p) * sizeof(float)), 0);
    }
    destroy(&b);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, every_model_is_what_its_file_is);
    tcase_add_test(tc, every_op_has_an_onnx_form);
    tcase_add_test(tc, every_op_is_in_the_table);
    tcase_add_test(tc, a_file_carries_its_preprocessing);
    tcase_add_test(tc, a_fixed_batch_is_fixed);
    tcase_add_test(tc, the_same_model_gives_the_same_bytes);
    tcase_add_test(tc, a_file_that_answers_differently_is_not_left);
    tcase_add_test(tc, a_file_is_held_against_the_models_own_rounding);
    tcase_add_test(tc, maps_are_drawn_as_pictures_are);
    tcase_add_test(tc, a_constant_of_the_batch_wants_a_fixed_batch);
    tcase_add_test(tc, weights_are_written_bit_by_bit);
}

int main(void)
{
    return run_suite("export", add_tests);
}
