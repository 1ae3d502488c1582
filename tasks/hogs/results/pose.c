/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/results/pose.h"

#include "data/kind.h"
#include "tasks/hogs/results/shapes.h"
#include "tasks/hogs/score.h"
#include "tasks/hogs/source.h"

#include <inttypes.h>
#include <math.h>

lt_status hogs_open_trained(lt_arena *arena, train_config *config, const char *checkpoint, const char *hand,
                            const char *data, hogs_opened *out)
{
    hogs_data_config *d = (hogs_data_config *)config->data;
    const dataset_kind *kind;
    const char *split;
    lt_status st;

    *out = (hogs_opened){ .run = { .arena = arena, .config = config, .m = &out->m }, .params = lt_params_new() };
    if (!out->params)
        return lt_error(LT_ENOMEM, "no memory for the model");
    if (hand)
        d->hand = hand;
    if (data) {
        d->common.dir = data;
        d->poses = "";                                  /* the folder's own */
    }
    st = dataset_find_kind(d->common.dir, &kind);
    if (st)
        return st;
    split = dataset_validation_split(kind, d->common.dir);
    st = hogs_open_data(&out->run, config, split ? split : "train");
    return st ? st : hogs_open_model(&out->run, checkpoint, out->params);
}

void hogs_close_trained(hogs_opened *o)
{
    hogs_lists_free(&o->run.lists);
    hogs_close_data(&o->run);
    lt_params_free(o->params);
}

/* ---- a frame --------------------------------------------------------------------------------------------- */

typedef struct {
    const task_posing *p;
    const task_run *run;
    const int64_t *number;          /* (n_frames) of the chosen frames */
} job;

static lt_status surface(const posed_frame *f, int part, lt_opacity_rule rule, double iso, lt_arena *arena,
                         lt_mesh *out)
{
    return hogs_posed_mesh(arena, f->ctx, part == POSED_OBJECT, rule, iso, out);
}

/* The first three of some planes, side by side as bytes; NULL without memory */
static uint8_t *bytes_of(lt_arena *arena, const float *planes, int64_t pixels)
{
    uint8_t *rgb = lt_arena_array(arena, (size_t)pixels, 3);

    for (int64_t i = 0; rgb && i < 3 * pixels; i++)
        rgb[i] = (uint8_t)lroundf(255 * fminf(1, fmaxf(0, planes[i % 3 * pixels + i / 3])));
    return rgb;
}

static lt_status show(const job *j, const compiled *c, const hogs_frame *f, lt_arena *arena)
{
    const hogs *m = hogs_of(j->run->m);
    const lt_real *drawn = compiled_output(c, "frame"), *R = compiled_output(c, "pose_rotation"),
                  *t = compiled_output(c, "pose_translation");
    const int64_t pixels = (int64_t)m->config.width * m->config.height;
    posed_frame out = {
        .number = j->number[f->number], .name = dataset_name(j->run->train, f->index),
        .part = { hogs_set_name(arena, m, f->subject), hogs_set_name(arena, m, m->config.hands + f->object) },
        .width = m->config.width, .height = m->config.height, .camera = f->camera, .near = HOGS_NEAR,
        .white = m->config.white, .jittered = j->run->check_source.jitter,
        .truth = bytes_of(arena, f->target, pixels), .drawn = bytes_of(arena, drawn, pixels),
        .surface = surface, .ctx = c,
    };
    double scores[HOGS_SCORES];
    lt_splat *splat;
    lt_status st = out.part[0] && out.part[1] && out.truth && out.drawn
        ? hogs_posed_splats(arena, c, &splat, out.n) : lt_error(LT_ENOMEM, "no memory to show a frame");

    if (!st)
        st = hogs_score_images(m, f, drawn, scores);
    if (st)
        return st;
    out.splat = splat;
    out.psnr_db = scores[HOGS_PSNR];
    for (int k = 0; k < 9; k++)
        out.R[k] = (double)R[k];
    for (int k = 0; k < 3; k++)
        out.t[k] = (double)t[k];
    return j->p->visit(j->p->ctx, &out);
}

static lt_status visit(void *ctx, const compiled *c, const void *batch)
{
    const job *j = ctx;
    const hogs_batch *b = batch;
    const hogs_frame *f = &b->frame[0];
    lt_arena *arena;
    lt_status st;

    if (!b->count)
        return LT_OK;
    if (!f->there)
        return !j->p->frame ? LT_OK : lt_error(LT_EINVAL, "frame %" PRId64 ": neither hand nor object is seen in it",
                                               j->number[f->number]);
    arena = lt_arena_new();
    st = arena ? show(j, c, f, arena) : lt_error(LT_ENOMEM, "no memory to show a frame");
    lt_arena_free(arena);
    return st;
}

static void skipped(void *ctx, int i, const char *line)
{
    (void)ctx, (void)i, (void)line;                     /* nothing is tolerated */
}

/* ---- all of them ------------------------------------------------------------------------------------------ */

/* The frames that are asked for, by their numbers among those with poses */
static lt_status choose(job *j, hogs_source *s)
{
    const task_posing *p = j->p;
    const int64_t *index;
    int64_t count, *chosen, *number;
    lt_status st = hogs_frames_of(p->arena, s->data, s->poses, &index, &count);

    if (st)
        return st;
    s->count = p->frame ? p->n_frames : lt_min_i64(p->n_frames, count);
    chosen = lt_arena_array(p->arena, (size_t)s->count, sizeof(*chosen));
    number = lt_arena_array(p->arena, (size_t)s->count, sizeof(*number));
    if (!chosen || !number)
        return lt_error(LT_ENOMEM, "no memory for %" PRId64 " frames", s->count);
    for (int64_t i = 0; i < s->count; i++) {
        number[i] = p->frame ? p->frame[i] : i * count / s->count;
        if (number[i] >= count)
            return lt_error(LT_EINVAL, "frame %" PRId64 ": %s, split %s, has %" PRId64 " with poses, counted from 0",
                            number[i], s->data->root, s->data->split, count);
        chosen[i] = index[number[i]];
    }
    s->index = chosen;
    j->number = number;
    return LT_OK;
}

lt_status hogs_show(const task_posing *p)
{
    hogs_opened o;
    job j = { .p = p, .run = &o.run };
    compiled c = { 0 };
    lt_status st = hogs_open_trained(p->arena, p->config, p->checkpoint, p->hand, p->data, &o);

    if (!st) {
        const recipe by = hogs_recipe(&o.run, HOGS_RENDER);

        o.run.check_source = hogs_source_of(&o.run, o.run.train, o.run.train_poses);
        st = choose(&j, &o.run.check_source);
        if (!st)
            st = compiled_new(&by, 1, false, &c);
        if (!st) {
            const loader_source frames = hogs_frames_loader(&o.run.check_source);

            st = compiled_walk(&c, &frames, p->config->data->threads, 0, visit, skipped, &j, p->stop);
        }
        compiled_free(&c);
    }
    hogs_close_trained(&o);
    return st;
}
