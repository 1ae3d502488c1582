/* SPDX-License-Identifier: Apache-2.0 */
/* lpips: y = sum over taps of mean over positions of sum_c lin_c (u_c - v_c)^2         [Zhang et al. 2018, equation 1]
 *   u = f / (|f| + 1e-10) over the channels of a tap of the image, v likewise of the truth
 *   du_c = dy 2 lin_c (u_c - v_c) / positions, then back through the network of alexnet.c
 *
 * The crops of the images come first and those of the truths after them, so that the gradient goes through the first
 * half of all columns alone.
 */
#include "models/backbones/lpips.h"

#include "libtensor/base/parallel.h"
#include "libtensor/graph/op.h"
#include "libtensor/ops/norm/l2_normalise.h"

#include <math.h>
#include <string.h>

#define EPS ((lt_real)1e-10)

static const double shift[3] = { -0.030, -0.088, -0.188 }, scale[3] = { 0.458, 0.448, 0.450 };

/* ---- what it works on --------------------------------------------------------------------------------------- */

enum { IMAGE, TRUTH, BOXES };

typedef struct {
    const lpips *m;
    lpips_range range;
} lpips_attr;

static lt_status infer(lt_call *c)
{
    const lt_tensor *x = c->in[IMAGE];
    const int64_t B = x->shape.rank == 4 ? lt_dim(x, 0) : 0, H = B ? lt_dim(x, 2) : 0, W = B ? lt_dim(x, 3) : 0;

    if (lt_want_rank(c, IMAGE, "image", 4) || lt_want_shape(c, TRUTH, "truth", x->shape))
        return LT_ESHAPE;
    if (lt_dim(x, 1) != 3)
        return lt_fail(c, "image has %lld channels, want red, green and blue", (long long)lt_dim(x, 1));
    if (B && (H < ALEXNET_LEAST || W < ALEXNET_LEAST || H > LPIPS_MOST || W > LPIPS_MOST))
        return lt_fail(c, "image is %lld x %lld pixels, want sides of %d to %d", (long long)W, (long long)H,
                       ALEXNET_LEAST, LPIPS_MOST);
    if (c->in[BOXES] && lt_want_shape(c, BOXES, "boxes", LT_SHAPE(lt_dim(x, 0), 4)))
        return LT_ESHAPE;
    c->out->shape = LT_SHAPE(lt_dim(x, 0));
    return LT_OK;
}

typedef struct { int64_t x, y, w, h; } box;

/* From lo to hi, grown to the smallest side that the network takes, and moved into 0 to n */
static void grow(int64_t *lo, int64_t *hi, int64_t n)
{
    const int64_t lack = lt_max_i64(0, ALEXNET_LEAST - (*hi - *lo));

    *lo = lt_max_i64(0, lt_min_i64(*lo - lack / 2, n - lt_max_i64(ALEXNET_LEAST, *hi - *lo)));
    *hi = lt_max_i64(*hi, *lo + ALEXNET_LEAST);
}

static box box_of(const lt_call *c, int64_t image)
{
    const int64_t H = lt_dim(c->in[IMAGE], 2), W = lt_dim(c->in[IMAGE], 3);
    const lt_real *b = c->in[BOXES] ? (const lt_real *)c->in[BOXES]->data + 4 * image : NULL;
    int64_t x0, x1, y0, y1;

    if (!b)
        return (box){ 0, 0, W, H };
    if (!(b[0] < b[2] && b[1] < b[3] && b[2] > 0 && b[3] > 0 && b[0] < (lt_real)W && b[1] < (lt_real)H))
        return (box){ 0, 0, 0, 0 };
    x0 = b[0] > 0 ? (int64_t)b[0] : 0, y0 = b[1] > 0 ? (int64_t)b[1] : 0;
    x1 = b[2] < (lt_real)W ? (int64_t)ceil((double)b[2]) : W, y1 = b[3] < (lt_real)H ? (int64_t)ceil((double)b[3]) : H;
    grow(&x0, &x1, W);
    grow(&y0, &y1, H);
    return (box){ x0, y0, x1 - x0, y1 - y0 };
}

/* The crops of the images, then those of the truths, laid out in memory that has room for 2 B of them */
static alexnet_crops crops_of(const lt_call *c, alexnet_crop *memory)
{
    const int B = (int)lt_dim(c->in[IMAGE], 0);
    alexnet_crops crops = { .crop = memory, .n = 2 * B };

    for (int i = 0; i < 2 * B; i++) {
        const box b = box_of(c, i % B);

        memory[i].in[0] = (alexnet_map){ .h = b.h, .w = b.w };
    }
    alexnet_lay_out(&crops);
    return crops;
}

/* ---- memory ------------------------------------------------------------------------------------------------- */

static int64_t aligned(int64_t n)
{
    return lt_ceil_div(n, LT_ALIGN) * LT_ALIGN;
}

/* The next n elements of memory, or of nothing, to count them */
static lt_real *take(lt_real *memory, int64_t *at, int64_t n)
{
    lt_real *here = memory ? memory + *at : NULL;

    *at += aligned(n);
    return here;
}

/* What is kept for backward, in `kept`, and the rest in `work`; each begins with the crops. */
typedef struct {
    alexnet_maps maps;
    lt_real *norm;                  /* of a tap's columns */
    lt_real *unit;                  /* a tap with its columns made one long, then the differences */
    lt_real *columns;               /* alexnet's scratch */
    lt_real *part;                  /* of each image's distance: a tap's channels */
    lt_real *dtap[2], *din;         /* gradients of two taps at a time, and of what a layer reads */
    int64_t kept, work;             /* elements of both */
} memory;

static int64_t crops_elements(const lt_call *c)
{
    return aligned(lt_ceil_div(2 * lt_dim(c->in[IMAGE], 0) * (int64_t)sizeof(alexnet_crop), (int64_t)sizeof(lt_real)));
}

/* For crops of these sizes, which are at most those of whole images */
static memory memory_of(const lt_call *c, const alexnet_crops *crops, lt_real *kept, lt_real *work)
{
    memory m = { .kept = crops_elements(c), .work = 0 };
    int64_t tap = 0, in = 3 * crops->in[0];

    for (int l = 0; l < ALEXNET_TAPS; l++) {
        const alexnet_layer *a = &alexnet_layers[l];

        m.maps.tap[l] = take(kept, &m.kept, a->o * crops->out[l]);
        if (a->pool && c->train)
            m.maps.where[l] = (int32_t *)take(kept, &m.kept, a->c * crops->in[l]);
        tap = lt_max_i64(tap, a->o * crops->out[l]);
        in = lt_max_i64(in, a->c * crops->in[l]);
    }
    m.columns = take(work, &m.work, alexnet_columns_count());
    m.norm = take(work, &m.work, crops->out[0]);
    m.unit = take(work, &m.work, tap);
    m.part = take(work, &m.work, lt_dim(c->in[IMAGE], 0) * alexnet_layers[2].o);
    m.din = take(work, &m.work, in);            /* in forward what layers read */
    m.dtap[0] = c->train ? take(work, &m.work, tap) : NULL;
    m.dtap[1] = c->train ? take(work, &m.work, tap) : NULL;
    for (int l = 0; l < ALEXNET_TAPS; l++)
        m.maps.in[l] = l == 0 || alexnet_layers[l].pool ? m.din : m.maps.tap[l - 1];
    return m;
}

static void plan(lt_call *c)
{
    alexnet_crop one[2];
    alexnet_crops crops = { .crop = one, .n = 2 };
    memory m;
    const int64_t B = lt_dim(c->in[IMAGE], 0);

    for (int i = 0; i < 2; i++)
        one[i].in[0] = (alexnet_map){ .h = lt_dim(c->in[IMAGE], 2), .w = lt_dim(c->in[IMAGE], 3) };
    alexnet_lay_out(&crops);
    for (int l = 0; l < ALEXNET_TAPS; l++)
        crops.in[l] *= B, crops.out[l] *= B;
    m = memory_of(c, &crops, NULL, NULL);
    if (c->train)
        c->saved_bytes[0] = (size_t)m.kept * sizeof(lt_real);
    c->work_bytes = (size_t)(m.work + (c->train ? 0 : m.kept)) * sizeof(lt_real);
}

static lt_real *kept_of(const lt_call *c)
{
    return c->train ? c->saved[0] : c->work;
}

static lt_real *work_of(const lt_call *c, const memory *sizes)
{
    return (lt_real *)c->work + (c->train ? 0 : sizes->kept);
}

/* ---- forward ------------------------------------------------------------------------------------------------ */

/* The run at hand */
typedef struct {
    const lt_call *c;
    const lpips *m;
    int B;
    alexnet_crops crops;
    memory memory;
    int l;                          /* the tap that is looked at */
} state;

static state state_of(const lt_call *c)
{
    state s = { .c = c, .m = ((const lpips_attr *)c->attr)->m, .B = (int)lt_dim(c->in[IMAGE], 0) };

    s.crops = crops_of(c, (alexnet_crop *)kept_of(c));
    s.memory = memory_of(c, &s.crops, kept_of(c), NULL);
    s.memory = memory_of(c, &s.crops, kept_of(c), work_of(c, &s.memory));
    return s;
}

/* What the network sees of a value v is v times `times`, plus `plus`. */
static void colour_map(const lt_call *c, int channel, double *times, double *plus)
{
    const bool sym = ((const lpips_attr *)c->attr)->range == LPIPS_SYM;

    *times = (sym ? 2 : 1) / scale[channel];
    *plus = ((sym ? -1 : 0) - shift[channel]) / scale[channel];
}

/* One channel of one crop, as the network wants it */
static void cut(void *ctx, int64_t task)
{
    const state *s = ctx;
    const int64_t i = task / 3, channel = task % 3, H = lt_dim(s->c->in[IMAGE], 2), W = lt_dim(s->c->in[IMAGE], 3);
    const alexnet_map *x = &s->crops.crop[i].in[0];
    const box b = box_of(s->c, i % s->B);
    const lt_real *from = s->c->in[i < s->B ? IMAGE : TRUTH]->data;
    lt_real *to = s->memory.maps.in[0] + channel * s->crops.in[0] + x->at;
    double times, plus;

    colour_map(s->c, (int)channel, &times, &plus);
    from += ((i % s->B * 3 + channel) * H + b.y) * W + b.x;
    for (int64_t y = 0; y < b.h; y++)
        lt_k->affine(to + y * b.w, from + y * W, (lt_real)times, (lt_real)plus, NULL,
                     (lt_act){ .kind = LT_ACT_NONE }, (size_t)b.w);
}

static void make_long(void *ctx, int64_t piece)
{
    const state *s = ctx;
    const int64_t all = s->crops.out[s->l], at = piece * OP_L2_COLUMNS;

    op_l2_normalise(s->memory.unit + at, all, s->memory.norm + at, s->memory.maps.tap[s->l] + at, all,
                    alexnet_layers[s->l].o, lt_min_i64(OP_L2_COLUMNS, all - at), EPS);
}

/* u - v of one channel in the place of u, and its share of each image's distance */
static void compare(void *ctx, int64_t channel)
{
    const state *s = ctx;
    const double lin = (double)s->m->lin[s->l]->data[channel];
    lt_real *row = s->memory.unit + channel * s->crops.out[s->l];

    for (int i = 0; i < s->B; i++) {
        const alexnet_map *u = &s->crops.crop[i].out[s->l], *v = &s->crops.crop[s->B + i].out[s->l];
        const int64_t n = u->h * u->w;

        lt_k->sub(row + u->at, row + u->at, row + v->at, (size_t)n);
        s->memory.part[i * alexnet_layers[s->l].o + channel] =
            n ? (lt_real)(lin * lt_k->sumsq(row + u->at, (size_t)n) / (double)n) : 0;
    }
}

/* Leaves u - v in s->memory.unit */
static void compare_tap(state *s, int l)
{
    s->l = l;
    lt_parallel_for(lt_ceil_div(s->crops.out[l], OP_L2_COLUMNS), make_long, s);
    lt_parallel_for(alexnet_layers[l].o, compare, s);
}

static void forward(const lt_call *c)
{
    lt_real *y = c->out->data;
    state s;

    if (lt_numel(c->out) == 0)
        return;
    s = state_of(c);
    memset(y, 0, (size_t)s.B * sizeof(*y));
    lt_parallel_for(3 * s.crops.n, cut, &s);
    alexnet_forward(&s.m->trunk, &s.crops, c->train ? s.B : 0, &s.memory.maps, s.memory.columns);
    for (int l = 0; l < ALEXNET_TAPS; l++) {
        const int64_t C = alexnet_layers[l].o;

        compare_tap(&s, l);
        for (int i = 0; i < s.B; i++)
            y[i] += (lt_real)lt_k->sum(s.memory.part + i * C, (size_t)C);
    }
}

/* ---- backward ----------------------------------------------------------------------------------------------- */

/* Columns of the images' crops at a tap */
static int64_t image_columns(const state *s, int l)
{
    return s->crops.crop[s->B].out[l].at;
}

/* u - v of one channel becomes the gradient of u. */
static void scale_differences(void *ctx, int64_t channel)
{
    const state *s = ctx;
    const double lin = (double)s->m->lin[s->l]->data[channel];
    lt_real *row = s->memory.unit + channel * s->crops.out[s->l];

    for (int i = 0; i < s->B; i++) {
        const alexnet_map *u = &s->crops.crop[i].out[s->l];
        const int64_t n = u->h * u->w;

        if (n)
            lt_k->scale(row + u->at, row + u->at, (lt_real)(2 * lin * (double)s->c->dout[i] / (double)n), (size_t)n);
    }
}

static void shorten(void *ctx, int64_t piece)
{
    const state *s = ctx;
    const int64_t all = s->crops.out[s->l], at = piece * OP_L2_COLUMNS;

    op_l2_normalise_grad(s->memory.dtap[s->l % 2] + at, s->memory.unit + at, s->memory.maps.tap[s->l] + at,
                         s->memory.norm + at, all, alexnet_layers[s->l].o,
                         lt_min_i64(OP_L2_COLUMNS, image_columns(s, s->l) - at), EPS);
}

/* dtap of tap l += what the distance gives it */
static void tap_gradient(state *s, int l)
{
    compare_tap(s, l);
    lt_parallel_for(alexnet_layers[l].o, scale_differences, s);
    lt_parallel_for(lt_ceil_div(image_columns(s, l), OP_L2_COLUMNS), shorten, s);
}

static void clear_dtap(const state *s, int l)
{
    lt_real *d = s->memory.dtap[l % 2];

    for (int64_t c = 0; c < alexnet_layers[l].o; c++)
        memset(d + c * s->crops.out[l], 0, (size_t)image_columns(s, l) * sizeof(*d));
}

/* One channel of one image: its crop's gradient goes where the crop was cut. */
static void put_back(void *ctx, int64_t task)
{
    const state *s = ctx;
    const int64_t i = task / 3, channel = task % 3, H = lt_dim(s->c->in[IMAGE], 2), W = lt_dim(s->c->in[IMAGE], 3);
    const box b = box_of(s->c, i);
    const lt_real *from = s->memory.din + channel * s->crops.in[0] + s->crops.crop[i].in[0].at;
    lt_real *to = s->c->din[IMAGE] + ((i * 3 + channel) * H + b.y) * W + b.x;
    double times, plus;

    colour_map(s->c, (int)channel, &times, &plus);
    for (int64_t y = 0; y < b.h; y++)
        lt_k->axpy(to + y * W, (lt_real)times, from + y * b.w, (size_t)b.w);
}

static void backward(const lt_call *c)
{
    state s;

    if (!c->din[IMAGE] || lt_numel(c->out) == 0)
        return;
    s = state_of(c);
    clear_dtap(&s, ALEXNET_TAPS - 1);
    for (int l = ALEXNET_TAPS - 1; l >= 0; l--) {
        const bool pool = alexnet_layers[l].pool;

        tap_gradient(&s, l);
        alexnet_backward(&s.m->trunk, &s.crops, s.B, l, s.memory.maps.tap[l], s.memory.dtap[l % 2],
                         l == 0 || pool ? s.memory.din : s.memory.dtap[(l - 1) % 2], s.memory.columns);
        if (pool) {
            clear_dtap(&s, l - 1);
            alexnet_pool_backward(&s.crops, s.B, l, s.memory.maps.where[l], s.memory.din, s.memory.dtap[(l - 1) % 2]);
        }
    }
    lt_parallel_for(3 * s.B, put_back, &s);
}

static int64_t macs(const lt_call *c)
{
    alexnet_crop one;
    alexnet_crops crops = { .crop = &one, .n = 1 };
    int64_t sum = 0;

    one.in[0] = (alexnet_map){ .h = lt_dim(c->in[IMAGE], 2), .w = lt_dim(c->in[IMAGE], 3) };
    alexnet_lay_out(&crops);
    for (int l = 0; l < ALEXNET_TAPS; l++) {
        const alexnet_layer *a = &alexnet_layers[l];

        sum += crops.out[l] * a->o * a->c * a->k * a->k;
    }
    return 2 * lt_dim(c->in[IMAGE], 0) * sum;
}

static const lt_op lpips_op = {
    .name = "lpips", .keeps = LT_KEEP_IN(BOXES), .optional = LT_OPTIONAL_IN(BOXES), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward, .macs = macs,
};

lt_tensor *lpips_distance(const lpips *m, lpips_range range, lt_tensor *image, lt_tensor *truth, lt_tensor *boxes)
{
    const lpips_attr a = { m, range };

    return lt_apply(&lpips_op, &a, sizeof(a), (lt_tensor *[]){ image, truth, boxes }, 3);
}
