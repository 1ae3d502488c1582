/* SPDX-License-Identifier: Apache-2.0 */
/* Takes as HO3D has them: a sequence for each camera, two lists, the evaluation's truth. */
#include "synth/write/layout.h"

#include "libtensor/io/file.h"
#include "synth/write/calibration.h"
#include "synth/write/ho3d.h"
#include "synth/write/truth.h"
#include "vision/picture.h"

#include <stdio.h>

typedef struct {
    synth_truth truth;
    FILE *list[2];                  /* train.txt, evaluation.txt */
    lt_atomic_file list_file[2];
} ho3d_state;

/* A take's: a sequence for each camera. */
typedef struct {
    char sequence[SYNTH_MAX_CAMERAS][80];
} ho3d_take;

static const char *const list_name[2] = { "train.txt", "evaluation.txt" };

static lt_status plan(const synth_options *o, synth_cast *out)
{
    return synth_cast_plan(o->preset, o->frames, out);
}

static lt_status open(synth_session *s)
{
    ho3d_state *h = s->state = lt_arena_alloc(s->arena, sizeof(*h));

    if (!h)
        return lt_error(LT_ENOMEM, "synth: no memory");
    for (int i = 0; i < 2; i++) {
        const char *path = lt_path_join(s->arena, s->opt->out, list_name[i]);
        const lt_status st = path ? lt_atomic_open(&h->list_file[i], path) : lt_error(LT_ENOMEM, "synth: no memory");
        if (st)
            return st;
        h->list[i] = h->list_file[i].stream;
    }
    return synth_truth_open(&h->truth, s->opt->out);
}

static bool cameras(const synth_session *s, const synth_take *take, synth_camera *out)
{
    (void)s;
    (void)take;
    (void)out;
    return false;
}

static lt_status begin_take(const synth_session *s, const synth_take *take, const synth_stage *stage, lt_arena *arena,
                            void **own)
{
    ho3d_take *t = *own = lt_arena_alloc(arena, sizeof(*t));
    lt_status st = t ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for a take");

    for (int c = 0; !st && c < stage->n_cameras; c++) {
        snprintf(t->sequence[c], sizeof(t->sequence[c]), "%s%d", take->base, c);
        st = synth_make_sequence(s->opt->out, t->sequence[c], take->evaluation);
    }
    return st;
}

static lt_status write(const synth_session *s, synth_shot *shot, int quality, synth_file *files, int *n)
{
    const ho3d_take *t = shot->own;

    shot->picture.sequence = t->sequence[shot->camera];
    *n = SYNTH_FRAME_FILES;
    return synth_write_picture(s->opt->out, &shot->picture, s->opt->png, quality, files);
}

static lt_status record(synth_session *s, const synth_shot *shot)
{
    const synth_picture *p = &shot->picture;
    ho3d_state *h = s->state;

    fprintf(h->list[p->evaluation], "%s/%04d\n", p->sequence, p->frame);
    if (p->evaluation)
        synth_truth_add(&h->truth, p->joints, p->vertices);
    return LT_OK;
}

static lt_status end_take(synth_session *s, const synth_shot *last)
{
    const synth_stage *stage = last->stage;

    if (stage->n_cameras == 1)
        return LT_OK;
    return synth_write_calibration(s->opt->out, last->take->base, stage->camera, stage->n_cameras, &s->manifest);
}

/* Lists and truth take their names. */
static lt_status close(synth_session *s)
{
    static const char *const file[] = { "train.txt", "evaluation.txt", "evaluation_xyz.json", "evaluation_verts.json" };
    ho3d_state *h = s->state;
    lt_status st = LT_OK;

    for (int i = 0; !st && i < 2; i++) {
        h->list[i] = NULL;
        st = lt_atomic_commit(&h->list_file[i]);
    }
    if (!st)
        st = synth_truth_commit(&h->truth);
    for (size_t i = 0; !st && i < LT_COUNT(file); i++)
        st = synth_manifest_file(&s->manifest, s->opt->out, file[i]);
    return st;
}

static void abort_all(synth_session *s)
{
    ho3d_state *h = s->state;

    for (int i = 0; h && i < 2; i++)
        if (h->list[i])
            lt_atomic_abort(&h->list_file[i]);
    if (h)
        synth_truth_abort(&h->truth);
}

const synth_layout_ops synth_layout_ho3d = {
    .name = "ho3d", .title = "HO3D v3", .title_png = "HO3D v2",
    .axes = "OpenGL camera, metres, MANO joint order, as in HO3D",
    .plan = plan, .open = open, .cameras = cameras, .depth_unit = HO3D_DEPTH_UNIT, .begin_take = begin_take,
    .write = write, .record = record, .end_take = end_take, .close = close, .abort = abort_all,
};
