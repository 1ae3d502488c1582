/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The task of still scenes: what the trainer asks of it. A step is an iteration, and draws one view.
 */
#include "tasks/splats/task.h"

#include "tasks/splats/run.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

/* ---- configuration --------------------------------------------------------------------------------------- */

#define DATA(field) #field, .offset = offsetof(splats_data_config, field)

static const char *const masks[] = { "ignored", "background", NULL };

const lt_config_key splats_data_keys[] = {
    TRAIN_DIR_KEY(splats_data_config),
    { DATA(holdout), .type = LT_CONFIG_INT, .fallback = "8", .lo = 2, .hi = 100000,
      .doc = "where the folder does not say which views are held out: of those in order of name every so many-th" },
    { DATA(downscale), .type = LT_CONFIG_INT, .fallback = "1", .lo = 1, .hi = 64,
      .doc = "make pictures so many times smaller" },
    { DATA(mask), .type = LT_CONFIG_CHOICE, .fallback = "\"ignored\"", .choices = masks,
      .doc = "what is black in masks: ignored, or background, which is painted as model.bg and counts" },
    { DATA(iterations), .type = LT_CONFIG_INT, .fallback = "7000", .lo = 10, .hi = 10000000,
      .doc = "one view each; density control, opacity resets and rates go by them" },
    TRAIN_LOADER_KEYS(splats_data_config),
    { .name = NULL },
};

/* ---- how it learns --------------------------------------------------------------------------------------- */

/* Of 30,000 iterations, and shorter runs in proportion; a Gaussian whose opacity was reset needs some steps to show
 * again before it may be taken out.                                                             [Kerbl et al. 2023] */
enum { PROFILE = 30000, SH_STEP = 1000, START = 500, END = 15000, EVERY = 100, RESET = 3000, LEAST_RESET = 500 };

static int64_t part(int64_t iterations, int64_t of_profile)
{
    return lt_max_i64(1, iterations * of_profile / PROFILE);
}

static splats_schedule schedule_of(int64_t iterations)
{
    return (splats_schedule){
        .iterations = iterations, .sh_step = part(iterations, SH_STEP),
        .density = { .start = part(iterations, START), .end = part(iterations, END), .every = EVERY,
                     .reset = lt_max_i64(LEAST_RESET, part(iterations, RESET)) },
    };
}

static lt_optim_group group_of(const char *name, const char *const *prefix, double lr)
{
    return (lt_optim_group){ .name = name, .prefix = prefix, .kind = LT_ADAM, .by_step = true, .eps = 1e-15,
                             .schedule = { .kind = LT_CONSTANT_LR, .lr = lr } };
}

/* Rates of Kerbl et al. 2023; that of places falls to a hundredth, in a line of its logarithm. */
static const lt_optim_group *run_groups(const task_run *r, int *n, lt_optim_average *average)
{
    static const char *const centre[] = { "gaussians.centre", NULL }, *const dc[] = { "gaussians.dc", NULL },
        *const rest[] = { "gaussians.rest", NULL }, *const opacity[] = { "gaussians.opacity", NULL },
        *const scale[] = { "gaussians.log_scale", NULL }, *const rotation[] = { "gaussians.quaternion", NULL };
    const double place = 1.6e-4 * splats_of(r->m)->config.extent;
    lt_optim_group *g = ((task_run *)r)->group;

    (void)average;
    g[0] = group_of("centre", centre, place);
    g[0].schedule = (lt_schedule){ .kind = LT_LOG_LINEAR_LR, .lr = place, .min_lr = 0.01 * place,
                                   .epochs = (int)r->schedule.iterations };
    g[1] = group_of("dc", dc, 2.5e-3);
    g[2] = group_of("rest", rest, 2.5e-3 / 20);
    g[3] = group_of("opacity", opacity, 0.05);
    g[4] = group_of("scale", scale, 0.005);
    g[5] = group_of("rotation", rotation, 0.001);
    *n = SPLATS_GROUPS;
    return g;
}

/* ---- opening --------------------------------------------------------------------------------------------- */

static bool is_white(const train_config *c)
{
    const cJSON *bg = cJSON_GetObjectItemCaseSensitive(c->model_keys, "bg");

    return cJSON_IsString(bg) && strcmp(bg->valuestring, "white") == 0;
}

static lt_status run_open(lt_arena *arena, train_config *c, task_run **out)
{
    task_run *r = lt_arena_alloc(arena, sizeof(*r));
    lt_status st;

    *out = r;
    if (!r)
        return lt_error(LT_ENOMEM, "no memory to begin");
    *r = (task_run){ .arena = arena, .config = c };
    st = splats_open_views(r, c, is_white(c));
    return st ? st : splats_find_scene(r, c);
}

static void run_close(task_run *r)
{
    density_free(&r->density);
    lt_release(r->seen);
}

static lt_status run_build(task_run *r, const train_config *c, lt_params *set, model *out)
{
    lt_status st = train_config_model(c, NULL, set, out);
    const splats *m;

    if (st)
        return st;
    r->m = out;
    m = splats_of(out);
    r->schedule = schedule_of(splats_data_of(c)->iterations);
    splats_give_scene(out, &r->scene);
    return density_new(&r->density, &m->gaussians, &(density_limits){
        .extent = m->config.extent, .least_opacity = 0.005, .most_pixels = INFINITY, .cap = m->config.cap,
        .reset_at_start = m->config.white });
}

static void run_describe(const task_run *r, train_progress *p)
{
    const splats_config *c = &splats_of(r->m)->config;

    progress_note(p, "data         %s%s: %" PRId64 " views to learn from, %" PRId64 " held out, up to %d x %d",
                  r->set.path, r->set.synthetic ? " (synthetic)" : "", r->train.count, r->held_out.count, c->width,
                  c->height);
    progress_note(p, "scene        extent %.3g, %d Gaussians %s, %d at most", c->extent, c->gaussians,
                  r->set.n_points ? "at the folder's points" : "anywhere between the cameras", c->cap);
}

static void run_facts(const task_run *r, cJSON *env)
{
    cJSON_AddStringToObject(env, "data", "transforms.json");
    cJSON_AddBoolToObject(env, "synthetic_data", r->set.synthetic);
}

/* ---- batches --------------------------------------------------------------------------------------------- */

static loader_source run_samples(const task_run *r)
{
    return splats_views_loader(&r->train);
}

static loader_source run_checked(const task_run *r)
{
    return splats_views_loader(&r->held_out);
}

static size_t run_sample_bytes(const task_run *r)
{
    (void)r;
    return sizeof(int64_t);
}

static double batch_weight(const void *batch)
{
    const splats_batch *b = batch;

    return b->count && b->view[0] >= 0;
}

static const char *run_sample_name(const task_run *r, const void *batch, int i)
{
    const splats_batch *b = batch;

    return i < b->count && b->view[i] >= 0 ? r->set.view[r->train.view[b->view[i]]].name : NULL;
}

/* ---- graphs ---------------------------------------------------------------------------------------------- */

static lt_status record_training(const void *ctx, model_record *out)
{
    const model *m = ((const splats_source *)ctx)->run->m;

    m->cls->record(m, true, out);
    return LT_OK;
}

static lt_status record_drawing(const void *ctx, model_record *out)
{
    const model *m = ((const splats_source *)ctx)->run->m;

    m->cls->record(m, false, out);
    return LT_OK;
}

/* What is drawn to be looked at has all harmonics: those that no step has moved are zeros. */
static double feed(const void *ctx, const lt_plan *p, const model_record *record, const void *batch, int first,
                   int which, int n)
{
    const splats_source *s = ctx;
    const splats_batch *b = batch;
    const bool training = record->loss != NULL;

    (void)which, (void)n;
    if (first >= b->count || b->view[first] < 0)
        return 0;
    splats_feed(s->run, p, record, s->view[b->view[first]], training ? s->run->degree : 3);
    return 1;
}

recipe splats_recipe(const splats_source *s, bool training)
{
    return (recipe){ .ctx = s, .batch = 1, .record = training ? record_training : record_drawing, .feed = feed };
}

static recipe run_recipe(const task_run *r, const task_phase *phase)
{
    return phase ? splats_recipe(&r->train, true) : splats_recipe(&r->held_out, false);
}

/* ---- steps ----------------------------------------------------------------------------------------------- */

static task_phase run_phase(const task_run *r, int64_t step)
{
    (void)step;
    return (task_phase){ .batch = 1, .shards = 1, .until = r->schedule.iterations,
                         .groups = (UINT64_C(1) << SPLATS_GROUPS) - 1,
                         .shape = (uint64_t)gaussians_capacity(&splats_of(r->m)->gaussians) };
}

static lt_status run_rows(task_run *r, const void *batch, int64_t step)
{
    const gaussians *g = &splats_of(r->m)->gaussians;
    lt_param *kind[GAUSSIANS_KINDS];
    const int kinds = gaussians_kinds(g, kind);
    lt_status st = LT_OK;

    r->degree = (int)lt_min_i64(3, step / r->schedule.sh_step);
    r->shown = batch_weight(batch) > 0;
    for (int i = 0; i < kinds && !st && r->shown; i++)
        st = lt_param_touch(kind[i], 0, gaussians_count(g, 0));
    return st;
}

static lt_real *run_observed(const task_run *r, int64_t *n)
{
    task_run *own = (task_run *)r;

    *n = 2 * gaussians_capacity(&splats_of(r->m)->gaussians);
    lt_release(own->seen);
    own->seen = lt_alloc((size_t)*n * sizeof(lt_real));
    return own->seen;
}

/* How far a Gaussian's place on the screen matters, in units of half an image */
static void run_observe(task_run *r, const compiled *c, const void *batch, int first)
{
    const splats *m = splats_of(r->m);
    const int64_t N = gaussians_capacity(&m->gaussians);
    const lt_real *g = lt_plan_grad(c->plan, model_port_find(&c->record.inputs, "offset"));
    const lt_real *radius = compiled_output(c, "radius");
    const double half_w = m->config.width / 2.0, half_h = m->config.height / 2.0;

    (void)batch, (void)first;
    for (int64_t i = 0; i < N; i++) {
        r->seen[i] = (lt_real)hypot(half_w * (double)g[2 * i], half_h * (double)g[2 * i + 1]);
        r->seen[N + i] = radius[i];
    }
}

static lt_status run_adapt(task_run *r, int64_t step, lt_optim *o)
{
    const gaussians *g = &splats_of(r->m)->gaussians;
    bool moved;

    if (!r->shown)
        return LT_OK;
    density_add(&r->density, 0, gaussians_count(g, 0), r->seen, r->seen + gaussians_capacity(g));
    return density_control(&r->density, &r->schedule.density, step, (uint64_t)r->config->loop.seed, o, &moved);
}

static int run_counts(const task_run *r, train_count out[TRAIN_COUNTS])
{
    out[0] = (train_count){ "gaussians", density_total(&splats_of(r->m)->gaussians) };
    out[1] = (train_count){ "densified", r->density.densified };
    out[2] = (train_count){ "pruned", r->density.pruned };
    return 3;
}

static int run_save(const task_run *r, lt_named_array *out, int room)
{
    return density_save(&r->density, out, room);
}

static lt_status run_load(task_run *r, const char *path, const lt_named_array *entry, size_t n)
{
    return density_load(&r->density, path, entry, n);
}

/* ---- scores ---------------------------------------------------------------------------------------------- */

static lt_status run_score(task_run *r, const compiled *c, const void *batch, records *out, bool *no_losses)
{
    const splats_batch *b = batch;
    double scores[SPLATS_SCORES];
    lt_status st;

    *no_losses = true;
    if (!(batch_weight(batch) > 0))
        return LT_OK;
    st = splats_score_view(r, c, r->held_out.view[b->view[0]], NULL, scores);
    return st ? st : records_add(out, b->view[0], scores, sizeof(scores));
}

/* The first of a view's scores */
enum { MEASURED = 2 };
static const char *const metrics[] = { "psnr_db", "ssim", NULL };

static void run_measure(task_run *r, const records *all, double *out)
{
    double sum[MEASURED] = { 0 };
    int64_t n[MEASURED] = { 0 };

    (void)r;
    for (int64_t i = 0; i < all->n; i++) {
        double scores[SPLATS_SCORES];
        size_t bytes;

        memcpy(scores, records_at(all, i, &bytes), sizeof(scores));
        for (int k = 0; k < MEASURED; k++)
            if (isfinite(scores[k])) {
                sum[k] += scores[k];
                n[k]++;
            }
    }
    for (int k = 0; k < MEASURED; k++)
        out[k] = n[k] ? sum[k] / (double)n[k] : NAN;
}

const task splats_task = {
    .name = "splats", .data_size = sizeof(splats_data_config), .data_keys = splats_data_keys, .metrics = metrics,
    .bytes = splats_bytes, .open = run_open, .close = run_close, .build = run_build, .describe = run_describe,
    .facts = run_facts, .samples = run_samples, .checked = run_checked, .sample_bytes = run_sample_bytes,
    .recipe = run_recipe, .weight = batch_weight, .sample_name = run_sample_name, .score = run_score,
    .measure = run_measure, .phase = run_phase, .groups = run_groups, .rows = run_rows, .observed = run_observed,
    .observe = run_observe, .adapt = run_adapt, .counts = run_counts, .save = run_save, .load = run_load,
    .evaluate = splats_evaluate, .scores = splats_score_keys, .predict = splats_predict, .pose = splats_show,
    .export = splats_export,
};
