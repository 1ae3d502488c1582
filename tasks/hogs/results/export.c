/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/results/export.h"

#include "libtensor/base/clock.h"
#include "libtensor/geometry/mesh/parts.h"
#include "libtensor/io/file.h"
#include "libtensor/io/mesh/glb.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/mesh/splat.h"
#include "tasks/hogs/results/animation.h"
#include "tasks/hogs/results/pose.h"
#include "tasks/hogs/results/shapes.h"

#include <inttypes.h>
#include <string.h>

/* ---- files ----------------------------------------------------------------------------------------------------- */

static lt_status write_mesh(const char *path, const char *format, const char *name, lt_mesh *m)
{
    if (strcmp(format, "obj") == 0)
        return lt_obj_write(path, m, NULL);
    if (strcmp(format, "glb") != 0)
        return lt_ply_write_mesh(path, m);
    hogs_linear_colours(m);
    return lt_glb_write(path, &(lt_glb_part){ .name = name, .mesh = m, .color = { 1, 1, 1, 1 } }, 1);
}

static lt_status write_splats(const task_export *e, const char *name, const char *frame, const lt_splat *s, size_t n,
                              int degree)
{
    if (strcmp(e->format, "splat") == 0)
        return lt_splat_write(e->file, s, n);
    if (strcmp(e->format, "glb") == 0)
        return lt_glb_write_splats(e->file, name, s, n, degree);
    return lt_ply_write_splats(e->file, frame, s, n);
}

/* ---- frames ---------------------------------------------------------------------------------------------------- */

static lt_status export_mesh(const task_export *e, const posed_frame *f, int part, lt_arena *arena)
{
    static const char *const names[POSED_PARTS] = { "hand", "object" };
    const char *path = lt_arena_printf(arena, "%s/frame-%04" PRId64 "-%s.%s", e->folder, f->number, names[part],
                                       e->format);
    const double began = lt_clock();
    lt_mesh_topology t;
    lt_mesh m;
    lt_status st = path ? f->surface(f, part, e->rule, e->iso, arena, &m)
                        : lt_error(LT_ENOMEM, "%s: no memory", e->folder);
    const double seconds = lt_clock() - began;

    if (!st)
        st = lt_mesh_topology_of(&m, &t);
    if (!st)
        st = write_mesh(path, e->format, names[part], &m);
    if (!st)
        e->made(e->ctx, &(task_exported){ .file = path, .part = names[part], .frame = f->number,
                                          .vertices = m.n_vertices, .faces = m.n_faces, .watertight = t.watertight,
                                          .components = t.components, .seconds = seconds });
    return st;
}

static lt_status export_frame(void *ctx, const posed_frame *f)
{
    const task_export *e = ctx;
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "no memory for a surface");

    for (int part = 0; part < POSED_PARTS && !st && e->folder; part++)
        st = export_mesh(e, f, part, arena);
    if (!st && e->file)
        st = write_splats(e, "frame", "opencv camera, metres", f->splat, f->n[POSED_HAND] + f->n[POSED_OBJECT], 0);
    lt_arena_free(arena);
    return st;
}

static lt_status export_frames(const task_export *e)
{
    const task_posing p = { .arena = e->arena, .config = e->config, .checkpoint = e->checkpoint, .hand = e->hand,
                            .frame = e->frame, .n_frames = e->n_frames, .visit = export_frame, .ctx = (void *)e };
    const lt_status st = e->folder ? lt_make_dirs(e->folder) : LT_OK;

    return st ? st : hogs_show(&p);
}

/* ---- sets ------------------------------------------------------------------------------------------------------ */

static lt_status unknown_set(lt_arena *arena, const task_export *e, const hogs *m)
{
    const char *all = "";

    for (int i = 0; i < hogs_n_sets(m) && all; i++)
        all = lt_arena_printf(arena, "%s%s%s", all, i ? ", " : "", hogs_set_name(arena, m, i));
    return lt_error(LT_EINVAL, "%s: no set \"%s\"; it has %s", e->checkpoint, e->set, all ? all : "others");
}

static lt_status write_set(const task_export *e, const hogs *m)
{
    for (int i = 0; i < hogs_n_sets(m); i++) {
        const char *name = hogs_set_name(e->arena, m, i);
        lt_splat *splat;
        size_t n;
        lt_status st;

        if (!name || strcmp(name, e->set) != 0)
            continue;
        st = gaussians_splats(&m->gaussians, i, e->arena, &splat, &n);
        return st ? st : write_splats(e, name, "canonical, metres", splat, n, 3);
    }
    return unknown_set(e->arena, e, m);
}

static lt_status export_set(const task_export *e)
{
    hogs_opened o;
    lt_status st = hogs_open_trained(e->arena, e->config, e->checkpoint, e->hand, NULL, &o);

    if (!st)
        st = write_set(e, hogs_of(o.run.m));
    hogs_close_trained(&o);
    return st;
}

/* ---- frames, one after the other ------------------------------------------------------------------------------- */

static lt_status export_animation(const task_export *e)
{
    hogs_animation a = { .arena = e->arena, .rule = e->rule, .iso = e->iso };
    const task_posing p = { .arena = e->arena, .config = e->config, .checkpoint = e->checkpoint, .hand = e->hand,
                            .frame = e->frame, .n_frames = e->n_frames, .visit = hogs_animation_add, .ctx = &a };
    const lt_status st = hogs_show(&p);

    return st ? st : hogs_animation_write(&a, e->file);
}

lt_status hogs_export(const task_export *e)
{
    if (e->animated)
        return export_animation(e);
    return e->set ? export_set(e) : export_frames(e);
}
