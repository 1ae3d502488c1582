/* SPDX-License-Identifier: Apache-2.0 */
/* The view of a page: frames packed for view.js, which draws them. Arrays are little-endian words of 16 bits in base64;
 * a number x of an array of some range stands for low + step * x. */
#include "eval/report/internal.h"
#include "libtensor/io/image/write.h"
#include "libtensor/io/mesh/splat.h"

#include <math.h>
#include <string.h>

enum { SPLAT_WORDS = 12, VERTEX_WORDS = 5, JPEG_QUALITY = 90 };

static const char *const script[] = {
#include "eval/report/view_js.inc"
};

typedef struct { double low[3], step; } range;

typedef struct {
    range place;
    int n_vertices, n_faces;
    uint8_t *vertex, *face;         /* VERTEX_WORDS each: place, red green, blue; words, or twice as wide */
    size_t vertex_bytes, face_bytes;
} packed_mesh;

typedef struct {
    int64_t number;
    const char *name, *part[POSED_PARTS];
    int width, height;
    lt_camera camera;
    double near;
    bool white;
    double psnr_db;
    size_t n[POSED_PARTS];
    range place, size;              /* size: of logarithms of scales */
    uint8_t *splats, *still;        /* still: the truth beside the rendering, JPEG */
    size_t splat_bytes, still_bytes;
    packed_mesh mesh[POSED_PARTS];
} packed_frame;

struct report_view {
    lt_arena *arena;
    packed_frame *frame;
    int n;
    size_t room;
};

report_view *report_view_new(void)
{
    report_view *v = lt_alloc(sizeof(*v));
    lt_arena *arena = v ? lt_arena_new() : NULL;

    if (!arena) {
        lt_release(v);
        return NULL;
    }
    *v = (report_view){ .arena = arena };
    return v;
}

void report_view_free(report_view *v)
{
    if (!v)
        return;
    lt_arena_free(v->arena);
    lt_release(v);
}

/* ---- packing ---------------------------------------------------------------------------------------------------- */

static void put_word(uint8_t **at, double x)
{
    const uint16_t word = (uint16_t)lround(fmin(65535, fmax(0, x)));

    *(*at)++ = (uint8_t)(word & 255);
    *(*at)++ = (uint8_t)(word >> 8);
}

static void put_in_range(uint8_t **at, const range *r, const float x[3])
{
    for (int k = 0; k < 3; k++)
        put_word(at, ((double)x[k] - r->low[k]) / r->step);
}

/* Two bytes in a word, of numbers from 0 to 1 */
static void put_shares(uint8_t **at, double a, double b)
{
    put_word(at, 256 * round(255 * fmin(1, fmax(0, a))) + round(255 * fmin(1, fmax(0, b))));
}

/* Around n vectors, `stride` floats apart */
static range range_of(const float *x, size_t n, size_t stride)
{
    range r = { .step = 1e-9 };

    for (int k = 0; k < 3; k++) {
        float low = n ? INFINITY : 0, high = n ? -INFINITY : 0;

        for (size_t i = 0; i < n; i++) {
            low = fminf(low, x[i * stride + (size_t)k]);
            high = fmaxf(high, x[i * stride + (size_t)k]);
        }
        r.low[k] = (double)low;
        r.step = fmax(r.step, ((double)high - (double)low) / 65535);
    }
    return r;
}

/* Place, logarithms of scales, rotation w x y z from -1 to 1, red green, blue opacity */
static void pack_splat(uint8_t **at, const packed_frame *p, const lt_splat *s)
{
    double length = 0, rgb[3];

    for (int k = 0; k < 4; k++)
        length += (double)s->rotation[k] * (double)s->rotation[k];
    lt_splat_rgb(s, rgb);
    put_in_range(at, &p->place, s->x);
    put_in_range(at, &p->size, s->scale);
    for (int k = 0; k < 4; k++)
        put_word(at, 32767.5 * (1 + (double)s->rotation[k] / sqrt(length)));
    put_shares(at, rgb[0], rgb[1]);
    put_shares(at, rgb[2], 1 / (1 + exp(-(double)s->opacity)));
}

static lt_status pack_splats(lt_arena *arena, const posed_frame *f, packed_frame *p)
{
    const size_t n = f->n[POSED_HAND] + f->n[POSED_OBJECT], stride = sizeof(*f->splat) / sizeof(float);
    uint8_t *at = p->splats = lt_arena_array(arena, n, p->splat_bytes = 2 * SPLAT_WORDS);

    if (!at)
        return lt_error(LT_ENOMEM, "no memory for %zu Gaussians of the page", n);
    p->splat_bytes *= n;
    p->place = range_of(n ? f->splat->x : NULL, n, stride);
    p->size = range_of(n ? f->splat->scale : NULL, n, stride);
    for (size_t i = 0; i < n; i++)
        pack_splat(&at, p, &f->splat[i]);
    return LT_OK;
}

static lt_status pack_mesh(lt_arena *arena, const lt_mesh *m, packed_mesh *p)
{
    const bool wide = m->n_vertices > 65536;
    uint8_t *vertex, *face;

    *p = (packed_mesh){ .n_vertices = m->n_vertices, .n_faces = m->n_faces,
                        .place = range_of(m->vertex[0], (size_t)m->n_vertices, 3),
                        .vertex_bytes = 2 * VERTEX_WORDS * (size_t)m->n_vertices,
                        .face_bytes = (wide ? 12 : 6) * (size_t)m->n_faces };
    vertex = p->vertex = lt_arena_array(arena, p->vertex_bytes, 1);
    face = p->face = lt_arena_array(arena, p->face_bytes, 1);
    if (!vertex || !face)
        return lt_error(LT_ENOMEM, "no memory for a surface of the page");
    for (int i = 0; i < m->n_vertices; i++) {
        put_in_range(&vertex, &p->place, m->vertex[i]);
        put_shares(&vertex, (double)m->color[i][0], (double)m->color[i][1]);
        put_shares(&vertex, (double)m->color[i][2], 0);
    }
    for (int i = 0; i < 3 * m->n_faces; i++) {
        const int32_t x = m->face[i / 3][i % 3];

        put_word(&face, x & 0xffff);
        if (wide)
            put_word(&face, x >> 16);
    }
    return LT_OK;
}

static lt_status pack_surfaces(lt_arena *arena, const posed_frame *f, packed_frame *p)
{
    lt_arena *scratch = lt_arena_new();
    lt_status st = scratch ? LT_OK : lt_error(LT_ENOMEM, "no memory for a surface of the page");

    for (int part = 0; part < POSED_PARTS && !st; part++) {
        lt_mesh m;

        st = posed_surface(f, part, LT_OPACITY_MEAN, POSED_ISO, scratch, &m);
        if (!st && m.n_faces)
            st = pack_mesh(arena, &m, &p->mesh[part]);
    }
    lt_arena_free(scratch);
    return st;
}

static lt_status pack_still(lt_arena *arena, const posed_frame *f, packed_frame *p)
{
    lt_image both;
    lt_status st = lt_image_init(arena, 2 * f->width, f->height, 3, 8, &both);

    if (st)
        return st;
    posed_beside(f, both.data);
    return lt_jpeg_encode(arena, &both, JPEG_QUALITY, &p->still, &p->still_bytes);
}

lt_status report_view_add(report_view *v, const posed_frame *f, bool surface)
{
    packed_frame *all = lt_arena_grow(v->arena, v->frame, (size_t)v->n, &v->room, sizeof(*all)), *p;
    lt_status st;

    if (!all)
        return lt_error(LT_ENOMEM, "no memory for frames of the page");
    v->frame = all;
    p = &all[v->n];
    *p = (packed_frame){ .number = f->number, .name = lt_arena_printf(v->arena, "%s", f->name),
                         .part = { lt_arena_printf(v->arena, "%s", f->part[0]),
                                   lt_arena_printf(v->arena, "%s", f->part[1]) },
                         .width = f->width, .height = f->height, .camera = f->camera, .near = f->near,
                         .white = f->white,
                         .psnr_db = f->psnr_db, .n = { f->n[0], f->n[1] } };
    if (!p->name || !p->part[0] || !p->part[1])
        return lt_error(LT_ENOMEM, "no memory for frames of the page");
    st = pack_splats(v->arena, f, p);
    if (!st)
        st = pack_still(v->arena, f, p);
    if (!st && surface)
        st = pack_surfaces(v->arena, f, p);
    if (!st)
        v->n++;
    return st;
}

/* ---- the page --------------------------------------------------------------------------------------------------- */

static void put_range(FILE *f, const char *name, const range *r)
{
    fprintf(f, "\"%s\":{\"low\":[%.9g,%.9g,%.9g],\"step\":%.9g},", name, r->low[0], r->low[1], r->low[2], r->step);
}

static void put_array(FILE *f, const char *name, const uint8_t *bytes, size_t n)
{
    fprintf(f, "\"%s\":\"", name);
    html_base64(f, bytes, n);
    fputc('"', f);
}

static void put_mesh(FILE *f, const packed_mesh *m)
{
    if (!m->n_faces) {
        fputs("null", f);
        return;
    }
    fprintf(f, "{\"vertices\":%d,", m->n_vertices);
    put_range(f, "place", &m->place);
    put_array(f, "vertex", m->vertex, m->vertex_bytes);
    fputc(',', f);
    put_array(f, "face", m->face, m->face_bytes);
    fputc('}', f);
}

static void put_frame(FILE *f, const packed_frame *p)
{
    fputs("{\"name\":", f);
    html_script_string(f, p->name);
    for (int part = 0; part < POSED_PARTS; part++) {
        fputs(part ? "," : ",\"parts\":[", f);
        html_script_string(f, p->part[part]);
    }
    fprintf(f, "],\"width\":%d,\"height\":%d,\"camera\":[%.9g,%.9g,%.9g,%.9g],\"near\":%.9g,", p->width, p->height,
            p->camera.fx, p->camera.fy, p->camera.cx, p->camera.cy, p->near);
    fprintf(f, "\"white\":%s,\"n\":[%zu,%zu],", p->white ? "true" : "false", p->n[0], p->n[1]);
    put_range(f, "place", &p->place);
    put_range(f, "size", &p->size);
    put_array(f, "splats", p->splats, p->splat_bytes);
    fputs(",\"mesh\":[", f);
    for (int part = 0; part < POSED_PARTS; part++) {
        fputs(part ? "," : "", f);
        put_mesh(f, &p->mesh[part]);
    }
    fputs("]}", f);
}

/* Without WebGL, or without scripts, this is the view. */
static void put_still(FILE *f, const packed_frame *p)
{
    fputs("<figure>", f);
    html_jpeg(f, p->still, p->still_bytes, "the truth, and the rendering");
    fprintf(f, "<figcaption>Frame %lld, ", (long long)p->number);
    html_text(f, p->name);
    fprintf(f, ": the truth, and as palmar draws it, PSNR %.2f dB.</figcaption></figure>\n", p->psnr_db);
}

static size_t size_of(const packed_frame *p)
{
    size_t n = p->splat_bytes + p->still_bytes;

    for (int part = 0; part < POSED_PARTS; part++)
        n += p->mesh[part].vertex_bytes + p->mesh[part].face_bytes;
    return (n + 2) / 3 * 4;
}

static const char controls[] =
    "<canvas tabindex=0 hidden></canvas>\n<p class=controls hidden>"
    "<label><input type=checkbox class=hand checked> hand</label>"
    "<label><input type=checkbox class=object checked> object</label>"
    "<label><input type=checkbox class=surface> surface</label>"
    "<label>frame <input type=range class=frame min=0 value=0></label>"
    "<button type=button class=home>the frame's own camera</button></p>\n"
    "<p class=controls hidden>Turn: drag, arrow keys. Zoom: wheel, two fingers, + and -. "
    "<span class=note></span></p>\n";

void view_put(FILE *f, const report_view *v, const char *nonce)
{
    size_t bytes = 0;

    for (int i = 0; i < v->n; i++)
        bytes += size_of(&v->frame[i]);
    fprintf(f, "<h2>Frames, to turn</h2>\n<p>%d %s, %.1f MB of this page.</p>\n<div id=view>\n", v->n,
            v->n == 1 ? "frame" : "frames", (double)bytes / 1e6);
    fputs("<p class=still>The view that turns needs WebGL 2 and scripts; these pictures are still.</p>\n", f);
    fputs(controls, f);
    for (int i = 0; i < v->n; i++)
        put_still(f, &v->frame[i]);
    fputs("</div>\n<script type=application/json id=view-frames>[", f);
    for (int i = 0; i < v->n; i++) {
        fputs(i ? ",\n" : "", f);
        put_frame(f, &v->frame[i]);
    }
    fprintf(f, "]</script>\n<script nonce=%s>\n", nonce);
    for (size_t i = 0; i < LT_COUNT(script); i++)
        fputs(script[i], f);
    fputs("</script>\n", f);
}
