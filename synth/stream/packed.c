/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/stream/packed.h"

#include "libtensor/io/image/image.h"
#include "libtensor/io/image/write.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { QUALITY = 92, SILHOUETTE = 4 /* beside the two bits of a segment */ };

typedef struct { uint8_t *bytes; size_t n; } block;

struct packed_sample {
    dataset_sample sample;          /* without images */
    block rgb, masks, depth;       /* n 0: there is none */
    bool silhouette, segments;
};

/* ---- packing ---- */

static bool pack(const void *bytes, size_t n, block *out)
{
    uLongf room = compressBound((uLong)n);
    uint8_t *p = malloc(room), *fitting;

    if (!p || compress2(p, &room, bytes, (uLong)n, Z_BEST_SPEED) != Z_OK) {
        free(p);
        return false;
    }
    fitting = realloc(p, room);
    *out = (block){ fitting ? fitting : p, room };
    return true;
}

static bool unpack(const block *p, void *out, size_t n)
{
    uLongf room = (uLongf)n;

    return uncompress(out, &room, p->bytes, (uLong)p->n) == Z_OK && room == n;
}

static bool pack_rgb(const dataset_sample *s, block *out)
{
    const lt_image img = { s->width, s->height, 3, 8, (uint8_t *)s->rgb };
    lt_arena *arena = lt_arena_new();
    uint8_t *bytes;
    bool ok = arena && !lt_jpeg_encode(arena, &img, QUALITY, &bytes, &out->n);

    out->bytes = ok ? malloc(out->n) : NULL;
    if (out->bytes)
        memcpy(out->bytes, bytes, out->n);
    lt_arena_free(arena);
    return out->bytes != NULL;
}

static bool pack_masks(const dataset_sample *s, block *out)
{
    const size_t n = (size_t)s->width * (size_t)s->height;
    uint8_t *both = malloc(n);
    bool ok = both != NULL;

    for (size_t i = 0; ok && i < n; i++)
        both[i] = (uint8_t)((s->segments ? s->segments[i] : 0) | (s->silhouette && s->silhouette[i] ? SILHOUETTE : 0));
    ok = ok && pack(both, n, out);
    free(both);
    return ok;
}

static bool pack_depth(const dataset_sample *s, block *out)
{
    const size_t n = (size_t)s->width * (size_t)s->height;
    uint16_t *mm = malloc(n * sizeof(*mm));
    bool ok = mm != NULL;

    for (size_t i = 0; ok && i < n; i++)
        mm[i] = (uint16_t)(s->depth[i] * 1000 + 0.5f);
    ok = ok && pack(mm, n * sizeof(*mm), out);
    free(mm);
    return ok;
}

packed_sample *packed_new(const dataset_sample *s)
{
    packed_sample *k = calloc(1, sizeof(*k));

    if (!k)
        return NULL;
    k->sample = *s;
    k->sample.rgb = k->sample.silhouette = k->sample.segments = NULL;
    k->sample.depth = NULL;
    k->silhouette = s->silhouette != NULL;
    k->segments = s->segments != NULL;
    if (pack_rgb(s, &k->rgb) && (!(k->silhouette || k->segments) || pack_masks(s, &k->masks))
        && (!s->depth || pack_depth(s, &k->depth)))
        return k;
    packed_free(k);
    return NULL;
}

void packed_free(packed_sample *k)
{
    if (!k)
        return;
    free(k->rgb.bytes);
    free(k->masks.bytes);
    free(k->depth.bytes);
    free(k);
}

size_t packed_bytes(const packed_sample *k)
{
    return sizeof(*k) + k->rgb.n + k->masks.n + k->depth.n;
}

bool packed_has(const packed_sample *k, unsigned want)
{
    return (!(want & SAMPLE_OBJECT) || k->silhouette || !(k->sample.flags & SAMPLE_OBJECT))
        && (!(want & SAMPLE_SEGMENTS) || k->segments) && (!(want & SAMPLE_DEPTH) || k->depth.n);
}

/* ---- unpacking ---- */

static bool read_rgb(const packed_sample *k, lt_arena *arena, dataset_sample *out)
{
    lt_image img;

    if (lt_image_decode(arena, out->name, k->rgb.bytes, k->rgb.n, &img))
        return false;
    out->rgb = img.data;
    return true;
}

static bool read_masks(const packed_sample *k, lt_arena *arena, dataset_sample *out)
{
    const size_t n = (size_t)out->width * (size_t)out->height;
    uint8_t *segments = lt_arena_array(arena, n, 1), *silhouette = lt_arena_array(arena, n, 1);

    if (!segments || !silhouette || !unpack(&k->masks, segments, n))
        return false;
    for (size_t i = 0; i < n; i++) {
        silhouette[i] = segments[i] / SILHOUETTE;
        segments[i] %= SILHOUETTE;
    }
    out->silhouette = k->silhouette ? silhouette : NULL;
    out->segments = k->segments ? segments : NULL;
    return true;
}

static bool read_depth(const packed_sample *k, lt_arena *arena, dataset_sample *out)
{
    const size_t n = (size_t)out->width * (size_t)out->height;
    uint16_t *mm = lt_arena_array(arena, n, sizeof(*mm));
    float *depth = lt_arena_array(arena, n, sizeof(*depth));

    if (!mm || !depth || !unpack(&k->depth, mm, n * sizeof(*mm)))
        return false;
    for (size_t i = 0; i < n; i++)
        depth[i] = (float)mm[i] / 1000;
    out->depth = depth;
    return true;
}

lt_status packed_read(const packed_sample *k, lt_arena *arena, dataset_sample *out)
{
    *out = k->sample;
    if (read_rgb(k, arena, out) && (!k->masks.n || read_masks(k, arena, out))
        && (!k->depth.n || read_depth(k, arena, out)))
        return LT_OK;
    return lt_error(LT_ENOMEM, "%s: no memory", out->name);
}
