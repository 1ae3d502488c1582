/* SPDX-License-Identifier: Apache-2.0 */
#include "models/backbones/alexnet.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/gemm/gemm.h"
#include "libtensor/nn/init.h"
#include "models/backbones/crop_columns.h"

#include <math.h>
#include <string.h>

enum { POOL = 3, POOL_STRIDE = 2 };

const alexnet_layer alexnet_layers[ALEXNET_TAPS] = {
    { .c = 3, .o = 64, .k = 11, .stride = 4, .pad = 2 },
    { .c = 64, .o = 192, .k = 5, .stride = 1, .pad = 2, .pool = true },
    { .c = 192, .o = 384, .k = 3, .stride = 1, .pad = 1, .pool = true },
    { .c = 384, .o = 256, .k = 3, .stride = 1, .pad = 1 },
    { .c = 256, .o = 256, .k = 3, .stride = 1, .pad = 1 },
};

void alexnet_new(alexnet *m, lt_params *set, const char *prefix)
{
    static const int place[ALEXNET_TAPS] = { 0, 3, 6, 8, 10 };      /* among torchvision's features */
    const char *dot = *prefix ? "." : "";

    for (int l = 0; l < ALEXNET_TAPS; l++) {
        const alexnet_layer *a = &alexnet_layers[l];

        m->conv[l] = lt_conv_layer_new(set, lt_name(set, "%s%sfeatures.%d", prefix, dot, place[l]), a->c, a->o, a->k,
                                       true, &(lt_conv_opts){ .stride = a->stride, .pad = a->pad });
        m->conv[l].weight->frozen = m->conv[l].bias->frozen = true;
    }
}

void alexnet_init(const alexnet *m, uint64_t seed)
{
    for (int l = 0; l < ALEXNET_TAPS; l++) {
        lt_init_normal(m->conv[l].weight, seed, sqrt(2 / lt_fan_in(m->conv[l].weight)));
        lt_init_constant(m->conv[l].bias, 0);
    }
}

/* ---- sizes ---------------------------------------------------------------------------------------------- */

static int64_t window_fits(int64_t n, int k, int stride, int pad)
{
    return n + 2 * pad < k ? 0 : (n + 2 * pad - k) / stride + 1;
}

static alexnet_map next_map(const alexnet_map *from, int k, int stride, int pad, int64_t *columns)
{
    alexnet_map m = { window_fits(from->h, k, stride, pad), window_fits(from->w, k, stride, pad), *columns };

    if (!from->h || !from->w)
        m.h = m.w = 0;
    *columns += m.h * m.w;
    return m;
}

void alexnet_lay_out(alexnet_crops *crops)
{
    memset(crops->in, 0, sizeof(crops->in));
    memset(crops->out, 0, sizeof(crops->out));
    for (int i = 0; i < crops->n; i++) {
        alexnet_crop *c = &crops->crop[i];

        c->in[0].at = crops->in[0];
        crops->in[0] += c->in[0].h * c->in[0].w;
        for (int l = 0; l < ALEXNET_TAPS; l++) {
            const alexnet_layer *a = &alexnet_layers[l];

            if (a->pool) {
                c->in[l] = next_map(&c->out[l - 1], POOL, POOL_STRIDE, 0, &crops->in[l]);
            } else if (l > 0) {
                c->in[l] = c->out[l - 1];
                crops->in[l] = crops->out[l - 1];
            }
            c->out[l] = next_map(&c->in[l], a->k, a->stride, a->pad, &crops->out[l]);
        }
    }
}

/* ---- pools ---------------------------------------------------------------------------------------------- */

/* Of one channel */
typedef struct {
    const alexnet_crops *crops;
    int l, back;
    const lt_real *from;
    lt_real *to;
    int32_t *where;
} pool_job;

static void pool_channel(void *ctx, int64_t channel)
{
    const pool_job *j = ctx;
    const lt_real *from = j->from + channel * j->crops->out[j->l - 1];
    const int64_t columns = j->crops->in[j->l];

    for (int i = 0; i < j->crops->n; i++) {
        const alexnet_map *x = &j->crops->crop[i].out[j->l - 1], *y = &j->crops->crop[i].in[j->l];
        int32_t *where = j->where && i < j->back ? j->where + channel * columns + y->at : NULL;

        if (y->h && y->w)
            lt_k->maxpool(j->to + channel * columns + y->at, where, from + x->at, (int)x->h, (int)x->w, POOL,
                          POOL_STRIDE, 0, (int)y->h, (int)y->w);
    }
}

static void unpool_channel(void *ctx, int64_t channel)
{
    const pool_job *j = ctx;
    const int64_t columns = j->crops->in[j->l];

    for (int i = 0; i < j->back; i++) {
        const alexnet_map *x = &j->crops->crop[i].out[j->l - 1], *y = &j->crops->crop[i].in[j->l];

        lt_k->maxpool_grad(j->to + channel * j->crops->out[j->l - 1] + x->at, j->from + channel * columns + y->at,
                           j->where + channel * columns + y->at, (size_t)(y->h * y->w));
    }
}

void alexnet_pool_backward(const alexnet_crops *crops, int n, int l, const int32_t *where, const lt_real *din,
                           lt_real *dtap)
{
    pool_job j = { .crops = crops, .l = l, .back = n, .from = din, .to = dtap, .where = (int32_t *)where };

    lt_parallel_for(alexnet_layers[l].c, unpool_channel, &j);
}

/* ---- convolutions ----------------------------------------------------------------------------------------- */

/* Columns that are multiplied at once: what they read, and its products, then stay in the caches */
enum { STRIP = 1024 };

int64_t alexnet_columns_count(void)
{
    int64_t most = 0;

    for (int l = 0; l < ALEXNET_TAPS; l++) {
        const alexnet_layer *a = &alexnet_layers[l];

        most = lt_max_i64(most, (int64_t)a->c * a->k * a->k * STRIP);
    }
    return most;
}

static crop_columns columns_of(const alexnet_crops *crops, int n, int l)
{
    const alexnet_layer *a = &alexnet_layers[l];

    return (crop_columns){ .crops = crops, .n = n, .l = l, .channels = a->c, .ld = STRIP };
}

static void convolve(const alexnet *m, const alexnet_crops *crops, int l, const alexnet_maps *maps, lt_real *work)
{
    const alexnet_layer *a = &alexnet_layers[l];
    const int64_t k = (int64_t)a->c * a->k * a->k, all = crops->out[l];
    const lt_epilogue e = { .row_bias = m->conv[l].bias->data, .act = { .kind = LT_ACT_RELU } };
    crop_columns c = columns_of(crops, crops->n, l);

    while (crop_columns_next(&c)) {
        crop_columns_gather(&c, maps->in[l], work);
        lt_gemm(LT_NO_TRANS, LT_NO_TRANS, a->o, c.columns, k, m->conv[l].weight->data, k, work, STRIP, false,
                maps->tap[l] + c.from, all, &e);
    }
}

void alexnet_forward(const alexnet *m, const alexnet_crops *crops, int back, const alexnet_maps *maps, lt_real *work)
{
    for (int l = 0; l < ALEXNET_TAPS; l++) {
        if (alexnet_layers[l].pool) {
            pool_job j = { crops, l, back, maps->tap[l - 1], maps->in[l], maps->where[l] };

            lt_parallel_for(alexnet_layers[l].c, pool_channel, &j);
        }
        convolve(m, crops, l, maps, work);
    }
}

typedef struct {
    lt_real *d;
    const lt_real *tap;
    int64_t ld;
    size_t n;
} relu_job;

/* d where the tap is above 0 */
static void relu_channel(void *ctx, int64_t channel)
{
    const relu_job *j = ctx;
    const lt_real *tap = j->tap + channel * j->ld;
    lt_real *d = j->d + channel * j->ld;

    lt_k->affine_grad(d, d, &(lt_behind){ .y = tap, .slope = 0 }, tap, 1, 0, 0, false, j->n);
}

void alexnet_backward(const alexnet *m, const alexnet_crops *crops, int n, int l, const lt_real *tap, lt_real *dtap,
                      lt_real *din, lt_real *work)
{
    const alexnet_layer *a = &alexnet_layers[l];
    const int64_t k = (int64_t)a->c * a->k * a->k, all = crops->out[l];
    crop_columns c = columns_of(crops, n, l);
    relu_job relu = { dtap, tap, all, (size_t)crop_columns_count(&c) };

    lt_parallel_for(a->o, relu_channel, &relu);
    crop_columns_clear(&c, din);
    while (crop_columns_next(&c)) {
        lt_gemm(LT_TRANS, LT_NO_TRANS, k, c.columns, a->o, m->conv[l].weight->data, k, dtap + c.from, all, false, work,
                STRIP, NULL);
        crop_columns_scatter(&c, work, din);
    }
}
