/* SPDX-License-Identifier: Apache-2.0 */
/* Writes down light and initial poses, and measures them. */
#include "synth/hogs.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"

#include <math.h>
#include <string.h>

enum { TRUTH, INDEPENDENT, CORRELATED };
enum { POSES = 0x504f5345 };

static const char *const pose_file[SYNTH_POSE_FILES] = {
    "poses/truth.json", "poses/independent.json", "poses/correlated.json",
};
static const double OF_FRAME = 0.1;             /* of a frame's own draw where noise is correlated */
#define DEGREE 0.017453292519943295

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

typedef struct {
    double hand[48], object[3], shift[3];       /* axis-angle, metres */
} noise;

/* Half of the draws are coarse, half fine. */
static noise draw_noise(uint64_t seed, uint64_t stream, bool coarse)
{
    const double hand = coarse ? 8 * DEGREE : 4 * DEGREE, object = coarse ? 15 * DEGREE : 9 * DEGREE;
    const double shift = coarse ? 0.0144 : 0.0086;
    lt_rng rng = lt_rng_make(seed, stream);
    noise n;

    for (int i = 0; i < 48; i++)
        n.hand[i] = hand * lt_rng_normal(&rng);
    for (int k = 0; k < 3; k++)
        n.object[k] = object * lt_rng_normal(&rng);
    for (int k = 0; k < 3; k++)
        n.shift[k] = shift * lt_rng_normal(&rng);
    return n;
}

static bool is_coarse(uint64_t seed, uint64_t stream)
{
    lt_rng rng = lt_rng_make(seed, lt_rng_mix(stream, 'c'));

    return lt_rng_uniform(&rng) < 0.5;
}

/* The noise of a frame in one of the files; none on the truth. */
static noise noise_of(const synth_stage *stage, int k, int file)
{
    const uint64_t of_take = lt_rng_mix(stage->stream, POSES), of_frame = lt_rng_mix(of_take, (uint64_t)k + 1);
    noise n = { .hand = { 0 } };

    if (file == INDEPENDENT)
        n = draw_noise(stage->seed, of_frame, is_coarse(stage->seed, of_frame));
    if (file == CORRELATED) {
        const bool coarse = is_coarse(stage->seed, of_take);
        const noise own = draw_noise(stage->seed, of_frame, coarse);
        n = draw_noise(stage->seed, of_take, coarse);
        for (int i = 0; i < 48; i++)
            n.hand[i] += OF_FRAME * own.hand[i];
        for (int i = 0; i < 3; i++) {
            n.object[i] += OF_FRAME * own.object[i];
            n.shift[i] += OF_FRAME * own.shift[i];
        }
    }
    return n;
}

/* The rotation turned by a few degrees. */
static void turn(const double by[3], const double R[9], double out[9])
{
    double T[9];

    lt_rot_from_axis_angle(by, T);
    lt_mat3_mul(T, R, out);
}

static void print_numbers(FILE *f, const char *key, const double *x, int n)
{
    fprintf(f, "\"%s\": [", key);
    for (int i = 0; i < n; i++)
        fprintf(f, "%s%.7g", i ? ", " : "", x[i]);
    fprintf(f, "]");
}

static void add_pose(synth_growing *g, const synth_picture *p, const noise *n, double R[9], double t[3])
{
    double pose[48], root[9], turned[9], object[3];

    lt_rot_from_axis_angle(p->pose, root);
    turn(n->hand, root, turned);
    lt_rot_to_axis_angle(turned, pose);
    for (int i = 3; i < 48; i++)
        pose[i] = p->pose[i] + n->hand[i];
    turn(n->object, p->R, R);
    lt_rot_to_axis_angle(R, object);
    for (int k = 0; k < 3; k++)
        t[k] = p->t[k] + n->shift[k];
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

/* The box along the camera's axes around the object as R, t place it. */
static void posed_box(const lt_mesh *mesh, const double R[9], const double t[3], lt_box *out)
{
    *out = (lt_box){ { INFINITY, INFINITY, INFINITY }, { -INFINITY, -INFINITY, -INFINITY } };
    for (int i = 0; i < mesh->n_vertices; i++) {
        const double x[3] = { mesh->vertex[i][0], mesh->vertex[i][1], mesh->vertex[i][2] };
        double p[3];
        lt_rigid_apply(R, t, x, p);
        for (int k = 0; k < 3; k++) {
            out->lo[k] = fmin(out->lo[k], p[k]);
            out->hi[k] = fmax(out->hi[k], p[k]);
        }
    }
}

/* OCE, how far the object's place is off, and MCE, how far the corners of boxes along the axes are, as HOISDF's
 * evaluation has them. */
static void measure(synth_hogs *h, const lt_mesh *mesh, const synth_picture *p, const double R[9], const double t[3])
{
    lt_box is, should;
    double corners = 0;

    posed_box(mesh, R, t, &is);
    posed_box(mesh, p->R, p->t, &should);
    for (int i = 0; i < 8; i++) {
        double d2 = 0;
        for (int k = 0; k < 3; k++)
            d2 += i >> k & 1 ? (is.hi[k] - should.hi[k]) * (is.hi[k] - should.hi[k])
                             : (is.lo[k] - should.lo[k]) * (is.lo[k] - should.lo[k]);
        corners += sqrt(d2) / 8;
    }
    h->centre_mm.sum += 1000 * lt_vec3_distance(t, p->t);
    h->corners_mm.sum += 1000 * corners;
    h->centre_mm.n++;
    h->corners_mm.n++;
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
    for (int i = 0; i < SYNTH_POSE_FILES; i++) {
        const noise n = noise_of(shot->stage, shot->k, i);
        double R[9], t[3];
        fprintf(h->poses[i].stream, "%s", h->both.n ? "," : "");
        add_pose(&h->poses[i], p, &n, R, t);
        if (i == INDEPENDENT)
            measure(h, &shot->stage->prop->mesh, p, R, t);
    }
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
