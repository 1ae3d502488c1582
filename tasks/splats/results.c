/* SPDX-License-Identifier: Apache-2.0 */
/* What a trained scene is asked for: scores, pictures of its views, its Gaussians as a file. */
#include "estimate/checkpoint/checkpoint.h"
#include "eval/metrics/image.h"
#include "eval/tables/scores_file.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/write.h"
#include "libtensor/io/mesh/glb.h"
#include "libtensor/io/mesh/splat.h"
#include "libtensor/io/text/csv.h"
#include "tasks/splats/run.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

enum { WORST = 6 };                                 /* views in pictures.png */

const char *const splats_score_keys[] = { "psnr_db", "ssim", NULL };

/* ---- a view ---------------------------------------------------------------------------------------------- */

lt_status splats_score_view(const task_run *r, const compiled *c, int view, double out[SPLATS_SCORES])
{
    const splats *m = splats_of(r->m);
    const transforms_picture *v = &r->picture[view];
    const int64_t W = m->config.width, drawn_plane = W * m->config.height, plane = (int64_t)v->width * v->height;
    const lt_real *drawn = compiled_output(c, "picture");
    float *a = lt_alloc(6 * (size_t)plane * sizeof(*a)), *b = a ? a + 3 * plane : NULL;
    const eval_pictures p = { .a = a, .b = b, .channels = 3, .height = v->height, .width = v->width, .plane = plane,
                              .row = v->width };
    lt_status st;

    if (!a)
        return lt_error(LT_ENOMEM, "no memory to score a view");
    for (int64_t i = 0; i < 3 * plane; i++) {
        const int64_t pixel = i % plane, at = pixel / v->width * W + pixel % v->width;
        const bool counts = splats_counts(r, view, pixel);

        a[i] = counts ? fminf(1, fmaxf(0, (float)drawn[i / plane * drawn_plane + at])) : 0;
        b[i] = counts ? (float)v->rgb[3 * pixel + i / plane] / 255 : 0;
    }
    out[SPLATS_PSNR] = eval_psnr(&p, v->mask);
    st = eval_ssim(&p, EVAL_SSIM_ZERO_PADDED, &out[SPLATS_SSIM]);
    lt_release(a);
    return st;
}

/* What was drawn of a view, as bytes into an image whose rows are `row` bytes long */
static void draw_into(uint8_t *out, int64_t row, const task_run *r, const compiled *c, int view)
{
    const splats *m = splats_of(r->m);
    const transforms_picture *v = &r->picture[view];
    const int64_t W = m->config.width, plane = W * m->config.height;
    const lt_real *drawn = compiled_output(c, "picture");

    for (int64_t y = 0; y < v->height; y++)
        for (int64_t i = 0; i < 3 * (int64_t)v->width; i++)
            out[y * row + i] = (uint8_t)lround(255 * fmin(1, fmax(0, (double)drawn[i % 3 * plane + y * W + i / 3])));
}

/* ---- a run ----------------------------------------------------------------------------------------------- */

typedef struct {
    task_run run;
    model m;
    lt_params *params;
    const splats_source *views;     /* held out, or all that there are where none is */
    compiled drawing;
} opened;

static void close_run(opened *o)
{
    compiled_free(&o->drawing);
    lt_params_free(o->params);
}

static lt_status load(lt_arena *arena, train_config *config, const char *checkpoint, opened *o)
{
    lt_status st;

    *o = (opened){ .run = { .arena = arena, .config = config, .m = &o->m }, .params = lt_params_new() };
    st = o->params ? train_config_model(config, NULL, o->params, &o->m)
                   : lt_error(LT_ENOMEM, "no memory for the model");
    return st ? st : checkpoint_load_model(checkpoint, &o->m);
}

/* With the views of the configuration's folder. split: "train" for those that were learnt from */
static lt_status open_run(lt_arena *arena, train_config *config, const char *checkpoint, const char *split, opened *o)
{
    lt_status st = load(arena, config, checkpoint, o);
    task_run *r = &o->run;
    recipe by;

    if (!st)
        st = splats_open_views(r, config, splats_of(&o->m)->config.white);
    if (st)
        return st;
    for (int i = 0; i < r->set.n; i++)
        if (r->picture[i].width > splats_of(&o->m)->config.width
            || r->picture[i].height > splats_of(&o->m)->config.height)
            return lt_error(LT_EINVAL, "%s: is %d x %d, but the run draws up to %d x %d", r->set.view[i].image,
                            r->picture[i].width, r->picture[i].height, splats_of(&o->m)->config.width,
                            splats_of(&o->m)->config.height);
    o->views = (split && strcmp(split, "train") == 0) || r->held_out.count == 0 ? &r->train : &r->held_out;
    by = splats_recipe(o->views, false);
    return compiled_new(&by, 1, false, &o->drawing);
}

/* Draw a view of the folder with all harmonics. */
static void draw_view(const opened *o, int view)
{
    splats_feed(&o->run, o->drawing.plan, &o->drawing.record, view, 3);
    lt_run(o->drawing.plan);
}

/* ---- scores ---------------------------------------------------------------------------------------------- */

typedef struct {
    const task_evaluation *e;
    opened o;
    int64_t n;
    int *view;                      /* (n) those that are scored */
    double (*score)[SPLATS_SCORES]; /* (n) */
    double mean[SPLATS_SCORES];     /* of what is finite: a picture that nothing differs in counts for nothing */
} evaluating;

/* Spread over all, where a limit is set */
static lt_status score_views(evaluating *v)
{
    const int64_t all = v->o.views->count;
    int64_t finite[SPLATS_SCORES] = { 0 };
    lt_status st = LT_OK;

    v->n = v->e->limit ? lt_min_i64(v->e->limit, all) : all;
    v->view = lt_arena_array(v->e->arena, (size_t)v->n, sizeof(*v->view));
    v->score = lt_arena_array(v->e->arena, (size_t)v->n, sizeof(*v->score));
    if (!v->view || !v->score)
        return lt_error(LT_ENOMEM, "no memory for the scores");
    for (int64_t i = 0; i < v->n && !st; i++) {
        v->view[i] = v->o.views->view[i * all / v->n];
        draw_view(&v->o, v->view[i]);
        st = splats_score_view(&v->o.run, &v->o.drawing, v->view[i], v->score[i]);
        for (int k = 0; k < SPLATS_SCORES && !st; k++)
            if (isfinite(v->score[i][k])) {
                v->mean[k] += v->score[i][k];
                finite[k]++;
            }
        if (!st && v->e->progress && !v->e->progress(v->e->ctx, i + 1, v->n))
            st = LT_ESTOPPED;
    }
    for (int k = 0; k < SPLATS_SCORES; k++)
        v->mean[k] = finite[k] ? v->mean[k] / (double)finite[k] : NAN;
    return st;
}

static cJSON *scores_of(const evaluating *v)
{
    const task_run *r = &v->o.run;
    cJSON *root = cJSON_CreateObject();

    cJSON_AddStringToObject(root, "model", v->o.m.cls->name);
    cJSON_AddStringToObject(root, "variant", v->o.m.variant);
    cJSON_AddStringToObject(root, "checkpoint", v->e->checkpoint);
    cJSON_AddNumberToObject(root, "step", (double)v->e->step);
    cJSON_AddStringToObject(root, "data", r->set.path);
    cJSON_AddBoolToObject(root, "synthetic", r->set.synthetic);
    cJSON_AddStringToObject(root, "split", v->o.views == &r->train ? "train" : "held out");
    cJSON_AddStringToObject(root, "ssim_form", eval_ssim_name(EVAL_SSIM_ZERO_PADDED));
    for (int k = 0; k < SPLATS_SCORES; k++)
        if (isfinite(v->mean[k]))
            cJSON_AddNumberToObject(root, splats_score_keys[k], v->mean[k]);
    cJSON_AddNumberToObject(root, "gaussians", (double)density_total(&splats_of(&v->o.m)->gaussians));
    cJSON_AddNumberToObject(root, "views", (double)v->n);
    return root;
}

static void print(const evaluating *v, FILE *f)
{
    const task_run *r = &v->o.run;

    fprintf(f, "%s%s: %lld views %s\n\n", r->set.path, r->set.synthetic ? " (synthetic)" : "", (long long)v->n,
            v->o.views == &r->train ? "that were learnt from" : "held out");
    fprintf(f, "| PSNR (dB) | %s | Gaussians |\n|---|---|---|\n| %.2f | %.4f | %lld |\n",
            eval_ssim_name(EVAL_SSIM_ZERO_PADDED), v->mean[SPLATS_PSNR], v->mean[SPLATS_SSIM],
            (long long)density_total(&splats_of(&v->o.m)->gaussians));
}

static lt_status write_table(const evaluating *v, const char *path)
{
    lt_atomic_file f;
    const lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    print(v, f.stream);
    return lt_atomic_commit(&f);
}

static lt_status write_per_view(const evaluating *v, const char *path)
{
    lt_csv w;
    const lt_status st = lt_csv_open(&w, path, "sample", SPLATS_SCORES, splats_score_keys);

    for (int64_t i = 0; !st && i < v->n; i++)
        lt_csv_add(&w, v->o.run.set.view[v->view[i]].name, v->score[i]);
    return st ? st : lt_csv_commit(&w);
}

/* The number of the view that is drawn worst but for `rank` others; of equals the first */
static int64_t worst(const evaluating *v, int64_t rank)
{
    for (int64_t i = 0; i < v->n; i++) {
        int64_t worse = 0;

        for (int64_t k = 0; k < v->n; k++)
            worse += v->score[k][SPLATS_PSNR] < v->score[i][SPLATS_PSNR]
                  || (k < i && !(v->score[k][SPLATS_PSNR] > v->score[i][SPLATS_PSNR]));
        if (worse == rank)
            return i;
    }
    return 0;
}

/* The truth, and beside it what is drawn, of the worst views, worst first */
static lt_status write_pictures(const evaluating *v, const char *path)
{
    const splats_config *c = &splats_of(&v->o.m)->config;
    const int64_t rows = lt_min_i64(WORST, v->n), row = 6 * (int64_t)c->width;
    lt_image im;
    lt_status st = lt_image_init(v->e->arena, 2 * c->width, (int)rows * c->height, 3, 8, &im);

    for (int64_t i = 0; i < rows && !st; i++) {
        const int view = v->view[worst(v, i)];
        const transforms_picture *p = &v->o.run.picture[view];
        uint8_t *at = (uint8_t *)im.data + i * c->height * row;

        for (int64_t y = 0; y < p->height; y++)
            memcpy(at + y * row, p->rgb + 3 * y * p->width, 3 * (size_t)p->width);
        draw_view(&v->o, view);
        draw_into(at + row / 2, row, &v->o.run, &v->o.drawing, view);
    }
    return st ? st : lt_png_write(path, &im);
}

static lt_status write_files(const evaluating *v)
{
    static const char *const name[] = { "table.md", "per-sample.csv", "pictures.png" };
    lt_status (*const write[])(const evaluating *, const char *) = { write_table, write_per_view, write_pictures };
    lt_status st = LT_OK;

    for (size_t i = 0; i < LT_COUNT(name) && !st; i++) {
        const char *path = lt_path_join(v->e->arena, v->e->folder, name[i]);

        st = path ? write[i](v, path) : lt_error(LT_ENOMEM, "no memory to write %s", v->e->folder);
    }
    return st ? st : scores_file_write(v->e->folder, scores_of(v));
}

lt_status splats_evaluate(const task_evaluation *e, cJSON **scores)
{
    evaluating v = { .e = e };
    lt_status st = open_run(e->arena, e->config, e->checkpoint, e->split, &v.o);

    if (!st)
        st = score_views(&v);
    if (!st)
        st = write_files(&v);
    if (!st && e->tables)
        print(&v, e->tables);
    if (!st) {
        *scores = scores_of(&v);
        st = *scores ? LT_OK : lt_error(LT_ENOMEM, "no memory for the scores");
    }
    close_run(&v.o);
    return st;
}

/* ---- pictures -------------------------------------------------------------------------------------------- */

/* OUT/images/0001.png, by the name that the folder has for the view */
static lt_status write_view(const opened *o, const char *folder, int view)
{
    const transforms_picture *p = &o->run.picture[view];
    const char *name = o->run.set.view[view].name, *dot = strrchr(name, '.'), *slash = strrchr(name, '/');
    const int length = (int)(dot && (!slash || dot > slash) ? (size_t)(dot - name) : strlen(name));
    lt_arena *arena = lt_arena_new();
    const char *path = arena ? lt_arena_printf(arena, "%s/%.*s.png", folder, length, name) : NULL;
    const char *in = path ? lt_arena_printf(arena, "%.*s", (int)(strrchr(path, '/') - path), path) : NULL;
    lt_image im;
    lt_status st = in ? lt_make_dirs(in) : lt_error(LT_ENOMEM, "%s: no memory", folder);

    if (!st)
        st = lt_image_init(arena, p->width, p->height, 3, 8, &im);
    if (!st) {
        draw_view(o, view);
        draw_into((uint8_t *)im.data, 3 * (int64_t)p->width, &o->run, &o->drawing, view);
        st = lt_png_write_fast(path, &im);
    }
    lt_arena_free(arena);
    return st;
}

lt_status splats_predict(const task_prediction *p, int64_t *written)
{
    lt_status st = lt_make_dirs(p->out);

    *written = 0;
    for (int i = 0; i < p->n_inputs && !st; i++) {
        opened o;

        p->config->data->dir = p->inputs[i];
        st = open_run(p->arena, p->config, p->checkpoint, NULL, &o);
        for (int64_t k = 0; !st && k < o.views->count; k++) {
            st = p->stop && p->stop() ? LT_ESTOPPED : write_view(&o, p->out, o.views->view[k]);
            *written += !st;
        }
        close_run(&o);
    }
    return st;
}

/* ---- Gaussians ------------------------------------------------------------------------------------------- */

lt_status splats_export(const task_export *e)
{
    opened o;
    lt_splat *splat;
    size_t n;
    lt_status st = !e->file || e->animated || e->set
        ? lt_error(LT_EUSAGE, "%s: a still scene is written whole: -o FILE, as ply, glb or splat", e->checkpoint)
        : load(e->arena, e->config, e->checkpoint, &o);

    if (st == LT_EUSAGE)
        return st;
    if (!st)
        st = gaussians_splats(&splats_of(&o.m)->gaussians, 0, e->arena, &splat, &n);
    if (!st && strcmp(e->format, "splat") == 0)
        st = lt_splat_write(e->file, splat, n);
    else if (!st && strcmp(e->format, "glb") == 0)
        st = lt_glb_write_splats(e->file, "scene", splat, n, 3);
    else if (!st)
        st = lt_ply_write_splats(e->file, "the world of the cameras", splat, n);
    close_run(&o);
    return st;
}
