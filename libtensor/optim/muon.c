/* SPDX-License-Identifier: Apache-2.0 */
/* Muon: a matrix moves by the orthogonal matrix that is nearest to its mean gradient. */
#include "libtensor/kernels/gemm/gemm.h"
#include "libtensor/optim/internal.h"

#include <math.h>

/* Of each round x <- (A + B x x' + C (x x')^2) x, which brings singular values in (0, 1] near to 1: between 0.7 and 1.2
 * after five [Jordan et al. 2024] */
static const lt_real A = 3.4445f, B = -4.775f, C = 2.0315f;
static const double USUAL_STEP = 0.2;       /* root mean square of Adam's, in units of its rate [Liu et al. 2025] */

enum { ROUNDS = 5 };

bool optim_by_muon(const lt_optim *o, const optim_slot *s)
{
    return o->group[s->group].recipe.kind == LT_MUON && s->p->shape.rank == 2 && !s->p->rows;
}

static int64_t shorter(const lt_param *p)
{
    return lt_min_i64(p->shape.dim[0], p->shape.dim[1]);
}

int64_t optim_muon_scratch(const lt_param *p)
{
    return 2 * lt_param_numel(p) + 2 * shorter(p) * shorter(p);
}

/* y = (A + B s + C s s) x, s = x x'; or x (A + B s + C s s), s = x' x, whichever s is the smaller */
static void one_round(lt_real *y, const lt_real *x, int64_t rows, int64_t columns, lt_real *s, lt_real *sum)
{
    const bool wide = rows <= columns;
    const int64_t n = wide ? rows : columns, k = wide ? columns : rows;

    lt_gemm(wide ? LT_NO_TRANS : LT_TRANS, wide ? LT_TRANS : LT_NO_TRANS, n, n, k, x, columns, x, columns, false, s, n,
            NULL);
    lt_gemm(LT_NO_TRANS, LT_NO_TRANS, n, n, n, s, n, s, n, false, sum, n, NULL);
    for (int64_t i = 0; i < n * n; i++)
        sum[i] = B * s[i] + C * sum[i];
    lt_k->scale(y, x, A, (size_t)(rows * columns));
    if (wide)
        lt_gemm(LT_NO_TRANS, LT_NO_TRANS, n, k, n, sum, n, x, k, true, y, k, NULL);
    else
        lt_gemm(LT_NO_TRANS, LT_NO_TRANS, k, n, n, x, n, sum, n, true, y, n, NULL);
}

void optim_muon(const lt_optim *o, const optim_slot *s)
{
    const optim_group *g = &o->group[s->group];
    const int64_t rows = s->p->shape.dim[0], columns = s->p->shape.dim[1], n = rows * columns;
    const lt_real keep = g->sgd.momentum, grad_scale = g->sgd.grad_scale, lr = g->sgd.lr * (lt_real)s->p->rate;
    lt_real *x = o->scratch, *y = x + n, *square = y + n, *sum = square + shorter(s->p) * shorter(s->p);
    lt_real *m = s->m.data, *w = s->p->data, length, step;

    for (int64_t i = 0; i < n; i++) {
        const lt_real gradient = (1 - keep) * grad_scale * s->p->grad[i];

        m[i] = keep * m[i] + gradient;
        x[i] = keep * m[i] + gradient;          /* as it will be, if the next gradient is this one [Nesterov] */
    }
    length = (lt_real)sqrt(lt_k->sumsq(x, (size_t)n));
    lt_k->scale(x, x, length > 0 ? 1 / length : 0, (size_t)n);
    for (int i = 0; i < ROUNDS; i++) {
        lt_real *of = x;

        one_round(y, x, rows, columns, square, sum);
        x = y;
        y = of;
    }
    step = lr * (lt_real)(USUAL_STEP * sqrt((double)lt_max_i64(rows, columns)));
    for (int64_t i = 0; i < n; i++)
        w[i] -= (s->decays ? lr * g->sgd.l2 * w[i] : 0) + step * x[i];
}
