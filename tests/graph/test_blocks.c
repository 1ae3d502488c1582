/* SPDX-License-Identifier: Apache-2.0 */
/* Inference plans whose chains of convolutions keep maps in blocks of channels. What these compute is held in
 * tests/kernels. */
#include "libtensor/base/parallel.h"
#include "libtensor/ops/ops.h"
#include "tests/graph/graphs.h"

#include <math.h>

enum { B = 2, C = 16, H = 17, W = 15, O = 24, MOST = B * 40 * H * W };

static lt_tensor *image;                /* what each network starts from */

static void begin(void)
{
    start();
    image = input("x", LT_SHAPE(B, C, H, W));
}

static lt_tensor *depthwise(const char *layer, lt_tensor *x, int k)
{
    const int c = (int)lt_dim(x, 1);

    return lt_conv2d(x, weight(layer, "weight", LT_SHAPE(c, 1, k, k)), NULL,
                     &(lt_conv_opts){ .pad = k / 2, .groups = c });
}

/* An inverted bottleneck with squeeze and excitation and a residual sum, as EfficientNet has them. */
static lt_tensor *bottleneck(lt_tensor *x)
{
    lt_tensor *a = lt_silu(conv("expand", x, 40, 1, 1)), *gate;

    a = lt_silu(depthwise("depthwise", a, 3));
    gate = lt_sigmoid(linear("gate", lt_global_avg_pool(a), 40));
    a = conv("project", lt_mul(a, lt_reshape(gate, LT_SHAPE(B, 40, 1, 1))), O, 1, 1);
    return lt_add(a, x);
}

/* "to_blocks expand depthwise ...": ops that go into blocks and back, and layers in between */
static const char *in_blocks(const lt_plan *p)
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

/* The same numbers as without fusion, whatever the number of threads, and when weights come from elsewhere. */
static void expect_same(const lt_tensor *y)
{
    static lt_real want[MOST], first[MOST], got[MOST];
    const lt_compile_opts none = { .no_fusion = true }, consume = { .consume_params = true };
    const int64_t count = lt_numel(y);
    double most = 0, off = 0;

    compute(image, y, &none, want);
    compute(image, y, NULL, first);
    for (int64_t i = 0; i < count; i++) {
        most = fmax(most, fabs((double)want[i]));
        off = fmax(off, fabs((double)want[i] - (double)first[i]));
    }
    ck_assert_double_gt(most, 0.01);
    ck_assert_double_lt(off, 1e-5 * most);
    for (int threads = 1; threads <= 4; threads++) {
        lt_set_threads(threads);
        compute(image, y, NULL, got);
        ck_assert(memcmp(got, first, (size_t)count * sizeof(*got)) == 0);
    }
    compute(image, y, &consume, got);
    ck_assert(memcmp(got, first, (size_t)count * sizeof(*got)) == 0);
}

static void expect_steps(const char *want)
{
    lt_plan *p = compile_filled(image, NULL);

    ck_assert_str_eq(in_blocks(p), want);
    lt_plan_free(p);
}

/* Into blocks once, out of them nowhere: the mean reads them. The depthwise convolution does what is before it. */
START_TEST(a_chain)
{
    lt_tensor *y = bottleneck(conv("stem", image, O, 3, 1));

    y = lt_output(linear("head", lt_global_avg_pool(conv("last", y, 33, 3, 2)), 5), "y");
    expect_steps("to_blocks stem depthwise project last ");
    expect_same(y);
}
END_TEST

/* What reads the maps of an image with a stride of 2 makes blocks of them itself. */
START_TEST(from_an_image)
{
    lt_tensor *maps = lt_slice(image, 1, 0, 3);
    lt_tensor *y = lt_global_avg_pool(bottleneck(lt_relu(conv("stem", maps, O, 3, 2))));

    lt_output(y, "y");
    expect_steps("stem expand depthwise project ");
    expect_same(y);
}
END_TEST

/* What moves or adds maps, or takes their maxima, leaves them in blocks. */
START_TEST(between_convolutions)
{
    lt_tensor *a = lt_silu(conv("a", image, 32, 3, 1)), *half = lt_slice(a, 1, 16, 16), *part[4];

    part[0] = a;
    part[1] = lt_add(lt_silu(conv("b", half, 16, 3, 1)), half);
    part[2] = lt_max_pool2d(part[1], 5, 1, 2, false);
    part[3] = lt_upsample_nearest(lt_max_pool2d(lt_silu(conv("c", image, 16, 3, 1)), 1, 3, 0, false), 3);
    part[3] = lt_conv2d(part[3], weight("d", "weight", LT_SHAPE(16, 16, 2, 1)), NULL, NULL);
    a = conv("e", lt_concat(part, 4, 1), 32, 1, 1);
    lt_output(a, "y");
    expect_steps("to_blocks a b c d e from_blocks ");
    expect_same(a);
}
END_TEST

/* Maps that others read, or that are looked at, are there in both forms; a run of inner maps is not. */
START_TEST(seen_from_outside)
{
    lt_tensor *a = lt_relu(conv("a", image, O, 3, 1)), *b = lt_relu(conv("b", a, O, 3, 1));
    lt_tensor *c = lt_relu(conv("c", b, 32, 1, 1)), *d = lt_relu(conv("d", c, 32, 1, 1));
    lt_tensor *e = lt_relu(conv("e", d, 32, 1, 1)), *f = lt_relu(conv("f", e, 16, 1, 1));
    lt_plan *p;

    lt_output(f, "f");
    lt_output(lt_softmax(b), "softmax");
    p = compile_filled(image, NULL);
    ck_assert_str_eq(in_blocks(p), "to_blocks a b c d e f from_blocks from_blocks ");
    ck_assert_ptr_null(lt_plan_data(p, d));
    lt_plan_free(p);
    expect_same(f);
}
END_TEST

/* One convolution alone would go into blocks and back for nothing; so would none in a plan with a table of integers. */
START_TEST(too_short)
{
    lt_tensor *y = lt_output(conv("alone", image, O, 3, 1), "y");
    lt_plan *p;

    expect_steps("");
    expect_same(y);
    stop();
    begin();
    y = bottleneck(conv("stem", image, O, 3, 1));
    lt_output(lt_global_avg_pool(y), "y");
    p = compile_filled(image, &(lt_compile_opts){ .int8 = &(lt_int8_table){ 0 } });
    ck_assert_str_eq(in_blocks(p), "");
    lt_plan_free(p);
}
END_TEST

/* New weights are packed anew. */
START_TEST(refresh)
{
    static lt_real before[MOST], after[MOST], fresh[MOST];
    lt_tensor *y = lt_output(bottleneck(conv("stem", image, O, 3, 1)), "y");
    lt_plan *p = compile_filled(image, NULL);
    const size_t bytes = (size_t)lt_numel(y) * sizeof(lt_real);

    ck_assert_str_eq(in_blocks(p), "to_blocks stem depthwise project from_blocks ");
    lt_run(p);
    memcpy(before, lt_plan_data(p, y), bytes);
    lt_params_find(set, "depthwise.weight")->data[3] += 1;
    lt_params_find(set, "stem.weight")->data[5] += 1;
    lt_params_find(set, "expand.weight")->data[7] += 1;
    lt_plan_refresh(p);
    lt_run(p);
    memcpy(after, lt_plan_data(p, y), bytes);
    lt_plan_free(p);
    compute(image, y, NULL, fresh);
    ck_assert(memcmp(before, after, bytes) != 0);
    ck_assert(memcmp(fresh, after, bytes) == 0);
}
END_TEST

/* What such a layer computes is looked at as that of any other. */
START_TEST(nonfinite)
{
    lt_tensor *y = bottleneck(conv("stem", image, O, 3, 1));
    char where[128];
    lt_plan *p;

    lt_output(lt_global_avg_pool(y), "y");
    lt_params_find(set, "project.weight")->data[7] = (lt_real)INFINITY;
    p = compile_filled(image, NULL);
    lt_plan_find_nonfinite(p, where, sizeof(where));
    ck_assert_str_eq(where, "conv2d \"project\"");
    lt_plan_free(p);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, begin, stop);
    tcase_add_test(t, a_chain);
    tcase_add_test(t, from_an_image);
    tcase_add_test(t, between_convolutions);
    tcase_add_test(t, seen_from_outside);
    tcase_add_test(t, too_short);
    tcase_add_test(t, refresh);
    tcase_add_test(t, nonfinite);
}

int main(void)
{
    return run_suite("blocks", add_tests);
}
