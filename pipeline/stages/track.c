/* SPDX-License-Identifier: Apache-2.0 */
/* track: whose number each detection of a film's frame has among those of the frames before. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

typedef struct {
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
    t->options.method = o->track;
    t->options.embedding = 0;
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

static lt_status step(tracks *t, predict_frame *f)
{
    track_detection *found = lt_arena_array(f->arena, (size_t)f->n_detections, sizeof(*found));
    const tracked_box *box;
    int n;
    lt_status st;

    if (!found)
        return lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
    for (int i = 0; i < f->n_detections; i++) {
        const predict_detection *d = &f->detection[i];

        found[i] = (track_detection){ .box = { d->box.x0, d->box.y0, d->box.x1, d->box.y1 }, .cls = d->cls,
                                      .score = (float)d->score };
    }
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
