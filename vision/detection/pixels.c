/* SPDX-License-Identifier: Apache-2.0 */
/* Masks of what a detector found, each inside its box. */
#include "vision/detection/detection.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/kernels.h"

#include <math.h>
#include <string.h>

enum { STRIDE = 4 };

/* The cells of the prototypes around a window of the picture, and their sigmoids */
typedef struct {
    int x0, y0, w, h;
    float *value;                   /* (h, w) */
} region;

typedef struct {
    const detection_maps *maps;
    const detection *found;
    const letterbox *l;
    detection_pixels *out;
    region *region;
    float **row;                    /* of each finding: two rows of its region mixed, and places along it */
} job;

static int between(double x, int lo, int hi)
{
    return x <= lo ? lo : x >= hi ? hi : (int)x;
}

/* The place of the picture's pixel among the prototypes' cells, whose first centre is 0 */
static double place(const letterbox *l, double shift, int pixel)
{
    return ((pixel + 0.5) * l->scale + shift) / STRIDE - 0.5;
}

static region region_of(const job *j, const detection_pixels *p)
{
    const int side = j->maps->size / STRIDE;
    const int x0 = between(floor(place(j->l, j->l->left, p->x0)), 0, side - 1);
    const int y0 = between(floor(place(j->l, j->l->top, p->y0)), 0, side - 1);
    const int x1 = between(floor(place(j->l, j->l->left, p->x1 - 1)) + 1, x0, side - 1);
    const int y1 = between(floor(place(j->l, j->l->top, p->y1 - 1)) + 1, y0, side - 1);

    return (region){ .x0 = x0, .y0 = y0, .w = x1 - x0 + 1, .h = y1 - y0 + 1 };
}

static void fill_region(const detection_maps *m, const float *coefficient, const region *r)
{
    const int64_t side = m->size / STRIDE, n = (int64_t)r->w * r->h;

    memset(r->value, 0, (size_t)n * sizeof(*r->value));
    for (int y = 0; y < r->h; y++)
        for (int k = 0; k < DETECTION_COEFFICIENTS; k++) {
            const float *from = m->proto + (k * side + r->y0 + y) * side + r->x0;
            float *to = r->value + (int64_t)y * r->w, c = coefficient[k];

            for (int x = 0; x < r->w; x++)
                to[x] += c * from[x];
        }
    for (int64_t i = 0; i < n; i++)
        r->value[i] = 1 / (1 + expf(-r->value[i]));
}

/* Between cell `at` and the next: the share of the next */
typedef struct { int at; float share; } mix;

static mix mix_at(double place, int first, int n)
{
    const double at = fmin(fmax(place - first, 0), n - 1);
    const int low = at >= n - 1 ? (n > 1 ? n - 2 : 0) : (int)at;

    return (mix){ low, (float)(at - low) };
}

static void draw(void *ctx, int64_t i)
{
    const job *j = ctx;
    const region *r = &j->region[i];
    const detection_pixels *p = &j->out[i];
    const int w = p->x1 - p->x0, more_x = r->w > 1, more_y = r->h > 1;
    float *row = j->row[i];
    mix *column = (mix *)(row + r->w);

    if (!p->pixel)
        return;
    fill_region(j->maps, j->found[i].coefficient, r);
    for (int x = 0; x < w; x++)
        column[x] = mix_at(place(j->l, j->l->left, p->x0 + x), r->x0, r->w);
    for (int y = 0; y < p->y1 - p->y0; y++) {
        const mix v = mix_at(place(j->l, j->l->top, p->y0 + y), r->y0, r->h);
        const float *a = r->value + (int64_t)v.at * r->w, *b = a + more_y * r->w;
        uint8_t *to = p->pixel + (int64_t)y * w;

        for (int x = 0; x < r->w; x++)
            row[x] = a[x] + v.share * (b[x] - a[x]);
        for (int x = 0; x < w; x++) {
            const float *c = row + column[x].at;

            to[x] = c[0] + column[x].share * (c[more_x] - c[0]) > 0.5f;
        }
    }
}

/* The picture's pixels whose centres lie in a box; none where that is empty */
static detection_pixels window_of(const letterbox *l, const float *box, int width, int height)
{
    float b[4];
    detection_pixels p;

    letterbox_back(l, width, height, box, b);
    p = (detection_pixels){ between(ceil((double)b[0] - 0.5), 0, width), between(ceil((double)b[1] - 0.5), 0, height),
                            between(ceil((double)b[2] - 0.5), 0, width), between(ceil((double)b[3] - 0.5), 0, height),
                            NULL };
    if (p.x1 <= p.x0 || p.y1 <= p.y0)
        p.x1 = p.x0, p.y1 = p.y0;
    return p;
}

static bool reserve(lt_arena *arena, const job *j, int i)
{
    detection_pixels *p = &j->out[i];
    const size_t w = (size_t)(p->x1 - p->x0), h = (size_t)(p->y1 - p->y0);
    region *r = &j->region[i];

    if (!w)
        return true;
    *r = region_of(j, p);
    r->value = lt_arena_array(arena, (size_t)r->w * (size_t)r->h, sizeof(*r->value));
    j->row[i] = lt_arena_alloc(arena, (size_t)r->w * sizeof(float) + w * sizeof(mix));
    p->pixel = lt_arena_array(arena, w * h, 1);
    return r->value && j->row[i] && p->pixel;
}

lt_status detection_pixels_of(lt_arena *arena, const detection_maps *maps, const detection *found, int n,
                              const letterbox *l, int width, int height, detection_pixels *out)
{
    job j = { .maps = maps, .found = found, .l = l, .out = out,
              .region = lt_arena_array(arena, (size_t)n + 1, sizeof(*j.region)),
              .row = lt_arena_array(arena, (size_t)n + 1, sizeof(*j.row)) };

    for (int i = 0; i < n; i++)
        out[i] = window_of(l, found[i].box, width, height);
    for (int i = 0; i < n; i++)
        if (!j.region || !j.row || !reserve(arena, &j, i))
            return lt_error(LT_ENOMEM, "no memory for the masks of what a detector found");
    lt_parallel_for(n, draw, &j);
    return LT_OK;
}
