/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/models/model_gradient.h"

#include "libtensor/base/rng.h"
#include "libtensor/graph/plan.h"
#include "libtensor/graph/rows.h"
#include "libtensor/io/text/json.h"
#include "models/hogs/hogs.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

typedef struct {
    const char *through, *config;
    hogs_stage stage;
    const char *block[6];
} chain;

#define SMALL "\"size\": \"cpu\", \"gaussians\": 60, \"width\": 128, \"height\": 112, \"hands\": 1, \"objects\": 1"

static const chain chains[MODEL_GRADIENT_CHAINS] = {
    { "Gaussians to images", "{\"variant\": \"no-vpm\", " SMALL "}", HOGS_GAUSSIANS, { "gaussians", "skin", NULL } },
    { "V-PM to images", "{\"variant\": \"full\", \"lambda_nr\": \"dexycb\", " SMALL "}", HOGS_GAUSSIANS,
      { "vit", "hand", "object", "skin", NULL } },
    { "G-PM to images, poses and contact", "{\"variant\": \"full\", " SMALL "}", HOGS_JOINT, { "gpm", NULL } },
};

typedef struct {
    lt_params *set;
    model m;
    model_record r;
    lt_plan *plan;
} subject;

static void fill(subject *s)
{
    for (int i = 0; i < s->r.inputs.n; i++)
        hogs_fill(&s->m, s->r.inputs.port[i].name, lt_plan_data(s->plan, s->r.inputs.port[i].tensor));
    *(int32_t *)lt_plan_data(s->plan, model_port_find(&s->r.inputs, "degree")) = 0;
}

/* What begins with nothing has no slope to speak of. */
static void stir(const subject *s)
{
    lt_rng rng = lt_rng_make(3, 0);

    for (lt_param *p = lt_params_first(s->set); p; p = p->next)
        for (int64_t i = 0; !p->frozen && p->kind == LT_WEIGHT && i < lt_param_numel(p); i++)
            p->data[i] += (lt_real)(0.001 * lt_rng_normal(&rng));
    lt_params_changed(s->set);
}

static lt_status make(subject *s, const chain *c)
{
    cJSON *config;
    lt_status st = lt_json_parse("gradcheck", c->config, strlen(c->config), &config);

    if (!st)
        st = model_create(&hogs_class, "gradcheck", config, NULL, s->set, &s->m);
    cJSON_Delete(config);
    if (st)
        return st;
    hogs_class.init(&s->m, 1);
    stir(s);
    s->r = (model_record){ .g = lt_graph_new(), .batch = 1 };
    hogs_record(&s->m, c->stage, &s->r);
    s->plan = lt_compile(s->r.g, &(lt_compile_opts){ .loss = s->r.loss, .train = true });
    if (!s->plan)
        return lt_last_status();
    fill(s);
    for (lt_param *p = lt_params_first(s->set); p && !st; p = p->next)
        if (p->rows)
            st = lt_param_touch(p, 0, p->shape.dim[0]);
    return st;
}

static double loss(const subject *s)
{
    lt_run(s->plan);
    return (double)*(const lt_real *)lt_plan_data(s->plan, s->r.loss);
}

/* Move a block's parameters along a random direction; returns the slope there, if gradients are. */
static double move(const subject *s, const char *block, double h)
{
    lt_rng rng = lt_rng_make(7, 0);
    double slope = 0;

    for (lt_param *p = lt_params_first(s->set); p; p = p->next)
        for (int64_t i = 0; p->kind == LT_WEIGHT && p->grad && strncmp(p->name, block, strlen(block)) == 0
                            && i < lt_param_numel(p); i++) {
            const double d = lt_rng_normal(&rng);

            slope += (double)p->grad[i] * d;
            p->data[i] += (lt_real)(h * d);
        }
    lt_params_changed(s->set);
    return slope;
}

static double loss_at(const subject *s, const char *block, double h)
{
    double out;

    move(s, block, h);
    out = loss(s);
    move(s, block, -h);
    return out;
}

/* Of a few steps the best counts: long ones cross kinks of relus, maxima and tiles, short ones round. */
static double error_of(const subject *s, const char *block)
{
    static const double step[] = { 1e-8, 1e-7, 1e-9, 1e-6 };
    double best = INFINITY, slope, least;

    lt_params_zero_grad(s->set);
    least = 1e-3 * fabs(loss(s));               /* a slope that rounding of the loss hides is none */
    slope = move(s, block, 0);
    for (size_t i = 0; i < LT_COUNT(step) && best > 5e-7; i++) {
        const double h = step[i];
        const double by = (8 * (loss_at(s, block, h) - loss_at(s, block, -h))
                           - (loss_at(s, block, 2 * h) - loss_at(s, block, -2 * h))) / (12 * h);

        best = fmin(best, fabs(by - slope) / fmax(fabs(slope), least));
    }
    return best;
}

int model_gradients(int which, model_gradient out[MODEL_GRADIENT_PARTS])
{
    const chain *c = &chains[which];
    subject s = { .set = lt_params_new() };
    int n = 0;

    if (s.set && make(&s, c) == LT_OK)
        for (; c->block[n]; n++)
            out[n] = (model_gradient){ c->through, c->block[n], error_of(&s, c->block[n]) };
    lt_plan_free(s.plan);
    lt_graph_free(s.r.g);
    lt_params_free(s.set);
    return n;
}
