/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/detection/found.h"

#include "models/detect/csp_seg.h"

/* Image i of an output */
static const float *output(const compiled *c, int k, int i)
{
    const lt_tensor *t = model_port_find(&c->record.outputs, csp_seg_output[k]);

    return (const float *)lt_plan_data(c->plan, t) + (int64_t)i * (lt_numel(t) / lt_dim(t, 0));
}

static detection_maps maps_of(const compiled *c, const model *m, int i)
{
    const csp_seg_config *config = csp_seg_config_of(m);
    detection_maps maps = { .size = config->image_size, .classes = config->classes };

    for (int k = 0; k < DETECTION_LEVELS; k++) {
        maps.box[k] = output(c, k, i);
        maps.cls[k] = output(c, DETECTION_LEVELS + k, i);
        maps.mask[k] = output(c, 2 * DETECTION_LEVELS + k, i);
    }
    maps.proto = output(c, 3 * DETECTION_LEVELS, i);
    return maps;
}

lt_status detect_found_in(const compiled *c, const model *m, int i, int width, int height, const detection_rules *rules,
                          lt_arena *arena, detect_found **out, int *n)
{
    const detection_maps maps = maps_of(c, m, i);
    const letterbox l = letterbox_of(width, height, maps.size);
    detection_pixels *pixels;
    detection *found;
    lt_status st = detection_find(arena, &maps, rules, &found, n);

    if (st)
        return st;
    *out = lt_arena_array(arena, (size_t)*n + 1, sizeof(**out));
    pixels = lt_arena_array(arena, (size_t)*n + 1, sizeof(*pixels));
    if (!*out || !pixels)
        return lt_error(LT_ENOMEM, "no memory for what a detector found");
    st = detection_pixels_of(arena, &maps, found, *n, &l, width, height, pixels);
    for (int k = 0; k < *n && st == LT_OK; k++) {
        (*out)[k] = (detect_found){ .cls = found[k].cls, .score = (double)found[k].score, .window = pixels[k] };
        letterbox_back(&l, width, height, found[k].box, (*out)[k].box);
    }
    return st;
}
