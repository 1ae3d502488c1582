/* SPDX-License-Identifier: Apache-2.0 */
/* Writes down light and initial poses, and measures them. */
#include "synth/hogs.h"

#include "data/poses/pose_noise.h"
#include "eval/metrics/object_pose.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"

#include <math.h>
#include <string.h>

enum { POSES = 0x504f5345 };

static const char *const pose_file[SYNTH_POSE_FILES] = {
    [POSE_NOISE_NONE] = "poses/truth.json", [POSE_NOISE_INDEPENDENT] = "poses/independent.json",
    [POSE_NOISE_CORRELATED] = "poses/correlated.json",
};

/* ---- light ---- */

static lt_status begin_light(synth_hogs *h)
{
    const lt_status st = synth_growing_open(&h->light, "light.csv");

    if (st)
        return st;
    fprintf(h->light.stream, "frame,exposure,warmth,tint,toward_x,toward_y,toward_z,key,highlight,"
                             "jitter_r,jitter_g,jitter_b\n");
    return LT_OK;
}

static void add_light(synth_hogs *h, const synth_shot *shot)
{
    const synth_light_state l = synth_light_at(&shot->stage->light, shot->k);
    const double *toward = l.local.toward;

    fprintf(h->light.stream, "%04d,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", shot->picture.frame,
            l.global.exposure, l.global.warmth, l.global.tint, toward[0], toward[1], toward[2], l.local.key,
            l.local.highlight, l.jitter[0], l.jitter[1], l.jitter[2]);
}

static lt_status end_light(synth_hogs *h, synth_session *s, const synth_picture *p)
{
    char within[160];

    snprintf(within, sizeof(within), "%s/%s/light.csv", p->evaluation ? "evaluation" : "train", p->sequence);
    return synth_growing_write(&h->light, s->opt->out, within, &s->manifest);
}

/* ---- poses ---- */

/* The noise of a frame in one of the files. */
static pose_noise noise_of(const synth_stage *stage, int k, pose_noise_kind kind)
{
    const uint64_t of_take = lt_rng_mix(stage->stream, POSES);

    return pose_noise_draw(kind, stage->seed, of_take, lt_rng_mix(of_take, (uint64_t)k + 1));
}

static void print_numbers(FILE *f, const char *key, const double *x, int n)
{
    fprintf(f, "\"%s\": [", key);
    for (int i = 0; i < n; i++)
        fprintf(f, "%s%.7g", i ? ", " : "", x[i]);
    fprintf(f, "]");
}

static void add_pose(synth_growing *g, const synth_picture *p, const pose_noise *n, double R[9], double t[3])
{
    double pose[48], object[3];

    memcpy(pose, p->pose, sizeof(pose));
    memcpy(R, p->R, 9 * sizeof(*R));
    memcpy(t, p->t, 3 * sizeof(*t));
    pose_noise_apply(n, pose, R, t);
    lt_rot_to_axis_angle(R, object);
    fprintf(g->stream, "\n\"%s/%04d\": {\"hand\": {\"side\": \"right\", ", p->sequence, p->frame);
    print_numbers(g->stream, "pose", pose, 48);
    fprintf(g->stream, ", ");
    print_numbers(g->stream, "shape", p->beta, LT_HAND_BETAS);
    fprintf(g->stream, ", ");
    print_numbers(g->stream, "trans", p->trans, 3);
    fprintf(g->stream, "}, \"object\": {\"id\": %d, ", p->object_id);
    print_numbers(g->stream, "R", object, 3);
    fprintf(g->stream, ", ");
    print_numbers(g->stream, "t", t, 3);
    fprintf(g->stream, "}}");
}

/* OCE and MCE of an object, as HOISDF's evaluation has them. */
static lt_status measure(synth_hogs *h, const lt_mesh *mesh, const synth_picture *p, const double R[9],
                         const double t[3])
{
    double *x = lt_alloc((size_t)mesh->n_vertices * 3 * sizeof(*x));
    lt_pose is, should;

    if (!x)
        return lt_error(LT_ENOMEM, "synth: no memory to measure poses");
    for (int i = 0; i < 3 * mesh->n_vertices; i++)
        x[i] = mesh->vertex[i / 3][i % 3];
    memcpy(is.R, R, sizeof(is.R));
    memcpy(is.t, t, sizeof(is.t));
    memcpy(should.R, p->R, sizeof(should.R));
    memcpy(should.t, p->t, sizeof(should.t));
    h->centre_mm.sum += 1000 * eval_oce(&is, &should);
    h->corners_mm.sum += 1000 * eval_mce(mesh->n_vertices, x, &is, &should);
    h->centre_mm.n++;
    h->corners_mm.n++;
    lt_release(x);
    return LT_OK;
}

/* ---- a run ---- */

lt_status synth_hogs_open(synth_hogs *h)
{
    *h = (synth_hogs){ .part = { 0 } };
    for (int i = 0; i < SYNTH_POSE_FILES; i++) {
        const lt_status st = synth_growing_open(&h->poses[i], "poses");

        if (st)
            return st;
        fprintf(h->poses[i].stream, "{\"format\": \"palmar.poses/1\", \"axes\": \"opencv\", \"unit\": \"m\", "
                "\"rotation\": \"axis-angle\", \"flat_hand_mean\": true, \"frames\": {");
    }
    return LT_OK;
}

void synth_hogs_fini(synth_hogs *h)
{
    synth_growing_fini(&h->light);
    for (int i = 0; i < SYNTH_POSE_FILES; i++)
        synth_growing_fini(&h->poses[i]);
}

lt_status synth_hogs_record(synth_hogs *h, synth_session *s, const synth_hogs_frame *f)
{
    const synth_shot *shot = f->shot;
    const synth_picture *p = &shot->picture;
    lt_status st = h->light.stream ? LT_OK : begin_light(h);

    if (st)
        return st;
    add_light(h, shot);
    for (int i = 0; !st && i < SYNTH_POSE_FILES; i++) {
        const pose_noise n = noise_of(shot->stage, shot->k, (pose_noise_kind)i);
        double R[9], t[3];
        fprintf(h->poses[i].stream, "%s", h->both.n ? "," : "");
        add_pose(&h->poses[i], p, &n, R, t);
        if (i == POSE_NOISE_INDEPENDENT)
            st = measure(h, &shot->stage->prop->mesh, p, R, t);
    }
    if (st)
        return st;
    for (int i = 0; i < 2; i++)
        h->part[i] += f->part[i];
    h->both.sum += f->seen->both;
    h->inside.sum += f->seen->inside_object;
    h->contact.sum += f->seen->contact;
    h->both.n++;
    h->inside.n++;
    h->contact.n++;
    return shot->k + 1 == shot->stage->n_kept ? end_light(h, s, p) : LT_OK;
}

static double mean(synth_mean m)
{
    return m.n ? m.sum / (double)m.n : NAN;
}

lt_status synth_hogs_close(synth_hogs *h, synth_session *s, synth_stats *stats)
{
    const double all = h->part[0] + h->part[1];
    const synth_figure figures[] = {
        { "change of pixels by global light, share", h->part[0] / all, 0.5, 0.7 },
        { "change of pixels by local light, share", h->part[1] / all, 0.3, 0.5 },
        { "frames that show hand and object", mean(h->both), 0.98, 1 },
        { "frames with the hand in the object", mean(h->inside), 0, 0 },
        { "frames in which the hand touches the object", mean(h->contact), 0.5, 0.95 },
        { "independent poses: OCE, mm", mean(h->centre_mm), 17, 20 },
        { "independent poses: MCE, mm", mean(h->corners_mm), 22, 32 },
    };
    char *folder = lt_path_join(s->arena, s->opt->out, "poses");
    lt_status st = folder ? lt_make_dirs(folder) : lt_error(LT_ENOMEM, "synth: no memory for poses");

    for (int i = 0; !st && i < SYNTH_POSE_FILES; i++) {
        fprintf(h->poses[i].stream, "\n}}\n");
        st = synth_growing_write(&h->poses[i], s->opt->out, pose_file[i], &s->manifest);
    }
    for (size_t i = 0; i < LT_COUNT(figures); i++)
        stats->more[stats->n_more++] = figures[i];
    return st;
}
