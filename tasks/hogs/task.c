/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The task of HOGS: what the trainer asks of it.
 */
#include "tasks/hogs/task.h"

#include "data/kind.h"
#include "estimate/checkpoint/checkpoint.h"
#include "tasks/hogs/backbone.h"
#include "tasks/hogs/results/evaluate.h"
#include "tasks/hogs/results/export.h"
#include "tasks/hogs/results/pose.h"
#include "tasks/hogs/results/render.h"
#include "tasks/hogs/source.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

static const size_t MB = 1000000;

/* ---- opening --------------------------------------------------------------------------------------------- */

/* Evaluation frames, spread evenly over the split */
static lt_status choose_checked(task_run *r, const train_config *c)
{
    hogs_source *s = &r->check_source;
    const int64_t *index;
    int64_t count, *some;
    lt_status st;

    if (!r->check_poses)
        return LT_OK;
    *s = hogs_source_of(r, r->evaluation, r->check_poses);
    st = hogs_frames_of(r->arena, r->evaluation, r->check_poses, &index, &count);
    if (st)                             /* none has poses of both */
        return st == LT_ENOMEM ? st : LT_OK;
    s->count = lt_min_i64(count, c->loop.validate_samples);
    some = lt_arena_array(r->arena, (size_t)s->count, sizeof(*some));
    for (int64_t i = 0; some && i < s->count; i++)
        some[i] = index[i * count / s->count];
    s->index = some;
    return some ? LT_OK : lt_error(LT_ENOMEM, "no memory to begin");
}

/* What the ViT saw of frames, of models of the paper's size alone */
static size_t run_bytes(const train_config *c, const char **less)
{
    const cJSON *size = cJSON_GetObjectItemCaseSensitive(c->model_keys, "size");

    *less = "data.cache_mb";
    return cJSON_IsString(size) && strcmp(size->valuestring, "full") == 0 ? (size_t)hogs_data_of(c)->cache_mb * MB : 0;
}

static lt_status run_open(lt_arena *arena, train_config *c, task_run **out)
{
    task_run *r = lt_arena_alloc(arena, sizeof(*r));
    lt_status st;

    *out = r;
    if (!r)
        return lt_error(LT_ENOMEM, "no memory to begin");
    *r = (task_run){ .arena = arena, .config = c, .iteration = -1 };
    st = hogs_open_data(r, c, NULL);
    if (st)
        return st;
    r->train_source = hogs_source_of(r, r->train, r->train_poses);
    r->train_source.training = true;
    st = hogs_frames_of(arena, r->train, r->train_poses, &r->train_source.index, &r->train_source.count);
    if (!st)
        st = hogs_frames_check(&r->train_source);
    if (!st)
        st = choose_checked(r, c);
    return st ? st : hogs_find_training_sets(r, c);
}

static void run_close(task_run *r)
{
    if (r->vit_cache)
        vit_cache_free(r->vit_cache);
    density_free(&r->density);
    hogs_lists_free(&r->lists);
    lt_release(r->seen);
    hogs_close_data(r);
}

static lt_status check_codes(const hogs *m, int64_t frames)
{
    if (!m->is->avatar || m->config.frames == frames)
        return LT_OK;
    return lt_error(LT_EINVAL, "model.frames is %d, but the data have %" PRId64 " frames to train on; leave it out of "
                    "the configuration to have as many as the data", m->config.frames, frames);
}

static lt_status new_density(density *d, const hogs *m)
{
    return density_new(d, &m->gaussians, &(density_limits){
        .extent = HOGS_EXTENT, .least_opacity = 0.05, .most_pixels = 20, .cap = 4 * (int64_t)m->config.gaussians,
        .reset_at_start = m->config.white });
}

/* The paper's ViT is CLIP's, and stays as it is: what it sees of a frame is the same in each epoch. */
static lt_status freeze_vit(task_run *r, const train_config *c, lt_params *set, model *m)
{
    const hogs_data_config *d = hogs_data_of(c);

    for (lt_param *p = lt_params_first(set); p; p = p->next)
        if (strncmp(p->name, "vit.", 4) == 0)
            p->frozen = true;
    r->vit_cache = lt_arena_alloc(r->arena, sizeof(*r->vit_cache));
    if (!r->vit_cache)
        return lt_error(LT_ENOMEM, "no memory to begin");
    hogs_take_seen(m);
    return vit_cache_new(hogs_of(m), r->train_source.count, d->jitter ? 0 : (size_t)d->cache_mb * MB,
                         r->vit_cache);
}

static lt_status run_build(task_run *r, const train_config *c, lt_params *set, model *out)
{
    const hogs_data_config *d = hogs_data_of(c);
    lt_status st = train_config_model(c, NULL, set, out);
    const hogs *m;

    if (st)
        return st;
    r->m = out;
    m = hogs_of(out);
    r->train_source.m = r->check_source.m = out;
    st = check_codes(m, r->train_source.count);
    if (!st)
        st = hogs_give_sets(out, &r->sets);
    if (!st)
        st = new_density(&r->density, m);
    if (st)
        return st;
    r->schedule = hogs_schedule_of(m, d->iterations, d->pose_epochs, r->train_source.count);
    for (int i = 0; i < HOGS_STAGES; i++)
        r->feeder[i] = (hogs_feeder){ r, (hogs_stage)i };
    return m->config.small || m->is->avatar ? LT_OK : freeze_vit(r, c, set, out);
}

/* ---- telling --------------------------------------------------------------------------------------------- */

static void run_describe(const task_run *r, train_progress *p)
{
    const hogs *m = hogs_of(r->m);
    const hogs_schedule *s = &r->schedule;

    progress_note(p, "data         %s%s, %s: %" PRId64 " frames to train on, %" PRId64 " to validate", r->train->title,
                  r->train->synthetic ? " (synthetic)" : "", r->train->root, r->train_source.count,
                  r->check_source.count);
    progress_note(p, "poses        %s", initial_poses_how(r->train_poses));
    progress_note(p, "sets         %d hands, %d objects, %d Gaussians each, %" PRId64 " at most", r->sets.hands,
                  r->sets.objects, m->config.gaussians, r->density.limits.cap);
    progress_note(p, "stages       %" PRId64 " steps of skinning, %" PRId64 " iterations%s, %" PRId64 " steps of poses",
                  s->skin, s->iterations, m->is->gpm ? "" : " without G-PM", s->poses);
    if (r->vit_cache)
        progress_note(p, "vit          does not learn: what it sees is kept of %" PRId64 " frames, %.0f MB",
                      lt_min_i64(r->vit_cache->room, r->train_source.count),
                      1e-6 * (double)vit_cache_bytes(m)
                          * (double)lt_min_i64(r->vit_cache->room, r->train_source.count));
    if (lpips_is_random(&m->lpips))
        progress_note(p, "lpips        random trunk: --init with AlexNet's weights makes it the metric");
    if (m->is->gpm && !*m->config.point_backbone)
        progress_note(p, "points       a random backbone: model.point_backbone names a pretrained one");
}

static void run_facts(const task_run *r, cJSON *env)
{
    cJSON_AddStringToObject(env, "data", r->train->title);
    cJSON_AddBoolToObject(env, "synthetic_data", r->train->synthetic);
    cJSON_AddBoolToObject(env, "synthetic_hand", r->hands.right->synthetic);
    cJSON_AddStringToObject(env, "poses", initial_poses_how(r->train_poses));
}

/* ---- batches --------------------------------------------------------------------------------------------- */

static loader_source run_samples(const task_run *r)
{
    return hogs_frames_loader(&r->train_source);
}

static loader_source run_checked(const task_run *r)
{
    return hogs_frames_loader(&r->check_source);
}

static size_t run_sample_bytes(const task_run *r)
{
    const hogs *m = hogs_of(r->m);
    const size_t pixels = (size_t)m->config.width * (size_t)m->config.height;

    return (HOGS_TARGETS * pixels + 3 * (size_t)m->sizes.crop * (size_t)m->sizes.crop) * sizeof(float) + pixels;
}

static double batch_weight(const void *batch)
{
    const hogs_batch *b = batch;
    double sum = 0;

    for (int i = 0; i < b->count; i++)
        sum += b->frame[i].there;
    return sum;
}

static const char *run_sample_name(const task_run *r, const void *batch, int i)
{
    const hogs_batch *b = batch;

    return i < b->count ? dataset_name(r->train, b->frame[i].index) : NULL;
}

/* ---- stages ---------------------------------------------------------------------------------------------- */

static const char *const stage_names[HOGS_STAGES] = {
    [HOGS_SKIN] = "skin", [HOGS_WARM] = "warm", [HOGS_GAUSSIANS] = "gaussians", [HOGS_JOINT] = "joint",
    [HOGS_POSES] = "poses",
};

/* The first step behind this stage */
static int64_t end_of(const hogs_schedule *s, hogs_stage stage)
{
    const int64_t end[HOGS_STAGES] = {
        [HOGS_SKIN] = s->skin, [HOGS_WARM] = s->skin + s->warm, [HOGS_GAUSSIANS] = s->skin + s->gpm_start,
        [HOGS_JOINT] = s->skin + s->iterations, [HOGS_POSES] = s->skin + s->iterations + s->poses,
    };

    return end[stage];
}

static task_phase run_phase(const task_run *r, int64_t step)
{
    const hogs_schedule *s = &r->schedule;
    const hogs_stage stage = hogs_stage_of(s, lt_min_i64(step, s->skin + s->iterations + s->poses - 1));
    const int batch = stage == HOGS_POSES ? HOGS_POSE_BATCH : 1;

    return (task_phase){
        .name = stage_names[stage], .batch = batch, .shards = 1, .until = end_of(s, stage),
        .groups = hogs_stage_groups(stage),
        .shape = (uint64_t)gaussians_capacity(&hogs_of(r->m)->gaussians) << 8 | (uint64_t)stage,
    };
}

static recipe run_recipe(const task_run *r, const task_phase *phase)
{
    return hogs_recipe(r, phase ? (hogs_stage)(phase->shape & 0xff) : HOGS_RENDER);
}

static const lt_optim_group *run_groups(const task_run *r, int *n, lt_optim_average *average)
{
    (void)average;
    return hogs_optim_groups(hogs_of(r->m), &r->schedule, ((task_run *)r)->group, n);
}

/* ---- steps ----------------------------------------------------------------------------------------------- */

static lt_status touch_set(const hogs *m, int set)
{
    lt_param *kind[GAUSSIANS_KINDS];
    const int kinds = gaussians_kinds(&m->gaussians, kind);
    lt_status st = LT_OK;

    for (int i = 0; i < kinds && !st; i++)
        st = lt_param_touch(kind[i], gaussians_first(&m->gaussians, set), gaussians_count(&m->gaussians, set));
    return st;
}

static lt_status touch_appearance(const hogs *m, const hogs_frame *f)
{
    lt_status st;

    if (m->is->avatar)
        return avatar_touch(&m->avatar, f->subject, f->object, f->number);
    st = set_mlp_touch(&m->hand.trunk, f->subject);
    return st ? st : set_mlp_touch(&m->object.trunk, f->object);
}

static lt_status touch_frame(const hogs *m, const hogs_frame *f)
{
    lt_status st = touch_set(m, f->subject);

    if (!st)
        st = touch_set(m, m->config.hands + f->object);
    if (!st)
        st = set_mlp_touch(&m->skin.mlp, f->subject);
    return st ? st : touch_appearance(m, f);
}

static bool lists_are_due(const task_run *r)
{
    const hogs_schedule *s = &r->schedule;

    return r->lists.rows == 0
        || (r->iteration > 0 && r->iteration <= s->iterations && r->iteration % s->lists == 0)
        || r->iteration == s->gpm_start || r->iteration == s->iterations;
}

static lt_status run_rows(task_run *r, const void *batch, int64_t step)
{
    const hogs *m = hogs_of(r->m);
    const hogs_batch *b = batch;
    lt_status st = LT_OK;

    r->iteration = step - r->schedule.skin;
    r->degree = r->iteration < 0 ? 0 : (int)lt_min_i64(3, r->iteration / r->schedule.sh_step);
    r->frame = b->count && b->frame[0].there ? &b->frame[0] : NULL;
    if (step == 0 && m->is->gpm && !m->is->random_points && *m->config.point_backbone)
        st = hogs_load_backbone(r->m->params, m->config.point_backbone);
    if (!st && r->vit_cache)
        st = vit_cache_begin(r->vit_cache);
    if (!st && lists_are_due(r))
        st = hogs_lists_make(&r->lists, m, r->rig);
    for (int i = 0; i < b->count && !st; i++)
        if (b->frame[i].there)
            st = touch_frame(m, &b->frame[i]);
    return st;
}

/* ---- density control ------------------------------------------------------------------------------------- */

/* Slope and radius of each row of the two sets that a frame shows */
static lt_real *run_observed(const task_run *r, int64_t *n)
{
    task_run *own = (task_run *)r;
    const int64_t capacity = gaussians_capacity(&hogs_of(r->m)->gaussians);

    *n = 4 * capacity;
    lt_release(own->seen);
    own->seen = lt_alloc((size_t)*n * sizeof(lt_real));
    return own->seen;
}

static void observe_set(const task_run *r, const compiled *c, bool object, lt_real *slope, lt_real *radius)
{
    const hogs *m = hogs_of(r->m);
    const int64_t N = gaussians_capacity(&m->gaussians);
    const lt_tensor *offset = model_port_find(&c->record.inputs, object ? "object_offset" : "hand_offset");
    const lt_real *g = lt_plan_grad(c->plan, offset), *all = compiled_output(c, "radius");
    const double half_w = m->config.width / 2.0, half_h = m->config.height / 2.0;

    for (int64_t i = 0; i < N; i++) {
        slope[i] = (lt_real)hypot(half_w * (double)g[2 * i], half_h * (double)g[2 * i + 1]);
        radius[i] = all[(object ? N : 0) + i];
    }
}

static void run_observe(task_run *r, const compiled *c, const void *batch, int first)
{
    const int64_t N = gaussians_capacity(&hogs_of(r->m)->gaussians);

    (void)batch, (void)first;
    if (!model_port_find(&c->record.inputs, "hand_offset")) {
        memset(r->seen, 0, 4 * (size_t)N * sizeof(*r->seen));
        return;
    }
    observe_set(r, c, false, r->seen, r->seen + N);
    observe_set(r, c, true, r->seen + 2 * N, r->seen + 3 * N);
}

static void add_observed(task_run *r)
{
    const hogs *m = hogs_of(r->m);
    const int64_t N = gaussians_capacity(&m->gaussians);
    const int set[2] = { r->frame->subject, m->config.hands + r->frame->object };

    for (int i = 0; i < 2; i++)
        density_add(&r->density, gaussians_first(&m->gaussians, set[i]), gaussians_count(&m->gaussians, set[i]),
                    r->seen + 2 * i * N, r->seen + (2 * i + 1) * N);
}

/* Stage 2 has a rate of its own, and is not clipped. */
static void set_pose_rate(const hogs *m, lt_optim *o)
{
    lt_optim_group g;
    const int k = hogs_pose_group(m, &g);

    lt_optim_set_group(o, k, &g);
}

static lt_status run_adapt(task_run *r, int64_t step, lt_optim *o)
{
    const hogs_schedule *s = &r->schedule;
    bool moved = false;
    lt_status st;

    (void)step;
    if (r->iteration >= s->iterations)
        set_pose_rate(hogs_of(r->m), o);
    if (r->iteration < 0 || r->iteration >= s->iterations || !r->frame)
        return LT_OK;
    add_observed(r);
    st = density_control(&r->density, &s->density, r->iteration, (uint64_t)r->config->loop.seed, o, &moved);
    if (!st && moved)
        st = hogs_lists_make(&r->lists, hogs_of(r->m), r->rig);
    return st;
}

static int run_counts(const task_run *r, train_count out[TRAIN_COUNTS])
{
    out[0] = (train_count){ "gaussians", density_total(&hogs_of(r->m)->gaussians) };
    out[1] = (train_count){ "densified", r->density.densified };
    out[2] = (train_count){ "pruned", r->density.pruned };
    return 3;
}

/* ---- its own state --------------------------------------------------------------------------------------- */

static int run_save(const task_run *r, lt_named_array *out, int room)
{
    hogs_lists *l = (hogs_lists *)&r->lists;
    const int n = l->rows ? hogs_lists_save(l, out, room) : 0;

    return n + density_save(&r->density, out + n, room - n);
}

static lt_status run_load(task_run *r, const char *path, const lt_named_array *entry, size_t n)
{
    const lt_status st = hogs_lists_load(&r->lists, hogs_of(r->m), path, entry, n);

    return st ? st : density_load(&r->density, path, entry, n);
}

/* ---- scores ---------------------------------------------------------------------------------------------- */

static lt_status run_score(task_run *r, const compiled *c, const void *batch, records *out, bool *no_losses)
{
    const hogs_batch *b = batch;
    const hogs_frame *f = &b->frame[0];
    double scores[HOGS_SCORES];
    lt_status st;

    *no_losses = true;
    if (!b->count || !f->there)
        return LT_OK;
    st = hogs_score_frame(r->m, r->check_source.data, f, c, scores);
    return st ? st : records_add(out, f->index, scores, sizeof(scores));
}

static const hogs_score measured[] = { HOGS_PSNR, HOGS_SSIM, HOGS_PSNR_FG, HOGS_OCE, HOGS_MCE, HOGS_ADDS };
static const char *const metrics[] = { "psnr_db", "ssim", "psnr_fg_db", "oce_mm", "mce_mm", "adds_mm", NULL };

static void run_measure(task_run *r, const records *all, double *out)
{
    hogs_means means = { 0 };

    (void)r;
    for (int64_t i = 0; i < all->n; i++) {
        double scores[HOGS_SCORES];
        size_t bytes;

        memcpy(scores, records_at(all, i, &bytes), sizeof(scores));
        hogs_means_add(&means, scores);
    }
    for (size_t i = 0; i < LT_COUNT(measured); i++)
        out[i] = hogs_means_of(&means, measured[i]);
}

const task hogs_task = {
    .name = "hogs", .data_size = sizeof(hogs_data_config), .data_keys = hogs_data_keys, .metrics = metrics,
    .bytes = run_bytes, .open = run_open, .close = run_close, .build = run_build, .describe = run_describe,
    .facts = run_facts,
    .samples = run_samples, .checked = run_checked, .sample_bytes = run_sample_bytes, .recipe = run_recipe,
    .weight = batch_weight, .sample_name = run_sample_name, .score = run_score, .measure = run_measure,
    .phase = run_phase, .groups = run_groups, .rows = run_rows, .observed = run_observed, .observe = run_observe,
    .adapt = run_adapt, .counts = run_counts, .save = run_save, .load = run_load, .evaluate = hogs_evaluate,
    .scores = hogs_score_keys,
    .predict = hogs_render, .export = hogs_export, .pose = hogs_show,
};
