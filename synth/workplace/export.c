/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/workplace/export.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "synth/preset.h"

#include <stdio.h>
#include <string.h>

#define SPLIT "bop/train_synt"

static lt_status no_memory(void)
{
    return lt_error(LT_ENOMEM, "synth: no memory to export a frame");
}

/* ---- opening -------------------------------------------------------------------------------------------------- */

static lt_status open_coco(workplace_export *e)
{
    static const char *const folder[] = { "coco/annotations", "coco/train" };
    const lt_status st = synth_folders(e->opt->out, folder, LT_COUNT(folder));

    return st ? st : synth_coco_open(&e->list, "coco/annotations/instances_train.json");
}

static lt_status open_scene(workplace_export *e, int c)
{
    static const char *const kind[] = { "rgb", "depth", "mask", "mask_visib" };
    lt_status st = synth_bop_open(&e->scene[c]);

    for (size_t i = 0; i < LT_COUNT(kind) && !st; i++) {
        char folder[64];
        const char *const one = folder;

        snprintf(folder, sizeof(folder), SPLIT "/%06d/%s", c + 1, kind[i]);
        st = synth_folders(e->opt->out, &one, 1);
    }
    return st;
}

lt_status export_open(workplace_export *e, const synth_options *options, const recording_rig *rig)
{
    static const char *const models = "bop/models";
    lt_status st = LT_OK;

    *e = (workplace_export){ .opt = options, .rig = rig };
    if (options->coco)
        st = open_coco(e);
    if (options->bop && !st)
        st = synth_folders(options->out, &models, 1);
    for (int c = 0; options->bop && c < rig->n && !st; c++)
        st = open_scene(e, c);
    return st;
}

void export_fini(workplace_export *e)
{
    synth_coco_fini(&e->list);
    for (int c = 0; c < RECORDING_CAMERAS; c++)
        synth_bop_fini(&e->scene[c]);
}

/* ---- a frame -------------------------------------------------------------------------------------------------- */

/* A camera's frame that is exported */
typedef struct {
    const workplace_export *e;
    lt_arena *kept, *scratch;
    const workplace_scene *scene;
    int c;
    synth_camera camera;
    size_t pixels;
    const synth_seen *seen;
    const uint16_t *depth;
    uint8_t *whole;                             /* the amodal mask of the thing that is looked at */
    bool cut;                                   /* whether it goes on past the border */
} shooting;

/* A file's path, whose place in the view it takes; NULL without memory */
static const char *begin_file(const shooting *s, export_view *out, const char *within)
{
    snprintf(out->file[out->n_files].path, sizeof(out->file[out->n_files].path), "%s", within);
    return lt_path_join(s->scratch, s->e->opt->out, within);
}

static lt_status end_file(const shooting *s, export_view *out)
{
    synth_file *file = &out->file[out->n_files++];

    return synth_describe_file(s->e->opt->out, file->path, file);
}

/* The recording's picture once more, byte by byte */
static lt_status copy_picture(const shooting *s, const char *within, export_view *out)
{
    const char *from = lt_arena_printf(s->scratch, "%s/%s/%06d.jpg", s->e->opt->out, s->e->rig->camera[s->c].name,
                                       s->scene->k + 1);
    const char *to = begin_file(s, out, within);
    uint8_t *bytes;
    size_t n;
    lt_status st = from && to ? lt_read_file(s->scratch, from, LT_FILE_MAX, &bytes, &n) : no_memory();

    st = st ? st : lt_write_file(to, bytes, n);
    return st ? st : end_file(s, out);
}

static lt_status write_png(const shooting *s, const char *within, int bits, uint8_t *data, export_view *out)
{
    const lt_image img = { s->camera.width, s->camera.height, 1, bits, data };
    const char *path = begin_file(s, out, within);
    const lt_status st = path ? lt_png_write_fast(path, &img) : no_memory();

    return st ? st : end_file(s, out);
}

static lt_status find_whole(shooting *s, int thing)
{
    s->cut = false;
    memcpy(s->whole, s->seen[thing].mask, s->pixels);
    return synth_world_cover(s->scratch, &s->scene->world, &s->camera, thing, s->whole, &s->cut);
}

/* ---- COCO ---- */

static lt_status shoot_coco(shooting *s, export_view *out)
{
    const synth_world *w = &s->scene->world;
    synth_coco_image *image = &out->image;
    char within[80];
    lt_status st = LT_OK;

    *image = (synth_coco_image){ .width = s->camera.width, .height = s->camera.height,
                                 .camera = s->e->rig->camera[s->c].name, .frame = s->scene->k + 1 };
    snprintf(image->file, sizeof(image->file), "%s_%06d.jpg", image->camera, image->frame);
    for (int i = 0; i < w->n_things && !st; i++) {
        if (!synth_coco_counts(&s->seen[i]))
            continue;
        st = find_whole(s, i);
        st = st ? st : synth_coco_see(s->kept, &w->thing[i], &s->seen[i], s->whole, image);
    }
    snprintf(within, sizeof(within), "coco/train/%s", image->file);
    return st ? st : copy_picture(s, within, out);
}

/* ---- BOP ---- */

/* Count an object's pixels past the picture's border too, as far as a picture's size; the box goes along. */
static lt_status look_past_border(const shooting *s, int thing, synth_bop_object *o)
{
    const int w = s->camera.width, h = s->camera.height;
    synth_camera wide = s->camera;
    uint8_t *mask = lt_arena_alloc(s->scratch, 9 * s->pixels);
    bool cut = true;
    lt_status st;

    if (!mask)
        return no_memory();
    wide.width = 3 * w;
    wide.height = 3 * h;
    wide.cx += w;
    wide.cy += h;
    st = synth_world_cover(s->scratch, &s->scene->world, &wide, thing, mask, &cut);
    for (int y = 0; y < h; y++)
        memcpy(&mask[(size_t)(h + y) * (size_t)(3 * w) + (size_t)w], &s->whole[(size_t)y * (size_t)w], (size_t)w);
    o->whole_box = synth_pixels_of(mask, 3 * w, 3 * h, &o->whole);
    o->whole_box.x0 -= w;
    o->whole_box.x1 -= w;
    o->whole_box.y0 -= h;
    o->whole_box.y1 -= h;
    return st;
}

/* mask/ or mask_visib/: 255 where it is */
static lt_status write_mask(const shooting *s, const char *folder, int object, const uint8_t *mask, export_view *out)
{
    uint8_t *white = lt_arena_alloc(s->scratch, s->pixels);
    char within[80];

    if (!white)
        return no_memory();
    for (size_t i = 0; i < s->pixels; i++)
        white[i] = mask[i] ? 255 : 0;
    snprintf(within, sizeof(within), SPLIT "/%06d/%s/%06d_%06d.png", s->c + 1, folder, s->scene->k + 1, object);
    return write_png(s, within, 8, white, out);
}

static lt_status shoot_object(shooting *s, int object, export_view *out)
{
    const workplace_scene *scene = s->scene;
    const int thing = 3 * scene->script->n_people + object;
    const synth_seen *seen = &s->seen[thing];
    synth_bop_object *o = &out->poses.object[object];
    lt_status st = find_whole(s, thing);

    *o = (synth_bop_object){ .id = scene->script->object[object].prop->right.id, .whole = seen->whole,
                             .whole_box = seen->whole_box, .visible = seen->visible, .box = seen->box };
    lt_mat3_mul(s->camera.R_cam_world, scene->object[object].R, o->R);
    lt_rigid_apply(s->camera.R_cam_world, s->camera.t_cam_world, scene->object[object].t, o->t);
    for (size_t i = 0; i < s->pixels; i++)
        o->measured += s->whole[i] && s->depth[i];
    if (!st && s->cut)
        st = look_past_border(s, thing, o);
    st = st ? st : write_mask(s, "mask", object, s->whole, out);
    return st ? st : write_mask(s, "mask_visib", object, seen->mask, out);
}

static lt_status shoot_bop(shooting *s, export_view *out)
{
    const int number = s->scene->k + 1, n = s->scene->script->n_objects;
    char within[80];
    lt_status st;

    out->poses = (synth_bop_image){ .number = number, .camera = s->camera, .depth_step = WORKPLACE_DEPTH_STEP,
                                    .n = n };
    snprintf(within, sizeof(within), SPLIT "/%06d/rgb/%06d.jpg", s->c + 1, number);
    st = copy_picture(s, within, out);
    snprintf(within, sizeof(within), SPLIT "/%06d/depth/%06d.png", s->c + 1, number);
    st = st ? st : write_png(s, within, 16, (uint8_t *)s->depth, out);
    for (int i = 0; i < n && !st; i++)
        st = shoot_object(s, i, out);
    return st;
}

lt_status export_shoot(const workplace_export *e, lt_arena *kept, lt_arena *scratch, const workplace_scene *scene,
                       int c, const synth_seen *seen, const uint16_t *depth, export_view *out)
{
    shooting s = { .e = e, .kept = kept, .scratch = scratch, .scene = scene, .c = c, .seen = seen, .depth = depth,
                   .camera = workplace_camera(&e->rig->camera[c]) };
    lt_status st = LT_OK;

    out->n_files = 0;
    s.pixels = (size_t)s.camera.width * (size_t)s.camera.height;
    s.whole = lt_arena_alloc(scratch, s.pixels);
    if (!s.whole)
        return no_memory();
    if (e->opt->coco)
        st = shoot_coco(&s, out);
    return st || !e->opt->bop ? st : shoot_bop(&s, out);
}

/* ---- files ---------------------------------------------------------------------------------------------------- */

lt_status export_add(workplace_export *e, int c, const export_view *view, synth_manifest *manifest)
{
    if (e->opt->coco)
        synth_coco_add(&e->list, &view->image);
    if (e->opt->bop)
        synth_bop_add(&e->scene[c], &view->poses);
    return synth_manifest_add(manifest, view->file, view->n_files);
}

static lt_status write_about(const workplace_export *e, synth_manifest *manifest)
{
    synth_growing about;
    lt_status st = synth_growing_open(&about, "dataset_info.md");

    if (st)
        return st;
    fprintf(about.stream, "# SYNTHETIC\n\nMade by palmar synth. Persons, hands and objects are drawn, and the models "
            "are stand-ins of the YCB\nobjects, not their scans; ids and frames are those of YCB-V.\n\n"
            "| scene | camera |\n|---|---|\n");
    for (int c = 0; c < e->rig->n; c++)
        fprintf(about.stream, "| %06d | %s |\n", c + 1, e->rig->camera[c].name);
    return synth_growing_write(&about, e->opt->out, "bop/dataset_info.md", manifest);
}

static lt_status close_bop(workplace_export *e, const workplace_script *script, synth_manifest *manifest)
{
    synth_bop_model model[WORKPLACE_OBJECTS];
    lt_status st = LT_OK;

    for (int c = 0; c < e->rig->n && !st; c++) {
        char folder[64];

        snprintf(folder, sizeof(folder), SPLIT "/%06d", c + 1);
        st = synth_bop_close(&e->scene[c], e->opt->out, folder, manifest);
    }
    for (int i = 0; i < script->n_objects; i++) {
        const synth_prop *p = &script->object[i].prop->right;

        model[i] = (synth_bop_model){ p->id, &p->mesh, (const uint8_t (*)[3])p->rgb };
    }
    st = st ? st : synth_bop_models(model, script->n_objects, e->opt->out, "bop/models", manifest);
    return st ? st : write_about(e, manifest);
}

lt_status export_close(workplace_export *e, const workplace_script *script, synth_manifest *manifest)
{
    lt_status st = LT_OK;

    if (e->opt->coco)
        st = synth_coco_close(&e->list, e->opt->out, manifest);
    return st || !e->opt->bop ? st : close_bop(e, script, manifest);
}
