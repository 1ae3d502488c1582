/* SPDX-License-Identifier: Apache-2.0 */
/* The unified estimator: parameters and multiply-adds of the paper's variants, and what must hold of its parts. */
#include "libtensor/base/parallel.h"
#include "libtensor/graph/plan.h"
#include "libtensor/nn/init.h"
#include "models/unified/unified.h"
#include "tests/estimate/tiny_model.h"
#include "tests/models/stale.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>

/* ---- sizes, of the paper's ------------------------------------------------------------------------------ */

static const struct {
    const char *config;
    int64_t total;
} variants[] = {
    { "{\"variant\": \"full\"}", 8603325 },
    { "{\"variant\": \"no_depth\"}", 8280999 },
    { "{\"variant\": \"no_aaf\"}", 8603325 - 14242 },
    { "{\"variant\": \"no_cross_attention\"}", 8603325 - 24960 },
    { "{\"stage5_dilation\": 2}", 8603325 },
};

static const struct {
    const char *prefix;
    int64_t count;
} parts[] = {
    { "rgb", 308660 }, { "depth", 308084 }, { "aaf", 14242 }, { "hand_encoder", 630880 },
    { "object_encoder", 630880 }, { "cross", 24960 }, { "hourglass", 3605418 }, { "object_head", 66399 },
};

static const double MACS = 1948898816;

START_TEST(configs_that_cannot_be)
{
    expect_no_model("unified", "{\"image_size\": 100}", "test.image_size: 100 is no multiple of 32");
    expect_no_model("unified", "{\"heads\": 7}", "test.heads: 7 do not divide 128 channels");
}
END_TEST

START_TEST(parameter_totals)
{
    tiny_model t;
    lt_params *set;
    model m;

    tiny_model_init(&t);
    set = model_of("unified", variants[_i].config, t.layer, &m);
    ck_assert_int_eq(lt_params_count(set, LT_WEIGHT, ""), variants[_i].total);
    for (size_t i = 0; i < LT_COUNT(parts); i++)
        if (lt_params_count(set, LT_WEIGHT, parts[i].prefix))
            ck_assert_int_eq(lt_params_count(set, LT_WEIGHT, parts[i].prefix), parts[i].count);
    ck_assert_int_eq(lt_params_count(set, LT_WEIGHT, "mesh_encoder")
                     + lt_params_count(set, LT_WEIGHT, "mano"), 3013802);
    lt_params_free(set);
    tiny_model_fini(&t);
}
END_TEST

START_TEST(multiply_adds)
{
    model_record r = { .g = lt_graph_new(), .batch = 1 };
    tiny_model t;
    lt_params *set;
    lt_plan *plan;
    model m;

    tiny_model_init(&t);
    set = model_of("unified", "{}", t.layer, &m);
    m.cls->record(&m, false, &r);
    plan = lt_compile(r.g, NULL);
    ck_assert_msg(plan != NULL, "%s", lt_last_error());
    ck_assert_double_eq_tol((double)lt_plan_macs(plan), MACS, 0.01 * MACS);
    lt_plan_free(plan);
    lt_graph_free(r.g);
    lt_params_free(set);
    tiny_model_fini(&t);
}
END_TEST

/* The stride of the last stage is gone: 224 pixels become 28 cells. */
START_TEST(cut_of_the_backbone)
{
    lt_params *set = lt_params_new();
    lt_graph *g = lt_graph_new();
    efficientnet net;

    efficientnet_new(&net, set, "", &(efficientnet_opts){ .in = 1, .stages = 4, .last_stride = 1,
                                                          .last_dilation = 1 + _i });
    lt_tensor *x = lt_input(g, "x", LT_F32, 4, (int64_t[]){ 2, 1, 224, 224 });
    lt_tensor *y = lt_output(efficientnet_forward(&net, x), "y");
    lt_plan *p = lt_compile(g, NULL);

    ck_assert_msg(p != NULL, "%s", lt_last_error());
    ck_assert_int_eq(lt_dim(y, 1), 80);
    ck_assert_int_eq(lt_dim(y, 2), 28);
    ck_assert_int_eq(lt_dim(y, 3), 28);
    ck_assert_int_eq(lt_plan_macs(p), 2 * 258045184);
    lt_plan_free(p);
    lt_graph_free(g);
    lt_params_free(set);
}
END_TEST

/* ---- parts ------------------------------------------------------------------------------------------------ */

/* One cell of 14 x 14 through the last transposed convolution lies in the middle around 2 i + 2.5 of the heat
 * map's cells: crop pixel 16 (i + 0.5). */
START_TEST(geometry_of_the_heat_maps)
{
    enum { IN = 14, OUT = 32, AT = 5 };
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 4, (int64_t[]){ 1, 1, IN, IN });
    lt_tensor *w = lt_input(g, "w", LT_F32, 4, (int64_t[]){ 1, 1, 6, 6 });
    lt_tensor *y = lt_output(lt_conv_transpose2d(x, w, NULL, 2, 0), "y");
    lt_plan *p = lt_compile(g, NULL);
    double sum = 0, mean = 0;

    ck_assert_msg(p != NULL, "%s", lt_last_error());
    memset(lt_plan_data(p, x), 0, lt_nbytes(x));
    ((lt_real *)lt_plan_data(p, x))[IN * AT + AT] = 1;
    for (int i = 0; i < 36; i++)
        ((lt_real *)lt_plan_data(p, w))[i] = 1;
    lt_run(p);
    for (int i = 0; i < OUT * OUT; i++) {
        sum += ((lt_real *)lt_plan_data(p, y))[i];
        mean += ((lt_real *)lt_plan_data(p, y))[i] * (i % OUT);
    }
    mean /= sum;
    ck_assert_double_eq_tol(mean, 2 * AT + 2.5, 1e-6);
    ck_assert_double_eq_tol(8 * mean - 12, 16 * (AT + 0.5), 1e-5);
    lt_plan_free(p);
    lt_graph_free(g);
}
END_TEST

/* Cells of the first heat map that are as low as any */
static int lowest_cells(bool up3_relu)
{
    enum { CELLS = 16, CHANNELS = 8, JOINTS = 21, SIDE = CELLS + 2 * HOURGLASS_MARGIN };
    lt_params *set = lt_params_new();
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 4, (int64_t[]){ 1, CHANNELS, CELLS, CELLS }), *maps;
    const lt_real *cell;
    unified_hourglass m;
    lt_plan *p;
    lt_real lowest = 1;
    int n = 0;

    unified_hourglass_new(&m, set, "hourglass", CELLS, CHANNELS, JOINTS, up3_relu);
    lt_init_default(set, 1);
    lt_init_constant(m.temperature, 1);
    maps = lt_output(unified_hourglass_forward(&m, x).heatmaps, "maps");
    p = lt_compile(g, NULL);
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    for (int i = 0; i < CHANNELS * CELLS * CELLS; i++)
        ((lt_real *)lt_plan_data(p, x))[i] = (lt_real)sin(i);
    lt_run(p);
    cell = lt_plan_data(p, maps);
    for (int i = 0; i < SIDE * SIDE; i++)
        lowest = cell[i] < lowest ? cell[i] : lowest;
    for (int i = 0; i < SIDE * SIDE; i++)
        n += cell[i] == lowest;
    lt_plan_free(p);
    lt_graph_free(g);
    lt_params_free(set);
    return n;
}

/* The printed ReLU makes all cells below 0 alike. */
START_TEST(relu_before_the_heat_maps)
{
    ck_assert_int_eq(lowest_cells(false), 1);
    ck_assert_int_gt(lowest_cells(true), 40);
}
END_TEST

static double cell(const lt_real *map, int side, int C, int channel, double x, double y)
{
    return x < 0 || y < 0 || x > side - 1 || y > side - 1 ? 0 : map[((int)y * side + (int)x) * C + channel];
}

/* At first each head, before the output projection, is the plain mean of its value map at the four cells towards
 * which its offsets' bias points; heads 0, 2, 4, 6 look along the axes, at whole cells. */
START_TEST(first_look_is_a_mean)
{
    enum { SIDE = 12, C = 16, HEADS = 8, POINTS = 4, D = C / HEADS };
    static const int way[HEADS][2] = {
        { 1, 0 }, { 1, 1 }, { 0, 1 }, { -1, 1 }, { -1, 0 }, { -1, -1 }, { 0, -1 }, { 1, -1 },
    };
    const encoder_opts o = { .cells = SIDE, .in = 8, .width = C, .out = 8, .layers = 1, .heads = HEADS,
                             .points = POINTS, .ffn = 8 };
    lt_params *set = lt_params_new();
    lt_graph *g = lt_graph_new();
    deformable_encoder m;
    lt_tensor *x, *y;
    lt_plan *p;
    const lt_real *in, *out;

    deformable_encoder_new(&m, set, "e", &o);
    lt_init_default(set, 1);
    deformable_encoder_init(&m, 1);
    x = lt_input(g, "x", LT_F32, 3, (int64_t[]){ 1, SIDE * SIDE, C });
    y = lt_output(lt_deformable_attention(x, lt_linear_layer_forward(&m.layer[0].offsets, x),
                                          lt_linear_layer_forward(&m.layer[0].weights, x),
                                          lt_cell_places(g, SIDE, SIDE), HEADS, SIDE, SIDE), "y");
    p = lt_compile(g, NULL);
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    for (int i = 0; i < SIDE * SIDE * C; i++)
        ((lt_real *)lt_plan_data(p, x))[i] = (lt_real)sin(i);
    lt_run(p);
    in = lt_plan_data(p, x);
    out = lt_plan_data(p, y);
    for (int i = 0; i < SIDE * SIDE * C; i++) {
        const int *w = way[i % C / D], at = i / C;
        double want = 0;

        for (int k = 1; k <= POINTS; k++)
            want += cell(in, SIDE, C, i % C, at % SIDE + k * w[0], at / SIDE + k * w[1]) / POINTS;
        ck_assert_double_eq_tol(out[i], want, 1e-5);
    }
    lt_plan_free(p);
    lt_graph_free(g);
    lt_params_free(set);
}
END_TEST

START_TEST(offsets_learn_slowly)
{
    tiny_model t;
    int slow = 0;

    tiny_model_of(&t, "unified", tiny_unified);
    for (lt_param *p = lt_params_first(t.params); p; p = p->next) {
        const bool offset = strstr(p->name, ".offsets.") != NULL;

        ck_assert_double_eq(p->rate, offset ? 0.1 : 1);
        slow += offset;
    }
    ck_assert_int_eq(slow, 2 * 2);
    tiny_model_fini(&t);
}
END_TEST

/* ---- the whole --------------------------------------------------------------------------------------------- */

static void fill_inputs(const model_record *r, const lt_plan *plan)
{
    for (int i = 0; i < r->inputs.n; i++) {
        const lt_tensor *x = r->inputs.port[i].tensor;
        lt_rng rng = lt_rng_make(3, (uint64_t)i);

        for (int64_t k = 0; k < lt_numel(x); k++)
            ((lt_real *)lt_plan_data(plan, x))[k] = (lt_real)lt_rng_uniform(&rng);
    }
}

START_TEST(fused_and_plain_agree)
{
    model_record r = { .g = lt_graph_new(), .batch = 2 };
    lt_plan *plan, *plain;
    tiny_model t;

    tiny_model_of(&t, "unified", tiny_unified);
    t.m.cls->record(&t.m, false, &r);
    plan = lt_compile(r.g, NULL);
    plain = lt_compile(r.g, &(lt_compile_opts){ .no_fusion = true });
    ck_assert_msg(plan && plain, "%s", lt_last_error());
    fill_inputs(&r, plan);
    fill_inputs(&r, plain);
    lt_run(plan);
    lt_run(plain);
    for (int i = 0; i < r.outputs.n; i++) {
        const lt_tensor *v = r.outputs.port[i].tensor;
        const lt_real *a = lt_plan_data(plan, v), *b = lt_plan_data(plain, v);

        for (int64_t k = 0; k < lt_numel(v); k++)
            ck_assert_msg(fabs((double)a[k] - (double)b[k]) <= 1e-4 * fmax(1, fabs((double)b[k])),
                          "%s[%d]: %g, plain %g", r.outputs.port[i].name, (int)k, (double)a[k], (double)b[k]);
    }
    ck_assert_int_lt(lt_plan_steps(plan), lt_plan_steps(plain));
    expect_nothing_stale(plan, &r, fill_inputs);
    expect_nothing_stale(plain, &r, fill_inputs);
    lt_plan_free(plan);
    lt_plan_free(plain);
    lt_graph_free(r.g);
    tiny_model_fini(&t);
}
END_TEST

/* All gradients of a step with dropout, one after another; the caller's to free. */
static lt_real *gradients(const tiny_model *t, size_t *n)
{
    model_record r = { .g = lt_graph_new(), .batch = 2 };
    lt_real *all = calloc((size_t)lt_params_count(t->params, LT_WEIGHT, ""), sizeof(*all));
    lt_plan *plan;

    t->m.cls->record(&t->m, true, &r);
    plan = lt_compile(r.g, &(lt_compile_opts){ .loss = r.loss, .train = true });
    ck_assert_msg(plan != NULL, "%s", lt_last_error());
    fill_inputs(&r, plan);
    lt_params_zero_grad(t->params);
    lt_run(plan);
    *n = 0;
    for (lt_param *p = lt_params_first(t->params); p; p = p->next)
        for (int64_t i = 0; p->kind == LT_WEIGHT && i < lt_param_numel(p); i++)
            all[(*n)++] = p->grad[i];
    lt_plan_free(plan);
    lt_graph_free(r.g);
    return all;
}

START_TEST(threads_change_no_bit)
{
    tiny_model t;
    lt_real *one, *more;
    size_t n;

    tiny_model_of(&t, "unified", tiny_unified);
    lt_set_threads(1);
    one = gradients(&t, &n);
    for (int threads = 2; threads <= 4; threads++) {
        lt_set_threads(threads);
        more = gradients(&t, &n);
        ck_assert_msg(memcmp(one, more, n * sizeof(*one)) == 0, "other bits on %d threads", threads);
        free(more);
    }
    free(one);
    tiny_model_fini(&t);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_loop_test(tc, parameter_totals, 0, (int)LT_COUNT(variants));
    tcase_add_test(tc, multiply_adds);
    tcase_add_loop_test(tc, cut_of_the_backbone, 0, 2);
    tcase_add_test(tc, geometry_of_the_heat_maps);
    tcase_add_test(tc, relu_before_the_heat_maps);
    tcase_add_test(tc, configs_that_cannot_be);
    tcase_add_test(tc, first_look_is_a_mean);
    tcase_add_test(tc, offsets_learn_slowly);
    tcase_add_test(tc, fused_and_plain_agree);
    tcase_add_test(tc, threads_change_no_bit);
}

int main(void)
{
    return run_suite("unified", add_tests);
}
