/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/detect/kept.h"

#include "tasks/detect/scores.h"

#include <math.h>
#include <string.h>

static size_t kept_bytes(kept_head h)
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

        to->box_iou[at] = overlap(both_boxes(f->box, o->box), box_area(f->box), box_area(o->box), o->crowd);
        if (f->cls != o->cls)
            continue;
        to->mask_iou[at] = overlap(both_masks(&f->window, mask, width), pixels_in(&f->window), pixels, o->crowd);
    }
}

lt_status detect_record(const detection_set *set, int64_t i, int width, int height, const detect_found *found, int n,
                        records *out)
{
    const kept_head h = { n, set->image[i].n };
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
        k.found[f] = (kept_found){
            found[f].cls, (float)found[f].score, (float)(at640 * box_area(found[f].box)),
            (float)(at640 * pixels_in(&found[f].window)),
            { found[f].box[0], found[f].box[1], found[f].box[2], found[f].box[3] },
        };
    for (int t = 0; t < h.n_truth && st == LT_OK; t++) {
        k.truth[t] = (kept_truth){ object[t].cls, (float)(at640 * object[t].area),
                                   { object[t].box[0], object[t].box[1], object[t].box[2], object[t].box[3] },
                                   object[t].crowd };
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

lt_status kept_read(lt_arena *arena, const records *all, int64_t i, kept *out)
{
    size_t bytes;
    const void *record = records_at(all, i, &bytes);
    void *copy = lt_arena_alloc(arena, bytes);

    if (!copy)
        return lt_error(LT_ENOMEM, "no memory to score an image");
    memcpy(copy, record, bytes);
    *out = kept_in(copy);
    return LT_OK;
}
