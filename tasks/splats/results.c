/* SPDX-License-Identifier: Apache-2.0 */
/* How good a trained scene is: scores of its views, and pictures of the worst. */
#include "eval/metrics/image.h"
#include "eval/tables/scores_file.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/write.h"
#include "libtensor/io/text/csv.h"
#include "tasks/splats/trained.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

enum { WORST = 6 };                                 /* views in pictures.png */

const char *const splats_score_keys[] = { "psnr_db", "ssim", "lpips_raw01", "lpips_sym", NULL };

/* ---- a view ---------------------------------------------------------------------------------------------- */

lt_status splats_score_view(const task_run *r, const compiled *c, int view, const eval_lpips *judge,
                            double out[SPLATS_SCORES])
{
    const splats *m = splats_of(r->m);
    const transforms_picture *v = &r->picture[view];
    const int64_t W = m->config.width, drawn_plane = W * m->config.height, plane = (int64_t)v->width * v->height;
    const lt_real *drawn = compiled_output(c, "picture");
    float *a = lt_alloc(6 * (size_t)plane * sizeof(*a)), *b = a ? a + 3 * plane : NULL;
    const eval_pictures p = { .a = a, .b = b, .channels = 3, .height = v->height, .width = v->width, .plane = plane,
                              .row = v->width };
    eval_lpips_scores far = { NAN, NAN };
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
    if (judge)
        far = eval_lpips_score(judge, &p);
    lt_release(a);
    out[SPLATS_LPIPS_RAW01] = far.raw01;
    out[SPLATS_LPIPS_SYM] = far.sym;
    return st;
}

/* ---- scores ---------------------------------------------------------------------------------------------- */

typedef struct {
    const task_evaluation *e;
    splats_trained o;
    eval_lpips *judge;              /* NULL: pictures of a size that LPIPS does not take */
    int64_t n;
    int *view;                      /* (n) those that are scored */
    double (*score)[SPLATS_SCORES]; /* (n) */
    double mean[SPLATS_SCORES];     /* of what is finite: a picture that nothing differs in counts for nothing */
} evaluating;

static lt_status open_lpips(evaluating *v)
{
    const splats_config *c = &splats_of(&v->o.m)->config;

    return eval_lpips_takes(c->height, c->width)
        ? eval_lpips_new(&(eval_lpips_options){ .file = v->e->lpips, .n_files = v->e->n_lpips, .height = c->height,
                                                .width = c->width }, &v->judge)
        : LT_OK;
}

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
        splats_trained_draw(&v->o, v->view[i]);
        st = splats_score_view(&v->o.run, &v->o.drawing, v->view[i], v->judge, v->score[i]);
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
    if (v->judge)
        cJSON_AddStringToObject(root, "lpips", eval_lpips_name(v->judge));
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
    char far[32] = "-";

    fprintf(f, "%s%s: %lld views %s\n\n", r->set.path, r->set.synthetic ? " (synthetic)" : "", (long long)v->n,
            v->o.views == &r->train ? "that were learnt from" : "held out");
    if (isfinite(v->mean[SPLATS_LPIPS_SYM]))
        snprintf(far, sizeof(far), "%.2f", v->mean[SPLATS_LPIPS_SYM]);
    fprintf(f, "| PSNR (dB) | %s | %s x1000 | Gaussians |\n|---|---|---|---|\n| %.2f | %.4f | %s | %lld |\n",
            eval_ssim_name(EVAL_SSIM_ZERO_PADDED), v->judge ? eval_lpips_name(v->judge) : "lpips",
            v->mean[SPLATS_PSNR], v->mean[SPLATS_SSIM], far,
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
        splats_trained_draw(&v->o, view);
        splats_trained_picture(&v->o, view, row, at + row / 2);
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
    lt_status st = splats_trained_open(e->arena, e->config, e->checkpoint, e->split, &v.o);

    if (!st)
        st = open_lpips(&v);
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
    eval_lpips_free(v.judge);
    splats_trained_close(&v.o);
    return st;
}
