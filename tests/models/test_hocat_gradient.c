/* SPDX-License-Identifier: Apache-2.0 */
/* Whole models' total loss in double: its slope along a random direction of each block's parameters against
 * differences. What is constant to the gradient by design is left out: the confidences' targets, and the
 * object's features in HOCAT's loss of the hand. */
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/graph/plan.h"
#include "tests/geometry/hashed_hand.h"
#include "tests/models/model_of.h"
#include "tests/suite.h"

#include <math.h>

enum { BATCH = 2 };

/* HOCAT is held to the bound of single ops. The unified estimator's slopes are of the order of 1 beside a loss of
 * 400: with steps that cross no kink, differences of it round to 5e-5. */
static const struct {
    const char *model;
    double bound;
    const char *config;
} models[] = {
    { "hocat", 1e-6, "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], \"roi\": 8, \"depth\": 1, "
      "\"heads\": 2, \"mlp_ratio\": 1, \"detach_minor\": false, \"w_conf\": 0}" },
    { "hocat", 1e-6, "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], \"roi\": 8, \"depth\": 1, "
      "\"heads\": 2, \"mlp_ratio\": 1, \"detach_minor\": false, \"w_conf\": 0, \"w_maps\": 100, \"w_local\": 1e4}" },
    { "hocat", 1e-6, "{\"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], \"roi\": 8, \"fused\": true, "
      "\"heads\": 2, \"mlp_ratio\": 1, \"detach_minor\": false, \"w_conf\": 0}" },
    { "hocat", 1e-6, "{\"variant\": \"base\", \"image_size\": 64, \"width\": 8, \"blocks\": [1, 1, 1, 1], "
      "\"roi\": 8, \"base_feat\": \"c5up\", \"w_conf\": 0}" },
    { "unified", 2e-4, "{\"image_size\": 96, \"width\": 8, \"layers\": 1, \"heads\": 2, \"points\": 2, "
      "\"dropout\": 0, \"stochastic_depth\": 0, \"w_conf\": 0, \"w_maps\": 100, \"w_local\": 1e4}" },
};

static lt_arena *arena;
static lt_params *params;
static model m;
static model_record r;
static lt_plan *plan;

static void fill(const model_port *port, lt_rng *rng)
{
    static const lt_real boxes[] = { 10, 8, 50, 60, 4, 4, 33, 30 };
    lt_real *x = lt_plan_data(plan, port->tensor);

    for (int64_t i = 0; i < lt_numel(port->tensor); i++)
        x[i] = lt_rng_uniform(rng);
    if (strstr(port->name, "_box"))
        memcpy(x, boxes, sizeof(boxes));
}

/* Deformable attention first looks at whole cells, where its samples have a kink. */
static void leave_whole_cells(void)
{
    for (lt_param *p = lt_params_first(params); p; p = p->next)
        for (int64_t i = 0; strstr(p->name, ".offsets.bias") && i < lt_param_numel(p); i++)
            p->data[i] += 0.3;
}

static void start(int i)
{
    lt_rng rng = lt_rng_make(5, 0);
    lt_hand_model *hand;
    lt_hand_layer *layer;

    arena = lt_arena_new();
    hand = lt_arena_alloc(arena, sizeof(*hand));
    hashed_hand(hand);
    ck_assert_int_eq(lt_hand_layer_new(arena, hand, lt_hand_tips_ho3d, &layer), LT_OK);
    params = model_of(models[i].model, models[i].config, layer, &m);
    m.cls->init(&m, 1);
    leave_whole_cells();
    r = (model_record){ .g = lt_graph_new(), .batch = BATCH };
    m.cls->record(&m, true, &r);
    plan = lt_compile(r.g, &(lt_compile_opts){ .loss = r.loss, .train = true });
    ck_assert_msg(plan != NULL, "%s", lt_last_error());
    for (int k = 0; k < r.inputs.n; k++)
        fill(&r.inputs.port[k], &rng);
}

static void stop(void)
{
    lt_plan_free(plan);
    lt_graph_free(r.g);
    lt_params_free(params);
    lt_arena_free(arena);
}

static double loss(void)
{
    lt_run(plan);
    return *(const lt_real *)lt_plan_data(plan, r.loss);
}

static bool in_block(const lt_param *p, const char *block)
{
    return p->kind == LT_WEIGHT && p->grad && strncmp(p->name, block, strlen(block)) == 0;
}

/* Moves the block's parameters by h along a random direction; returns the slope there, if gradients are. */
static double move(const char *block, double h)
{
    lt_rng rng = lt_rng_make(7, 0);
    double slope = 0;

    for (lt_param *p = lt_params_first(params); p; p = p->next)
        for (int64_t i = 0; in_block(p, block) && i < lt_param_numel(p); i++) {
            const double d = lt_rng_normal(&rng);
            slope += p->grad[i] * d;
            p->data[i] += h * d;
        }
    return slope;
}

static double loss_at(const char *block, double h)
{
    double out;

    move(block, h);
    out = loss();
    move(block, -h);
    return out;
}

/* Of the fourth order, for the hand's rotations bend sharply. */
static double differences(const char *block, double h)
{
    return (8 * (loss_at(block, h) - loss_at(block, -h)) - (loss_at(block, 2 * h) - loss_at(block, -2 * h))) /
           (12 * h);
}

/* Of a few steps the best counts: long ones cross kinks of relu and max_pool2d, short ones round. */
START_TEST(every_block)
{
    static const double step[] = { 1e-8, 1e-9, 1e-7, 2e-10, 3e-8 };

    start(_i);
    for (const char *const *b = m.cls->blocks; *b; b++) {
        double best = INFINITY, slope;

        if (!lt_params_count(params, LT_WEIGHT, *b))    /* of another variant */
            continue;
        lt_params_zero_grad(params);
        loss();
        slope = move(*b, 0);
        for (size_t k = 0; k < LT_COUNT(step) && best > models[_i].bound / 2; k++)
            best = fmin(best, fabs(differences(*b, step[k]) / slope - 1));
        printf("%-14s slope %.9g, differences disagree by %.2g of it\n", *b, slope, best);
        ck_assert_msg(best < models[_i].bound, "%s: slope %.9g, differences disagree by %.2g of it", *b, slope, best);
    }
    stop();
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 600);
    tcase_add_loop_test(tc, every_block, 0, (int)LT_COUNT(models));
}

int main(void)
{
    return run_suite("hocat_gradient", add_tests);
}
