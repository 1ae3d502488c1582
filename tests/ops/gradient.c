/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/ops/gradient.h"

#include "tests/ops/op_run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PROBES = 40, LARGE = 4096 }; /* elements of an input that are tried; above LARGE none alone */


static double loss_of(const op_run *r)
{
    lt_run(r->plan);
    return *op_run_data(r, r->loss);
}

/* ---- moving inputs -------------------------------------------------------------------------------- */

/* One element of one input, or with input < 0 all of them along direction d. */
typedef struct {
    op_run *r;
    int input;
    int64_t at;
    double step;
    double *d[OP_INPUTS];
} probe;

static void move(const probe *p, double by)
{
    if (p->input >= 0) {
        op_run_data(p->r, p->r->in[p->input])[p->at] += (lt_real)by;
        return;
    }
    for (int i = 0; i < OP_INPUTS; i++)
        for (int64_t k = 0; p->d[i] && k < lt_numel(p->r->in[i]); k++)
            op_run_data(p->r, p->r->in[i])[k] += (lt_real)(by * p->d[i][k]);
}

static double loss_at(const probe *p, double by)
{
    double f;

    move(p, by);
    f = loss_of(p->r);
    move(p, -by);
    return f;
}

/* Central differences of fourth order: the error is h^4, so that h may be large and noise small. */
static double difference(const probe *p)
{
    const double h = p->step;

    return (8 * (loss_at(p, h) - loss_at(p, -h)) - (loss_at(p, 2 * h) - loss_at(p, -2 * h))) / (12 * h);
}

/* ---- comparing ------------------------------------------------------------------------------------ */

static void compare(gradient_report *out, const char *what, int64_t at, double a, double n, double scale)
{
    const double size = fmax(fmax(fabs(a), fabs(n)), 1e-3 * fmax(scale, OP_READ_AGAIN));
    const double error = isfinite(a) && isfinite(n) ? fabs(a - n) / size : INFINITY;

    out->probes++;
    if (error <= out->worst)
        return;
    out->worst = error;
    snprintf(out->where, sizeof(out->where), "%s[%lld]: %.9g, differences say %.9g", what, (long long)at, a, n);
}

static double largest(const double *g, int64_t n)
{
    double most = 0;

    for (int64_t i = 0; i < n; i++)
        most = fmax(most, fabs(g[i]));
    return most;
}

static void check_elements(op_run *r, int input, const double *g, lt_rng *rng, gradient_report *out)
{
    const int64_t n = lt_numel(r->in[input]);
    const double scale = largest(g, n);
    char what[16];

    snprintf(what, sizeof(what), "in%d", input);
    for (int64_t k = 0; k < lt_min_i64(n, PROBES); k++) {
        probe p = { .r = r, .input = input, .at = n <= PROBES ? k : lt_rng_below(rng, (uint32_t)n) };

        p.step = 1e-3 * fmin(1, fmax(0.1, fabs((double)op_run_data(r, r->in[input])[p.at])));
        compare(out, what, p.at, g[p.at], difference(&p) - OP_READ_AGAIN, scale);
    }
}

static void check_direction(op_run *r, double *const *g, lt_rng *rng, gradient_report *out)
{
    probe p = { .r = r, .input = -1, .step = 4e-4 };
    double slope = 0, squares = 0, again = 0;

    for (int i = 0; i < OP_INPUTS; i++) {
        const int64_t n = g[i] ? lt_numel(r->in[i]) : 0;

        p.d[i] = g[i] ? calloc((size_t)n + 1, sizeof(double)) : NULL;
        for (int64_t k = 0; k < n; k++) {
            p.d[i][k] = lt_rng_range(rng, -1, 1);
            slope += p.d[i][k] * g[i][k];
            squares += (g[i][k] + OP_READ_AGAIN) * (g[i][k] + OP_READ_AGAIN);
            again += OP_READ_AGAIN * p.d[i][k];
        }
    }
    compare(out, "direction", 0, slope, difference(&p) - again, sqrt(squares));
    for (int i = 0; i < OP_INPUTS; i++)
        free(p.d[i]);
}

/* ---- a case --------------------------------------------------------------------------------------- */

/* Gradients less what the second reader gives. */
static void take_gradients(const op_run *r, double less, double *g[OP_INPUTS])
{
    for (int i = 0; i < OP_INPUTS; i++) {
        const lt_real *found = op_run_grad(r, i);
        const int64_t n = found ? lt_numel(r->in[i]) : 0;

        g[i] = found ? calloc((size_t)n + 1, sizeof(double)) : NULL;
        for (int64_t k = 0; k < n; k++)
            g[i][k] = found[k] - less;
    }
}

static void free_gradients(double *g[OP_INPUTS])
{
    for (int i = 0; i < OP_INPUTS; i++)
        free(g[i]);
}

static void compare_tensor(int64_t n, const double *twice, const double *once, gradient_report *out)
{
    const double scale = largest(twice, n);

    for (int64_t k = 0; k < n; k++)
        compare(out, "two readers, one", k, twice[k], once[k], scale);
}

static void compare_readers(const op_run *r, double *const *twice, double *const *once, gradient_report *out)
{
    for (int i = 0; i < OP_INPUTS; i++)
        if (twice[i] && once[i])
            compare_tensor(lt_numel(r->in[i]), twice[i], once[i], out);
}

static bool with_one_reader(const op_suite *s, const op_case *c, uint64_t seed, double *g[OP_INPUTS])
{
    op_run r;

    if (!op_run_new(&r, s, c, &(op_run_opts){ .train = true, .want = OP_ALL_INPUTS }))
        return false;
    op_run_fill(&r, seed);
    lt_run(r.plan);
    take_gradients(&r, 0, g);
    op_run_free(&r);
    return true;
}

bool gradient_check(const op_suite *s, const op_case *c, uint64_t seed, gradient_report *out)
{
    lt_rng rng = lt_rng_make(seed, 77);
    double *twice[OP_INPUTS], *once[OP_INPUTS];
    op_run r;

    if (!with_one_reader(s, c, seed, once))
        return false;
    if (!op_run_new(&r, s, c, &(op_run_opts){ .train = true, .read_again = true, .want = OP_ALL_INPUTS })) {
        free_gradients(once);
        return false;
    }
    op_run_fill(&r, seed);
    lt_run(r.plan);
    take_gradients(&r, OP_READ_AGAIN, twice);
    compare_readers(&r, twice, once, out);
    for (int i = 0; i < OP_INPUTS; i++)
        if (twice[i] && lt_numel(r.in[i]) <= LARGE)
            check_elements(&r, i, twice[i], &rng, out);
    check_direction(&r, twice, &rng, out);
    free_gradients(twice);
    free_gradients(once);
    op_run_free(&r);
    return true;
}

bool gradient_check_op(const op_suite *s, int shapes, gradient_report *out)
{
    lt_rng rng = lt_rng_make(2026, 0);

    for (int i = 0; i < s->n_cases; i++)
        if (!gradient_check(s, &s->cases[i], (uint64_t)i + 1, out))
            return false;
    for (int i = 0; s->vary && i < shapes; i++) {
        op_case c = s->cases[0];

        s->vary(&c, &rng);
        if (!gradient_check(s, &c, (uint64_t)i + 1000, out))
            return false;
    }
    return true;
}
