/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/nn/init.h"

#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static lt_rng stream_of(const lt_param *p, uint64_t seed)
{
    uint64_t stream = 0;

    for (const char *s = p->name; *s; s++)
        stream = lt_rng_mix(stream, (unsigned char)*s);
    return lt_rng_make(seed, stream);
}

void lt_init_constant(lt_param *p, double value)
{
    for (int64_t i = 0; i < lt_param_numel(p); i++)
        p->data[i] = (lt_real)value;
    lt_params_changed(p->set);
}

/* Runs of elements are drawn in parallel: element i of a parameter begins at its own draw. */
enum { RUN = 16384, UNIFORM_DRAWS = 2, NORMAL_DRAWS = 4 };

typedef struct { lt_param *p; lt_rng stream; double scale; } fill;

static void uniform_run(void *ctx, int64_t task)
{
    const fill *f = ctx;
    const int64_t from = task * RUN, to = lt_min_i64(from + RUN, lt_param_numel(f->p));
    lt_rng r = f->stream;

    r.index = (uint64_t)from * UNIFORM_DRAWS;
    for (int64_t i = from; i < to; i++)
        f->p->data[i] = (lt_real)lt_rng_range(&r, -f->scale, f->scale);
}

static void normal_run(void *ctx, int64_t task)
{
    const fill *f = ctx;
    const int64_t from = task * RUN, to = lt_min_i64(from + RUN, lt_param_numel(f->p));
    lt_rng r = f->stream;

    r.index = (uint64_t)from * NORMAL_DRAWS;
    for (int64_t i = from; i < to; i++)
        f->p->data[i] = (lt_real)(f->scale * lt_rng_normal(&r));
}

void lt_init_uniform(lt_param *p, uint64_t seed, double bound)
{
    fill f = { p, stream_of(p, seed), bound };

    lt_parallel_for(lt_ceil_div(lt_param_numel(p), RUN), uniform_run, &f);
    lt_params_changed(p->set);
}

void lt_init_normal(lt_param *p, uint64_t seed, double deviation)
{
    fill f = { p, stream_of(p, seed), deviation };

    lt_parallel_for(lt_ceil_div(lt_param_numel(p), RUN), normal_run, &f);
    lt_params_changed(p->set);
}

/* Elements of the window behind the two channel dimensions. */
static double window(const lt_param *p)
{
    double n = 1;

    for (int i = 2; i < p->shape.rank; i++)
        n *= (double)p->shape.dim[i];
    return n;
}

double lt_fan_in(const lt_param *p)
{
    return p->shape.rank < 2 ? 1 : (double)p->shape.dim[1] * window(p);
}

double lt_fan_out(const lt_param *p)
{
    return p->shape.rank < 2 ? 1 : (double)p->shape.dim[0] * window(p);
}

void lt_init_xavier(lt_param *p, uint64_t seed, double gain)
{
    lt_init_uniform(p, seed, gain * sqrt(6 / (lt_fan_in(p) + lt_fan_out(p))));
}

static const char *last_part(const char *name)
{
    const char *dot = strrchr(name, '.');

    return dot ? dot + 1 : name;
}

/* The weight that a bias stands beside: "a.bias" -> "a.weight". */
static const lt_param *weight_beside(const lt_params *set, const lt_param *bias)
{
    char name[512];
    const int stem = (int)(last_part(bias->name) - bias->name);

    snprintf(name, sizeof(name), "%.*sweight", stem, bias->name);
    return lt_params_find(set, name);
}

static void init_bias(const lt_params *set, lt_param *p, uint64_t seed)
{
    const lt_param *weight = weight_beside(set, p);

    if (weight && weight->shape.rank >= 2 && lt_param_numel(weight))
        lt_init_uniform(p, seed, 1 / sqrt(lt_fan_in(weight)));
    else
        lt_init_constant(p, 0);
}

void lt_init_default(lt_params *set, uint64_t seed)
{
    for (lt_param *p = lt_params_first(set); p; p = p->next) {
        const char *part = last_part(p->name);

        if (strcmp(part, "weight") == 0 && p->shape.rank >= 2)
            lt_init_uniform(p, seed, 1 / sqrt(lt_fan_in(p)));
        else if (strcmp(part, "weight") == 0 || strcmp(part, "running_var") == 0)
            lt_init_constant(p, 1);
        else if (strcmp(part, "bias") == 0)
            init_bias(set, p, seed);
        else if (strcmp(part, "running_mean") == 0)
            lt_init_constant(p, 0);
    }
}
