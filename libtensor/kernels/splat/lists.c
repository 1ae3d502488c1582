/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which Gaussians each tile has, near to far: Gaussians are sorted by depth once, and their instances dealt to tiles in
 * that order by counting, which leaves every list sorted.
 *
 * An instance is a tile that an ellipse meets: of each row of tiles the columns between the ellipse's leftmost and
 * rightmost places in that band [AccuTile of Hanson et al. 2025, "Speedy-Splat"].
 */
#include "libtensor/kernels/splat/lists.h"

#include "libtensor/base/parallel.h"

#include <math.h>
#include <string.h>

#ifdef LT_DOUBLE
#define SQRT sqrt
#else
#define SQRT sqrtf
#endif

enum { TILE = LT_SPLAT_TILE, MOST_PARTS = 16, PART = 512, ROOM = 8, LENGTHS = 256, LENGTH = 4 };
enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS, PASSES = 3 };

/* Rounding moves an ellipse's border by less; pixels are tested one by one in the end. */
static const lt_real slack = (lt_real)0.02;

/* ---- ellipses and tiles -------------------------------------------------------------------------------- */

/* Tiles [from, to), none where to <= from */
typedef struct { int64_t from, to; } span;

static int64_t pixel_of(lt_real x, int64_t size)
{
    return x < 0 ? 0 : x < (lt_real)size ? (int64_t)x : size;
}

/* The tiles of those that lie from `low` to `high` of a row or column of `size` pixels */
static span tiles_between(lt_real low, lt_real high, int64_t size)
{
    const int64_t first = pixel_of(low - slack + 1, size), end = pixel_of(high + slack + 1, size);

    return (span){ first / TILE, end > first ? (end - 1) / TILE + 1 : 0 };
}

static span rows_of(const lt_splat_seen *g, const lt_splat_view *view)
{
    return tiles_between(g->v - g->tall, g->v + g->tall, view->height);
}

static lt_real half_width(const lt_splat_seen *g, lt_real dy)
{
    const lt_real square = g->tall * g->tall - dy * dy;

    return g->wide * SQRT(square > 0 ? square : 0);
}

static lt_real clamp(lt_real x, lt_real low, lt_real high) { return x < low ? low : x > high ? high : x; }

/* Of one row of tiles. The border bulges: its farthest place in a band is where the tip is, or nearest to it. */
static span columns_of(const lt_splat_seen *g, const lt_splat_view *view, int64_t row)
{
    const lt_real top = (lt_real)(row * TILE) - g->v - slack, bottom = top + TILE - 1 + 2 * slack;
    const lt_real low = top > -g->tall ? top : -g->tall, high = bottom < g->tall ? bottom : g->tall;
    const lt_real tip = g->slant * g->broad, right = clamp(tip, low, high), left = clamp(-tip, low, high);

    return tiles_between(g->u + g->lean * left - half_width(g, left), g->u + g->lean * right + half_width(g, right),
                         view->width);
}

uint32_t lt_splat_covers(const lt_splat_seen *g, const lt_splat_view *view)
{
    const span rows = rows_of(g, view);
    int64_t n = 0;

    for (int64_t row = rows.from; g->tall > 0 && row < rows.to; row++) {
        const span columns = columns_of(g, view, row);

        n += lt_max_i64(0, columns.to - columns.from);
    }
    return (uint32_t)n;
}

/* The tiles of a Gaussian, lt_splat_covers of them */
static void find_tiles(uint32_t *tile, const lt_splat_seen *g, const lt_splat_view *view, int64_t across)
{
    const span rows = rows_of(g, view);

    for (int64_t row = rows.from; row < rows.to; row++) {
        const span columns = columns_of(g, view, row);

        for (int64_t i = columns.from; i < columns.to; i++)
            *tile++ = (uint32_t)(row * across + i);
    }
}

/* ---- memory -------------------------------------------------------------------------------------------- */

/* Room for n elements behind what `used` counts */
static void *take(void *memory, size_t *used, int64_t n, size_t element)
{
    void *p = memory ? (char *)memory + *used : NULL;

    *used += ((size_t)n * element + LT_ALIGN - 1) / LT_ALIGN * LT_ALIGN;
    return p;
}

/* One Gaussian has at most all tiles, so that much always fits. */
static lt_splat_lists lay_out(void *memory, int64_t n, int64_t width, int64_t height, size_t *used)
{
    const int64_t across = lt_ceil_div(width, TILE), tiles = across * lt_ceil_div(height, TILE);
    lt_splat_lists l = {
        .n = n, .across = across, .tiles = tiles, .capacity = lt_min_i64(ROOM * n + tiles, INT32_MAX),
    };

    *used = 0;
    l.covers = take(memory, used, n, sizeof(*l.covers));
    l.instance = take(memory, used, n, sizeof(*l.instance));
    l.order = take(memory, used, n, sizeof(*l.order));
    l.start = take(memory, used, tiles + 1, sizeof(*l.start));
    l.longest = take(memory, used, tiles, sizeof(*l.longest));
    l.tile_of = take(memory, used, l.capacity, sizeof(*l.tile_of));
    l.count = take(memory, used, MOST_PARTS * tiles, sizeof(*l.count));
    l.key = take(memory, used, n, sizeof(*l.key));
    l.other_key = take(memory, used, n, sizeof(*l.other_key));
    l.entry = take(memory, used, l.capacity, sizeof(*l.entry));
    return l;
}

size_t lt_splat_lists_bytes(int64_t n, int64_t width, int64_t height)
{
    size_t used;

    lay_out(NULL, n, width, height, &used);
    return used;
}

lt_splat_lists lt_splat_lists_in(void *memory, int64_t n, int64_t width, int64_t height)
{
    size_t used;

    return lay_out(memory, n, width, height, &used);
}

/* ---- by depth ------------------------------------------------------------------------------------------ */

/* z's bits as a float, which is above 0, and so in the order of integers; the number below them */
static uint64_t key_of(const lt_splat_seen *g, int64_t i)
{
    const float z = (float)g->z;
    uint32_t bits;

    memcpy(&bits, &z, sizeof(bits));
    return (uint64_t)bits << 32 | (uint32_t)i;
}

static int64_t find_keys(lt_splat_lists *l, const lt_splat_seen *seen, uint32_t count[PASSES][DIGITS])
{
    int64_t n = 0;

    memset(count, 0, PASSES * sizeof(count[0]));
    l->instances = 0;
    for (int64_t i = 0; i < l->n; i++) {
        if (!l->covers[i])
            continue;
        l->key[n] = key_of(&seen[i], i);
        for (int p = 0; p < PASSES; p++)
            count[p][l->key[n] >> (32 + p * DIGIT_BITS) & (DIGITS - 1)]++;
        l->instances += l->covers[i];
        n++;
    }
    return n;
}

/* One digit, stable: counts become places. */
static void sort_digit(uint64_t *to, const uint64_t *from, int64_t n, int shift, uint32_t count[DIGITS])
{
    uint32_t place = 0;

    for (int d = 0; d < DIGITS; d++) {
        const uint32_t many = count[d];

        count[d] = place;
        place += many;
    }
    for (int64_t i = 0; i < n; i++)
        to[count[from[i] >> shift & (DIGITS - 1)]++] = from[i];
}

/* From the lowest digit of depth up; numbers are in order from the start. */
void lt_splat_sort(lt_splat_lists *l, const lt_splat_seen *seen)
{
    uint32_t count[PASSES][DIGITS];
    uint64_t *from = l->key, *to = l->other_key;

    l->drawn = find_keys(l, seen, count);
    l->from = l->to = 0;
    for (int p = 0; p < PASSES; p++) {
        uint64_t *last = from;

        sort_digit(to, from, l->drawn, 32 + p * DIGIT_BITS, count[p]);
        from = to, to = last;
    }
    for (int64_t i = 0; i < l->drawn; i++)
        l->order[i] = (uint32_t)from[i];
}

/* ---- by tile ------------------------------------------------------------------------------------------- */

/* Parts of the order are counted and dealt by themselves; where each begins in a tile's list is known in between. */
typedef struct {
    lt_splat_lists *l;
    const lt_splat_seen *seen;
    const lt_splat_view *view;
    int64_t parts;
} dealing;

static int64_t part_at(const dealing *d, int64_t part)
{
    return d->l->from + (d->l->to - d->l->from) * part / d->parts;
}

static void count_part(void *ctx, int64_t part)
{
    const dealing *d = ctx;
    const lt_splat_lists *l = d->l;
    uint32_t *count = l->count + part * l->tiles;

    memset(count, 0, (size_t)l->tiles * sizeof(*count));
    for (int64_t i = part_at(d, part); i < part_at(d, part + 1); i++) {
        const uint32_t g = l->order[i];
        uint32_t *tile = l->tile_of + l->instance[g];

        find_tiles(tile, &d->seen[g], d->view, l->across);
        for (uint32_t k = 0; k < l->covers[g]; k++)
            count[tile[k]]++;
    }
}

static void place_parts(const dealing *d)
{
    lt_splat_lists *l = d->l;
    uint32_t place = 0;

    for (int64_t tile = 0; tile < l->tiles; tile++) {
        l->start[tile] = place;
        for (int64_t part = 0; part < d->parts; part++) {
            uint32_t *count = &l->count[part * l->tiles + tile];
            const uint32_t many = *count;

            *count = place;
            place += many;
        }
    }
    l->start[l->tiles] = place;
}

static void deal_part(void *ctx, int64_t part)
{
    const dealing *d = ctx;
    const lt_splat_lists *l = d->l;
    uint32_t *place = l->count + part * l->tiles;

    for (int64_t i = part_at(d, part); i < part_at(d, part + 1); i++) {
        const uint32_t g = l->order[i], first = l->instance[g];

        for (uint32_t k = first; k < first + l->covers[g]; k++)
            l->entry[place[l->tile_of[k]]++] = (lt_splat_entry){ g, k };
    }
}

static int64_t length_of(const lt_splat_lists *l, int64_t tile)
{
    return lt_min_i64(LENGTHS - 1, (l->start[tile + 1] - l->start[tile]) / LENGTH);
}

/* Roughly, so that no thread begins a long one when the others are done. */
static void order_tiles(lt_splat_lists *l)
{
    int64_t place[LENGTHS + 1] = { 0 };

    for (int64_t tile = 0; tile < l->tiles; tile++)
        place[LENGTHS - 1 - length_of(l, tile) + 1]++;
    for (int i = 0; i < LENGTHS; i++)
        place[i + 1] += place[i];
    for (int64_t tile = 0; tile < l->tiles; tile++)
        l->longest[place[LENGTHS - 1 - length_of(l, tile)]++] = (uint32_t)tile;
}

static void take_what_fits(lt_splat_lists *l)
{
    int64_t used = 0;

    for (l->from = l->to; l->to < l->drawn; l->to++) {
        const uint32_t g = l->order[l->to];

        if (used + l->covers[g] > l->capacity)
            break;
        l->instance[g] = (uint32_t)used;
        used += l->covers[g];
    }
}

void lt_splat_fill(lt_splat_lists *l, const lt_splat_seen *seen, const lt_splat_view *view)
{
    dealing d = { l, seen, view, 0 };

    take_what_fits(l);
    d.parts = lt_min_i64(MOST_PARTS, lt_ceil_div(l->to - l->from, PART));
    lt_parallel_for(d.parts, count_part, &d);
    place_parts(&d);
    lt_parallel_for(d.parts, deal_part, &d);
    order_tiles(l);
}
