/* SPDX-License-Identifier: Apache-2.0 */
/* box_region: the rows and columns of a map that roi_align reads for any of the boxes.
 *   boxes (R, 5), as roi_align has them, several times   ->   y (B, 4): y0, y1, x0, x1, ends exclusive
 *
 * One rectangle for each image, empty where no box is; no gradient.
 */
#include "libtensor/ops/common.h"

typedef struct {
    int64_t B, H, W;
    double scale;
    int margin;
} region_attr;

static lt_status infer(lt_call *c)
{
    const region_attr *a = c->attr;
    char text[LT_SHAPE_TEXT];

    for (int i = 0; i < c->n_in; i++)
        if (lt_want_rank(c, i, "boxes", 2))
            return LT_ESHAPE;
        else if (lt_dim(c->in[i], 1) != 5)
            return lt_fail(c, "boxes are %s, want (R, 5)", lt_shape_text(&c->in[i]->shape, text));
    if (a->B < 0 || a->H < 1 || a->W < 1 || a->margin < 0 || !(a->scale > 0) || isinf(a->scale))
        return lt_fail(c, "%lld maps of %lld x %lld, scale %g, margin %d: want none below 0, and sizes and a "
                       "scale above 0", (long long)a->B, (long long)a->H, (long long)a->W, a->scale, a->margin);
    c->out->shape = LT_SHAPE(a->B, 4);
    return LT_OK;
}

/* First and last place read along one axis: a sample stands between two cells, borders repeat, and a box
 * has at least the extent of a cell. One cell more on both sides is for rounding. */
static void reach(lt_real range[2], double from, double to, double scale, int64_t n, int margin)
{
    const double lo = floor(from * scale) - 1 - margin, hi = floor(fmax(to * scale, from * scale + 1)) + 2 + margin;
    const double first = fmin(fmax(lo, 0), (double)(n - 1)), last = fmin(fmax(hi, 0), (double)(n - 1));
    const bool empty = !(range[0] < range[1]);

    range[0] = (lt_real)(empty ? first : fmin(first, range[0]));
    range[1] = (lt_real)(empty ? last + 1 : fmax(last + 1, range[1]));
}

static void add_box(const region_attr *a, const lt_real *box, lt_real *y)
{
    const double image = floor((double)box[0]);

    for (int i = 0; i < 5; i++)
        if (!isfinite(box[i]))
            return;
    if (image < 0 || image >= (double)a->B)
        return;
    y += 4 * (int64_t)image;
    reach(y, box[2], box[4], a->scale, a->H, a->margin);
    reach(y + 2, box[1], box[3], a->scale, a->W, a->margin);
}

static void forward(const lt_call *c)
{
    const region_attr *a = c->attr;

    memset(c->out->data, 0, (size_t)lt_numel(c->out) * sizeof(lt_real));
    for (int i = 0; i < c->n_in; i++)
        for (int64_t r = 0; r < lt_dim(c->in[i], 0); r++)
            add_box(a, (const lt_real *)c->in[i]->data + 5 * r, c->out->data);
}

static const lt_op box_region_op = { .name = "box_region", .flags = LT_OP_DETACH, .infer = infer, .forward = forward };

lt_tensor *(lt_box_region)(lt_tensor *const *boxes, int n, int64_t B, int64_t H, int64_t W, double scale, int margin)
{
    const region_attr a = { B, H, W, scale, margin };

    return lt_apply(&box_region_op, &a, sizeof(a), boxes, n);
}
