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

/* Further apart than they are timed with, or it would hardly matter which of them a Gaussian follows */
static void spread(lt_real *bones)
{
    for (int b = 0; b < SKIN_FIELD_BONES; b++)
        bones[12 * b + 3] += (lt_real)(0.01 * (b - SKIN_FIELD_BONES / 2));
}

static void fill(subject *s)
{
    for (int i = 0; i < s->r.inputs.n; i++)
        hogs_fill(&s->m, s->r.inputs.port[i].name, lt_plan_data(s->plan, s->r.inputs.port[i].tensor));
    *(int32_t *)lt_plan_data(s->plan, model_port_find(&s->r.inputs, "degree")) = 0;
    spread(lt_plan_data(s->plan, model_port_find(&s->r.inputs, "bones")));
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

static const double LEAN = 0.3;

/* ---- a block's parameters, moved along a line ---------------------------------------------------------- */

typedef struct {
    const subject *s;
    const char *block;
    double *direction;
    double slope;                   /* of the loss along it, if gradients are */
} line;

static bool of_block(const lt_param *p, const char *block)
{
    return p->kind == LT_WEIGHT && p->grad && strncmp(p->name, block, strlen(block)) == 0;
}

/* A random direction that leans to where the loss grows: across it, rounding of the loss would hide what is left of the
 * slope. False: no memory. */
static bool line_make(line *l, const subject *s, const char *block)
{
    lt_rng rng = lt_rng_make(7, 0);
    int64_t n = 0, k = 0;

    *l = (line){ .s = s, .block = block };
    for (const lt_param *p = lt_params_first(s->set); p; p = p->next)
        n += of_block(p, block) ? lt_param_numel(p) : 0;
    l->direction = lt_alloc((size_t)n * sizeof(*l->direction));
    for (const lt_param *p = lt_params_first(s->set); p && l->direction; p = p->next)
        for (int64_t i = 0; of_block(p, block) && i < lt_param_numel(p); i++, k++) {
            l->direction[k] = lt_rng_normal(&rng) + copysign(LEAN, p->grad[i]);
            l->slope += p->grad[i] * l->direction[k];
        }
    return l->direction != NULL;
}

static void move(const line *l, double h)
{
    int64_t k = 0;

    for (lt_param *p = lt_params_first(l->s->set); p; p = p->next)
        for (int64_t i = 0; of_block(p, l->block) && i < lt_param_numel(p); i++)
            p->data[i] += (lt_real)(h * l->direction[k++]);
    lt_params_changed(l->s->set);
}

static double loss_at(const line *l, double h)
{
    double out;

    move(l, h);
    out = loss(l->s);
    move(l, -h);
    return out;
}

/* Of a few steps the best counts: long ones cross kinks of relus, maxima and tiles, short ones round. */
static double error_of(const subject *s, const char *block)
{
    static const double step[] = { 3e-8, 1e-8, 3e-9, 1e-7, 1e-9, 3e-10 };
    double best = INFINITY, least;
    line l;

    lt_params_zero_grad(s->set);
    least = 1e-3 * fabs(loss(s));               /* a slope that rounding of the loss hides is none */
    if (!line_make(&l, s, block))
        return INFINITY;
    for (size_t i = 0; i < LT_COUNT(step) && best > 5e-7; i++) {
        const double h = step[i];
        const double by = (8 * (loss_at(&l, h) - loss_at(&l, -h)) - (loss_at(&l, 2 * h) - loss_at(&l, -2 * h)))
                          / (12 * h);

        best = fmin(best, fabs(by - l.slope) / fmax(fabs(l.slope), least));
    }
    lt_release(l.direction);
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
