/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/report/sheet.h"

#include "eval/report/internal.h"
#include "eval/tables/tables.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/write.h"
#include "libtensor/io/text/json.h"
#include "vision/drawing/draw.h"

#include <cjson/cJSON.h>
#include <string.h>

enum { JPEG_QUALITY = 92 };

typedef struct { uint8_t *bytes; size_t n; } picture;

/* A frame of a run */
typedef struct {
    int64_t number;
    const char *name;
    const uint8_t *rgb;             /* the truth, of the first run */
    int width, height;
    bool jittered;
    double psnr_db;
    picture truth, drawn, surface;
} cell;

typedef struct {
    const char *folder, *variant, *label;
    cell *cell;                     /* (n_frames) */
    int n;
} column;

struct report_sheet {
    lt_arena *arena;
    int n_frames, n_runs;
    bool surfaces;
    column *run;
    size_t room;
};

report_sheet *report_sheet_new(int n_frames, bool surfaces)
{
    report_sheet *s = lt_alloc(sizeof(*s));
    lt_arena *arena = s ? lt_arena_new() : NULL;

    if (!arena) {
        lt_release(s);
        return NULL;
    }
    *s = (report_sheet){ .arena = arena, .n_frames = n_frames, .surfaces = surfaces };
    return s;
}

void report_sheet_free(report_sheet *s)
{
    if (!s)
        return;
    lt_arena_free(s->arena);
    lt_release(s);
}

/* ---- runs -------------------------------------------------------------------------------------------------------- */

/* As Table 6 calls a variant, or Table 7 where it is none of that one's; else its own name */
static const char *label_of(const char *variant)
{
    static const char *const ids[] = { "hogs-6", "hogs-7" };
    const eval_table *t;

    for (size_t k = 0; k < LT_COUNT(ids); k++)
        for (int i = 0; (t = eval_table_at(i)); i++) {
            const int row = strcmp(t->id, ids[k]) == 0 ? eval_find_variant(t, variant) : EVAL_NO_ROW;

            if (row != EVAL_NO_ROW)
                return t->row[row].label;
        }
    return variant;
}

lt_status report_sheet_run(report_sheet *s, const char *run)
{
    const char *path = lt_path_join(s->arena, run, "config.json");
    const cJSON *model, *jitter, *variant;
    column *all, *c;
    cJSON *config;
    lt_status st = path ? lt_json_read(path, &config) : lt_error(LT_ENOMEM, "no memory for the sheet");

    if (st)
        return st;
    all = lt_arena_grow(s->arena, s->run, (size_t)s->n_runs, &s->room, sizeof(*all));
    if (!all) {
        cJSON_Delete(config);
        return lt_error(LT_ENOMEM, "no memory for the sheet");
    }
    s->run = all;
    c = &all[s->n_runs++];
    model = cJSON_GetObjectItemCaseSensitive(config, "model");
    variant = cJSON_GetObjectItemCaseSensitive(model, "variant");
    jitter = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(config, "data"), "jitter");
    *c = (column){ .folder = lt_arena_printf(s->arena, "%s", run),
                   .variant = lt_arena_printf(s->arena, "%s%s", cJSON_IsString(variant) ? variant->valuestring : "",
                                              cJSON_IsTrue(jitter) ? "-cj" : ""),
                   .cell = lt_arena_array(s->arena, (size_t)s->n_frames, sizeof(*c->cell)) };
    cJSON_Delete(config);
    if (!c->folder || !c->variant || !c->cell)
        return lt_error(LT_ENOMEM, "no memory for the sheet");
    c->label = label_of(c->variant);
    return LT_OK;
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* Runs of a sheet have seen the same pictures: those of the first one. */
static lt_status check_same(const report_sheet *s, const column *c, const posed_frame *f)
{
    const column *first = &s->run[0];
    const cell *a = &first->cell[c->n];

    if (c == first)
        return LT_OK;
    if (strcmp(a->name, f->name) != 0)
        return lt_error(LT_EINVAL, "%s: frame %lld is %s, in %s %s; want runs on the same data", c->folder,
                        (long long)f->number, f->name, first->folder, a->name);
    if (a->width != f->width || a->height != f->height)
        return lt_error(LT_EINVAL, "%s: frames are %d x %d pixels, in %s %d x %d; want runs on the same data",
                        c->folder, f->width, f->height, first->folder, a->width, a->height);
    if (!a->jittered && !f->jittered && memcmp(a->rgb, f->truth, 3 * (size_t)f->width * (size_t)f->height) != 0)
        return lt_error(LT_EINVAL, "%s: frame %lld (%s) is another picture than in %s; want runs on the same data",
                        c->folder, (long long)f->number, f->name, first->folder);
    return LT_OK;
}

static lt_status take(report_sheet *s, const uint8_t *rgb, const posed_frame *f, picture *out)
{
    const lt_image image = { f->width, f->height, 3, 8, (uint8_t *)rgb };

    return lt_jpeg_encode(s->arena, &image, JPEG_QUALITY, &out->bytes, &out->n);
}

static lt_status take_surfaces(report_sheet *s, const posed_frame *f, picture *out)
{
    lt_arena *arena = lt_arena_new();
    draw_canvas c = arena ? draw_canvas_new(arena, f->width, f->height, (draw_color){ 0, 0, 0 }) : (draw_canvas){ 0 };
    float *depth = c.rgb ? lt_arena_array(arena, (size_t)f->width * (size_t)f->height, sizeof(*depth)) : NULL;
    lt_status st = depth ? LT_OK : lt_error(LT_ENOMEM, "no memory to draw surfaces");

    for (int part = 0; part < POSED_PARTS && !st; part++) {
        lt_mesh m;

        st = posed_surface(f, part, LT_OPACITY_MEAN, POSED_ISO, arena, &m);
        if (!st)
            draw_mesh(&c, depth, &f->camera, &m);
    }
    if (!st)
        st = take(s, c.rgb[0], f, out);
    lt_arena_free(arena);
    return st;
}

lt_status report_sheet_add(report_sheet *s, const posed_frame *f)
{
    column *c = &s->run[s->n_runs - 1];
    const size_t bytes = 3 * (size_t)f->width * (size_t)f->height;
    uint8_t *rgb = lt_arena_array(s->arena, bytes, 1);
    const char *name = lt_arena_printf(s->arena, "%s", f->name);
    cell *out = &c->cell[c->n];
    lt_status st = rgb && name ? check_same(s, c, f) : lt_error(LT_ENOMEM, "no memory for frames of the sheet");

    if (st)
        return st;
    memcpy(rgb, f->truth, bytes);
    *out = (cell){ .number = f->number, .name = name, .rgb = rgb, .width = f->width, .height = f->height,
                   .jittered = f->jittered, .psnr_db = f->psnr_db };
    st = take(s, f->truth, f, &out->truth);
    if (!st)
        st = take(s, f->drawn, f, &out->drawn);
    if (!st && s->surfaces)
        st = take_surfaces(s, f, &out->surface);
    c->n++;
    return st;
}

/* ---- the page ---------------------------------------------------------------------------------------------------- */

static const char head[] =
    "<!DOCTYPE html>\n<html lang=en><head><meta charset=utf-8>\n"
    "<meta http-equiv=Content-Security-Policy content=\"default-src 'none'; style-src 'unsafe-inline'; "
    "img-src data:\">\n"
    "<title>Runs beside each other</title>\n<style>\n"
    "body{font:15px/1.4 system-ui,sans-serif;margin:1rem;color:#222}th{font-weight:600}td,th{padding:.2rem;"
    "text-align:center;vertical-align:top}img{display:block}small{color:#555}\n</style></head><body>\n<table>\n<tr>";

static void put_head(FILE *f, const report_sheet *s)
{
    fputs(head, f);
    fputs("<th>truth</th>", f);
    for (int i = 0; i < s->n_runs; i++) {
        fputs("<th>", f);
        html_text(f, s->run[i].label);
        fputs("<br><small>", f);
        html_text(f, s->run[i].variant);
        fputs(", ", f);
        html_text(f, s->run[i].folder);
        fputs("</small></th>", f);
    }
    fputs("</tr>\n", f);
}

static void put_cell(FILE *f, const cell *c)
{
    fputs("<td>", f);
    html_jpeg(f, c->drawn.bytes, c->drawn.n, "drawn");
    if (c->surface.n)
        html_jpeg(f, c->surface.bytes, c->surface.n, "surfaces");
    fprintf(f, "%.2f dB", c->psnr_db);
    if (c->jittered) {
        html_jpeg(f, c->truth.bytes, c->truth.n, "the truth with other colours");
        fputs("<small>its truth, in jittered colours</small>", f);
    }
    fputs("</td>", f);
}

static void put_frame(FILE *f, const report_sheet *s, int i)
{
    const cell *first = &s->run[0].cell[i], *truth = first;

    for (int k = 0; k < s->n_runs && truth->jittered; k++)
        truth = &s->run[k].cell[i];                     /* in its own colours, where a run has it so */
    fputs("<tr><td>", f);
    html_jpeg(f, truth->truth.bytes, truth->truth.n, "the truth");
    fprintf(f, "<small>frame %lld, ", (long long)first->number);
    html_text(f, first->name);
    fputs("</small></td>", f);
    for (int k = 0; k < s->n_runs; k++)
        put_cell(f, &s->run[k].cell[i]);
    fputs("</tr>\n", f);
}

lt_status report_sheet_write(const report_sheet *s, const char *path)
{
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    put_head(f.stream, s);
    for (int i = 0; i < s->n_frames; i++)
        put_frame(f.stream, s, i);
    fputs("</table>\n</body></html>\n", f.stream);
    return lt_atomic_commit(&f);
}
