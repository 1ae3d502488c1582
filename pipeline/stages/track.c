/* SPDX-License-Identifier: Apache-2.0 */
/* track: whose number each detection of a film's frame has among those of the frames before. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

static const float CENTRE = 0.5f;       /* a tracker's boxes have edges where the first pixel is 0 to 1 */

typedef struct {
    embedder *embedder;             /* NULL: none */
    tracker_options options;
    tracker *tracker;               /* NULL: no film yet */
    int which;                      /* film */
} tracks;

static void close_tracks(void *state)
{
    tracks *t = state;

    tracker_free(t->tracker);
    lt_release(t);
}

static lt_status open_tracks(const predict_options *o, void **state)
{
    tracks *t = lt_alloc(sizeof(*t));

    if (!t)
        return lt_error(LT_ENOMEM, "no memory to predict with");
    t->options = tracker_defaults;
    t->options.look_conf = 0;           /* a detector's score says how sure it is, not how much is hidden */
    t->options.method = o->track;
    t->options.embedding = o->embedder ? REID_EMBEDDING : 0;
    t->embedder = o->embedder;
    *state = t;
    return LT_OK;
}

/* The numbers of one film have nothing to do with those of another. */
static lt_status begin_film(tracks *t, const predict_followed *film)
{
    if (t->tracker && t->which == film->which)
        return LT_OK;
    tracker_free(t->tracker);
    t->tracker = NULL;
    t->which = film->which;
    t->options.fps = 1 / film->dt;
    return tracker_new(&t->options, &t->tracker);
}

/* Where looks are few, those whose place leaves no doubt need none. */
static lt_status look_at(const tracks *t, const predict_frame *f, track_detection *found)
{
    const lt_image rgb = { f->scene.width, f->scene.height, 3, 8, (uint8_t *)f->scene.rgb };
    float *embedding = lt_arena_array(f->arena, (size_t)f->n_detections * REID_EMBEDDING, sizeof(*embedding));
    bool *doubt = lt_arena_array(f->arena, (size_t)f->n_detections, sizeof(*doubt));
    int looks = f->o->most_looks ? f->o->most_looks : f->n_detections;

    if (!embedding || !doubt)
        return lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
    tracker_doubts(t->tracker, found, f->n_detections, doubt);
    for (int i = 0; i < f->n_detections && looks > 0; i++, embedding += REID_EMBEDDING) {
        const bool person = f->detection[i].kind == DETECTED_PERSON;

        if ((double)found[i].score >= tracker_look_conf(&t->options) && (doubt[i] || !f->o->most_looks) &&
            embedder_run(t->embedder, &rgb, found[i].box, person, embedding)) {
            found[i].embedding = embedding;
            looks--;
        }
    }
    return LT_OK;
}

static lt_status step(const tracks *t, predict_frame *f)
{
    track_detection *found = lt_arena_array(f->arena, (size_t)f->n_detections, sizeof(*found));
    const tracked_box *box;
    int n = 0;
    lt_status st = found ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);

    for (int i = 0; i < f->n_detections && !st; i++) {
        const predict_detection *d = &f->detection[i];

        found[i] = (track_detection){ .cls = d->cls, .score = (float)d->score,
                                      .box = { d->box.x0 + CENTRE, d->box.y0 + CENTRE, d->box.x1 + CENTRE,
                                               d->box.y1 + CENTRE } };
    }
    if (!st && t->embedder)
        st = look_at(t, f, found);
    if (!st)
        st = tracker_step(t->tracker, f->film->time, found, f->n_detections, &box, &n);
    for (int i = 0; i < n && !st; i++)
        if (box[i].detection >= 0)
            f->detection[box[i].detection].track = box[i].id;
    return st;
}

/* What is hardly seen is there where a track goes on with it, and else is not. */
static void drop_doubtful(predict_frame *f)
{
    int kept = 0;

    for (int i = 0; i < f->n_detections; i++)
        if (f->detection[i].track || f->detection[i].score > detection_rules_shown.score)
            f->detection[kept++] = f->detection[i];
    f->n_detections = kept;
}

static lt_status run(void *state, predict_frame *f)
{
    lt_status st;

    if (!f->film || !f->detected)
        return LT_OK;
    st = begin_film(state, f->film);
    st = st ? st : step(state, f);
    drop_doubtful(f);
    return st;
}

const stage track_stage = {
    .name = "track", .needs = FRAME_DETECTIONS, .gives = FRAME_DETECTIONS,
    .open = open_tracks, .run = run, .close = close_tracks,
};
