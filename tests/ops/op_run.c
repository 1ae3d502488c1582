/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/ops/op_run.h"

#include <math.h>

static void record_inputs(op_run *r, const op_run_opts *o)
{
    for (int i = 0; i < OP_INPUTS; i++) {
        const op_input *in = &r->c->in[i];

        if (in->role == OP_NONE)
            continue;
        r->in[i] = lt_input(r->g, "in", LT_F32, in->shape.rank, in->shape.dim);
        if (in->role == OP_VALUE && (o->want & (1u << i)))
            lt_want_grad(r->in[i]);
    }
}

static void add_to_loss(op_run *r, lt_tensor *term)
{
    r->loss = r->loss ? lt_add(r->loss, term) : term;
}

static void record_loss(op_run *r, const op_run_opts *o)
{
    for (int i = 0; i < r->n_out; i++) {
        lt_output(r->out[i], "out");
        r->dout[i] = lt_input(r->g, "dout", LT_F32, r->out[i]->shape.rank, r->out[i]->shape.dim);
        add_to_loss(r, lt_sum(lt_mul(r->out[i], r->dout[i])));
    }
    for (int i = 0; o->read_again && i < OP_INPUTS; i++)
        if (r->c->in[i].role == OP_VALUE)
            add_to_loss(r, lt_scale(lt_sum(r->in[i]), OP_READ_AGAIN));
}

bool op_run_new(op_run *r, const op_suite *s, const op_case *c, const op_run_opts *opts)
{
    lt_tensor *out;

    *r = (op_run){ .suite = s, .c = c, .g = lt_graph_new() };
    if (!r->g)
        return false;
    record_inputs(r, opts);
    out = c->build(r->in);
    r->n_out = out->node ? out->node->n_out : 1;
    for (int i = 0; i < r->n_out; i++)
        r->out[i] = out->node ? lt_result(out, i) : out;
    record_loss(r, opts);
    r->plan = lt_compile(r->g, &(lt_compile_opts){ .loss = r->loss, .train = opts->train,
                                                   .no_fusion = opts->no_fusion });
    if (r->plan)
        return true;
    op_run_free(r);
    return false;
}

void op_run_free(op_run *r)
{
    lt_plan_free(r->plan);
    lt_graph_free(r->g);
}

static void fill_unit(lt_real *v, int64_t n, lt_rng *r)
{
    for (int64_t i = 0; i < n; i++)
        v[i] = (lt_real)lt_rng_range(r, -1, 1);
}

/* An op with LT_OP_ASSIGNS finds garbage where it is the first to add. */
static void poison(lt_real *grad, const lt_tensor *t)
{
    for (int64_t i = 0; grad && i < lt_numel(t); i++)
        grad[i] = (lt_real)NAN;
}

void op_run_fill(op_run *r, uint64_t seed)
{
    const op_fill_fn fill = r->c->fill ? r->c->fill : fill_clear_of_zero;

    for (int i = 0; i < OP_INPUTS; i++) {
        lt_rng rng = lt_rng_make(seed, (uint64_t)i);

        if (r->in[i])
            fill(r->c, i, lt_plan_data(r->plan, r->in[i]), lt_numel(r->in[i]), &rng);
        poison(op_run_grad(r, i), r->in[i]);
    }
    for (int i = 0; i < r->n_out; i++) {
        lt_rng rng = lt_rng_make(seed, (uint64_t)(OP_INPUTS + i));

        fill_unit(lt_plan_data(r->plan, r->dout[i]), lt_numel(r->dout[i]), &rng);
    }
}

lt_real *op_run_data(const op_run *r, const lt_tensor *t)
{
    return lt_plan_data(r->plan, t);
}

lt_real *op_run_grad(const op_run *r, int input)
{
    return r->in[input] ? lt_plan_grad(r->plan, r->in[input]) : NULL;
}
