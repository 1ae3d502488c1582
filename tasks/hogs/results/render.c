/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/results/render.h"

#include "data/kind.h"
#include "libtensor/base/clock.h"
#include "libtensor/base/printable.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/write.h"
#include "tasks/hogs/results/shapes.h"
#include "tasks/hogs/source.h"

#include <math.h>
#include <string.h>

enum { OPACITY = 9 };                           /* of the frame's channels: the joint mask */
enum { IMAGES = 3, OVERLAY = IMAGES, SPLATS, FILES };

typedef struct {
    const task_prediction *p;
    task_run *run;
    const char *folder;
    double began;
    int64_t written;
} job;

static lt_status write_splats(const char *path, const compiled *c, lt_arena *arena)
{
    lt_splat *splat;
    size_t n[2];
    const lt_status st = hogs_posed_splats(arena, c, &splat, n);

    return st ? st : lt_ply_write_splats(path, "opencv camera, metres", splat, n[0] + n[1]);
}

/* ---- pictures -------------------------------------------------------------------------------------------- */

static uint8_t byte_of(double x)
{
    return (uint8_t)lround(255 * fmin(1, fmax(0, x)));
}

static lt_status write_planes(const char *path, const lt_real *planes, int width, int height, uint8_t *rgb)
{
    const int64_t n = (int64_t)width * height;

    for (int64_t i = 0; i < 3 * n; i++)
        rgb[i] = byte_of((double)planes[i % 3 * n + i / 3]);
    return lt_png_write_fast(path, &(lt_image){ width, height, 3, 8, rgb });
}

/* What is drawn over the image, as much as it covers */
static lt_status write_overlay(const char *path, const lt_real *frame, const dataset_sample *s, uint8_t *rgb)
{
    const int64_t n = (int64_t)s->width * s->height;

    for (int64_t i = 0; i < 3 * n; i++) {
        const double covered = (double)frame[OPACITY * n + i / 3];

        rgb[i] = byte_of((double)frame[i % 3 * n + i / 3] + (1 - covered) * s->rgb[i] / 255);
    }
    return lt_png_write_fast(path, &(lt_image){ s->width, s->height, 3, 8, rgb });
}

static lt_status write_frame(const job *j, const hogs_frame *f, const compiled *c, lt_arena *arena)
{
    static const char *const names[FILES] = { "joint.png", "hand.png", "object.png", "overlay.png", "splats.ply" };
    const char *path[FILES], *base = lt_arena_printf(arena, "%s/%s", j->folder, dataset_name(j->run->train, f->index));
    const lt_real *frame = compiled_output(c, "frame");
    dataset_sample sample;
    uint8_t *rgb;
    lt_status st = base ? lt_make_dirs(base) : lt_error(LT_ENOMEM, "%s: no memory", j->folder);

    for (int i = 0; i < FILES && !st; i++) {
        path[i] = lt_path_join(arena, base, names[i]);
        if (!path[i])
            st = lt_error(LT_ENOMEM, "%s: no memory", base);
    }
    if (!st)
        st = dataset_read(j->run->train, f->index, 0, arena, &sample);
    if (st)
        return st;
    rgb = lt_arena_array(arena, (size_t)sample.width * (size_t)sample.height, 3);
    if (!rgb)
        return lt_error(LT_ENOMEM, "%s: no memory", base);
    for (size_t i = 0; i < IMAGES && !st; i++)
        st = write_planes(path[i], frame + 3 * (int64_t)i * sample.width * sample.height, sample.width, sample.height,
                          rgb);
    if (!st)
        st = write_overlay(path[OVERLAY], frame, &sample, rgb);
    return st ? st : write_splats(path[SPLATS], c, arena);
}

static lt_status visit(void *ctx, const compiled *c, const void *batch)
{
    job *j = ctx;
    const hogs_batch *b = batch;
    lt_arena *arena;
    lt_status st;

    if (!b->count || !b->frame[0].there)
        return LT_OK;
    arena = lt_arena_new();
    st = arena ? write_frame(j, &b->frame[0], c, arena) : lt_error(LT_ENOMEM, "no memory to draw");
    lt_arena_free(arena);
    if (!st && j->written++ == 0 && j->p->messages)
        fprintf(j->p->messages, "first rendering after %.2f s, without an optimiser's step\n", lt_clock() - j->began);
    return st;
}

static void skipped(void *ctx, int i, const char *line)
{
    const job *j = ctx;

    (void)i;
    if (j->p->messages)
        lt_say(j->p->messages, "%s", line);
}

/* ---- a folder -------------------------------------------------------------------------------------------- */

static lt_status draw_all(job *j)
{
    task_run *r = j->run;
    const hogs_data_config *d = hogs_data_of(r->config);
    hogs_source *s = &r->check_source;
    const recipe by = hogs_recipe(r, HOGS_RENDER);
    loader_source frames;
    compiled c = { 0 };
    lt_status st;

    *s = hogs_source_of(r, r->train, r->train_poses);
    s->jitter = false;
    st = hogs_frames_of(r->arena, r->train, r->train_poses, &s->index, &s->count);
    if (!st)
        st = compiled_new(&by, 1, false, &c);
    frames = hogs_frames_loader(s);
    if (!st)
        st = compiled_walk(&c, &frames, d->common.threads, 1, visit, skipped, j, j->p->stop);
    compiled_free(&c);
    return st;
}

static lt_status render_folder(const task_prediction *p, const char *input, lt_params *set, int64_t *written)
{
    model m;
    task_run run = { .arena = p->arena, .config = p->config, .m = &m };
    job j = { .p = p, .run = &run, .folder = p->out, .began = lt_clock() };
    const dataset_kind *kind;
    const char *split;
    lt_status st = dataset_find_kind(input, &kind);

    if (st)
        return st;
    p->config->data->dir = input;
    ((hogs_data_config *)p->config->data)->poses = "";          /* the folder's own */
    split = dataset_validation_split(kind, input);
    st = hogs_open_data(&run, p->config, split ? split : "train");
    if (!st)
        st = hogs_open_model(&run, p->checkpoint, set);
    if (!st)
        st = draw_all(&j);
    *written += j.written;
    hogs_lists_free(&run.lists);
    hogs_close_data(&run);
    return st;
}

lt_status hogs_render(const task_prediction *p, int64_t *written)
{
    lt_status st = lt_make_dirs(p->out);

    *written = 0;
    if (p->hand)
        ((hogs_data_config *)p->config->data)->hand = p->hand;
    for (int i = 0; i < p->n_inputs && !st; i++) {
        lt_params *set = lt_params_new();

        st = set ? render_folder(p, p->inputs[i], set, written) : lt_error(LT_ENOMEM, "no memory for the model");
        lt_params_free(set);
    }
    return st;
}
