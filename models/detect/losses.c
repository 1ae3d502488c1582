/* SPDX-License-Identifier: Apache-2.0 */
/*
 * detect_class_loss: y = sum over cells and classes of softplus(x) - t x, over the sum of scores
 *   x (B, classes, H, W) of each level      dx += dy (sigmoid(x) - t) / scores
 * detect_box_loss: y0 = sum of t (1 - CIoU), y1 = sum of t times the mean over the sides of
 *   -(1 - r) log q_k - r log q_(k + 1), both over the sum of scores, with q the softmax of a side's bins, of which the
 *   box of the CIoU takes the mean, and k + r the distance that it should have, cut off at 14.99
 *   x (B, 64, H, W) of each level       dx_i += -dy0 t dCIoU/dd q_i (i - d) + dy1 t (q_i - target_i) / 4, over scores
 *
 * t is the score that a cell is assigned, at its object's class. The sums are an image's first, then added in order.
 */
#include "models/detect/losses.h"

#include "libtensor/base/parallel.h"
#include "models/detect/counts.h"

#include <math.h>

enum { MAPS = 0, OBJECTS = DETECT_LEVELS, ASSIGNED, INPUTS };

static int64_t images_of(const lt_call *c)
{
    return lt_dim(c->in[MAPS], 0);
}

static lt_status check_rest(lt_call *c)
{
    if (lt_want_rank(c, OBJECTS, "objects", 3))
        return LT_ESHAPE;
    if (lt_want_shape(c, OBJECTS, "objects", LT_SHAPE(images_of(c), lt_dim(c->in[OBJECTS], 1), OBJECT_NUMBERS)))
        return LT_ESHAPE;
    return lt_want_shape(c, ASSIGNED, "assigned", LT_SHAPE(images_of(c), cells_of(c), ASSIGNED_NUMBERS));
}

static void share(const lt_call *c)
{
    counts_share(c, OBJECTS, ASSIGNED);
}

static void share_nothing(const lt_call *c)
{
    (void)c;
}

static lt_tensor *apply(const lt_op *op, lt_tensor *const *maps, lt_tensor *objects, lt_tensor *assigned)
{
    lt_tensor *in[INPUTS] = { maps[0], maps[1], maps[2], objects, assigned };

    return lt_apply(op, NULL, 0, in, INPUTS);
}

/* ---- classes ---- */

static lt_status class_infer(lt_call *c)
{
    c->out->shape = (lt_shape){ 0 };
    return cells_check(c, "classes", 0) ? LT_ESHAPE : check_rest(c);
}

static void class_plan(lt_call *c)
{
    counts_plan(c, images_of(c), 1);
}

/* Where in image b of its level's map a cell's own class is; -1: no object is assigned */
static int64_t own_class(const lt_call *c, int64_t b, int64_t i, const cell *at)
{
    const lt_real *t = assigned_at(c->in[ASSIGNED], b, i);

    if (t[ASSIGNED_OBJECT] < 0)
        return -1;
    return (int64_t)object_at(c->in[OBJECTS], b, (int64_t)t[ASSIGNED_OBJECT])[OBJECT_CLASS] * at->plane + at->at;
}

static const lt_real *map_of(const lt_call *c, int level, int64_t b)
{
    return (const lt_real *)c->in[level]->data + b * (lt_numel(c->in[level]) / images_of(c));
}

static void class_image(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    double sum = 0;

    for (int level = 0; level < DETECT_LEVELS; level++) {
        const lt_real *x = map_of(c, level, b);

        for (int64_t i = 0; i < lt_numel(c->in[level]) / images_of(c); i++)
            sum += fmax((double)x[i], 0) + log1p(exp(-fabs((double)x[i])));
    }
    for (int64_t i = 0; i < cells_of(c); i++) {
        const cell at = cell_at(c, i);
        const int64_t own = own_class(c, b, i, &at);

        if (own >= 0)
            sum -= (double)assigned_at(c->in[ASSIGNED], b, i)[ASSIGNED_SCORE] * (double)map_of(c, at.level, b)[own];
    }
    ((double *)c->work)[b] = sum;
}

static void class_forward(const lt_call *c)
{
    const counts n = counts_of(c, OBJECTS, ASSIGNED);
    double sum = 0;

    lt_parallel_for(images_of(c), class_image, (void *)c);
    for (int64_t b = 0; b < images_of(c); b++)
        sum += ((const double *)c->work)[b];
    *(lt_real *)c->out->data = (lt_real)(sum / n.scores * counts_parts(c));
}

static void class_grad_image(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    const double f = *c->dout / counts_saved(c).scores * counts_parts(c);

    for (int level = 0; level < DETECT_LEVELS; level++) {
        const int64_t n = lt_numel(c->in[level]) / images_of(c);
        const lt_real *x = map_of(c, level, b);

        for (int64_t i = 0; c->din[level] && i < n; i++)
            c->din[level][b * n + i] += (lt_real)(f / (1 + exp(-(double)x[i])));
    }
    for (int64_t i = 0; i < cells_of(c); i++) {
        const cell at = cell_at(c, i);
        const int64_t own = own_class(c, b, i, &at);

        if (own >= 0 && c->din[at.level])
            c->din[at.level][b * (lt_numel(c->in[at.level]) / images_of(c)) + own] -=
                (lt_real)(f * (double)assigned_at(c->in[ASSIGNED], b, i)[ASSIGNED_SCORE]);
    }
}

static void class_backward(const lt_call *c)
{
    lt_parallel_for(images_of(c), class_grad_image, (void *)c);
}

static const lt_op class_op = {
    .name = "detect_class_loss", .infer = class_infer, .plan = class_plan, .forward = class_forward,
    .backward = class_backward, .forward_share = share, .backward_share = share_nothing,
};

lt_tensor *(detect_class_loss)(const detect_maps *maps, lt_tensor *objects, lt_tensor *assigned)
{
    return apply(&class_op, maps->cls, objects, assigned);
}

/* ---- boxes ---- */

enum { IOU, SIDES, BOX_LOSSES };

static lt_status box_infer(lt_call *c)
{
    c->outs[IOU]->shape = c->outs[SIDES]->shape = (lt_shape){ 0 };
    return cells_check(c, "boxes", DETECT_SIDES * DETECT_BINS) ? LT_ESHAPE : check_rest(c);
}

static void box_plan(lt_call *c)
{
    counts_plan(c, images_of(c), BOX_LOSSES);
}

/* A cell with an object: its box, and the object's */
typedef struct {
    cell at;
    double score, alpha;
    ciou_box seen, truth;
    double q[DETECT_SIDES * DETECT_BINS];
} box_pair;

static bool box_pair_at(const lt_call *c, int64_t b, int64_t i, box_pair *out)
{
    const lt_real *t = assigned_at(c->in[ASSIGNED], b, i);

    if (t[ASSIGNED_OBJECT] < 0)
        return false;
    out->at = cell_at(c, i);
    out->score = (double)t[ASSIGNED_SCORE];
    out->alpha = (double)t[ASSIGNED_ALPHA];
    out->seen = cell_box(&out->at, cell_values(c, b, &out->at), out->q);
    out->truth = object_box(object_at(c->in[OBJECTS], b, (int64_t)t[ASSIGNED_OBJECT]), out->at.stride);
    return true;
}

/* How far side s of the truth is from the cell's centre: bin + rest */
typedef struct { int bin; double rest; } side_target;

static side_target target_of(const box_pair *p, int s)
{
    const double centre = s % 2 ? p->at.y : p->at.x;
    const double d = s < 2 ? centre - p->truth.v[s] : p->truth.v[s] - centre;
    const double cut = fmin(fmax(d, 0), DETECT_BINS - 1 - 0.01);

    return (side_target){ (int)cut, cut - (int)cut };
}

static void box_image(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    double *sum = (double *)c->work + BOX_LOSSES * b;
    box_pair p;

    sum[IOU] = sum[SIDES] = 0;
    for (int64_t i = 0; i < cells_of(c); i++) {
        if (!box_pair_at(c, b, i, &p))
            continue;
        sum[IOU] += p.score * (1 - ciou_with(&p.seen, &p.truth, p.alpha, NULL));
        for (int s = 0; s < DETECT_SIDES; s++) {
            const side_target t = target_of(&p, s);
            const double *q = p.q + s * DETECT_BINS + t.bin;

            sum[SIDES] -= p.score / DETECT_SIDES * ((1 - t.rest) * log(fmax(q[0], 1e-300))
                                                    + t.rest * log(fmax(q[1], 1e-300)));
        }
    }
}

static void box_forward(const lt_call *c)
{
    const counts n = counts_of(c, OBJECTS, ASSIGNED);

    lt_parallel_for(images_of(c), box_image, (void *)c);
    for (int k = 0; k < BOX_LOSSES; k++) {
        double sum = 0;

        for (int64_t b = 0; b < images_of(c); b++)
            sum += ((const double *)c->work)[BOX_LOSSES * b + k];
        *(lt_real *)c->outs[k]->data = (lt_real)(sum / n.scores * counts_parts(c));
    }
}

/* A side's 16 bins: diou, the slope of the CIoU along it, outwards */
static void side_grad(const box_pair *p, int s, double diou, double f_iou, double f_sides, lt_real *dx)
{
    const double *q = p->q + s * DETECT_BINS;
    const side_target t = target_of(p, s);
    double d = 0;

    for (int k = 0; k < DETECT_BINS; k++)
        d += k * q[k];
    for (int k = 0; k < DETECT_BINS; k++) {
        const double want = k == t.bin ? 1 - t.rest : k == t.bin + 1 ? t.rest : 0;

        dx[k * p->at.plane] += (lt_real)(-f_iou * diou * q[k] * (k - d) + f_sides / DETECT_SIDES * (q[k] - want));
    }
}

static void box_grad_image(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    const double f = counts_parts(c) / counts_saved(c).scores;
    const double dout[BOX_LOSSES] = { c->douts[IOU] ? (double)*c->douts[IOU] : 0,
                                      c->douts[SIDES] ? (double)*c->douts[SIDES] : 0 };
    box_pair p;

    for (int64_t i = 0; i < cells_of(c); i++) {
        double slope[4];
        lt_real *dx;

        if (!box_pair_at(c, b, i, &p) || !c->din[p.at.level])
            continue;
        ciou_with(&p.seen, &p.truth, p.alpha, slope);
        dx = c->din[p.at.level] + b * DETECT_SIDES * DETECT_BINS * p.at.plane + p.at.at;
        for (int s = 0; s < DETECT_SIDES; s++)
            side_grad(&p, s, s < 2 ? -slope[s] : slope[s], f * p.score * dout[IOU], f * p.score * dout[SIDES],
                      dx + s * DETECT_BINS * p.at.plane);
    }
}

static void box_backward(const lt_call *c)
{
    lt_parallel_for(images_of(c), box_grad_image, (void *)c);
}

static const lt_op box_op = {
    .name = "detect_box_loss", .n_out = BOX_LOSSES, .infer = box_infer, .plan = box_plan, .forward = box_forward,
    .backward = box_backward, .forward_share = share, .backward_share = share_nothing,
};

lt_tensor *(detect_box_loss)(const detect_maps *maps, lt_tensor *objects, lt_tensor *assigned)
{
    return apply(&box_op, maps->box, objects, assigned);
}
