/* SPDX-License-Identifier: Apache-2.0 */
/* The annotation as initial poses, with noise or without. */
#include "data/poses/internal.h"

#include "data/kind.h"
#include "data/poses/pose_noise.h"
#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"

#include <string.h>

enum { POSES = 0x504f5345 };

/* By the words behind "truth". */
static const struct { const char *path; pose_noise_kind noise; const char *how; } forms[] = {
    { "truth", POSE_NOISE_NONE, "the truth" },
    { "truth+independent", POSE_NOISE_INDEPENDENT, "the truth and noise of HOISDF's size, drawn for each frame" },
    { "truth+correlated", POSE_NOISE_CORRELATED, "the truth and noise of HOISDF's size, correlated over a sequence" },
};

static void angles_of(const float rotation[9], double aa[3])
{
    double R[9];

    for (int i = 0; i < 9; i++)
        R[i] = rotation[i];
    lt_rot_to_axis_angle(R, aa);
}

void initial_pose_of_sample(const dataset_sample *s, const lt_hand_model *hand, initial_pose *out)
{
    double J0[3];

    *out = (initial_pose){ .object = s->flags & SAMPLE_OBJECT ? s->object : -1 };
    out->has_hand = (s->flags & SAMPLE_HAND_POSE) && (s->flags & SAMPLE_ROOT);
    out->has_object = s->flags & SAMPLE_OBJECT;
    for (int i = 0; i < 9 && out->has_object; i++) {
        out->R[i] = s->R[i];
        out->t[i / 3] = s->t[i / 3];
    }
    if (!out->has_hand)
        return;
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        angles_of(s->rotation[j], out->pose + 3 * j);
    for (int i = 0; i < LT_HAND_BETAS; i++)
        out->beta[i] = s->beta[i];
    lt_hand_rest_wrist(hand, out->beta, J0);
    for (int k = 0; k < 3; k++) {
        out->wrist[k] = s->root[k];
        out->trans[k] = out->wrist[k] - J0[k];
    }
}

/* FNV-1a of n bytes: a stream's number from a name. */
static uint64_t hash(const char *text, size_t n)
{
    uint64_t h = 0xcbf29ce484222325u;

    for (size_t i = 0; i < n; i++)
        h = (h ^ (unsigned char)text[i]) * 0x100000001b3u;
    return h;
}

static void add_noise(pose_noise_kind kind, uint64_t seed, const char *name, initial_pose *p)
{
    const char *slash = strrchr(name, '/');
    const uint64_t sequence = lt_rng_mix(hash(name, slash ? (size_t)(slash - name) : 0), POSES);
    const pose_noise n = pose_noise_draw(kind, seed, sequence, lt_rng_mix(hash(name, strlen(name)), POSES));

    if (kind != POSE_NOISE_NONE)
        pose_noise_apply(&n, p->pose, p->R, p->t);
}

/* ---- all samples ---- */

typedef struct {
    const dataset *d;
    const lt_hand_model *hand;
    initial_pose *pose;             /* of each sample of d */
    lt_status *status;
} truth_job;

static void read_one(void *ctx, int64_t i)
{
    const truth_job *j = ctx;
    lt_arena *arena = lt_arena_new();
    dataset_sample s;

    j->status[i] = arena ? dataset_annotation(j->d, i, arena, &s) : LT_ENOMEM;
    if (!j->status[i])
        initial_pose_of_sample(&s, j->hand, &j->pose[i]);
    lt_arena_free(arena);
}

/* An error again, on this thread, whose line is ours. */
static lt_status first_error(const truth_job *j, lt_arena *arena)
{
    dataset_sample s;

    for (int64_t i = 0; i < j->d->count; i++)
        if (j->status[i])
            return dataset_annotation(j->d, i, arena, &s) ? j->status[i] : lt_error(LT_ENOMEM, "no memory");
    return LT_OK;
}

/* Poses of d for the frames of data that have the same names; -1 of an object that data does not know. */
static lt_status take_all(const initial_poses_options *o, const dataset *d, pose_noise_kind noise, lt_arena *arena,
                          initial_poses *out)
{
    const size_t n = (size_t)d->count;
    truth_job j = { d, o->hand, lt_arena_array(arena, n, sizeof(*j.pose)),
                    lt_arena_array(arena, n, sizeof(*j.status)) };
    frame_names names;
    lt_status st = j.pose && j.status ? frame_names_make(arena, o->data, &names)
                                      : lt_error(LT_ENOMEM, "%s: no memory for %zu poses", o->path, n);

    if (st)
        return st;
    lt_parallel_for(d->count, read_one, &j);
    st = first_error(&j, arena);
    for (int64_t i = 0; i < d->count && !st; i++) {
        const char *name = dataset_name(d, i);
        const int64_t frame = frame_names_find(&names, name);

        if (frame < 0) {
            out->counts.unknown++;
            continue;
        }
        add_noise(noise, o->seed, name, &j.pose[i]);
        if (d != o->data && j.pose[i].object >= 0)
            j.pose[i].object = dataset_find_object(o->data, d->objects[j.pose[i].object].name);
        st = initial_poses_add(out, frame, &j.pose[i], name);
    }
    return st;
}

/* The dataset of a folder, as data was opened. */
static lt_status take_folder(const initial_poses_options *o, lt_arena *arena, initial_poses *out)
{
    dataset *d;
    lt_status st = dataset_open(&(dataset_options){ .root = o->path, .split = o->data->split, .hand = o->hand }, &d);

    if (st)
        return st;
    st = take_all(o, d, POSE_NOISE_NONE, arena, out);
    dataset_free(d);
    out->how = "the truth";
    return st;
}

lt_status initial_poses_of_truth(const initial_poses_options *o, initial_poses *out)
{
    lt_arena *arena = lt_arena_new();
    lt_status st = LT_OK;
    bool found = false;

    if (!arena)
        return lt_error(LT_ENOMEM, "%s: no memory", o->path);
    for (size_t i = 0; i < LT_COUNT(forms); i++)
        if (strcmp(o->path, forms[i].path) == 0) {
            found = true;
            out->how = forms[i].how;
            st = take_all(o, o->data, forms[i].noise, arena, out);
        }
    if (!found)
        st = lt_is_folder(o->path) ? take_folder(o, arena, out)
                                   : lt_error(LT_EINVAL, "%s: no such truth; want truth, truth+independent or "
                                              "truth+correlated", o->path);
    lt_arena_free(arena);
    return st;
}
