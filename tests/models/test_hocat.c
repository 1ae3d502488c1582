/* SPDX-License-Identifier: Apache-2.0 */
/* HOCAT: parameters of the paper's variants, and what must hold of any build of it, on a tiny one. */
#include "libtensor/graph/plan.h"
#include "libtensor/nn/init.h"
#include "models/hocat/hocat.h"
#include "tests/estimate/tiny_model.h"
#include "tests/models/stale.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>

/* ---- parameters, of the paper's size ------------------------------------------------------------------ */

static const struct {
    const char *config;
    int64_t total, attention;
} variants[] = {
    { "{\"variant\": \"base\"}", 31002259, 0 },
    { "{\"variant\": \"base\", \"base_feat\": \"c5up\"}", 31002259 + 524544, 0 },
    { "{\"variant\": \"dual\"}", 34510995, 0 },
    { "{\"variant\": \"full\"}", 37404819, 2893824 },
    { "{\"variant\": \"full\", \"fused\": true}", 34510995 + 2888704, 2888704 },
};

static const struct {
    const char *prefix;
    int64_t count;
} parts[] = {
    { "trunk", 23508032 }, { "hand_head", 3075114 }, { "hand_encoder", 1787648 }, { "mano", 1628778 },
    { "object_head", 1002687 },
};

START_TEST(parameter_totals)
{
    tiny_model t;
    lt_params *set;
    model m;

    tiny_model_init(&t);
    set = model_of("hocat", variants[_i].config, ((const hocat *)t.m.self)->mano.hand, &m);
    ck_assert_int_eq(lt_params_count(set, LT_WEIGHT, ""), variants[_i].total);
    for (size_t i = 0; i < LT_COUNT(parts); i++)
        ck_assert_int_eq(lt_params_count(set, LT_WEIGHT, parts[i].prefix), parts[i].count);
    ck_assert_int_eq(lt_params_count(set, LT_WEIGHT, "hocat"), variants[_i].attention);
    if (_i > 1)                                         /* two pyramids and their eight gates */
        ck_assert_int_eq(lt_params_count(set, LT_WEIGHT, "hand_fpn")
                         + lt_params_count(set, LT_WEIGHT, "object_fpn"), 3148288 + 360448);
    lt_params_free(set);
    tiny_model_fini(&t);
}
END_TEST

START_TEST(configs_that_cannot_be)
{
    expect_no_model("hocat", "{\"image_size\": 100}", "test.image_size: 100 is no multiple of 32");
    expect_no_model("hocat", "{\"roi\": 24}", "test.roi: 24 is no power of two");
    expect_no_model("hocat", "{\"heads\": 3}", "test.heads: 3 do not divide 256 channels");
    expect_no_model("hocat", "{\"variant\": \"dual\", \"fused\": true}", "test.fused: variant dual has no attention");
    expect_no_model("hocat", "{\"base_feat\": \"c5up\"}", "test.base_feat: variant full pools from its pyramids");
}
END_TEST

/* ---- what must hold ----------------------------------------------------------------------------------- */

static const char fused_hocat[] = "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], \"roi\": 8, "
                                  "\"fused\": true, \"heads\": 2, \"mlp_ratio\": 1}";

static tiny_model t;
static model_record r;
static lt_plan *plan;

static void start(void)
{
    tiny_model_init(&t);
    r = (model_record){ .g = lt_graph_new(), .batch = 2 };
}

static void stop(void)
{
    lt_plan_free(plan);
    lt_graph_free(r.g);
    tiny_model_fini(&t);
}

static void set_all(const char *prefix, double value)
{
    for (lt_param *p = lt_params_first(t.params); p; p = p->next)
        if (p->kind == LT_WEIGHT && strncmp(p->name, prefix, strlen(prefix)) == 0)
            lt_init_constant(p, value);
}

static lt_real *data(const char *output)
{
    return lt_plan_data(plan, model_port_find(&r.outputs, output));
}

static lt_real boxes[] = { 10, 8, 50, 60, 4, 4, 33, 30 };       /* of two images */

static void fill_inputs(const model_record *record, const lt_plan *p)
{
    lt_rng rng = lt_rng_make(3, 0);

    for (int i = 0; i < record->inputs.n; i++) {
        const lt_tensor *x = record->inputs.port[i].tensor;
        lt_real *v = lt_plan_data(p, x);

        for (int64_t k = 0; k < lt_numel(x); k++)
            v[k] = (lt_real)lt_rng_uniform(&rng);
        if (strstr(record->inputs.port[i].name, "_box"))
            memcpy(v, boxes, sizeof(boxes));
    }
}

static void run(void)
{
    t.m.cls->record(&t.m, false, &r);
    plan = lt_compile(r.g, NULL);
    ck_assert_msg(plan != NULL, "%s", lt_last_error());
    fill_inputs(&r, plan);
    lt_run(plan);
}

/* P2 is computed in boxes: whatever their sides, what lies outside them is of no influence. */
START_TEST(nothing_stale)
{
    lt_rng rng = lt_rng_make(9, 0);

    run();
    for (int k = 0; k < 20; k++) {
        for (int i = 0; i < 8; i++)
            boxes[i] = (lt_real)(i % 4 < 2 ? lt_rng_range(&rng, 0, 35) : boxes[i - 2] + lt_rng_range(&rng, 4, 28));
        expect_nothing_stale(plan, &r, fill_inputs);
    }
}
END_TEST

/* Flat heat maps mean the middle of the box. */
START_TEST(no_logits_no_opinion)
{
    set_all("hand_head.", 0);
    run();
    for (int i = 0; i < 2 * LT_HAND_KEYPOINTS * 2; i++)
        ck_assert_double_eq_tol(data("joints2d")[i], 0.5, 1e-6);
}
END_TEST

START_TEST(no_object_output_means_cell_centres)
{
    set_all("object_head.head.", 0);
    run();
    for (int i = 0; i < 2 * OBJECT_POINTS * 64; i++) {
        ck_assert_double_eq_tol(data("conf")[i], 0.5, 1e-7);
        ck_assert_double_eq_tol(data("point_x")[i], (i % 8 + 0.5) / 8, 1e-7);
        ck_assert_double_eq_tol(data("point_y")[i], (i / 8 % 8 + 0.5) / 8, 1e-7);
    }
}
END_TEST

/* A map of any width: more cells than any preset has. */
START_TEST(cell_centres_of_a_wide_map)
{
    enum { WIDTH = 1000 };
    lt_params *set = lt_params_new();
    lt_graph *g = lt_graph_new();
    object_head m;
    object_out out;
    lt_plan *p;

    object_head_new(&m, set, "head", 2);
    out = object_head_forward(&m, lt_input(g, "map", LT_F32, 4, (int64_t[]){ 1, 2, 1, WIDTH }));
    lt_output(out.x, "x");
    p = lt_compile(g, NULL);
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    lt_run(p);
    for (int i = 0; i < WIDTH; i++)
        ck_assert_double_eq_tol(((const lt_real *)lt_plan_data(p, out.x))[i], (i + 0.5) / WIDTH, 1e-7);
    lt_plan_free(p);
    lt_graph_free(g);
    lt_params_free(set);
}
END_TEST

/* The identity for all joints and no shape: the template, seen from its wrist. */
START_TEST(no_pose_means_the_template)
{
    lt_param *bias = lt_params_find(t.params, "mano.pose.bias");
    double wrist[3] = { 0 };

    set_all("mano.", 0);
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        bias->data[6 * j] = bias->data[6 * j + 4] = 1;
    run();
    for (int a = 0; a < 3; a++) {
        for (int v = 0; v < LT_HAND_VERTICES; v++)
            wrist[a] += (double)t.hand->J_regressor[0][v] * t.hand->v_template[v][a];
        ck_assert(data("joints")[a] == 0);
    }
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int a = 0; a < 3; a++)
            ck_assert_double_eq_tol(data("vertices")[3 * v + a], t.hand->v_template[v][a] - wrist[a], 1e-6);
}
END_TEST

/* A quarter turn about z of the wrist turns every vertex and joint by it. */
START_TEST(turning_the_wrist_turns_the_hand)
{
    lt_graph *g = lt_graph_new();
    const hocat *m = t.m.self;
    lt_tensor *R = lt_input(g, "R", LT_F32, 4, (int64_t[]){ 2, 16, 3, 3 });
    lt_tensor *beta = lt_input(g, "beta", LT_F32, 2, (int64_t[]){ 2, 10 });
    lt_tensor *v = lt_output(lt_skin(m->mano.hand, R, beta), "v"), *k = lt_output(lt_result(v, 1), "k");
    lt_plan *p = lt_compile(g, NULL);
    lt_real *rot = lt_plan_data(p, R), *x = lt_plan_data(p, v), *y = lt_plan_data(p, k);

    for (int i = 0; i < 2 * 16; i++)
        for (int a = 0; a < 3; a++)
            rot[9 * i + 4 * a] = 1;
    memcpy(rot + 144, (lt_real[]){ 0, -1, 0, 1, 0, 0, 0, 0, 1 }, 9 * sizeof(lt_real));
    for (int j = 1; j < 16; j++)                        /* fingers bent alike in both */
        for (int b = 0; b < 2; b++)
            memcpy(rot + 144 * b + 9 * j, (lt_real[]){ 0.8f, 0, 0.6f, 0, 1, 0, -0.6f, 0, 0.8f }, 9 * sizeof(lt_real));
    lt_run(p);
    for (int i = 0; i < LT_HAND_VERTICES + LT_HAND_KEYPOINTS; i++) {
        const lt_real *a = i < LT_HAND_VERTICES ? x + 3 * i : y + 3 * (i - LT_HAND_VERTICES);
        const lt_real *b = a + 3 * (i < LT_HAND_VERTICES ? LT_HAND_VERTICES : LT_HAND_KEYPOINTS);

        ck_assert_double_eq_tol(b[0], -a[1], 1e-6);
        ck_assert_double_eq_tol(b[1], a[0], 1e-6);
        ck_assert_double_eq_tol(b[2], a[2], 1e-6);
    }
    lt_plan_free(p);
    lt_graph_free(g);
}
END_TEST

typedef lt_tensor *attention_fn(const hocat_attention *m, lt_tensor *hand, lt_tensor *object);

/* Without values and without its second layer an attention block passes the hand's map on. */
START_TEST(an_idle_block_is_the_identity)
{
    attention_fn *const forward[] = { hocat_attention_forward, hocat_fused_forward };
    const hocat *m;
    lt_graph *g = r.g;
    lt_tensor *hand = lt_input(g, "hand", LT_F32, 4, (int64_t[]){ 1, 32, 8, 8 });
    lt_tensor *object = lt_input(g, "object", LT_F32, 4, (int64_t[]){ 1, 32, 8, 8 });
    lt_tensor *out;

    if (_i == 1) {
        tiny_model_fini(&t);
        tiny_model_of(&t, "hocat", fused_hocat);
    }
    m = t.m.self;
    out = lt_output(forward[_i](&m->attention, hand, object), "out");
    for (int i = 0; i < m->attention.depth; i++) {
        lt_init_constant(m->attention.block[i].v.weight, 0);
        lt_init_constant(m->attention.block[i].v.bias, 0);
        lt_init_constant(m->attention.block[i].fc2.weight, 0);
        lt_init_constant(m->attention.block[i].fc2.bias, 0);
    }
    plan = lt_compile(g, NULL);
    ck_assert_msg(plan != NULL, "%s", lt_last_error());
    for (int i = 0; i < 32 * 64; i++) {
        ((lt_real *)lt_plan_data(plan, hand))[i] = (lt_real)sin(i);
        ((lt_real *)lt_plan_data(plan, object))[i] = (lt_real)cos(i);
    }
    lt_run(plan);
    ck_assert(memcmp(lt_plan_data(plan, hand), lt_plan_data(plan, out), lt_nbytes(out)) == 0);
}
END_TEST

/* The plan of inference says what the plain one says. */
START_TEST(fused_and_plain_agree)
{
    lt_plan *plain;
    const lt_tensor *v;

    run();
    plain = lt_compile(r.g, &(lt_compile_opts){ .no_fusion = true });
    for (int i = 0; i < r.inputs.n; i++)
        memcpy(lt_plan_data(plain, r.inputs.port[i].tensor), lt_plan_data(plan, r.inputs.port[i].tensor),
               lt_nbytes(r.inputs.port[i].tensor));
    lt_run(plain);
    for (int i = 0; i < r.outputs.n; i++) {
        v = r.outputs.port[i].tensor;
        for (int64_t k = 0; k < lt_numel(v); k++)
            ck_assert_double_eq_tol(((lt_real *)lt_plan_data(plan, v))[k], ((lt_real *)lt_plan_data(plain, v))[k],
                                    1e-5);
    }
    ck_assert_int_lt(lt_plan_steps(plan), lt_plan_steps(plain));
    lt_plan_free(plain);
}
END_TEST

static void read_outputs(const lt_plan *p, const model_record *rec, lt_real *out)
{
    for (int i = 0; i < rec->outputs.n; i++) {
        const lt_tensor *v = rec->outputs.port[i].tensor;

        memcpy(out, lt_plan_data(p, v), lt_nbytes(v));
        out += lt_numel(v);
    }
}

static int64_t count_outputs(void)
{
    int64_t n = 0;

    for (int i = 0; i < r.outputs.n; i++)
        n += lt_numel(r.outputs.port[i].tensor);
    return n;
}

/* Maps computed only where boxes read them: the same predictions, whatever stands in the rest of them. The
 * boxes are inside, across the border, and outside. */
static const lt_real placed[][8] = {
    { 10, 8, 50, 60, 4, 4, 33, 30 }, { 20, 20, 21, 22, 40, 3, 63, 20 }, { -10, -5, 30, 80, 50, 50, 90, 70 },
    { 0, 0, 64, 64, 70, 70, 90, 90 },
};

START_TEST(maps_in_boxes_or_whole)
{
    static const lt_real usual[] = { 10, 8, 50, 60, 4, 4, 33, 30 };
    lt_real *whole, *within;
    bool moved = false;

    memcpy(boxes, placed[_i], sizeof(boxes));
    r.whole_maps = true;
    run();
    whole = calloc((size_t)count_outputs(), sizeof(*whole));
    within = calloc((size_t)count_outputs(), sizeof(*within));
    read_outputs(plan, &r, whole);
    lt_plan_free(plan);
    lt_graph_free(r.g);
    r = (model_record){ .g = lt_graph_new(), .batch = 2 };
    memcpy(boxes, usual, sizeof(boxes));
    run();                                              /* leaves its maps in the plan's memory */
    memcpy(boxes, placed[_i], sizeof(boxes));
    fill_inputs(&r, plan);
    lt_run(plan);
    read_outputs(plan, &r, within);
    for (int64_t k = 0; k < count_outputs(); k++) {
        ck_assert_double_eq_tol(within[k], whole[k], 1e-5);
        moved |= within[k] != whole[k];
    }
    ck_assert(moved || _i == 3);                        /* there the rectangle is the map */
    memcpy(boxes, usual, sizeof(boxes));
    free(whole);
    free(within);
}
END_TEST

static void gradients(bool whole_maps, bool no_recompute, lt_real *out)
{
    r = (model_record){ .g = lt_graph_new(), .batch = 2, .whole_maps = whole_maps };
    t.m.cls->record(&t.m, true, &r);
    plan = lt_compile(r.g, &(lt_compile_opts){ .loss = r.loss, .train = true, .no_recompute = no_recompute });
    ck_assert_msg(plan != NULL, "%s", lt_last_error());
    fill_inputs(&r, plan);
    lt_params_zero_grad(t.params);
    lt_run(plan);
    for (lt_param *p = lt_params_first(t.params); p; p = p->next)
        for (int64_t i = 0; p->grad && i < lt_param_numel(p); i++)
            *out++ = p->grad[i];
    lt_plan_free(plan);
    lt_graph_free(r.g);
    plan = NULL;
    r.g = NULL;
}

static size_t count_gradients(void)
{
    return (size_t)(lt_params_count(t.params, LT_WEIGHT, "") + lt_params_count(t.params, LT_STATISTIC, ""));
}

static double norm(const lt_real *x, const lt_real *less, int64_t n)
{
    double sum = 0;

    for (int64_t i = 0; i < n; i++)
        sum += pow((double)x[i] - (less ? less[i] : 0), 2);
    return sqrt(sum);
}

START_TEST(gradients_in_boxes_or_whole)
{
    const size_t n = count_gradients();
    lt_real *whole = calloc(n, sizeof(*whole)), *within = calloc(n, sizeof(*within)), *a = whole, *b = within;
    const lt_real usual[] = { 10, 8, 50, 60, 4, 4, 33, 30 };
    double all;

    memcpy(boxes, placed[_i], sizeof(boxes));
    lt_graph_free(r.g);
    gradients(true, false, whole);
    gradients(false, false, within);
    all = norm(whole, NULL, (int64_t)n);
    for (lt_param *p = lt_params_first(t.params); p; p = p->next) {
        const int64_t size = p->grad ? lt_param_numel(p) : 0;

        ck_assert_msg(norm(a, b, size) <= 1e-4 * norm(a, NULL, size) + 1e-6 * all, "%s", p->name);
        a += size, b += size;
    }
    memcpy(boxes, usual, sizeof(boxes));
    free(whole);
    free(within);
}
END_TEST

/* Recomputing instead of keeping, and the number of threads, change no bit of any gradient. */
START_TEST(recomputing_changes_no_bit)
{
    const size_t n = count_gradients();
    lt_real *kept = calloc(n, sizeof(*kept)), *redone = calloc(n, sizeof(*redone));
    bool any = false;

    lt_graph_free(r.g);
    gradients(false, true, kept);
    gradients(false, false, redone);
    for (size_t i = 0; i < n; i++)
        any |= kept[i] != 0;
    ck_assert(any && memcmp(kept, redone, n * sizeof(*kept)) == 0);
    free(kept);
    free(redone);
}
END_TEST

/* ---- losses that the papers have not ----------------------------------------------------------------- */

static double loss_of(const char *name)
{
    return *(const lt_real *)lt_plan_data(plan, model_port_find(&r.losses, name));
}

/* Truth: fingers bent alike, the wrist turned by R_0. */
static void run_against(const lt_real R_0[9])
{
    static const lt_real bent[9] = { 0.8f, 0, 0.6f, 0, 1, 0, -0.6f, 0, 0.8f };
    lt_real *truth;

    fill_inputs(&r, plan);
    truth = lt_plan_data(plan, model_port_find(&r.inputs, "rotation"));
    for (int i = 0; i < 2 * LT_HAND_JOINTS; i++)
        memcpy(truth + 9 * i, i % LT_HAND_JOINTS ? bent : R_0, sizeof(bent));
    lt_run(plan);
}

START_TEST(the_local_loss_does_not_see_the_wrist)
{
    static const lt_real none[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, quarter[9] = { 0, -1, 0, 1, 0, 0, 0, 0, 1 };
    double local, joints;

    tiny_model_fini(&t);
    tiny_model_of(&t, "hocat", "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], \"roi\": 8, "
                  "\"depth\": 1, \"heads\": 2, \"mlp_ratio\": 1, \"w_local\": 10000}");
    t.m.cls->record(&t.m, true, &r);
    plan = lt_compile(r.g, &(lt_compile_opts){ .loss = r.loss, .train = true });
    run_against(none);
    local = loss_of("local");
    joints = loss_of("joints");
    run_against(quarter);
    ck_assert_double_gt(local, 1);
    ck_assert_double_eq_tol(loss_of("local"), local, 1e-5 * local);
    ck_assert_double_gt(fabs(loss_of("joints") - joints), 1e-2 * joints);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("hocat");
    TCase *sizes = tcase_create("sizes"), *tc = tcase_create("tiny");

    tcase_set_timeout(sizes, 0);
    tcase_add_loop_test(sizes, parameter_totals, 0, (int)LT_COUNT(variants));
    tcase_add_test(sizes, configs_that_cannot_be);
    tcase_add_test(sizes, cell_centres_of_a_wide_map);
    suite_add_tcase(suite, sizes);
    tcase_set_timeout(tc, 0);
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_test(tc, nothing_stale);
    tcase_add_test(tc, no_logits_no_opinion);
    tcase_add_test(tc, no_object_output_means_cell_centres);
    tcase_add_test(tc, no_pose_means_the_template);
    tcase_add_test(tc, turning_the_wrist_turns_the_hand);
    tcase_add_loop_test(tc, an_idle_block_is_the_identity, 0, 2);
    tcase_add_test(tc, fused_and_plain_agree);
    tcase_add_loop_test(tc, maps_in_boxes_or_whole, 0, (int)LT_COUNT(placed));
    tcase_add_loop_test(tc, gradients_in_boxes_or_whole, 0, (int)LT_COUNT(placed));
    tcase_add_test(tc, recomputing_changes_no_bit);
    tcase_add_test(tc, the_local_loss_does_not_see_the_wrist);
    suite_add_tcase(suite, tc);
    return run_tests(suite);
}
