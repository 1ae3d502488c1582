/* SPDX-License-Identifier: Apache-2.0 */
/* HOGS's parts in double: the slope of each one's loss along a random direction of each parameter, and of each
 * input that has a gradient, against differences. */
#include "tests/models/hogs_parts.h"

#include "libtensor/graph/rows.h"
#include "tests/models/model_gradient.h"
#include "tests/suite.h"

#include <math.h>

static const double BOUND = 1e-6;

enum { MOST = 8192 };               /* numbers of a parameter */

static lt_params *params;
static model_record r;
static lt_plan *plan;

static double loss(void)
{
    lt_run(plan);
    return *(const lt_real *)lt_plan_data(plan, r.loss);
}

/* n numbers and their gradient: a parameter, of which only the row in use takes part, or an input */
typedef struct {
    const char *name;
    lt_real *data;
    const lt_real *grad;
    int64_t n;
} block;

static double direction(int64_t i)
{
    lt_rng rng = lt_rng_make(11, (uint64_t)i);

    return lt_rng_normal(&rng);
}

static void move(const block *b, double by)
{
    for (int64_t i = 0; i < b->n; i++)
        b->data[i] += by * direction(i);
}

static double loss_at(const block *b, double by)
{
    double f;

    move(b, by);
    f = loss();
    move(b, -by);
    return f;
}

/* Of the fourth order */
static double difference(const block *b, double h)
{
    return (8 * (loss_at(b, h) - loss_at(b, -h)) - (loss_at(b, 2 * h) - loss_at(b, -2 * h))) / (12 * h);
}

/* Of a few steps the best counts: long ones cross kinks of relu and max, short ones round. *most: of all slopes of this
 * part so far, which rounding errors of the loss go with. */
static void check(const char *part, const block *b, double *most)
{
    static const double step[] = { 1e-6, 1e-7, 1e-8, 1e-5 };
    double slope = 0, best = INFINITY;

    for (int64_t i = 0; i < b->n; i++)
        slope += b->grad[i] * direction(i);
    *most = fmax(*most, fabs(slope));
    for (size_t k = 0; k < LT_COUNT(step) && best > BOUND / 10; k++)
        best = fmin(best, fabs(slope - difference(b, step[k])) / fmax(fabs(slope), 1e-2 * *most));
    ck_assert_msg(best <= BOUND, "%s: %s: slope %.12g, differences disagree by %.2g of it", part, b->name, slope, best);
}

/* The gradient of an input or parameter, after a run of its own */
static const lt_real *gradient_of(const lt_real *grad, int64_t n, lt_real *copy)
{
    lt_params_zero_grad(params);
    loss();
    for (int64_t i = 0; i < n; i++)
        copy[i] = grad[i];
    return copy;
}

static int check_parameters(const char *part, double *most)
{
    lt_real copy[MOST];
    int checked = 0;

    for (lt_param *p = lt_params_first(params); p; p = p->next) {
        const int64_t width = p->rows ? lt_param_width(p) : lt_param_numel(p), first = p->rows ? width : 0;
        block b = { p->name, p->data + first, NULL, width };

        if (p->kind != LT_WEIGHT || !p->grad)
            continue;
        ck_assert_int_le(width, MOST);
        b.grad = gradient_of(p->grad + first, width, copy);
        check(part, &b, most);
        checked++;
    }
    return checked;
}

static int check_inputs(const char *part, double *most)
{
    lt_real copy[MOST];
    int checked = 0;

    for (int k = 0; k < r.inputs.n; k++) {
        lt_tensor *t = r.inputs.port[k].tensor;
        block b = { r.inputs.port[k].name, lt_plan_data(plan, t), NULL, lt_numel(t) };

        if (!t->wants_grad)
            continue;
        b.grad = gradient_of(lt_plan_grad(plan, t), b.n, copy);
        check(part, &b, most);
        checked++;
    }
    return checked;
}

START_TEST(gradient)
{
    const char *part = hogs_parts[_i].name;
    double most;

    params = lt_params_new();
    r = (model_record){ .g = lt_graph_new() };
    hogs_parts[_i].record(params, &r);
    plan = lt_compile(r.g, &(lt_compile_opts){ .train = true, .loss = r.loss });
    ck_assert_msg(plan != NULL, "%s: %s", part, lt_last_error());
    hogs_part_fill(params, &r, plan);
    most = 1e-3 * fabs(loss());
    ck_assert_int_gt(check_parameters(part, &most) + check_inputs(part, &most), 0);
    lt_plan_free(plan);
    lt_graph_free(r.g);
    lt_params_free(params);
}
END_TEST

/* The chain from images to Gaussians; palmar gradcheck --model hogs goes through all of them. */
START_TEST(images_to_gaussians)
{
    model_gradient of[MODEL_GRADIENT_PARTS];
    const int n = model_gradients(0, of);

    ck_assert_msg(n > 0, "%s", lt_last_error());
    for (int i = 0; i < n; i++)
        ck_assert_msg(of[i].error < 1e-6, "%s: %s is off by %.1e", of[i].through, of[i].block, of[i].error);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 300);
    tcase_add_test(tc, images_to_gaussians);
    tcase_add_loop_test(tc, gradient, 0, n_hogs_parts);
}

int main(void)
{
    return run_suite("hogs gradient", add_tests);
}
