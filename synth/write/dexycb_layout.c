/* SPDX-License-Identifier: Apache-2.0 */
/* Takes as DexYCB has them: all cameras in one sequence, both hands, things on the table. */
#include "synth/write/layout.h"

#include "data/mirror.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/text/number.h"
#include "synth/take/rig.h"
#include "synth/write/dexycb.h"

#include <stdio.h>
#include <string.h>

enum { ID = 48 };                    /* characters of a calibration's name */

/* A take's: its sequence, and the objects in it by their ids. */
typedef struct {
    synth_dexycb_sequence sequence;
    const synth_prop *object[SYNTH_DEXYCB_OBJECTS];
    char extrinsics[ID], mano[ID];
} dexycb_take;

/* Poses of hand and objects in the first camera of the take that is being recorded. */
typedef struct {
    float *pose_m, *pose_y;         /* (frames, 51), (frames, n_objects, 7) */
} dexycb_state;

static lt_status plan(const synth_options *o, synth_cast *out)
{
    return synth_cast_plan_dexycb(o->preset, o->frames, o->seed, out);
}

static const char *extrinsics_id(int subject, char out[ID])
{
    snprintf(out, ID, "20260101_%02d0000", subject);
    return out;
}

static const char *mano_id(int subject, bool left, char out[ID])
{
    snprintf(out, ID, "20260101_subject-%02d_%s", subject + 1, left ? "left" : "right");
    return out;
}

static lt_status write_subject(synth_session *s, int subject, const synth_camera *camera)
{
    const double *beta = s->subject[subject].beta;
    char id[ID];
    lt_status st = synth_dexycb_write_extrinsics(s->opt->out, extrinsics_id(subject, id), camera, s->cast.n_cameras,
                                                 &s->manifest);

    for (int left = 0; !st && left < 2; left++)
        st = synth_dexycb_write_mano(s->opt->out, mano_id(subject, left, id), beta, &s->manifest);
    return st;
}

static lt_status open(synth_session *s)
{
    dexycb_state *d = s->state = lt_arena_alloc(s->arena, sizeof(*d));
    const size_t frames = (size_t)s->cast.take[0].frames + 1;
    synth_camera camera[SYNTH_MAX_CAMERAS];
    lt_status st = LT_OK;

    if (d) {
        d->pose_m = lt_arena_array(s->arena, frames * 51, sizeof(*d->pose_m));
        d->pose_y = lt_arena_array(s->arena, frames * SYNTH_DEXYCB_OBJECTS * 7, sizeof(*d->pose_y));
    }
    if (!d || !d->pose_m || !d->pose_y)
        return lt_error(LT_ENOMEM, "synth: no memory");
    for (int i = 0; !st && i < s->cast.n_subjects; i++) {
        synth_rig_new(s->opt->seed, i, s->cast.n_cameras, camera);
        st = write_subject(s, i, camera);
    }
    return st ? st : synth_dexycb_write_intrinsics(s->opt->out, camera, s->cast.n_cameras, &s->manifest);
}

/* A left hand's take is filmed in the mirror, with the cameras there. */
static bool cameras(const synth_session *s, const synth_take *take, synth_camera *out)
{
    synth_rig_new(s->opt->seed, take->subject, s->cast.n_cameras, out);
    if (take->left)
        synth_rig_mirror(out, s->cast.n_cameras);
    return true;
}

/* The objects in the order of their ids; prop NULL at the end of others. */
static void list_objects(dexycb_take *d, const synth_stage *stage)
{
    synth_dexycb_sequence *q = &d->sequence;

    for (int i = -1; i < stage->n_others; i++) {
        const synth_prop *p = i < 0 ? stage->prop : stage->other[i];
        int at = q->n_objects++;
        for (; at > 0 && d->object[at - 1]->id > p->id; at--)
            d->object[at] = d->object[at - 1];
        d->object[at] = p;
    }
    for (int i = 0; i < q->n_objects; i++) {
        q->id[i] = d->object[i]->id;
        if (d->object[i] == stage->prop)
            q->grasped = i;
    }
}

static lt_status begin_take(const synth_session *s, const synth_take *take, const synth_stage *stage, lt_arena *arena,
                            void **own)
{
    dexycb_take *d = *own = lt_arena_alloc(arena, sizeof(*d));

    if (!d)
        return lt_error(LT_ENOMEM, "synth: no memory for a take");
    d->sequence = (synth_dexycb_sequence){
        .folder = take->base, .left = take->left, .frames = take->frames, .cameras = stage->n_cameras,
        .extrinsics = extrinsics_id(take->subject, d->extrinsics), .mano = mano_id(take->subject, take->left, d->mano),
    };
    list_objects(d, stage);
    return synth_dexycb_make_folders(s->opt->out, &d->sequence);
}

/* Poses of all objects in the shot's camera; the picture is a right hand's still. */
static synth_dexycb_frame frame_of(const synth_session *s, const synth_shot *shot)
{
    const dexycb_take *d = shot->own;
    const synth_camera *c = &shot->stage->camera[synth_stage_view(shot->stage, shot->camera, shot->k)];
    synth_dexycb_frame f = { .sequence = &d->sequence, .hand = s->hand, .picture = &shot->picture,
                             .camera = shot->camera };

    for (int o = 0; o < d->sequence.n_objects; o++) {
        for (int i = 0; i < shot->stage->n_others; i++)
            if (shot->stage->other[i] == d->object[o]) {
                lt_mat3_mul(c->R_cam_world, shot->stage->at[i].R, f.R[o]);
                lt_rigid_apply(c->R_cam_world, c->t_cam_world, shot->stage->at[i].t, f.t[o]);
            }
        if (o == d->sequence.grasped) {
            memcpy(f.R[o], shot->picture.R, sizeof(f.R[o]));
            memcpy(f.t[o], shot->picture.t, sizeof(f.t[o]));
            continue;                           /* mirrored with the picture */
        }
        if (d->sequence.left)
            mirror_pose(f.R[o], f.t[o]);
    }
    return f;
}

static lt_status write(const synth_session *s, synth_shot *shot, int quality, synth_file *files, int *n)
{
    const dexycb_take *d = shot->own;
    synth_dexycb_frame f;

    shot->picture.sequence = d->sequence.folder;
    shot->picture.frame = shot->k;
    if (d->sequence.left)
        synth_dexycb_mirror(&shot->picture, shot->rgb, shot->depth, shot->label);
    f = frame_of(s, shot);
    *n = SYNTH_DEXYCB_FILES;
    return synth_dexycb_write_frame(s->opt->out, &f, quality, files);
}

/* pose.npz is in world axes: the first camera's. */
static lt_status record(synth_session *s, const synth_shot *shot)
{
    const dexycb_state *d = s->state;
    const int n = ((const dexycb_take *)shot->own)->sequence.n_objects;
    synth_dexycb_frame f;

    if (shot->camera != 0)
        return LT_OK;
    f = frame_of(s, shot);
    synth_dexycb_pose(&f, d->pose_m + 51 * shot->k);
    for (int o = 0; o < n; o++) {
        float *y = d->pose_y + 7 * (n * shot->k + o);
        double q[4];
        lt_rot_to_quat(f.R[o], q);
        for (int i = 0; i < 3; i++) {
            y[i] = (float)q[1 + i];
            y[4 + i] = (float)f.t[o][i];
        }
        y[3] = (float)q[0];
    }
    return LT_OK;
}

static lt_status end_take(synth_session *s, const synth_shot *last)
{
    const dexycb_state *d = s->state;
    const dexycb_take *t = last->own;

    return synth_dexycb_write_sequence(s->opt->out, &t->sequence, d->pose_m, d->pose_y, &s->manifest);
}

/* The splits count subjects and sequences: say how many there are. */
static lt_status close(synth_session *s)
{
    char text[256];

    snprintf(text, sizeof(text),
             "{\n\t\"synthetic\": true,\n\t\"subjects\": %d,\n\t\"sequences\": %d,\n\t\"cameras\": %d\n}\n",
             s->cast.n_subjects, s->cast.n_takes / s->cast.n_subjects, s->cast.n_cameras);
    return synth_manifest_text(&s->manifest, s->opt->out, "synthetic.json", text);
}

static void abort_nothing(synth_session *s)
{
    (void)s;
}

const synth_layout_ops synth_layout_dexycb = {
    .name = "dexycb", .title = "DexYCB",
    .axes = "OpenCV camera, metres, joints from thumb to little finger, as in DexYCB",
    .plan = plan, .open = open, .cameras = cameras, .depth_unit = 0.001, .begin_take = begin_take,
    .write = write, .record = record, .end_take = end_take, .close = close, .abort = abort_nothing,
};
