/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Convolutions between maps in blocks of channels, against plain loops: products and depthwise ones bit by bit, others
 * within their bounds.
 */
#include "tests/kernels/checkasm.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/blocks/conv.h"

#include <math.h>
#include <string.h>

static const lt_conv2d_params shapes[] = {
    /* n  c   h   w   o  kh kw  stride  pad   dil  groups */
    { 1, 16, 1, 1, 16, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 2, 24, 9, 7, 40, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 1, 300, 5, 6, 17, 1, 1, 1, 1, 0, 0, 1, 1, 1 },      /* several blocks of k */
    { 3, 33, 14, 14, 65, 1, 1, 1, 1, 0, 0, 1, 1, 1 },     /* several bands */
    { 2, 40, 15, 13, 20, 1, 1, 2, 2, 0, 0, 1, 1, 1 },
    { 2, 16, 12, 17, 33, 3, 3, 2, 2, 1, 1, 1, 1, 1 },
    { 1, 50, 9, 8, 19, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 16, 20, 11, 16, 5, 5, 1, 1, 2, 2, 1, 1, 1 },
    { 2, 17, 13, 19, 16, 5, 3, 3, 2, 0, 2, 2, 1, 1 },
    { 1, 16, 23, 20, 18, 7, 7, 2, 2, 3, 3, 1, 1, 1 },
    { 1, 18, 5, 5, 300, 2, 2, 1, 1, 1, 1, 2, 3, 1 },      /* panels before positions */
    { 1, 20, 6, 7, 21, 1, 1, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 33, 8, 120, 48, 9, 1, 1, 1, 4, 0, 1, 1, 1 },     /* rows that some taps see, and most do not */
    { 2, 16, 7, 70, 16, 9, 1, 2, 1, 4, 0, 1, 1, 1 },
    { 1, 16, 3, 60, 16, 5, 1, 1, 1, 8, 0, 2, 1, 1 },
    { 1, 16, 2, 60, 16, 2, 1, 3, 1, 7, 0, 3, 1, 1 },      /* nor any tap some of them */
    { 2, 48, 17, 13, 48, 3, 3, 1, 1, 1, 1, 1, 1, 48 },    /* from here on: depthwise */
    { 1, 40, 14, 15, 40, 5, 5, 1, 1, 2, 2, 1, 1, 40 },
    { 2, 16, 15, 16, 16, 3, 3, 2, 2, 1, 1, 1, 1, 16 },
    { 1, 35, 29, 30, 35, 5, 5, 2, 2, 2, 2, 1, 1, 35 },
    { 1, 16, 3, 2, 16, 5, 5, 1, 1, 2, 2, 1, 1, 16 },
    { 1, 16, 4, 5, 16, 5, 5, 2, 2, 4, 4, 1, 1, 16 },
    { 1, 32, 1, 1, 32, 5, 5, 1, 1, 2, 2, 1, 1, 32 },      /* less than the padding */
    { 1, 16, 2, 1, 16, 5, 5, 2, 2, 4, 4, 1, 1, 16 },
    { 1, 16, 1, 1, 16, 3, 3, 1, 1, 2, 2, 1, 1, 16 },
    { 1, 17, 40, 33, 17, 3, 3, 1, 1, 0, 0, 1, 1, 17 },
    { 2, 32, 13, 18, 48, 3, 3, 1, 1, 1, 1, 1, 1, 1 },     /* from here on: Winograd */
    { 1, 272, 12, 12, 32, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 3, 48, 8, 8, 64, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 32, 7, 11, 80, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 2, 32, 8, 7, 48, 9, 1, 1, 1, 4, 0, 1, 1, 1 },       /* from here on: down one column */
    { 1, 48, 15, 9, 32, 9, 1, 2, 1, 4, 0, 1, 1, 1 },
    { 2, 128, 24, 65, 128, 9, 1, 1, 1, 4, 0, 1, 1, 1 },   /* several rounds */
    { 3, 64, 30, 13, 80, 9, 1, 2, 1, 4, 0, 1, 1, 1 },
    { 1, 32, 9, 5, 64, 5, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 1, 32, 31, 3, 32, 12, 1, 1, 1, 3, 0, 1, 1, 1 },     /* three parts of a window */
    { 1, 160, 41, 1, 32, 11, 1, 2, 1, 5, 0, 1, 1, 1 },
    { 2, 64, 33, 31, 150, 1, 1, 1, 1, 0, 0, 1, 1, 1 },    /* from here on: tiles, where the CPU has them */
    { 1, 1000, 12, 11, 128, 1, 1, 1, 1, 0, 0, 1, 1, 1 },  /* several chunks of channels */
    { 3, 90, 36, 31, 160, 1, 1, 2, 1, 0, 0, 1, 1, 1 },
    { 3, 160, 12, 15, 192, 3, 3, 2, 2, 1, 1, 1, 1, 1 },   /* more positions at a time */
    { 9, 90, 8, 9, 160, 3, 3, 2, 2, 1, 1, 1, 1, 1 },      /* several images to a task */
    { 1, 125, 23, 20, 121, 5, 3, 1, 2, 3, 1, 2, 3, 1 },
    { 1, 64, 14, 70, 96, 1, 3, 1, 1, 0, 1, 1, 1, 1 },
    { 2, 3, 31, 40, 32, 3, 3, 2, 2, 1, 1, 1, 1, 1 },      /* from here on: stems */
    { 1, 3, 40, 33, 70, 7, 7, 2, 2, 3, 3, 1, 1, 1 },
    { 2, 1, 5, 6, 16, 3, 3, 2, 2, 1, 1, 1, 1, 1 },
    { 1, 15, 9, 700, 20, 1, 1, 2, 2, 0, 0, 1, 1, 1 },
    { 1, 4, 30, 11, 17, 5, 2, 2, 2, 0, 1, 3, 1, 1 },
    { 1, 2, 1, 1, 33, 3, 3, 2, 2, 1, 1, 1, 1, 1 },
};

/* Those that stay as they are: groups of several channels, few channels but by strides of 2, other depthwise windows */
static const lt_conv2d_params refused[] = {
    { 1, 32, 8, 8, 32, 3, 3, 1, 1, 1, 1, 1, 1, 2 },
    { 1, 3, 8, 8, 32, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 3, 8, 8, 32, 3, 3, 2, 1, 1, 1, 1, 1, 1 },
    { 1, 3, 8, 8, 32, 3, 3, 2, 2, 1, 1, 1, 2, 1 },
    { 1, 12, 8, 8, 32, 7, 7, 2, 2, 3, 3, 1, 1, 1 },
    { 1, 4, 8, 8, 32, 2, 2, 2, 2, 0, 0, 1, 1, 2 },
    { 1, 3, 9, 1 << 15, 32, 3, 3, 2, 2, 1, 1, 1, 1, 1 },
    { 1, 32, 8, 8, 4, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 32, 8, 8, 32, 7, 7, 1, 1, 3, 3, 1, 1, 32 },
    { 1, 32, 8, 8, 64, 3, 3, 1, 1, 1, 1, 1, 1, 32 },
    { 1, 32, 8, 8, 32, 3, 3, 1, 1, 1, 1, 2, 2, 32 },
    { 1, 32, 2, 2, 32, 3, 3, 1, 1, 0, 0, 1, 1, 1 },
};

typedef struct {
    const lt_conv2d_params *p;
    char name[96];
    int64_t in, out;                    /* positions of x, of y */
    float *x, *w, *bias, *residual, *gate;
} problem;

/* How far results may be from the sum, in parts of its terms' sizes; 0 where they are chains of multiply-adds */
static double bound_of(const problem *q)
{
    const char *name = lt_conv_blocks_name(q->p);

    return strncmp(name, "winograd", 8) == 0 ? 4e-6 : strncmp(name, "tiles", 5) == 0 ? 1e-6 : 0;
}

/* The chain of output i over (ky, kx, channel), or (channel, ky, kx); *size: the sum of its terms' sizes */
static float chain(const problem *q, int64_t i, const float *gate, double *size, double *sum)
{
    const lt_conv2d_params *p = q->p;
    const int64_t ow = lt_conv2d_out_w(p), cg = p->c / p->groups, o = i / q->out % p->o, n = i / q->out / p->o;
    const int64_t taps = (int64_t)p->kh * p->kw;
    const bool channels_first = lt_conv_blocks_reads_plain(p);
    float acc = 0;

    for (int64_t l = 0; l < cg * taps; l++) {
        const int64_t t = channels_first ? l % taps : l / cg, c = channels_first ? l / taps : l % cg;
        const int64_t ky = t / p->kw, kx = t % p->kw;
        const int64_t y = i % q->out / ow * p->stride_h + ky * p->dil_h - p->pad_h;
        const int64_t x = i % ow * p->stride_w + kx * p->dil_w - p->pad_w, channel = o / (p->o / p->groups) * cg + c;
        float w = q->w[(o * cg + c) * taps + t], v;

        if (y < 0 || y >= p->h || x < 0 || x >= p->w)
            continue;
        v = q->x[((n * p->c + channel) * p->h + y) * p->w + x];
        w = gate ? w * gate[n * p->c + channel] : w;
        acc = fmaf(w, v, acc);
        *sum += (double)w * (double)v;
        *size += fabs((double)w * (double)v);
    }
    return acc;
}

/* What follows a sum that is within `bound` may add its own roundings, and SiLU's slope is below 1.1. */
static void expect_sum(const problem *q, const lt_conv2d_around *around, size_t i, double sum, double bound, float got)
{
    const double before = sum;

    sum += around->bias ? (double)around->bias[(int64_t)i / q->out % q->p->o] : 0;
    sum += around->residual ? (double)q->residual[i] : 0;
    if (around->act.kind == LT_ACT_SILU)
        sum /= 1 + exp(-sum), bound *= 1.1;
    if (around->bias)
        bound += 2e-7 * (fabs(before) + 2);
    expect_near(got, sum, bound, lt_conv_blocks_name(q->p), q->name, i);
}

static void expect_chains(const problem *q, const lt_conv2d_around *around, const float *got)
{
    const size_t n = (size_t)(q->p->n * q->p->o * q->out);
    float *want = guarded_array(n);

    for (size_t i = 0; i < n; i++) {
        double size = 0, sum = 0;

        want[i] = chain(q, (int64_t)i, around->gate, &size, &sum);
        if (bound_of(q) > 0)
            expect_sum(q, around, i, sum, bound_of(q) * size, got[i]);
        want[i] = around->bias ? want[i] + around->bias[(int64_t)i / q->out % q->p->o] : want[i];
        want[i] = around->residual ? want[i] + q->residual[i] : want[i];
    }
    if (around->act.kind == LT_ACT_SILU)
        lt_k->silu(want, want, n);
    if (bound_of(q) == 0)
        expect_bits(got, want, n, "%s", q->name);
    free_array(want);
}

/* What stands in the lanes behind the last channel is 0. */
static void expect_zeros(const problem *q, const float *y)
{
    const int64_t blocks = lt_blocks_of(q->p->o);

    for (int64_t i = 0; i < q->p->n * blocks * q->out * LT_BLOCK; i++)
        if (i / LT_BLOCK / q->out % blocks * LT_BLOCK + i % LT_BLOCK >= q->p->o)
            expect_near(y[i], 0, 0, "lanes without a channel", q->name, (size_t)i);
}

static float *in_blocks(const float *x, int64_t n, int64_t c, int64_t positions)
{
    float *y = guarded_array((size_t)(n * lt_blocks_of(c) * positions * LT_BLOCK));

    lt_blocks_from_maps(y, x, n, c, positions);
    return y;
}

static void expect_means(const problem *q, const float *y, const float *mean)
{
    for (int64_t i = 0; i < q->p->n * q->p->o; i++) {
        double sum = 0;

        for (int64_t k = 0; k < q->out; k++)
            sum += (double)y[i * q->out + k];
        expect_near(mean[i], sum / (double)q->out, 1e-6, "means in blocks", q->name, (size_t)i);
    }
}

/* x as the convolution reads it */
static float *input_of(const problem *q)
{
    const lt_conv2d_params *p = q->p;
    const size_t n = (size_t)(p->n * p->c * q->in);
    float *x;

    if (!lt_conv_blocks_reads_plain(p))
        return in_blocks(q->x, p->n, p->c, q->in);
    x = guarded_array(n);
    memcpy(x, q->x, n * sizeof(float));
    return x;
}

static void check(const problem *q, const lt_conv2d_around *around, bool plainly)
{
    const lt_conv2d_params *p = q->p;
    const size_t n = (size_t)(p->n * p->o * q->out);
    float *x = input_of(q), *residual = in_blocks(q->residual, p->n, p->o, q->out);
    float *packed = guarded_array((size_t)lt_conv_blocks_packed(p)), *got = guarded_array(n);
    float *y = guarded_array((size_t)(p->n * lt_blocks_of(p->o) * q->out * LT_BLOCK));
    lt_conv2d_around here = *around;
    void *work = lt_alloc(lt_conv_blocks_work(p));

    here.residual = around->residual ? residual : NULL;
    lt_conv_blocks_pack(p, q->w, packed);
    lt_conv_blocks_forward(p, x, packed, &here, y, work);
    lt_blocks_to_maps(got, y, p->n, p->o, q->out);
    same_as_before(got, n, "%s %s %d %d %d", lt_conv_blocks_name(p), q->name, around->bias != NULL,
                   around->residual != NULL, around->gate != NULL);
    expect_zeros(q, y);
    if (plainly)
        expect_chains(q, around, got);
    if (around->mean) {
        expect_means(q, got, around->mean);
        same_as_before(around->mean, (size_t)(p->n * p->o), "means of blocks %s", q->name);
    }
    free_array(x), free_array(residual), free_array(packed), free_array(got), free_array(y), lt_release(work);
}

static void check_shape(const lt_conv2d_params *p, bool plainly)
{
    problem q = { .p = p, .in = p->h * p->w, .out = lt_conv2d_out_h(p) * lt_conv2d_out_w(p) };
    float *mean = guarded_array((size_t)(p->n * p->o));

    snprintf(q.name, sizeof(q.name), "%d %d %d %d to %d, %d x %d by %d, groups %d", (int)p->n, (int)p->c, (int)p->h,
             (int)p->w, (int)p->o, p->kh, p->kw, p->stride_w, p->groups);
    q.x = random_array((size_t)(p->n * p->c * q.in), 1);
    q.w = random_array((size_t)(p->o * p->c / p->groups * p->kh * p->kw), 2);
    q.bias = random_array((size_t)p->o, 3);
    q.residual = random_array((size_t)(p->n * p->o * q.out), 4);
    q.gate = random_array((size_t)(p->n * p->c), 5);
    check(&q, &(lt_conv2d_around){ 0 }, plainly);
    check(&q, &(lt_conv2d_around){ .bias = q.bias, .residual = q.residual, .act = { LT_ACT_SILU, 0 } }, plainly);
    if (lt_conv2d_takes_gate(p))
        check(&q, &(lt_conv2d_around){ .gate = q.gate, .bias = q.bias }, plainly);
    if (p->groups > 1)
        check(&q, &(lt_conv2d_around){ .mean = mean, .bias = q.bias }, plainly);
    free_array(mean), free_array(q.x), free_array(q.w), free_array(q.bias), free_array(q.residual), free_array(q.gate);
}

/* There and back: the same numbers; and the mean of each channel. */
static void check_turns(void)
{
    enum { N = 2, C = 35, POSITIONS = 700 };
    float *x = random_array((size_t)N * C * POSITIONS, 6), *y = in_blocks(x, N, C, POSITIONS);
    float *back = guarded_array((size_t)N * C * POSITIONS), *mean = guarded_array((size_t)N * C);
    const problem q = { .p = &(lt_conv2d_params){ .n = N, .o = C }, .name = "turned", .out = POSITIONS };

    expect_zeros(&q, y);
    lt_blocks_to_maps(back, y, N, C, POSITIONS);
    expect_bits(back, x, (size_t)N * C * POSITIONS, "maps to blocks and back");
    lt_blocks_mean(mean, y, N, C, POSITIONS);
    expect_means(&q, x, mean);
    same_as_before(mean, (size_t)N * C, "means of blocks");
    free_array(x), free_array(y), free_array(back), free_array(mean);
}

/* ---- two in a row ---- */

typedef struct { lt_conv2d_params first; int size, stride, pad; } pair_case;

static const pair_case pairs[] = {
    { { 2, 24, 14, 13, 40, 1, 1, 1, 1, 0, 0, 1, 1, 1 }, 3, 1, 1 },
    { { 1, 16, 28, 28, 144, 1, 1, 1, 1, 0, 0, 1, 1, 1 }, 5, 1, 2 },
    { { 1, 33, 57, 20, 65, 1, 1, 1, 1, 0, 0, 1, 1, 1 }, 5, 2, 2 },    /* many rows, several times */
    { { 1, 17, 90, 115, 33, 1, 1, 1, 1, 0, 0, 1, 1, 1 }, 3, 2, 0 },
    { { 1, 256, 13, 12, 20, 1, 1, 1, 1, 0, 0, 1, 1, 1 }, 5, 1, 4 },
    { { 3, 40, 1, 40, 16, 1, 1, 1, 1, 0, 0, 1, 1, 1 }, 3, 1, 2 },     /* rows that see nothing of the map */
    { { 1, 20, 2, 15, 48, 1, 1, 1, 1, 0, 0, 1, 1, 1 }, 5, 2, 4 },
};

/* Too narrow, too deep, not pointwise, with a wide window */
static const pair_case no_pairs[] = {
    { { 1, 24, 14, 11, 40, 1, 1, 1, 1, 0, 0, 1, 1, 1 }, 3, 1, 1 },
    { { 1, 257, 14, 14, 40, 1, 1, 1, 1, 0, 0, 1, 1, 1 }, 3, 1, 1 },
    { { 1, 24, 14, 14, 40, 1, 1, 2, 2, 0, 0, 1, 1, 1 }, 3, 1, 1 },
    { { 1, 24, 14, 14, 40, 1, 1, 1, 1, 0, 0, 1, 1, 1 }, 7, 1, 3 },
};

static lt_conv2d_params second_of(const pair_case *c)
{
    const lt_conv2d_params *p = &c->first;

    return (lt_conv2d_params){
        p->n, p->o, lt_conv2d_out_h(p), lt_conv2d_out_w(p), p->o, c->size, c->size, c->stride, c->stride, c->pad,
        c->pad, 1, 1, (int)p->o,
    };
}

static float *pack_random(const lt_conv2d_params *p, uint64_t seed)
{
    float *w = random_array((size_t)(p->o * p->c / p->groups * p->kh * p->kw), seed);
    float *packed = guarded_array((size_t)lt_conv_blocks_packed(p));

    lt_conv_blocks_pack(p, w, packed);
    free_array(w);
    return packed;
}

/* The same bits as one after the other, but for the means, which are as near as sums in double */
static void check_pair(const pair_case *c)
{
    const lt_conv2d_params *p = &c->first, q = second_of(c);
    const int64_t in = p->h * p->w, out = lt_conv2d_out_h(&q) * lt_conv2d_out_w(&q);
    const size_t size = (size_t)(q.n * lt_blocks_of(q.o) * out * LT_BLOCK);
    float *maps = random_array((size_t)(p->n * p->c * in), 1), *x = in_blocks(maps, p->n, p->c, in);
    float *bias = random_array((size_t)p->o, 2), *residual = random_array(size, 3), *packed = pack_random(p, 4);
    float *packed2 = pack_random(&q, 5), *between = guarded_array((size_t)(p->n * lt_blocks_of(p->o) * in * LT_BLOCK));
    float *want = guarded_array(size), *got = guarded_array(size), *mean = guarded_array((size_t)(q.n * q.o));
    float *want_mean = guarded_array((size_t)(q.n * q.o));
    lt_conv_blocks_step first = { p, packed, { .bias = bias, .act = { LT_ACT_SILU, 0 } } };
    lt_conv_blocks_step second = { &q, packed2, { .bias = bias, .residual = residual, .act = { LT_ACT_TANH, 0 } } };
    void *work = lt_alloc(lt_conv_blocks_work(p)), *work2 = lt_alloc(lt_conv_blocks_work(&q));
    void *pair_work = lt_alloc(lt_conv_blocks_pair_work(p, &q));

    second.around.mean = want_mean;
    lt_conv_blocks_forward(p, x, packed, &first.around, between, work);
    lt_conv_blocks_forward(&q, between, packed2, &second.around, want, work2);
    second.around.mean = mean;
    lt_conv_blocks_pair_forward(&first, &second, x, got, pair_work);
    expect_bits(got, want, size, "a pair, %d to %d @ %d x %d", (int)p->c, (int)p->o, (int)p->h, (int)p->w);
    for (int64_t i = 0; i < q.n * q.o; i++)
        expect_near(mean[i], want_mean[i], 1e-7, "a pair", "mean", (size_t)i);
    same_as_before(mean, (size_t)(q.n * q.o), "means of a pair, %d to %d", (int)p->c, (int)p->o);
    free_array(maps), free_array(x), free_array(bias), free_array(residual), free_array(packed), free_array(packed2);
    free_array(between), free_array(want), free_array(got), free_array(mean), free_array(want_mean);
    lt_release(work), lt_release(work2), lt_release(pair_work);
}

static void check_pairs(void)
{
    for (size_t i = 0; i < LT_COUNT(pairs); i++) {
        const lt_conv2d_params second = second_of(&pairs[i]);

        expect_near(lt_conv_blocks_pair_suits(&pairs[i].first, &second), 1, 0, "blocks", "a pair that suits", i);
        check_pair(&pairs[i]);
    }
    for (size_t i = 0; i < LT_COUNT(no_pairs); i++) {
        const lt_conv2d_params second = second_of(&no_pairs[i]);

        expect_near(lt_conv_blocks_pair_suits(&no_pairs[i].first, &second), 0, 0, "blocks", "no pair", i);
    }
}

void check_blocks(bool plainly)
{
    check_turns();
    check_pairs();
    for (size_t i = 0; i < LT_COUNT(shapes); i++)
        check_shape(&shapes[i], plainly);
    for (size_t i = 0; i < LT_COUNT(refused); i++)
        expect_near(lt_conv_blocks_takes(&refused[i]), 0, 0, "refused", "blocks", i);
}
