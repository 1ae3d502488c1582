/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/write/bop.h"

#include "assets/ycb/objects.h"
#include "assets/ycb/symmetry.h"
#include "eval/metrics/object_pose.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/io/file.h"
#include "libtensor/io/mesh/ply.h"

#include <math.h>
#include <stdio.h>

#define MM 1000.0

/* ---- a scene ------------------------------------------------------------------------------------------------ */

lt_status synth_bop_open(synth_bop_scene *s)
{
    lt_status st;

    *s = (synth_bop_scene){ 0 };
    st = synth_growing_open(&s->camera, "scene_camera.json");
    st = st ? st : synth_growing_open(&s->poses, "scene_gt.json");
    return st ? st : synth_growing_open(&s->counts, "scene_gt_info.json");
}

void synth_bop_fini(synth_bop_scene *s)
{
    synth_growing_fini(&s->camera);
    synth_growing_fini(&s->poses);
    synth_growing_fini(&s->counts);
}

/* "key": [...], n numbers times a unit */
static void put_numbers(FILE *f, const char *key, const double *x, int n, double unit)
{
    fprintf(f, "\"%s\": [", key);
    for (int i = 0; i < n; i++)
        fprintf(f, "%s%.9g", i ? ", " : "", x[i] == 0 ? 0.0 : x[i] * unit);
    fputs("], ", f);
}

static void put_camera(FILE *f, const synth_bop_image *image)
{
    const synth_camera *c = &image->camera;
    const double K[9] = { c->fx, 0, c->cx, 0, c->fy, c->cy, 0, 0, 1 };

    put_numbers(f, "cam_K", K, 9, 1);
    put_numbers(f, "cam_R_w2c", c->R_cam_world, 9, 1);
    put_numbers(f, "cam_t_w2c", c->t_cam_world, 3, MM);
    fprintf(f, "\"depth_scale\": %.9g", image->depth_step * MM);
}

/* The model's origin moves to the centre of its box: x_model = x_bop + centre. */
static void put_pose(FILE *f, const synth_bop_object *o)
{
    double t[3];

    lt_rigid_apply(o->R, o->t, ycb_find(o->id)->centre, t);
    put_numbers(f, "cam_R_m2c", o->R, 9, 1);
    put_numbers(f, "cam_t_m2c", t, 3, MM);
    fprintf(f, "\"obj_id\": %d", o->id);
}

static void put_box(FILE *f, const char *key, const synth_pixels *b, bool there)
{
    if (there)
        fprintf(f, "\"%s\": [%d, %d, %d, %d], ", key, b->x0, b->y0, b->x1 - b->x0, b->y1 - b->y0);
    else
        fprintf(f, "\"%s\": [-1, -1, -1, -1], ", key);
}

static void put_counts(FILE *f, const synth_bop_object *o)
{
    put_box(f, "bbox_obj", &o->whole_box, o->visible > 0);
    put_box(f, "bbox_visib", &o->box, o->visible > 0);
    fprintf(f, "\"px_count_all\": %lld, \"px_count_valid\": %lld, \"px_count_visib\": %lld, \"visib_fract\": %.6f",
            (long long)o->whole, (long long)o->measured, (long long)o->visible,
            o->whole ? (double)o->visible / (double)o->whole : 0.0);
}

void synth_bop_add(synth_bop_scene *s, const synth_bop_image *image)
{
    const char *const begin = s->n++ ? "," : "{";
    FILE *poses = s->poses.stream, *counts = s->counts.stream;

    fprintf(s->camera.stream, "%s\n\"%d\": {", begin, image->number);
    put_camera(s->camera.stream, image);
    fputs("}", s->camera.stream);
    fprintf(poses, "%s\n\"%d\": [", begin, image->number);
    fprintf(counts, "%s\n\"%d\": [", begin, image->number);
    for (int i = 0; i < image->n; i++) {
        fputs(i ? ", {" : "{", poses);
        put_pose(poses, &image->object[i]);
        fputs("}", poses);
        fputs(i ? ", {" : "{", counts);
        put_counts(counts, &image->object[i]);
        fputs("}", counts);
    }
    fputs("]", poses);
    fputs("]", counts);
}

lt_status synth_bop_close(synth_bop_scene *s, const char *root, const char *within, synth_manifest *manifest)
{
    const struct { synth_growing *text; const char *name; } file[] = {
        { &s->camera, "scene_camera.json" }, { &s->poses, "scene_gt.json" }, { &s->counts, "scene_gt_info.json" },
    };
    lt_status st = LT_OK;

    for (size_t i = 0; i < LT_COUNT(file) && !st; i++) {
        char path[128];

        snprintf(path, sizeof(path), "%s/%s", within, file[i].name);
        fputs(s->n ? "\n}\n" : "{}\n", file[i].text->stream);
        st = synth_growing_write(file[i].text, root, path, manifest);
    }
    return st;
}

/* ---- models ------------------------------------------------------------------------------------------------- */

/* The texture's colour at a vertex, as it is seen: sRGB */
static void look_up(const synth_bop_model *m, int vertex, float rgb[3])
{
    const float *uv = m->mesh->uv[vertex];
    const int x = (int)fminf(fmaxf(uv[0] * SYNTH_TEXTURE, 0), SYNTH_TEXTURE - 1);
    const int y = (int)fminf(fmaxf((1 - uv[1]) * SYNTH_TEXTURE, 0), SYNTH_TEXTURE - 1);

    for (int k = 0; k < 3; k++)
        rgb[k] = m->rgb[y * SYNTH_TEXTURE + x][k] / 255.0f;
}

/* In millimetres and BOP's frame */
static lt_status bop_mesh(lt_arena *arena, const synth_bop_model *m, lt_mesh *out)
{
    const double *centre = ycb_find(m->id)->centre;
    const int n = m->mesh->n_vertices;

    *out = *m->mesh;
    out->uv = NULL;
    out->vertex = lt_arena_array(arena, (size_t)n, sizeof(*out->vertex));
    out->color = lt_arena_array(arena, (size_t)n, sizeof(*out->color));
    if (!out->vertex || !out->color)
        return lt_error(LT_ENOMEM, "synth: no memory for a model");
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 3; k++)
            out->vertex[i][k] = (float)((m->mesh->vertex[i][k] - centre[k]) * MM);
        look_up(m, i, out->color[i]);
    }
    return LT_OK;
}

/* The turns are about axes through the origin, so that they move nothing but by turning. */
static void put_symmetries(FILE *f, int id)
{
    const ycb_object *o = ycb_find(id);
    lt_pose turn[YCB_TURNS];
    const int n = ycb_symmetries(o, turn);
    double axis[3];

    if (ycb_turns_about(o, axis)) {
        fprintf(f, ", \"symmetries_continuous\": [{\"axis\": [%g, %g, %g], \"offset\": [0, 0, 0]}]", axis[0], axis[1],
                axis[2]);
        return;
    }
    for (int i = 0; i < n; i++) {
        const double *R = turn[i].R;

        fputs(i ? ", " : ", \"symmetries_discrete\": [", f);
        for (int row = 0; row < 3; row++)
            fprintf(f, "%s%.9g, %.9g, %.9g, 0, ", row ? "" : "[", R[3 * row], R[3 * row + 1], R[3 * row + 2]);
        fputs("0, 0, 0, 1]", f);
    }
    fputs(n ? "]" : "", f);
}

static lt_status put_info(lt_arena *arena, FILE *f, int id, const lt_mesh *m)
{
    double (*x)[3] = lt_arena_array(arena, (size_t)m->n_vertices, sizeof(*x)), lo[3], hi[3];

    if (!x)
        return lt_error(LT_ENOMEM, "synth: no memory for a model");
    for (int k = 0; k < 3; k++) {
        lo[k] = hi[k] = m->vertex[0][k];
        for (int i = 0; i < m->n_vertices; i++) {
            x[i][k] = m->vertex[i][k];
            lo[k] = fmin(lo[k], x[i][k]);
            hi[k] = fmax(hi[k], x[i][k]);
        }
    }
    fprintf(f, "\"%d\": {\"diameter\": %.6f", id, eval_diameter(EVAL_MAX_DIST, m->n_vertices, x[0]));
    for (int k = 0; k < 3; k++)
        fprintf(f, ", \"min_%c\": %.6f", 'x' + k, lo[k]);
    for (int k = 0; k < 3; k++)
        fprintf(f, ", \"size_%c\": %.6f", 'x' + k, hi[k] - lo[k]);
    put_symmetries(f, id);
    fputs("}", f);
    return LT_OK;
}

static lt_status write_model(lt_arena *arena, const synth_bop_model *m, FILE *info, const char *root,
                             const char *within, synth_manifest *manifest)
{
    const char *file = lt_arena_printf(arena, "%s/obj_%06d.ply", within, m->id);
    const char *path = file ? lt_path_join(arena, root, file) : NULL;
    lt_mesh mesh;
    lt_status st = path ? bop_mesh(arena, m, &mesh) : lt_error(LT_ENOMEM, "synth: no memory for a model");

    st = st ? st : lt_ply_write_mesh(path, &mesh);
    st = st ? st : synth_manifest_file(manifest, root, file);
    return st ? st : put_info(arena, info, m->id, &mesh);
}

lt_status synth_bop_models(const synth_bop_model *model, int n, const char *root, const char *within,
                           synth_manifest *manifest)
{
    lt_arena *arena = lt_arena_new();
    char path[128];
    synth_growing info;
    lt_status st = synth_growing_open(&info, "models_info.json");

    if (!st && !arena)
        st = lt_error(LT_ENOMEM, "synth: no memory for models");
    for (int id = 1, written = 0; id <= YCB_COUNT && !st; id++)
        for (int i = 0; i < n && !st; i++)
            if (model[i].id == id) {
                fputs(written++ ? ",\n" : "{\n", info.stream);
                st = write_model(arena, &model[i], info.stream, root, within, manifest);
                break;
            }
    if (!st) {
        fputs("\n}\n", info.stream);
        snprintf(path, sizeof(path), "%s/models_info.json", within);
        st = synth_growing_write(&info, root, path, manifest);
    }
    synth_growing_fini(&info);
    lt_arena_free(arena);
    return st;
}
