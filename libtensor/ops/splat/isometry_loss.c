/* SPDX-License-Identifier: Apache-2.0 */
/* isometry_loss: how much distances to neighbours change.    [Prokudin et al. 2023; Qian et al. 2024, "3DGS-Avatar"]
 *   a, b (N, D)   neighbours (N, K)   ->   y = mean over pairs of | |a_i - a_j| - |b_i - b_j| |
 *   With e = dy sign(|a_i - a_j| - |b_i - b_j|) / pairs, each pair gives
 *   da_i += e (a_i - a_j) / |a_i - a_j|     da_j -= the same     db likewise with -e
 */
#include "libtensor/ops/splat/rows.h"

enum { A, B, NEIGHBOURS };
enum { LENGTHS, PAIRS };                /* saved: of each pair in a and in b; how many there are */

static lt_status infer(lt_call *c)
{
    const lt_tensor *list = c->in[NEIGHBOURS];
    char text[LT_SHAPE_TEXT];

    if (lt_want_rank(c, A, "a", 2) || lt_want_shape(c, B, "b", c->in[A]->shape))
        return LT_ESHAPE;
    if (list->dtype != LT_I32 || list->shape.rank != 2 || lt_dim(list, 0) != lt_dim(c->in[A], 0))
        return lt_fail(c, "neighbours is %s%s, want integers (%lld, K)", lt_shape_text(&list->shape, text),
                       list->dtype == LT_I32 ? "" : " and no LT_I32", (long long)lt_dim(c->in[A], 0));
    c->out->shape = (lt_shape){ 0 };
    return LT_OK;
}

/* What a block of rows sums up to */
typedef struct {
    double sum;
    int64_t pairs;
} block_sum;

static int64_t blocks(const lt_call *c)
{
    return lt_ceil_div(lt_dim(c->in[A], 0), SPLAT_ROWS);
}

static void plan(lt_call *c)
{
    c->work_bytes = (size_t)lt_max_i64(1, blocks(c)) * sizeof(block_sum);
    if (!c->train)
        return;
    c->saved_bytes[LENGTHS] = (size_t)lt_numel(c->in[NEIGHBOURS]) * sizeof(lt_real[2]);
    c->saved_bytes[PAIRS] = sizeof(double);
}

/* The neighbour at a place of the lists, or -1 where there is none */
static int64_t neighbour(const lt_call *c, int64_t place)
{
    const int64_t j = ((const int32_t *)c->in[NEIGHBOURS]->data)[place];

    return j >= 0 && j < lt_dim(c->in[A], 0) ? j : -1;
}

static lt_real distance(const lt_call *c, int which, int64_t i, int64_t j)
{
    const int64_t D = lt_dim(c->in[A], 1);
    const lt_real *x = c->in[which]->data;
    lt_real sum = 0;

    for (int64_t k = 0; k < D; k++) {
        const lt_real d = x[i * D + k] - x[j * D + k];

        sum += d * d;
    }
    return (lt_real)sqrt((double)sum);
}

static void forward_block(const lt_call *c, int64_t from, int64_t to)
{
    const int64_t K = lt_dim(c->in[NEIGHBOURS], 1);
    block_sum s = { 0 };

    for (int64_t place = from * K; place < to * K; place++) {
        const int64_t i = place / K, j = neighbour(c, place);
        lt_real a, b;

        if (j < 0)
            continue;
        a = distance(c, A, i, j);
        b = distance(c, B, i, j);
        s.sum += fabs((double)a - (double)b);
        s.pairs++;
        if (c->train)
            memcpy((lt_real (*)[2])c->saved[LENGTHS] + place, (lt_real[]){ a, b }, sizeof(lt_real[2]));
    }
    ((block_sum *)c->work)[from / SPLAT_ROWS] = s;
}

static block_sum total(const lt_call *c)
{
    block_sum s = { 0 };

    for (int64_t i = 0; i < blocks(c); i++) {
        s.sum += ((const block_sum *)c->work)[i].sum;
        s.pairs += ((const block_sum *)c->work)[i].pairs;
    }
    return s;
}

static void forward(const lt_call *c)
{
    block_sum s;

    splat_by_block(c, lt_dim(c->in[A], 0), forward_block);
    s = total(c);
    if (c->train)
        *(double *)c->saved[PAIRS] = (double)s.pairs;
    *(lt_real *)c->out->data = s.pairs ? (lt_real)(s.sum / (double)s.pairs) : 0;
}

/* One task a tensor, which walks all pairs in order: two rows of it may meet in a third. */
static void gradient_of(void *ctx, int64_t which)
{
    const lt_call *c = ctx;
    const int64_t D = lt_dim(c->in[A], 1), K = lt_dim(c->in[NEIGHBOURS], 1), N = lt_dim(c->in[A], 0);
    const lt_real e = *c->dout / (lt_real)*(const double *)c->saved[PAIRS], *x = c->in[which]->data;
    const lt_real (*length)[2] = c->saved[LENGTHS];
    lt_real *dx = c->din[which];

    for (int64_t place = 0; dx && place < N * K; place++) {
        const int64_t i = place / K, j = neighbour(c, place);
        lt_real own, other, f;

        if (j < 0)
            continue;
        own = length[place][which];
        other = length[place][1 - which];
        f = own > 0 ? e * (lt_real)((own > other) - (own < other)) / own : 0;
        for (int64_t k = 0; k < D; k++) {
            const lt_real g = f * (x[i * D + k] - x[j * D + k]);

            dx[i * D + k] += g;
            dx[j * D + k] -= g;
        }
    }
}

static void backward(const lt_call *c)
{
    lt_parallel_for(2, gradient_of, (void *)(uintptr_t)c);
}

static const lt_op isometry_loss_op = {
    .name = "isometry_loss", .any_type = LT_ANY_TYPE_IN(NEIGHBOURS),
    .keeps = LT_KEEP_IN(A) | LT_KEEP_IN(B) | LT_KEEP_IN(NEIGHBOURS), .infer = infer, .plan = plan, .forward = forward,
    .backward = backward,
};

lt_tensor *(lt_isometry_loss)(lt_tensor *a, lt_tensor *b, lt_tensor *neighbours)
{
    return lt_apply(&isometry_loss_op, NULL, 0, (lt_tensor *[]){ a, b, neighbours }, 3);
}
