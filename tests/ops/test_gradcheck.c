/* SPDX-License-Identifier: Apache-2.0 */
/* The gradient check is checked: one op with an honest gradient, and copies of it with a planted fault. */
#include "tests/ops/gradient.h"
#include "tests/suite.h"

/* y = a b */
static lt_status infer(lt_call *c)
{
    c->out->shape = c->in[0]->shape;
    return LT_OK;
}

static const lt_real *value(const lt_call *c, int i) { return c->in[i]->data; }

static void forward(const lt_call *c)
{
    for (int64_t i = 0; i < lt_numel(c->out); i++)
        ((lt_real *)c->out->data)[i] = value(c, 0)[i] * value(c, 1)[i];
}

/* da += s dy b, db += t dy a */
static void product_rule(const lt_call *c, lt_real s, lt_real t)
{
    for (int64_t i = 0; i < lt_numel(c->out); i++) {
        if (c->din[0])
            c->din[0][i] += s * c->dout[i] * value(c, 1)[i];
        if (c->din[1])
            c->din[1][i] += t * c->dout[i] * value(c, 0)[i];
    }
}

static void honest(const lt_call *c) { product_rule(c, 1, 1); }
static void flipped_sign(const lt_call *c) { product_rule(c, 1, -1); }
static void factor_2(const lt_call *c) { product_rule(c, 2, 1); }
static void missing_term(const lt_call *c) { product_rule(c, 1, 0); }
static void nearly(const lt_call *c) { product_rule(c, (lt_real)1.00001, 1); }

static void assigned(const lt_call *c)
{
    for (int64_t i = 0; c->din[0] && i < lt_numel(c->out); i++)
        c->din[0][i] = c->dout[i] * value(c, 1)[i];
    product_rule(c, 0, 1);
}

static void one_element(const lt_call *c)
{
    product_rule(c, 1, 1);
    c->din[0][lt_numel(c->out) - 1] = 0;
}

static void (*const backward[])(const lt_call *) = {
    honest, flipped_sign, factor_2, missing_term, nearly, assigned, one_element,
};

static int planted;

static lt_tensor *build(lt_tensor **in)
{
    static lt_op op;

    op = (lt_op){ .name = "planted", .infer = infer, .forward = forward, .backward = backward[planted] };
    return lt_apply(&op, NULL, 0, in, 2);
}

START_TEST(planted_faults_are_found)
{
    static const op_case cases[] = { { "small", build, .in = { S(3, 5), S(3, 5) } } };
    static const op_suite suite = { "planted", CASES(cases) };
    gradient_report r = { .worst = 0 };

    planted = _i;
    ck_assert(gradient_check_op(&suite, 0, &r));
    if (planted == 0)
        ck_assert_msg(r.worst <= GRADIENT_BOUND, "the honest one fails: %s", r.where);
    else
        ck_assert_msg(r.worst > GRADIENT_BOUND, "fault %d passes with %g", planted, r.worst);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_loop_test(tc, planted_faults_are_found, 0, (int)LT_COUNT(backward));
}

int main(void)
{
    return run_suite("gradient check", add_tests);
}
