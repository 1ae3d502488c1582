/* SPDX-License-Identifier: Apache-2.0 */
/* A finding's mask in runs, without the picture around it. */
#include "vision/detection/detection.h"

#include "libtensor/io/image/coco_rle.h"

typedef struct {
    lt_arena *arena;
    int64_t *run;                   /* n lengths: of zeros, of ones, of zeros ... */
    size_t n, room;
    int64_t end;                    /* the pixel behind the last run */
} runs;

static bool add(runs *r, int64_t length)
{
    r->run = lt_arena_grow(r->arena, r->run, r->n, &r->room, sizeof(*r->run));
    if (r->run)
        r->run[r->n++] = length;
    return r->run;
}

/* Ones from pixel `from` on, which may continue the last ones */
static bool add_ones(runs *r, int64_t from, int64_t length)
{
    bool ok = true;

    if (r->n && from == r->end)
        r->run[r->n - 1] += length;
    else
        ok = add(r, from - r->end) && add(r, length);
    r->end = from + length;
    return ok;
}

const char *detection_runs(lt_arena *arena, const detection_pixels *p, int width, int height)
{
    const int64_t all = (int64_t)width * height;
    runs r = { .arena = arena };
    bool ok = true;

    for (int x = p->x0; x < p->x1 && p->pixel; x++)
        for (int y = p->y0, from = y; y <= p->y1; y++)
            if (y == p->y1 || !p->pixel[(size_t)(y - p->y0) * (size_t)(p->x1 - p->x0) + (size_t)(x - p->x0)]) {
                ok = ok && (from == y || add_ones(&r, (int64_t)x * height + from, y - from));
                from = y + 1;
            }
    if (ok && (r.end < all || !r.n))
        ok = add(&r, all - r.end);
    return ok ? lt_rle_of_runs(arena, r.run, r.n) : NULL;
}
