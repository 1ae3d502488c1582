/* SPDX-License-Identifier: Apache-2.0 */
/*
 * detect_mask_loss: y = sum over cells with a known mask of 1 / area times the sum over the box's pixels of
 *   softplus(z) - t z, over their number; z = coefficients . prototypes, t the mask's bit
 *   coefficients (B, 32, H, W) of each level, prototypes (B, 32, h, w)
 *   dz = dy (sigmoid(z) - t) / (area number)      dcoefficients += dz prototypes     dprototypes += dz coefficients
 *
 * A pixel is in a box where its corner is, x0 <= x < x1. An image is one task's: its cells add to the same prototypes.
 */
#include "libtensor/base/parallel.h"
#include "models/detect/counts.h"
#include "models/detect/losses.h"

#include <math.h>

enum { COEFFICIENTS = 0, PROTO = DETECT_LEVELS, OBJECTS, MASKS, ASSIGNED, INPUTS };
enum { K = DETECT_COEFFICIENTS, PROTO_STRIDE = 4, BITS = 32 };

static int64_t images_of(const lt_call *c)
{
    return lt_dim(c->in[COEFFICIENTS], 0);
}

static int64_t pixels_of(const lt_call *c)
{
    return lt_dim(c->in[PROTO], 2) * lt_dim(c->in[PROTO], 3);
}

static lt_status infer(lt_call *c)
{
    const lt_tensor *proto = c->in[PROTO], *objects = c->in[OBJECTS];
    const int64_t B = images_of(c);

    c->out->shape = (lt_shape){ 0 };
    if (cells_check(c, "coefficients", K) || lt_want_rank(c, PROTO, "prototypes", 4) ||
        lt_want_shape(c, PROTO, "prototypes", LT_SHAPE(B, K, lt_dim(proto, 2), lt_dim(proto, 3))) ||
        lt_want_rank(c, OBJECTS, "objects", 3) ||
        lt_want_shape(c, OBJECTS, "objects", LT_SHAPE(B, lt_dim(objects, 1), OBJECT_NUMBERS)) ||
        lt_want_shape(c, MASKS, "masks", LT_SHAPE(B, lt_dim(objects, 1), lt_ceil_div(pixels_of(c), BITS))) ||
        lt_want_shape(c, ASSIGNED, "assigned", LT_SHAPE(B, cells_of(c), ASSIGNED_NUMBERS)))
        return LT_ESHAPE;
    if (c->in[MASKS]->dtype != LT_I32)
        return lt_fail(c, "masks are not LT_I32");
    return LT_OK;
}

static void plan(lt_call *c)
{
    counts_plan(c, images_of(c), 1);
}

/* A cell whose object's mask is known */
typedef struct {
    cell at;
    lt_real coefficient[K];
    const lt_real *proto;           /* the image's */
    const int32_t *mask;
    int64_t x0, y0, x1, y1, w;      /* the box's pixels */
    double area;
} mask_pair;

static int64_t pixel(double at, int64_t n)
{
    return at <= 0 ? 0 : at >= (double)n ? n : (int64_t)ceil(at);
}

static bool mask_pair_at(const lt_call *c, int64_t b, int64_t i, mask_pair *p)
{
    const lt_real *t = assigned_at(c->in[ASSIGNED], b, i), *object, *x;
    const int64_t h = lt_dim(c->in[PROTO], 2), words = lt_dim(c->in[MASKS], 2), G = lt_dim(c->in[OBJECTS], 1);
    ciou_box box;

    if (t[ASSIGNED_OBJECT] < 0)
        return false;
    object = object_at(c->in[OBJECTS], b, (int64_t)t[ASSIGNED_OBJECT]);
    if (!(object[OBJECT_HAS_MASK] > 0))
        return false;
    box = object_box(object, PROTO_STRIDE);
    p->at = cell_at(c, i);
    p->w = lt_dim(c->in[PROTO], 3);
    p->x0 = pixel(box.v[0], p->w), p->x1 = pixel(box.v[2], p->w);
    p->y0 = pixel(box.v[1], h), p->y1 = pixel(box.v[3], h);
    p->area = (box.v[2] - box.v[0]) * (box.v[3] - box.v[1]);
    p->proto = (const lt_real *)c->in[PROTO]->data + b * K * pixels_of(c);
    p->mask = (const int32_t *)c->in[MASKS]->data + (b * G + (int64_t)t[ASSIGNED_OBJECT]) * words;
    x = cell_values(c, b, &p->at);
    for (int k = 0; k < K; k++)
        p->coefficient[k] = x[k * p->at.plane];
    return p->area > 0;
}

enum { RUN = 64 };

/* Logits of n pixels from `at` on */
static void logits(const mask_pair *p, int64_t pixels, int64_t at, int n, lt_real z[RUN])
{
    for (int i = 0; i < n; i++)
        z[i] = 0;
    for (int k = 0; k < K; k++)
        for (int i = 0; i < n; i++)
            z[i] += p->coefficient[k] * p->proto[k * pixels + at + i];
}

static int bit(const mask_pair *p, int64_t at)
{
    return (int)((uint32_t)p->mask[at / BITS] >> (at % BITS) & 1);
}

static double pair_loss(const mask_pair *p, int64_t pixels)
{
    double sum = 0;
    lt_real z[RUN];

    for (int64_t y = p->y0; y < p->y1; y++)
        for (int64_t x = p->x0; x < p->x1; x += RUN) {
            const int64_t at = y * p->w + x;
            const int n = (int)lt_min_i64(RUN, p->x1 - x);

            logits(p, pixels, at, n, z);
            for (int i = 0; i < n; i++)
                sum += fmax((double)z[i], 0) + log1p(exp(-fabs((double)z[i]))) - bit(p, at + i) * (double)z[i];
        }
    return sum / p->area;
}

static void forward_image(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    double sum = 0;
    mask_pair p;

    for (int64_t i = 0; i < cells_of(c); i++)
        if (mask_pair_at(c, b, i, &p))
            sum += pair_loss(&p, pixels_of(c));
    ((double *)c->work)[b] = sum;
}

static void forward(const lt_call *c)
{
    const counts n = counts_of(c, OBJECTS, ASSIGNED);
    double sum = 0;

    lt_parallel_for(images_of(c), forward_image, (void *)c);
    for (int64_t b = 0; b < images_of(c); b++)
        sum += ((const double *)c->work)[b];
    *(lt_real *)c->out->data = (lt_real)(sum / n.masks * counts_parts(c));
}

/* Of n pixels whose slopes are dz */
static void run_grad(const lt_call *c, int64_t b, const mask_pair *p, int64_t at, int n, const lt_real dz[RUN],
                     double dcoefficient[K])
{
    const int64_t pixels = pixels_of(c);

    for (int k = 0; k < K; k++) {
        const lt_real *proto = p->proto + k * pixels + at;
        lt_real sum = 0;

        for (int i = 0; i < n; i++)
            sum += dz[i] * proto[i];
        dcoefficient[k] += (double)sum;
    }
    for (int k = 0; c->din[PROTO] && k < K; k++) {
        lt_real *to = c->din[PROTO] + (b * K + k) * pixels + at;

        for (int i = 0; i < n; i++)
            to[i] += dz[i] * p->coefficient[k];
    }
}

static void pair_grad(const lt_call *c, int64_t b, const mask_pair *p, double f)
{
    double dcoefficient[K] = { 0 };
    lt_real z[RUN];

    for (int64_t y = p->y0; y < p->y1; y++)
        for (int64_t x = p->x0; x < p->x1; x += RUN) {
            const int64_t at = y * p->w + x;
            const int n = (int)lt_min_i64(RUN, p->x1 - x);

            logits(p, pixels_of(c), at, n, z);
            for (int i = 0; i < n; i++)
                z[i] = (lt_real)(f / p->area * (1 / (1 + exp(-(double)z[i])) - bit(p, at + i)));
            run_grad(c, b, p, at, n, z, dcoefficient);
        }
    for (int k = 0; c->din[p->at.level] && k < K; k++)
        c->din[p->at.level][(b * K + k) * p->at.plane + p->at.at] += (lt_real)dcoefficient[k];
}

static void backward_image(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    const double f = *c->dout / counts_saved(c).masks * counts_parts(c);
    mask_pair p;

    for (int64_t i = 0; i < cells_of(c); i++)
        if (mask_pair_at(c, b, i, &p))
            pair_grad(c, b, &p, f);
}

static void backward(const lt_call *c)
{
    lt_parallel_for(images_of(c), backward_image, (void *)c);
}

static void share(const lt_call *c)
{
    counts_share(c, OBJECTS, ASSIGNED);
}

static void share_nothing(const lt_call *c)
{
    (void)c;
}

static const lt_op mask_op = {
    .name = "detect_mask_loss", .any_type = LT_ANY_TYPE_IN(MASKS), .infer = infer, .plan = plan, .forward = forward,
    .backward = backward, .forward_share = share, .backward_share = share_nothing,
};

lt_tensor *(detect_mask_loss)(const detect_maps *maps, lt_tensor *objects, lt_tensor *masks, lt_tensor *assigned)
{
    lt_tensor *in[INPUTS] = { maps->mask[0], maps->mask[1], maps->mask[2], maps->proto, objects, masks, assigned };

    return lt_apply(&mask_op, NULL, 0, in, INPUTS);
}
