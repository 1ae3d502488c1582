/* SPDX-License-Identifier: Apache-2.0 */
/* Initial poses matched with a dataset's frames, and brought into its conventions. */
#include "data/poses/initial_poses.h"

#include "assets/ycb/ycb.h"
#include "data/poses/internal.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"

#include <stdio.h>
#include <string.h>

static const double IN_TWENTY = 0.05;

/* ---- the list ---- */

lt_status initial_poses_add(initial_poses *p, int64_t frame, const initial_pose *pose, const char *who)
{
    if (p->at[frame] >= 0)
        return lt_error(LT_EFORMAT, "%s: the frame has a pose already; want one for each frame", who);
    p->pose = lt_arena_grow(p->arena, p->pose, p->n, &p->room, sizeof(*p->pose));
    if (!p->pose)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu poses", who, p->n + 1);
    p->at[frame] = (int64_t)p->n;
    p->pose[p->n++] = *pose;
    p->counts.matched++;
    return LT_OK;
}

const initial_pose *initial_poses_at(const initial_poses *p, int64_t index)
{
    return index >= 0 && index < p->frames && p->at[index] >= 0 ? &p->pose[p->at[index]] : NULL;
}

initial_poses_counts initial_poses_count(const initial_poses *p)
{
    return p->counts;
}

const char *initial_poses_how(const initial_poses *p)
{
    return p->how;
}

void initial_pose_rotations(const initial_pose *p, float rotation[LT_HAND_JOINTS][9])
{
    for (int j = 0; j < LT_HAND_JOINTS; j++) {
        double R[9];

        lt_rot_from_axis_angle(p->pose + 3 * j, R);
        for (int i = 0; i < 9; i++)
            rotation[j][i] = (float)R[i];
    }
}

/* ---- from a file's conventions ---- */

typedef struct {
    const initial_poses_options *o;
    initial_poses *out;
    frame_names names, others;
    char unknown[256];              /* the first name that nobody has */
    bool by_annotation;             /* some wrist was the annotation's */
} matcher;

/* Coefficients of the principal components, and the mean pose, to axis-angle. */
static void to_flat_hand(const pose_record *r, const lt_hand_model *hand, double pose[48])
{
    memcpy(pose, r->pose, sizeof(r->pose));
    for (int i = 0; i < LT_HAND_PCA && (r->pca || r->add_mean); i++) {
        double x = r->pca ? 0 : r->pose[3 + i];

        for (int k = 0; k < LT_HAND_PCA && r->pca; k++)
            x += r->pose[3 + k] * hand->hands_components[k][i];
        pose[3 + i] = x + (r->add_mean ? hand->hands_mean[i] : 0);
    }
}

static void place_hand(const pose_record *r, const dataset_sample *annotated, const lt_hand_model *hand,
                       initial_pose *out)
{
    double J0[3];

    lt_hand_rest_wrist(hand, out->beta, J0);
    for (int k = 0; k < 3; k++)
        out->trans[k] = r->placed == POSE_BY_TRANS ? r->trans[k]
                      : (r->placed == POSE_BY_WRIST ? r->wrist[k] : annotated->root[k]) - J0[k];
    if (r->opengl)
        lt_flip_yz_mano(out->pose, out->trans, J0);
    for (int k = 0; k < 3; k++)
        out->wrist[k] = out->trans[k] + J0[k];
}

/* Which of the dataset's objects it is, by number or name. */
static lt_status find_object(const matcher *m, const pose_record *r, int *out)
{
    const dataset *d = m->o->data;
    const ycb_object *known = r->object_name ? ycb_find_name(dataset_plain_name(r->object_name)) : NULL;
    const int id = r->object_id ? r->object_id : known ? known->id : 0;

    *out = r->object_name ? dataset_find_object(d, r->object_name) : -1;
    for (int i = 0; i < d->n_objects && *out < 0 && id; i++)
        if (d->objects[i].ycb_id == id)
            *out = i;
    if (*out >= 0 || !d->n_objects || (!id && !r->object_name))
        return LT_OK;
    if (!id)
        return lt_error(LT_EFORMAT, "%s, \"%s\": object %s is none of %s's", m->o->path, r->frame, r->object_name,
                        d->root);
    return lt_error(LT_EFORMAT, "%s, \"%s\": object.id is %d, %s, which is none of %s's", m->o->path, r->frame, id,
                    ycb_find(id) ? ycb_find(id)->name : "no YCB object", d->root);
}

static lt_status convert(matcher *m, const pose_record *r, const dataset_sample *annotated, initial_pose *out)
{
    lt_status st = LT_OK;

    *out = (initial_pose){ .has_hand = r->has_hand, .has_object = r->has_object, .object = -1 };
    if (r->has_hand) {
        to_flat_hand(r, m->o->hand, out->pose);
        memcpy(out->beta, r->beta, sizeof(out->beta));
        place_hand(r, annotated, m->o->hand, out);
    }
    if (r->has_object) {
        memcpy(out->R, r->R, sizeof(out->R));
        memcpy(out->t, r->t, sizeof(out->t));
        if (r->opengl)
            lt_flip_yz_pose(out->R, out->t);
        st = find_object(m, r, &out->object);
    }
    if (r->placed == POSE_BY_ANNOTATION && annotated->flags & SAMPLE_OBJECT)
        out->object = annotated->object;
    return st;
}

static lt_status take(void *ctx, const pose_record *r)
{
    matcher *m = ctx;
    const int64_t frame = frame_names_find(&m->names, r->frame);
    dataset_sample annotated = { .object = -1 };
    lt_arena *arena = NULL;
    initial_pose pose;
    lt_status st = LT_OK;

    if (frame < 0) {
        const bool other = frame_names_find(&m->others, r->frame) >= 0;

        m->out->counts.other += other;
        m->out->counts.unknown += !other;
        if (!other && !*m->unknown)
            snprintf(m->unknown, sizeof(m->unknown), "%s", r->frame);
        return LT_OK;
    }
    if (r->placed == POSE_BY_ANNOTATION && r->has_hand) {
        arena = lt_arena_new();
        st = arena ? dataset_annotation(m->o->data, frame, arena, &annotated) : lt_error(LT_ENOMEM, "no memory");
        m->by_annotation = true;
        if (!st && !(annotated.flags & SAMPLE_ROOT))
            st = lt_error(LT_EFORMAT, "%s, \"%s\": the hand has no place, and the annotation no wrist", m->o->path,
                          r->frame);
    }
    if (!st)
        st = convert(m, r, &annotated, &pose);
    lt_arena_free(arena);
    return st ? st : initial_poses_add(m->out, frame, &pose, r->frame);
}

/* ---- a file ---- */

static lt_status check_names(const matcher *m)
{
    const initial_poses_counts *c = &m->out->counts;
    const int64_t all = c->matched + c->other + c->unknown;

    if ((double)c->unknown > IN_TWENTY * (double)all)
        return lt_error(LT_EFORMAT, "%s: %lld of %lld frames are unknown to %s, \"%s\" first; want names like \"%s\"",
                        m->o->path, (long long)c->unknown, (long long)all, m->o->data->root, m->unknown,
                        m->o->data->count ? dataset_name(m->o->data, 0) : "none");
    return LT_OK;
}

static lt_status read_text(const initial_poses_options *o, pose_text file, pose_text list, initial_poses *out)
{
    matcher m = { .o = o, .out = out };
    const char *format = NULL, *base = strrchr(o->path, '/');
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? frame_names_make(arena, o->data, &m.names) : lt_error(LT_ENOMEM, "%s: no memory", o->path);

    if (!st)
        st = frame_names_make(arena, o->other, &m.others);
    if (!st)
        st = pose_file_parse(file, list, take, &m, &format);
    if (!st)
        st = check_names(&m);
    lt_arena_free(arena);
    if (st)
        return st;
    out->how = lt_arena_printf(out->arena, "%s (%s)%s", format, base ? base + 1 : o->path,
                               m.by_annotation ? ", wrists from the annotation" : "");
    return out->how ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", o->path);
}

static lt_status read_file(const initial_poses_options *o, initial_poses *out)
{
    lt_file file = { NULL, NULL, 0 }, list = { NULL, NULL, 0 };
    lt_status st = lt_file_load(&file, o->path, LT_FILE_MAX);

    if (!st && o->list)
        st = lt_file_load(&list, o->list, LT_FILE_MAX);
    if (!st)
        st = read_text(o, (pose_text){ o->path, (const char *)file.bytes, file.n },
                       (pose_text){ o->list, (const char *)list.bytes, list.n }, out);
    lt_file_free(&list);
    lt_file_free(&file);
    return st;
}

static lt_status new_list(int64_t frames, initial_poses **out)
{
    lt_arena *arena = lt_arena_new();
    initial_poses *p = arena ? lt_arena_alloc(arena, sizeof(*p)) : NULL;
    int64_t *at = p ? lt_arena_array(arena, (size_t)frames + 1, sizeof(*at)) : NULL;

    if (!at) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "initial poses: no memory for %lld frames", (long long)frames);
    }
    for (int64_t i = 0; i < frames; i++)
        at[i] = -1;
    *p = (initial_poses){ .arena = arena, .frames = frames, .at = at, .how = "" };
    *out = p;
    return LT_OK;
}

lt_status initial_poses_read(const initial_poses_options *o, initial_poses **out)
{
    const bool truth = strncmp(o->path, "truth", 5) == 0 || lt_is_folder(o->path);
    initial_poses *p = NULL;
    lt_status st = new_list(o->data->count, &p);

    if (st)
        return st;
    st = truth ? initial_poses_of_truth(o, p) : read_file(o, p);
    p->counts.missed = p->frames - p->counts.matched;
    if (!st && !p->counts.matched)
        st = lt_error(LT_EFORMAT, "%s: no pose is of a frame of %s, split %s", o->path, o->data->root, o->data->split);
    if (!st)
        st = initial_poses_check(p, o->path);
    if (st)
        initial_poses_free(p);
    else
        *out = p;
    return st;
}

void initial_poses_free(initial_poses *p)
{
    if (p)
        lt_arena_free(p->arena);
}
