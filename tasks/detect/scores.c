/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/detect/scores.h"

#include "eval/metrics/ap.h"
#include "tasks/detect/kept.h"

#include <math.h>
#include <string.h>

const char *const detect_metrics[DETECT_METRICS + 1] = {
    "map50_95_box", "map50_box", "map50_95_mask", "map50_mask", "ap50_hand", "ap50_small", "ap50_medium", "ap50_large",
    NULL,
};

/* ---- over all images ---- */

static lt_status image_of(lt_arena *arena, const records *all, int64_t i, detect_images *out)
{
    ap_found *box, *mask;
    ap_truth *truth;
    kept k;

    if (kept_read(arena, all, i, &k))
        return LT_ENOMEM;
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

static lt_status fill(const detection_set *set, const detect_images *of, int64_t n, double *ap,
                      double out[DETECT_METRICS])
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

lt_status detect_images_of(lt_arena *arena, const records *all, detect_images *out)
{
    lt_status st = LT_OK;

    out->box = lt_arena_array(arena, (size_t)all->n, sizeof(*out->box));
    out->mask = lt_arena_array(arena, (size_t)all->n, sizeof(*out->mask));
    if (!out->box || !out->mask)
        st = LT_ENOMEM;
    for (int64_t i = 0; i < all->n && st == LT_OK; i++)
        st = image_of(arena, all, i, out);
    return st ? lt_error(LT_ENOMEM, "no memory to score") : LT_OK;
}

lt_status detect_measure(const detection_set *set, const records *all, double out[DETECT_METRICS])
{
    lt_arena *arena = lt_arena_new();
    double *ap = arena ? lt_arena_array(arena, (size_t)set->classes * AP_THRESHOLDS, sizeof(*ap)) : NULL;
    detect_images of;
    lt_status st = ap ? detect_images_of(arena, all, &of) : LT_ENOMEM;

    for (int k = 0; k < DETECT_METRICS; k++)
        out[k] = NAN;
    if (st == LT_OK)
        st = fill(set, &of, all->n, ap, out);
    lt_arena_free(arena);
    return st ? lt_error(LT_ENOMEM, "no memory to score %s", set->root) : LT_OK;
}
