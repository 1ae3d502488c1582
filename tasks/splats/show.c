/* SPDX-License-Identifier: Apache-2.0 */
/* What a trained scene shows: pictures of its views, itself as each view's camera sees it, its Gaussians as a file. */
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/write.h"
#include "libtensor/io/mesh/glb.h"
#include "libtensor/io/mesh/splat.h"
#include "tasks/splats/trained.h"

#include <inttypes.h>
#include <string.h>

/* ---- pictures -------------------------------------------------------------------------------------------- */

/* OUT/images/0001.png, by the name that the folder has for the view */
static lt_status write_view(const splats_trained *o, const char *folder, int view)
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
        splats_trained_draw(o, view);
        splats_trained_picture(o, view, 3 * (int64_t)p->width, (uint8_t *)im.data);
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
        splats_trained o;

        p->config->data->dir = p->inputs[i];
        st = splats_trained_open(p->arena, p->config, p->checkpoint, NULL, &o);
        for (int64_t k = 0; !st && k < o.views->count; k++) {
            st = p->stop && p->stop() ? LT_ESTOPPED : write_view(&o, p->out, o.views->view[k]);
            *written += !st;
        }
        splats_trained_close(&o);
    }
    return st;
}

/* ---- views, to be turned and filmed ---------------------------------------------------------------------- */

static lt_status no_surface(const posed_frame *f, int part, lt_opacity_rule rule, double iso, lt_arena *arena,
                            lt_mesh *out)
{
    (void)part, (void)rule, (void)iso, (void)arena, (void)out;
    return lt_error(LT_EINVAL, "%s: a still scene has no surface", f->name);
}

/* The Gaussians in the camera's frame, of the one colour that it sees of each */
static lt_status take_splats(const splats_trained *o, int view, lt_arena *arena, lt_splat **out, size_t *n)
{
    const lt_real *centre = compiled_output(&o->drawing, "centre"), *colour = compiled_output(&o->drawing, "colour");
    lt_status st = gaussians_splats(&splats_of(&o->m)->gaussians, 0, arena, out, n);
    double turn[4];

    lt_rot_to_quat(o->run.set.view[view].R_cam_world, turn);
    for (size_t i = 0; !st && i < *n; i++) {
        lt_splat *s = &(*out)[i];
        double q[4], rgb[3];

        for (int k = 0; k < 4; k++)
            q[k] = (double)s->rotation[k];
        lt_quat_mul(turn, q, q);
        for (int k = 0; k < 4; k++)
            s->rotation[k] = (float)q[k];
        for (size_t k = 0; k < 3; k++) {
            s->x[k] = (float)centre[3 * i + k];
            rgb[k] = (double)colour[3 * i + k];
        }
        lt_splat_paint(s, rgb);
        memset(s->rest, 0, sizeof(s->rest));
    }
    return st;
}

static lt_status show(const splats_trained *o, const task_posing *p, int64_t number, lt_arena *arena)
{
    const int view = o->views->view[number];
    const transforms_picture *picture = &o->run.picture[view];
    uint8_t *drawn = lt_arena_array(arena, 3 * (size_t)picture->width, (size_t)picture->height);
    posed_frame f = {
        .number = number, .name = o->run.set.view[view].name, .part = { "", "scene" }, .width = picture->width,
        .height = picture->height, .camera = picture->camera, .near = splats_near(splats_of(&o->m)),
        .white = splats_of(&o->m)->config.white, .truth = picture->rgb, .drawn = drawn,
        .R = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, .surface = no_surface,
    };
    double scores[SPLATS_SCORES];
    lt_splat *splat;
    lt_status st;

    if (!drawn)
        return lt_error(LT_ENOMEM, "no memory to show a view");
    splats_trained_draw(o, view);
    splats_trained_picture(o, view, 3 * (int64_t)picture->width, drawn);
    st = splats_score_view(&o->run, &o->drawing, view, NULL, scores);
    if (!st)
        st = take_splats(o, view, arena, &splat, &f.n[POSED_OBJECT]);
    if (st)
        return st;
    f.splat = splat;
    f.psnr_db = scores[SPLATS_PSNR];
    return p->visit(p->ctx, &f);
}

static lt_status show_number(const splats_trained *o, const task_posing *p, int64_t i)
{
    const int64_t all = o->views->count, number = p->frame ? p->frame[i] : i * all / lt_min_i64(p->n_frames, all);
    lt_arena *arena;
    lt_status st;

    if (number >= all)
        return lt_error(LT_EINVAL, "frame %" PRId64 ": %s has %" PRId64 " views that are held out, counted from 0",
                        number, o->run.set.path, all);
    arena = lt_arena_new();
    st = arena ? show(o, p, number, arena) : lt_error(LT_ENOMEM, "no memory to show a view");
    lt_arena_free(arena);
    return st;
}

lt_status splats_show(const task_posing *p)
{
    splats_trained o;
    lt_status st;

    if (p->data)
        p->config->data->dir = p->data;
    st = splats_trained_open(p->arena, p->config, p->checkpoint, NULL, &o);
    for (int64_t i = 0; !st && i < p->n_frames && (p->frame || i < o.views->count); i++)
        st = p->stop && p->stop() ? lt_error(LT_ESTOPPED, "stopped") : show_number(&o, p, i);
    splats_trained_close(&o);
    return st;
}

/* ---- Gaussians ------------------------------------------------------------------------------------------- */

lt_status splats_export(const task_export *e)
{
    splats_trained o;
    lt_splat *splat;
    size_t n;
    lt_status st = !e->file || e->animated || e->set
        ? lt_error(LT_EUSAGE, "%s: a still scene is written whole: -o FILE, as ply, glb or splat", e->checkpoint)
        : splats_trained_load(e->arena, e->config, e->checkpoint, &o);

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
    splats_trained_close(&o);
    return st;
}
