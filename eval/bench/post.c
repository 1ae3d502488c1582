/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/bench/post.h"

#include "libtensor/base/clock.h"
#include "libtensor/base/order.h"
#include "libtensor/base/rng.h"
#include "models/detect/csp_seg.h"
#include "vision/detection/detection.h"

#include <stdlib.h>

enum { RUNS = 50, WARM_UP = 5, ACROSS = 6 };

/* Maps that nothing is found in */
static bool blank(lt_arena *arena, detection_maps *m, lt_rng *r)
{
    const int64_t side = m->size / 4;
    float *proto = lt_arena_array(arena, (size_t)(32 * side * side), sizeof(*proto));

    for (int l = 0; l < DETECTION_LEVELS; l++) {
        const int64_t n = (m->size / (8 << l)) * (m->size / (8 << l));
        float *cls = lt_arena_array(arena, (size_t)(m->classes * n), sizeof(*cls));
        float *mask = lt_arena_array(arena, (size_t)(32 * n), sizeof(*mask));

        m->box[l] = lt_arena_array(arena, (size_t)(64 * n), sizeof(float));
        m->cls[l] = cls;
        m->mask[l] = mask;
        if (!cls || !mask || !m->box[l])
            return false;
        for (int64_t i = 0; i < m->classes * n; i++)
            cls[i] = (float)lt_rng_range(r, -9, -4);
        for (int64_t i = 0; i < 32 * n; i++)
            mask[i] = (float)lt_rng_range(r, -1, 1);
    }
    m->proto = proto;
    for (int64_t i = 0; proto && i < 32 * side * side; i++)
        proto[i] = (float)lt_rng_range(r, -1, 1);
    return proto != NULL;
}

/* Object k of a lattice of 6 x 5, found by the 3 x 3 cells of its level around its middle; box and cls are ours. */
static void plant(const detection_maps *m, int k)
{
    const int level = k % DETECTION_LEVELS, side = m->size / (8 << level), plane = side * side;
    const int cx = (2 * (k % ACROSS) + 1) * side / (2 * ACROSS), cy = (2 * (k / ACROSS) + 1) * side / (2 * 5);
    const int far = 2 + k % 2;
    float *cls = (float *)m->cls[level] + k % m->classes * plane, *box = (float *)m->box[level];

    for (int i = 0; i < 9; i++) {
        const int dx = i % 3 - 1, dy = i / 3 - 1, x = cx + dx, y = cy + dy;
        const int distance[DETECTION_SIDES] = { far + dx, far + dy, far - dx, far - dy };

        if (x < 0 || y < 0 || x >= side || y >= side)
            continue;
        cls[y * side + x] = 1 + (float)i / 9;
        for (int s = 0; s < DETECTION_SIDES; s++)
            box[(s * DETECTION_BINS + distance[s]) * plane + y * side + x] = 20;
    }
}

static lt_status once(lt_arena *arena, const detection_maps *maps, int *n)
{
    const letterbox l = letterbox_of(maps->size, maps->size, maps->size);
    detection_pixels *pixels;
    detection *found;
    lt_status st;

    lt_arena_reset(arena);
    st = detection_find(arena, maps, &detection_rules_shown, &found, n);
    if (st)
        return st;
    pixels = lt_arena_array(arena, (size_t)*n + 1, sizeof(*pixels));
    return pixels ? detection_pixels_of(arena, maps, found, *n, &l, maps->size, maps->size, pixels)
                  : lt_error(LT_ENOMEM, "no memory to measure");
}

static lt_status measure(lt_arena *scratch, const detection_maps *maps, double *median_ms, int *objects)
{
    double ms[RUNS];
    lt_status st = LT_OK;

    for (int i = -WARM_UP; i < RUNS && st == LT_OK; i++) {
        const double t = lt_clock();

        st = once(scratch, maps, objects);
        if (i >= 0)
            ms[i] = 1e3 * (lt_clock() - t);
    }
    if (st == LT_OK) {
        qsort(ms, RUNS, sizeof(*ms), lt_ascending);
        *median_ms = ms[RUNS / 2];
    }
    return st;
}

lt_status bench_post(const model *m, double *median_ms, int *objects)
{
    const csp_seg_config *c = csp_seg_config_of(m);
    lt_arena *arena = lt_arena_new(), *scratch = lt_arena_new();
    lt_rng r = lt_rng_make(1, 0);
    detection_maps maps = { 0 };
    lt_status st = c ? LT_OK : lt_error(LT_EINVAL, "--post: %s finds no boxes and masks, csp_seg does", m->cls->name);

    if (c)
        maps = (detection_maps){ .size = c->image_size, .classes = c->classes };
    if (st == LT_OK && (!arena || !scratch || !blank(arena, &maps, &r)))
        st = lt_error(LT_ENOMEM, "no memory to measure");
    for (int k = 0; st == LT_OK && k < BENCH_POST_OBJECTS; k++)
        plant(&maps, k);
    if (st == LT_OK)
        st = measure(scratch, &maps, median_ms, objects);
    lt_arena_free(scratch);
    lt_arena_free(arena);
    return st;
}
