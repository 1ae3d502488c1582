/* SPDX-License-Identifier: Apache-2.0 */
/* The action model: a stream says what the units say of a long clip away from its ends; stream 2 that is off says
 * nothing, whatever its input is. */
#include "libtensor/base/rng.h"
#include "libtensor/graph/plan.h"
#include "models/action/stream.h"
#include "tests/models/model_of.h"

#include <math.h>

enum { V = 65, LONG = 120, DELAY = 44 };        /* of the small one: 4 + 4 + 4 + 2 (4 + 4) + 4 (4) frames */

static lt_params *params;
static model m;

static void open_model(const char *config)
{
    params = model_of("action", config, NULL, &m);
    check_ok(lt_params_allocate(params));
    m.cls->init(&m, 3);
}

/* Joints that move slowly and at random */
static void draw(lt_real *x, int n, uint64_t seed)
{
    for (int i = 0; i < 3 * V; i++) {
        lt_rng r = lt_rng_make(seed, (uint64_t)i);
        double at = lt_rng_normal(&r);

        for (int k = 0; k < n; k++, at += 0.2 * lt_rng_normal(&r))
            x[((int64_t)(i / V) * n + k) * V + i % V] = (lt_real)at;
    }
}

/* The whole clip through the units, less the first pelvis: (features, LONG / 4, V) */
static lt_plan *whole(lt_graph *g, const lt_real *x, lt_tensor **out)
{
    const stgcn *s = action_stgcn(&m);
    lt_tensor *in = lt_input(g, "in", LT_F32, 4, (int64_t[]){ 1, 3, LONG, V }), *y = stgcn_normalise(s, in);
    lt_plan *p;
    lt_real *to;

    for (int k = 0; k < s->n; k++)
        y = stgcn_unit_end(&s->unit[k], stgcn_mix(s, &s->unit[k], y), y, s->kernel / 2);
    *out = lt_output(y, "out");
    p = lt_compile(g, NULL);
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    to = lt_plan_data(p, in);
    for (int64_t i = 0; i < 3 * LONG * V; i++)
        to[i] = x[i] - x[i / (LONG * V) * LONG * V];
    lt_run(p);
    return p;
}

static void check_frame(const lt_real *ours, const lt_real *theirs, int64_t features, int at)
{
    const int64_t results = LONG / 4;
    double largest = 0, apart = 0;

    for (int64_t c = 0; c < features; c++)
        for (int v = 0; v < V; v++) {
            const double want = (double)theirs[(c * results + at) * V + v];

            largest = fmax(largest, fabs(want));
            apart = fmax(apart, fabs((double)ours[c * V + v] - want));
        }
    ck_assert_msg(apart <= 1e-5 * largest && largest > 0, "result %d: %g of %g apart", at, apart, largest);
}

START_TEST(streams_as_a_long_clip)
{
    static lt_real x[3 * LONG * V], frame[3 * V];
    lt_real feature[128];
    lt_graph *g = lt_graph_new();
    lt_tensor *out;
    action_stream *s;
    lt_plan *p;
    int results = 0;

    open_model("{}");
    draw(x, LONG, 1);
    p = whole(g, x, &out);
    check_ok(action_stream_new(&m, &s));
    ck_assert_int_eq(action_stream_features(s), 128);
    ck_assert_int_eq(action_stream_delay(s), DELAY);
    for (int round = 0; round < 2; round++, action_stream_begin(s))
        for (int k = 0; k < LONG; k++) {
            for (int i = 0; i < 3 * V; i++)
                frame[i] = x[(i / V * LONG + k) * V + i % V];
            ck_assert(action_stream_body(s, frame, feature) == (k >= 2 * DELAY));
            if (k < 2 * DELAY || k % 4)
                continue;
            check_frame(action_stream_last(s), lt_plan_data(p, out), 128, (k - DELAY) / 4);
            results++;
        }
    ck_assert_int_eq(results, 2 * (LONG - 2 * DELAY) / 4);
    action_stream_free(s);
    lt_plan_free(p);
    lt_graph_free(g);
    lt_params_free(params);
}
END_TEST

START_TEST(off_says_nothing)
{
    model_record r = { .g = lt_graph_new(), .batch = 1 };
    lt_real first[10], *on;
    lt_plan *p;

    open_model("{ \"frames\": 8 }");
    m.cls->record(&m, false, &r);
    p = lt_compile(r.g, NULL);
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    draw(lt_plan_data(p, model_port_find(&r.inputs, "body")), 8, 2);
    on = lt_plan_data(p, model_port_find(&r.inputs, "on"));
    for (int round = 0; round < 3; round++) {
        lt_real *x = lt_plan_data(p, model_port_find(&r.inputs, "hand_object"));
        const lt_real *logits = lt_plan_data(p, model_port_find(&r.outputs, "logits"));

        *on = round == 2;
        for (int i = 0; i < 3 * 8 * 30; i++)
            x[i] = (lt_real)(round * sin(i));
        lt_run(p);
        for (int i = 0; i < 10; i++) {
            first[i] = round ? first[i] : logits[i];
            ck_assert(isfinite(logits[i]));
            ck_assert(round == 2 || logits[i] == first[i]);
        }
        ck_assert(round < 2 || fabs((double)(logits[0] - first[0])) > 1e-5);
    }
    lt_plan_free(p);
    lt_graph_free(r.g);
    lt_params_free(params);
}
END_TEST

START_TEST(refused)
{
    expect_no_model("action", "{ \"kernel\": 8 }", "kernel: 8, expected an odd number");
    expect_no_model("action", "{ \"variant\": \"large\" }", "variant");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 120);
    tcase_add_test(tc, streams_as_a_long_clip);
    tcase_add_test(tc, off_says_nothing);
    tcase_add_test(tc, refused);
}

int main(void)
{
    return run_suite("action_stream", add_tests);
}
