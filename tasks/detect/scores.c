/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/detect/scores.h"

#include "eval/metrics/ap.h"

#include <math.h>
#include <string.h>

const char *const detect_metrics[DETECT_METRICS + 1] = {
    "map50_95_box", "map50_box", "map50_95_mask", "map50_mask", "ap50_hand", "ap50_small", "ap50_medium", "ap50_large",
    NULL,
};

/* ---- what is kept of an image ---- */

/* A record is a head, n_found findings, n_truth objects, and twice n_found * n_truth overlaps: of boxes, of masks. */
typedef struct { int32_t n_found, n_truth; } head;
typedef struct { int32_t cls; float score, box_area, mask_area; } kept_found;
typedef struct { int32_t cls; float area; int32_t crowd; } kept_truth;

typedef struct {
    head head;
    kept_found *found;
    kept_truth *truth;
    float *box_iou, *mask_iou;
} kept;

static size_t kept_bytes(head h)
{
    const size_t f = (size_t)h.n_found, t = (size_t)h.n_truth;

    return sizeof(h) + f * sizeof(kept_found) + t * sizeof(kept_truth) + 2 * f * t * sizeof(float);
}

/* bytes begin with the head. */
static kept kept_in(void *bytes)
{
    kept k;

    memcpy(&k.head, bytes, sizeof(k.head));
    k.found = (kept_found *)((char *)bytes + sizeof(k.head));
    k.truth = (kept_truth *)(k.found + k.head.n_found);
    k.box_iou = (float *)(k.truth + k.head.n_truth);
    k.mask_iou = k.box_iou + (size_t)k.head.n_found * (size_t)k.head.n_truth;
    return k;
}

static double box_area(const float b[4])
{
    return (double)(b[2] - b[0]) * (double)(b[3] - b[1]);
}

static double pixels_in(const detection_pixels *p)
{
    const size_t n = p->pixel ? (size_t)(p->x1 - p->x0) * (size_t)(p->y1 - p->y0) : 0;
    double sum = 0;

    for (size_t i = 0; i < n; i++)
        sum += p->pixel[i];
    return sum;
}

/* Of a crowd all that it covers of what was found is right. */
static float overlap(double both, double found, double truth, bool crowd)
{
    const double all = crowd ? found : found + truth - both;

    return (float)(all > 0 ? both / all : 0);
}

static double both_boxes(const float a[4], const float b[4])
{
    const double w = (double)fminf(a[2], b[2]) - (double)fmaxf(a[0], b[0]);
    const double h = (double)fminf(a[3], b[3]) - (double)fmaxf(a[1], b[1]);

    return w > 0 && h > 0 ? w * h : 0;
}

static double both_masks(const detection_pixels *p, const uint8_t *mask, int width)
{
    int64_t sum = 0;

    for (int y = p->y0; p->pixel && y < p->y1; y++) {
        const uint8_t *a = p->pixel + (size_t)(y - p->y0) * (size_t)(p->x1 - p->x0);
        const uint8_t *b = mask + (size_t)y * (size_t)width + p->x0;

        for (int x = 0; x < p->x1 - p->x0; x++)
            sum += a[x] & b[x];
    }
    return (double)sum;
}

/* All findings beside object k, whose mask is there */
static void compare(const detect_found *found, const detection_object *o, int k, const uint8_t *mask, int width,
                    int height, const kept *to)
{
    double pixels = 0;

    for (size_t i = 0; i < (size_t)width * (size_t)height; i++)
        pixels += mask[i];
    for (int i = 0; i < to->head.n_found; i++) {
        const size_t at = (size_t)i * (size_t)to->head.n_truth + (size_t)k;
        const detect_found *f = &found[i];

        if (f->cls != o->cls)
            continue;
        to->box_iou[at] = overlap(both_boxes(f->box, o->box), box_area(f->box), box_area(o->box), o->crowd);
        to->mask_iou[at] = overlap(both_masks(&f->window, mask, width), pixels_in(&f->window), pixels, o->crowd);
    }
}

lt_status detect_record(const detection_set *set, int64_t i, int width, int height, const detect_found *found, int n,
                        records *out)
{
    const head h = { n, set->image[i].n };
    const double longer = width > height ? width : height, at640 = (640 / longer) * (640 / longer);
    lt_arena *scratch = lt_arena_new();
    void *bytes = scratch ? lt_arena_alloc(scratch, kept_bytes(h)) : NULL;
    uint8_t *mask = bytes ? lt_arena_array(scratch, (size_t)width * (size_t)height, 1) : NULL;
    const detection_object *object;
    lt_status st = mask ? detection_objects(set, i, width, height, scratch, &object)
                        : lt_error(LT_ENOMEM, "no memory to score an image");
    kept k;

    if (st)
        goto done;
    memcpy(bytes, &h, sizeof(h));
    k = kept_in(bytes);
    for (int f = 0; f < n; f++)
        k.found[f] = (kept_found){ found[f].cls, (float)found[f].score, (float)(at640 * box_area(found[f].box)),
                                   (float)(at640 * pixels_in(&found[f].window)) };
    for (int t = 0; t < h.n_truth && st == LT_OK; t++) {
        k.truth[t] = (kept_truth){ object[t].cls, (float)(at640 * object[t].area), object[t].crowd };
        st = detection_mask(&object[t], width, height, mask);
        if (st == LT_OK)
            compare(found, &object[t], t, mask, width, height, &k);
    }
    if (st == LT_OK)
        st = records_add(out, i, bytes, kept_bytes(h));
done:
    lt_arena_free(scratch);
    return st;
}

/* ---- over all images ---- */

typedef struct { ap_image *box, *mask; } images;

static lt_status image_of(lt_arena *arena, const records *all, int64_t i, images *out)
{
    size_t bytes;
    const void *record = records_at(all, i, &bytes);
    void *copy = lt_arena_alloc(arena, bytes);
    ap_found *box, *mask;
    ap_truth *truth;
    kept k;

    if (!copy)
        return LT_ENOMEM;
    memcpy(copy, record, bytes);
    k = kept_in(copy);
    box = lt_arena_array(arena, (size_t)k.head.n_found + 1, sizeof(*box));
    mask = lt_arena_array(arena, (size_t)k.head.n_found + 1, sizeof(*mask));
    truth = lt_arena_array(arena, (size_t)k.head.n_truth + 1, sizeof(*truth));
    if (!box || !mask || !truth)
        return LT_ENOMEM;
    for (int f = 0; f < k.head.n_found; f++) {
        box[f] = (ap_found){ k.found[f].cls, (double)k.found[f].score, (double)k.found[f].box_area };
        mask[f] = (ap_found){ k.found[f].cls, (double)k.found[f].score, (double)k.found[f].mask_area };
    }
    for (int t = 0; t < k.head.n_truth; t++)
        truth[t] = (ap_truth){ k.truth[t].cls, (double)k.truth[t].area, k.truth[t].crowd };
    out->box[i] = (ap_image){ box, truth, k.head.n_found, k.head.n_truth, k.box_iou };
    out->mask[i] = (ap_image){ mask, truth, k.head.n_found, k.head.n_truth, k.mask_iou };
    return LT_OK;
}

static int class_named(const detection_set *set, const char *name)
{
    for (int c = 0; c < set->classes; c++)
        if (set->class_name[c] && strcmp(set->class_name[c], name) == 0)
            return c;
    return -1;
}

static lt_status fill(const detection_set *set, const images *of, int64_t n, double *ap, double out[DETECT_METRICS])
{
    static const ap_range any = { 0, 1e10 }, sizes[] = { { 0, 32 * 32 }, { 32 * 32, 96 * 96 }, { 96 * 96, 1e10 } };
    const int hand = class_named(set, "hand");
    lt_status st = ap_measure(of->box, n, set->classes, any, ap);

    if (st)
        return st;
    out[0] = ap_mean(ap, 0, set->classes, AP_THRESHOLDS);
    out[1] = ap_mean(ap, 0, set->classes, 1);
    out[4] = hand < 0 ? NAN : ap_mean(ap, hand, hand + 1, 1);
    st = ap_measure(of->mask, n, set->classes, any, ap);
    if (st)
        return st;
    out[2] = set->masks ? ap_mean(ap, 0, set->classes, AP_THRESHOLDS) : NAN;
    out[3] = set->masks ? ap_mean(ap, 0, set->classes, 1) : NAN;
    for (int k = 0; k < 3 && st == LT_OK; k++) {
        st = ap_measure(of->box, n, set->classes, sizes[k], ap);
        out[5 + k] = st ? NAN : ap_mean(ap, 0, set->classes, 1);
    }
    return st;
}

lt_status detect_measure(const detection_set *set, const records *all, double out[DETECT_METRICS])
{
    lt_arena *arena = lt_arena_new();
    images of = { NULL, NULL };
    double *ap = NULL;
    lt_status st = arena ? LT_OK : LT_ENOMEM;

    for (int k = 0; k < DETECT_METRICS; k++)
        out[k] = NAN;
    if (st == LT_OK) {
        of.box = lt_arena_array(arena, (size_t)all->n + 1, sizeof(*of.box));
        of.mask = lt_arena_array(arena, (size_t)all->n + 1, sizeof(*of.mask));
        ap = lt_arena_array(arena, (size_t)set->classes * AP_THRESHOLDS, sizeof(*ap));
        st = of.box && of.mask && ap ? LT_OK : LT_ENOMEM;
    }
    for (int64_t i = 0; i < all->n && st == LT_OK; i++)
        st = image_of(arena, all, i, &of);
    if (st == LT_OK)
        st = fill(set, &of, all->n, ap, out);
    lt_arena_free(arena);
    return st ? lt_error(LT_ENOMEM, "no memory to score %s", set->root) : LT_OK;
}
