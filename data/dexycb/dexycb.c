/* SPDX-License-Identifier: Apache-2.0 */
/* Opens a DexYCB tree and reads its samples; left hands become right ones. */
#include "data/dexycb/internal.h"

#include "assets/ycb/ycb.h"
#include "data/mirror.h"
#include "libtensor/io/file.h"
#include "vision/picture.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* ---- places ---- */

static int64_t number_of(const dexycb *d, int64_t index)
{
    return d->kept ? d->kept[index] : index;
}

dexycb_place dexycb_place_of(const dataset *base, int64_t index)
{
    const dexycb *d = (const dexycb *)base;
    const int64_t number = number_of(d, index);
    const dexycb_spot spot = dexycb_find(d, number);
    const dexycb_sequence *q = spot.sequence;
    dexycb_place p = { .index = number, .image = spot.frame, .keyframe = spot.frame % 4 == 0,
                       .n_targets = q->n_objects, .grasped = q->grasped };

    for (int c = 0; c < d->n_cameras; c++)
        if (d->camera[c] == spot.camera)
            p.scene = spot.position * d->n_cameras + c;
    memcpy(p.target, q->object, sizeof(p.target));
    return p;
}

int64_t dexycb_list_length(const dataset *base)
{
    return ((const dexycb *)base)->total;
}

/* ---- reading ---- */

/* The model of an annotated object into *out, an index into the dataset's objects. */
static lt_status find_model(const dexycb *d, int id, const char *sample, int *out)
{
    for (int i = 0; i < d->base.n_objects; i++)
        if (d->base.objects[i].ycb_id == id) {
            *out = i;
            return LT_OK;
        }
    return lt_error(LT_EIO, "%s: the object is %s, which is not in %s", sample, ycb_find(id)->name, d->models);
}

static lt_status fill_object(const dexycb *d, dexycb_spot spot, const dexycb_label *l, dataset_sample *s)
{
    lt_status st;

    if (!l->object.known || !d->base.n_objects)
        return LT_OK;
    st = find_model(d, spot.sequence->object[spot.sequence->grasped], s->name, &s->object);
    if (st)
        return st;
    memcpy(s->R, l->object.R, sizeof(s->R));
    memcpy(s->t, l->object.t, sizeof(s->t));
    s->flags |= SAMPLE_OBJECT;
    return LT_OK;
}

/* All that the label says, a left hand still as a left hand. */
static lt_status read_label(const dexycb *d, dexycb_spot spot, dataset_sample *s)
{
    dexycb_label l;
    lt_status st = dexycb_read_label(d, spot, &l);

    if (st)
        return st;
    s->width = DEXYCB_WIDTH;
    s->height = DEXYCB_HEIGHT;
    s->camera = d->intrinsics[spot.camera];
    if (l.hand)
        dexycb_fill_hand(d, spot, &l, s);
    /* of a test sample without a crop, the papers take the whole picture */
    if (l.hand && d->filter == DEXYCB_HFL && d->split.part != DEXYCB_TRAIN && dexycb_box_is_empty(&l)) {
        s->hand_box[2] = DEXYCB_WIDTH - 1;
        s->hand_box[3] = DEXYCB_HEIGHT - 1;
        s->flags |= SAMPLE_HAND_BOX;
    }
    return fill_object(d, spot, &l, s);
}

static const char *picture(const dexycb *d, dexycb_spot spot, lt_arena *arena, const char *what, const char *usual)
{
    const char *stem = lt_arena_printf(arena, "%s/%s/%s/%s_%06d", d->base.root, spot.sequence->folder,
                                       d->serial[spot.camera], what, spot.frame);

    return stem ? picture_path(arena, stem, usual) : NULL;
}

static const char *rgb_path(const dexycb *d, dexycb_spot spot, lt_arena *arena)
{
    return picture(d, spot, arena, "color", "jpg");
}

static const char *depth_path(const dexycb *d, dexycb_spot spot, lt_arena *arena)
{
    return picture(d, spot, arena, "aligned_depth_to_color", "png");
}

static lt_status read_rgb(const dexycb *d, dexycb_spot spot, lt_arena *arena, uint8_t **out)
{
    const char *path = rgb_path(d, spot, arena);
    lt_image img;
    const lt_status st = path ? picture_read_rgb(arena, path, DEXYCB_WIDTH, DEXYCB_HEIGHT, &img)
                              : lt_error(LT_ENOMEM, "%s: no memory", spot.sequence->folder);

    if (!st)
        *out = img.data;
    return st;
}

static lt_status read_depth(const dexycb *d, dexycb_spot spot, lt_arena *arena, float **out)
{
    const char *path = depth_path(d, spot, arena);

    return path ? picture_read_depth(arena, path, DEXYCB_WIDTH, DEXYCB_HEIGHT, out)
                : lt_error(LT_ENOMEM, "%s: no memory", spot.sequence->folder);
}

static lt_status read_sample(const dataset *base, int64_t index, unsigned want, lt_arena *arena, dataset_sample *out)
{
    const dexycb *d = (const dexycb *)base;
    const dexycb_spot spot = dexycb_find(d, number_of(d, index));
    dataset_sample s = { .name = d->name[index], .object = -1 };
    uint8_t *rgb = NULL, *segments = NULL;
    float *depth = NULL;
    lt_status st = read_label(d, spot, &s);

    if (!st)
        st = read_rgb(d, spot, arena, &rgb);
    if (!st && (want & SAMPLE_DEPTH))
        st = read_depth(d, spot, arena, &depth);
    if (!st && (want & SAMPLE_SEGMENTS))
        st = dexycb_read_segments(d, spot, arena, &segments);
    if (st)
        return st;
    s.rgb = rgb;
    s.depth = depth;
    s.segments = segments;
    s.segments_width = segments ? DEXYCB_WIDTH : 0;
    s.segments_height = segments ? DEXYCB_HEIGHT : 0;
    s.flags |= (depth ? SAMPLE_DEPTH : 0) | (segments ? SAMPLE_SEGMENTS : 0);
    if (spot.sequence->left) {
        mirror_sample(&s, rgb, depth, NULL);
        mirror_plane(segments, DEXYCB_WIDTH, DEXYCB_HEIGHT, 1);
    }
    st = dataset_project(base, &s);
    if (!st && (want & SAMPLE_OBJECT) && s.object >= 0)
        st = dataset_draw_silhouette(base, arena, &s);
    if (!st)
        *out = s;
    return st;
}

static lt_status read_annotation(const dataset *base, int64_t index, lt_arena *arena, dataset_sample *out)
{
    const dexycb *d = (const dexycb *)base;
    const dexycb_spot spot = dexycb_find(d, number_of(d, index));
    lt_status st;

    (void)arena;
    *out = (dataset_sample){ .name = d->name[index], .object = -1 };
    st = read_label(d, spot, out);
    if (!st && spot.sequence->left)
        mirror_sample(out, NULL, NULL, NULL);
    return st;
}

lt_status dexycb_read_scene(const dataset *base, int64_t index, lt_arena *arena, dexycb_scene *out)
{
    const dexycb *d = (const dexycb *)base;
    const dexycb_spot spot = dexycb_find(d, number_of(d, index));
    float *depth = NULL;
    lt_status st;

    *out = (dexycb_scene){ .camera = d->intrinsics[spot.camera] };
    st = dexycb_read_poses(d, spot, out->pose);
    for (int i = 0; !st && i < spot.sequence->n_objects; i++) {
        int model = -1;
        if (!out->pose[i].known)
            continue;
        st = find_model(d, spot.sequence->object[i], d->name[index], &model);
        if (!st)
            out->model[i] = &base->objects[model];
    }
    if (!st)
        st = read_depth(d, spot, arena, &depth);
    out->depth = depth;
    return st;
}

lt_status dexycb_models_info(const dataset *base, lt_arena *arena, const char **out)
{
    const dexycb *d = (const dexycb *)base;
    const char *path[2] = {
        lt_arena_printf(arena, "%s/bop/s%d/models_eval/models_info.json", base->root, d->split.setup),
        lt_arena_printf(arena, "%s/bop/models_info.json", d->models),
    };

    *out = NULL;
    for (int i = 0; i < 2 && !*out; i++) {
        if (!path[i])
            return lt_error(LT_ENOMEM, "%s: no memory", base->root);
        if (!access(path[i], F_OK))
            *out = path[i];
    }
    return LT_OK;
}

static const char *missing_file(const dataset *base, int64_t index, lt_arena *arena)
{
    const dexycb *d = (const dexycb *)base;
    const dexycb_spot spot = dexycb_find(d, number_of(d, index));
    const char *const file[] = { rgb_path(d, spot, arena), depth_path(d, spot, arena),
                                 dexycb_label_path(d, spot, arena) };

    for (size_t i = 0; i < LT_COUNT(file); i++)
        if (file[i] && access(file[i], F_OK))
            return file[i];
    return NULL;
}

static const char *sample_name(const dataset *d, int64_t index)
{
    return ((const dexycb *)d)->name[index];
}

static void free_dataset(dataset *d)
{
    lt_arena_free(((dexycb *)d)->arena);
}

static const dataset_ops ops = { read_sample, read_annotation, missing_file, sample_name, free_dataset };

/* ---- opening ---- */

/* In the right hand's axes every triple (a, b, c) of a left one is (a, -b, -c), and the other way round. */
static void mirror_triples(float pose[LT_HAND_PCA])
{
    for (int i = 0; i < LT_HAND_PCA; i++)
        if (i % 3)
            pose[i] = -pose[i];
}

/* The mean of left hands is the right hand's, as the papers' code has it; so a left model's own is not used. */
static void set_pose_spaces(dexycb *d, const lt_hand_model *right, const lt_hand_model *left)
{
    memcpy(d->hand[0].mean, right->hands_mean, sizeof(d->hand[0].mean));
    memcpy(d->hand[0].component, right->hands_components, sizeof(d->hand[0].component));
    d->hand[1] = d->hand[0];
    mirror_triples(d->hand[1].mean);
    for (int k = 0; k < LT_HAND_PCA; k++)
        mirror_triples(d->hand[1].component[k]);
    if (left)
        memcpy(d->hand[1].component, left->hands_components, sizeof(d->hand[1].component));
}

static lt_status open_models(dexycb *d, const char *models)
{
    const char *names[YCB_COUNT];

    d->models = models ? lt_arena_strdup(d->arena, models) : lt_arena_printf(d->arena, "%s/models", d->base.root);
    if (!d->models)
        return lt_error(LT_ENOMEM, "%s: no memory", d->base.root);
    if (!lt_is_folder(d->models))
        return lt_error(LT_EIO, "%s: no such folder; it comes with DexYCB (models.tar.gz), or name another", d->models);
    for (int id = 1; id <= YCB_COUNT; id++)
        names[id - 1] = ycb_find(id)->name;
    return dataset_load_objects(d->arena, d->models, names, YCB_COUNT, &d->base.objects, &d->base.n_objects);
}

static lt_status make_names(dexycb *d)
{
    d->name = lt_arena_array(d->arena, (size_t)d->base.count, sizeof(*d->name));
    for (int64_t i = 0; d->name && i < d->base.count; i++) {
        const dexycb_spot spot = dexycb_find(d, number_of(d, i));
        d->name[i] = lt_arena_printf(d->arena, "%s/%s/%06d", spot.sequence->folder, d->serial[spot.camera], spot.frame);
        if (!d->name[i])
            d->name = NULL;
    }
    return d->name ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory for %lld names", d->base.root,
                                      (long long)d->base.count);
}

static lt_status open_all(dexycb *d, const dexycb_options *o)
{
    lt_status st = dexycb_open_tree(d);

    if (!st && !o->no_objects)
        st = open_models(d, o->models);
    if (st)
        return st;
    set_pose_spaces(d, o->hand, o->left);
    st = dexycb_apply_filter(d, o->hand);
    return st ? st : make_names(d);
}

lt_status dexycb_open(const dexycb_options *o, dataset **out)
{
    lt_arena *arena;
    dexycb_split split;
    dexycb *d;
    lt_status st = dexycb_split_parse(o->setup, o->split, &split);

    if (!st && o->filter == DEXYCB_HOISDF && o->no_objects)
        st = lt_error(LT_EINVAL, "%s: the filter hoisdf asks for contact, so it needs the objects", o->root);
    if (st)
        return st;
    arena = lt_arena_new();
    d = arena ? lt_arena_alloc(arena, sizeof(*d)) : NULL;
    if (!d || !(d->base.root = lt_arena_strdup(arena, o->root)) ||
        !(d->base.title = lt_arena_printf(arena, "DexYCB %s", o->setup))) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "%s: no memory", o->root);
    }
    d->arena = arena;
    d->split = split;
    d->filter = o->filter;
    d->base.ops = &ops;
    d->base.kind = &dexycb_kind;
    d->base.split = dexycb_split_name(split);
    d->base.tips = lt_hand_tips_dexycb;
    st = open_all(d, o);
    if (st)
        lt_arena_free(arena);
    else
        *out = &d->base;
    return st;
}
