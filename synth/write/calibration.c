/* SPDX-License-Identifier: Apache-2.0 */
/* Where the cameras of a take stand to each other, as HO3D's calibration folders say it. */
#include "synth/write/calibration.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/number.h"
#include "vision/picture.h"

#include <stdio.h>
#include <string.h>

typedef struct {
    lt_arena *arena;
    const char *root, *folder;      /* folder: within root */
    synth_manifest *manifest;
} place;

static lt_status write_text(const place *p, const char *name, const char *text)
{
    const char *within = text ? lt_arena_printf(p->arena, "%s/%s", p->folder, name) : NULL;

    return within ? synth_manifest_text(p->manifest, p->root, within, text)
                  : lt_error(LT_ENOMEM, "%s: no memory", p->folder);
}

void synth_camera_to_first(const synth_camera *first, const synth_camera *c, double R[9], double t[3])
{
    double back[9], shift[3];

    lt_mat3_transpose(c->R_cam_world, back);
    lt_mat3_mul(first->R_cam_world, back, R);
    lt_mat3_mulvec(R, c->t_cam_world, shift);
    lt_vec3_sub(first->t_cam_world, shift, t);
}

static const char *matrix_text(lt_arena *arena, const double R[9], const double t[3])
{
    char n[12][LT_NUMBER_TEXT];

    for (int i = 0; i < 12; i++)
        lt_print_double(i % 4 < 3 ? R[3 * (i / 4) + i % 4] : t[i / 4], n[i]);
    return lt_arena_printf(arena, "%s %s %s %s\n%s %s %s %s\n%s %s %s %s\n0 0 0 1\n", n[0], n[1], n[2], n[3],
                           n[4], n[5], n[6], n[7], n[8], n[9], n[10], n[11]);
}

static const char *intrinsics_text(lt_arena *arena, const synth_camera *c)
{
    char n[4][LT_NUMBER_TEXT];

    return lt_arena_printf(arena, "fx: %s, fy: %s, ppx: %s, ppy: %s\n", lt_print_double(c->fx, n[0]),
                           lt_print_double(c->fy, n[1]), lt_print_double(c->cx, n[2]),
                           lt_print_double(c->cy, n[3]));
}

static lt_status write_camera(const place *p, const synth_camera *camera, int i)
{
    char name[48];
    double R[9], t[3];
    lt_status st;

    synth_camera_to_first(&camera[0], &camera[i], R, t);
    snprintf(name, sizeof(name), "trans_%d.txt", i);
    st = write_text(p, name, matrix_text(p->arena, R, t));
    snprintf(name, sizeof(name), "cam_%d_intrinsics.txt", i);
    return st ? st : write_text(p, name, intrinsics_text(p->arena, &camera[i]));
}

static lt_status write_all(const place *p, const synth_camera *camera, int n)
{
    const char *path = lt_path_join(p->arena, p->root, p->folder), *order = "";
    char unit[LT_NUMBER_TEXT];
    lt_status st = path ? lt_make_dirs(path) : lt_error(LT_ENOMEM, "%s: no memory", p->folder);

    for (int i = 0; i < n; i++)
        order = order ? lt_arena_printf(p->arena, "%s%d\n", order, i) : NULL;
    if (!st)
        st = write_text(p, "cam_orders.txt", order);
    if (!st)
        st = write_text(p, "cam_0_depth_scale.txt",
                        lt_arena_printf(p->arena, "%s\n", lt_print_double(HO3D_DEPTH_UNIT, unit)));
    for (int i = 0; !st && i < n; i++)
        st = write_camera(p, camera, i);
    return st;
}

lt_status synth_write_calibration(const char *root, const char *base, const synth_camera *camera, int n,
                                  synth_manifest *manifest)
{
    lt_arena *arena = lt_arena_new();
    const place p = { .arena = arena, .root = root, .manifest = manifest,
                      .folder = arena ? lt_arena_printf(arena, "calibration/%s/calibration", base) : NULL };
    const lt_status st = p.folder ? write_all(&p, camera, n) : lt_error(LT_ENOMEM, "%s: no memory", base);

    lt_arena_free(arena);
    return st;
}
