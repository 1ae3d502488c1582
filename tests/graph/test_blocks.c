/* SPDX-License-Identifier: Apache-2.0 */
/* Inference plans whose chains of convolutions keep maps in blocks of channels. What these compute is held in
 * tests/kernels. */
#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "libtensor/graph/plan.h"
#include "libtensor/ops/ops.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { B = 2, C = 16, H = 17, W = 15, O = 24, MOST = B * 40 * H * W };

typedef struct {
    lt_params *set;
    lt_graph *g;
    lt_tensor *x;
} network;

static network start(void)
{
    network n = { .set = lt_params_new(), .g = lt_graph_new() };

    n.x = lt_input(n.g, "x", LT_F32, 4, (int64_t[]){ B, C, H, W });
    return n;
}

static void destroy(network *n)
{
    lt_graph_free(n->g);
    lt_params_free(n->set);
}

static lt_tensor *weight(network *n, const char *layer, const char *name, lt_shape shape)
{
    lt_param *p = lt_params_add(n->set, layer, name, LT_WEIGHT, shape);
    lt_rng r = lt_rng_make(3, (uint64_t)lt_param_numel(p));

    for (int64_t i = 0; i < lt_param_numel(p); i++)
        p->data[i] = (lt_real)lt_rng_range(&r, -0.2, 0.2);
    return lt_use(n->g, p);
}

static lt_tensor *conv(network *n, const char *layer, lt_tensor *x, int64_t outputs, int k, int stride)
{
    lt_tensor *w = weight(n, layer, "weight", LT_SHAPE(outputs, lt_dim(x, 1), k, k));

    return lt_conv2d(x, w, weight(n, layer, "bias", LT_SHAPE(outputs)),
                     &(lt_conv_opts){ .pad = k / 2, .stride = stride });
}

static lt_tensor *depthwise(network *n, const char *layer, lt_tensor *x, int k)
{
    const int c = (int)lt_dim(x, 1);

    return lt_conv2d(x, weight(n, layer, "weight", LT_SHAPE(c, 1, k, k)), NULL,
                     &(lt_conv_opts){ .pad = k / 2, .groups = c });
}

static lt_tensor *linear(network *n, const char *layer, lt_tensor *x, int64_t outputs)
{
    lt_tensor *w = weight(n, layer, "weight", LT_SHAPE(outputs, lt_dim(x, -1)));

    return lt_linear(x, w, weight(n, layer, "bias", LT_SHAPE(outputs)));
}

/* An inverted bottleneck with squeeze and excitation and a residual sum, as EfficientNet has them. */
static lt_tensor *bottleneck(network *n, lt_tensor *x)
{
    lt_tensor *a = lt_silu(conv(n, "expand", x, 40, 1, 1)), *gate;

    a = lt_silu(depthwise(n, "depthwise", a, 3));
    gate = lt_sigmoid(linear(n, "gate", lt_global_avg_pool(a), 40));
    a = conv(n, "project", lt_mul(a, lt_reshape(gate, LT_SHAPE(B, 40, 1, 1))), O, 1, 1);
    return lt_add(a, x);
}

/* "to_blocks expand depthwise ...": ops that go into blocks and back, and layers in between */
static const char *steps_of(const lt_plan *p)
{
    static char list[512];

    *list = '\0';
    for (int i = 0; i < lt_plan_steps(p); i++) {
        const lt_step_info s = lt_plan_step(p, i);

        if (strstr(s.op, "_blocks"))
            strcat(strcat(list, s.op), " ");
        else if (strstr(s.algorithm, "blocks"))
            strcat(strcat(list, s.layer), " ");
    }
    return list;
}

static lt_plan *compile(const network *n, const lt_compile_opts *opts)
{
    lt_plan *p = lt_compile(n->g, opts);
    lt_rng r = lt_rng_make(5, 0);
    lt_real *x;

    ck_assert_msg(p != NULL, "%s", lt_last_error());
    x = lt_plan_data(p, n->x);
    for (int64_t i = 0; i < lt_numel(n->x); i++)
        x[i] = (lt_real)lt_rng_range(&r, -1, 1);
    return p;
}

static int64_t result(const network *n, const lt_tensor *y, const lt_compile_opts *opts, lt_real *out)
{
    lt_plan *p = compile(n, opts);

    lt_run(p);
    memcpy(out, lt_plan_data(p, y), (size_t)lt_numel(y) * sizeof(*out));
    lt_plan_free(p);
    return lt_numel(y);
}

/* The same numbers as without fusion, whatever the number of threads, and when weights come from elsewhere. */
static void expect_same(const network *n, const lt_tensor *y)
{
    static lt_real want[MOST], first[MOST], got[MOST];
    const lt_compile_opts none = { .no_fusion = true }, consume = { .consume_params = true };
    const int64_t count = result(n, y, &none, want);
    double most = 0, off = 0;

    result(n, y, NULL, first);
    for (int64_t i = 0; i < count; i++) {
        most = fmax(most, fabs((double)want[i]));
        off = fmax(off, fabs((double)want[i] - (double)first[i]));
    }
    ck_assert_double_gt(most, 0.01);
    ck_assert_double_lt(off, 1e-5 * most);
    for (int threads = 1; threads <= 4; threads++) {
        lt_set_threads(threads);
        result(n, y, NULL, got);
        ck_assert(memcmp(got, first, (size_t)count * sizeof(*got)) == 0);
    }
    result(n, y, &consume, got);
    ck_assert(memcmp(got, first, (size_t)count * sizeof(*got)) == 0);
}

static void expect_steps(const network *n, const char *want)
{
    lt_plan *p = compile(n, NULL);

    ck_assert_str_eq(steps_of(p), want);
    lt_plan_free(p);
}

/* Into blocks once, out of them nowhere: the mean reads them. The depthwise convolution does what is before it. */
START_TEST(a_chain)
{
    network n = start();
    lt_tensor *y = bottleneck(&n, conv(&n, "stem", n.x, O, 3, 1));

    y = lt_output(linear(&n, "head", lt_global_avg_pool(conv(&n, "last", y, 33, 3, 2)), 5), "y");
    expect_steps(&n, "to_blocks stem depthwise project last ");
    expect_same(&n, y);
    destroy(&n);
}
END_TEST

/* What reads the maps of an image with a stride of 2 makes blocks of them itself. */
START_TEST(from_an_image)
{
    network n = start();
    lt_tensor *maps = lt_slice(n.x, 1, 0, 3);
    lt_tensor *y = lt_global_avg_pool(bottleneck(&n, lt_relu(conv(&n, "stem", maps, O, 3, 2))));

    lt_output(y, "y");
    expect_steps(&n, "stem expand depthwise project ");
    expect_same(&n, y);
    destroy(&n);
}
END_TEST

/* Maps that others read, or that are looked at, are there in both forms; a run of inner maps is not. */
START_TEST(seen_from_outside)
{
    network n = start();
    lt_tensor *a = lt_relu(conv(&n, "a", n.x, O, 3, 1)), *b = lt_relu(conv(&n, "b", a, O, 3, 1));
    lt_tensor *c = lt_relu(conv(&n, "c", b, 32, 1, 1)), *d = lt_relu(conv(&n, "d", c, 32, 1, 1));
    lt_tensor *e = lt_relu(conv(&n, "e", d, 32, 1, 1)), *f = lt_relu(conv(&n, "f", e, 16, 1, 1));
    lt_plan *p;

    lt_output(f, "f");
    lt_output(lt_softmax(b), "softmax");
    p = compile(&n, NULL);
    ck_assert_str_eq(steps_of(p), "to_blocks a b c d e f from_blocks from_blocks ");
    ck_assert_ptr_null(lt_plan_data(p, d));
    lt_plan_free(p);
    expect_same(&n, f);
    destroy(&n);
}
END_TEST

/* One convolution alone would go into blocks and back for nothing; so would none in a plan with a table of integers. */
START_TEST(too_short)
{
    network n = start();
    lt_tensor *y = lt_output(conv(&n, "alone", n.x, O, 3, 1), "y");
    lt_plan *p;

    expect_steps(&n, "");
    expect_same(&n, y);
    destroy(&n);
    n = start();
    y = bottleneck(&n, conv(&n, "stem", n.x, O, 3, 1));
    lt_output(lt_global_avg_pool(y), "y");
    p = compile(&n, &(lt_compile_opts){ .int8 = &(lt_int8_table){ 0 } });
    ck_assert_str_eq(steps_of(p), "");
    lt_plan_free(p);
    destroy(&n);
}
END_TEST

/* New weights are packed anew. */
START_TEST(refresh)
{
    static lt_real before[MOST], after[MOST], fresh[MOST];
    network n = start();
    lt_tensor *y = lt_output(bottleneck(&n, conv(&n, "stem", n.x, O, 3, 1)), "y");
    lt_plan *p = compile(&n, NULL);
    const size_t bytes = (size_t)lt_numel(y) * sizeof(lt_real);

    ck_assert_str_eq(steps_of(p), "to_blocks stem depthwise project from_blocks ");
    lt_run(p);
    memcpy(before, lt_plan_data(p, y), bytes);
    lt_params_find(n.set, "depthwise.weight")->data[3] += 1;
    lt_params_find(n.set, "stem.weight")->data[5] += 1;
    lt_params_find(n.set, "expand.weight")->data[7] += 1;
    lt_plan_refresh(p);
    lt_run(p);
    memcpy(after, lt_plan_data(p, y), bytes);
    lt_plan_free(p);
    result(&n, y, NULL, fresh);
    ck_assert(memcmp(before, after, bytes) != 0);
    ck_assert(memcmp(fresh, after, bytes) == 0);
    destroy(&n);
}
END_TEST

/* What such a layer computes is looked at as that of any other. */
START_TEST(nonfinite)
{
    network n = start();
    lt_tensor *y = bottleneck(&n, conv(&n, "stem", n.x, O, 3, 1));
    char where[128];
    lt_plan *p;

    lt_output(lt_global_avg_pool(y), "y");
    lt_params_find(n.set, "project.weight")->data[7] = (lt_real)INFINITY;
    p = compile(&n, NULL);
    lt_plan_find_nonfinite(p, where, sizeof(where));
    ck_assert_str_eq(where, "conv2d \"project\"");
    lt_plan_free(p);
    destroy(&n);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, a_chain);
    tcase_add_test(t, from_an_image);
    tcase_add_test(t, seen_from_outside);
    tcase_add_test(t, too_short);
    tcase_add_test(t, refresh);
    tcase_add_test(t, nonfinite);
}

int main(void)
{
    return run_suite("blocks", add_tests);
}
