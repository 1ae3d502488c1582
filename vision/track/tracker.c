/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/track/tracker.h"

#include "vision/track/internal.h"

#include <math.h>
#include <string.h>

const char *const track_method_names[TRACK_METHODS] = { "deepsort", "byte", "iou" };

const tracker_options tracker_defaults = {
    .method = TRACK_DEEPSORT, .embedding = 128, .fps = 30, .min_conf = 0.3, .low_conf = 0.1, .look_conf = 0.6,
    .max_cosine = 0.2, .max_iou = 0.7, .overlap_cosine = 0.5, .unsure_iou = 0.4, .max_age = 30, .n_init = 3,
    .budget = 100,
};
const tracker_options tracker_as_published = {
    .method = TRACK_DEEPSORT, .embedding = 128, .fps = 30, .min_conf = 0.3, .low_conf = 0.1, .look_conf = 0,
    .max_cosine = 0.2, .max_iou = 0.7, .overlap_cosine = 2, .unsure_iou = 1, .max_age = 30, .n_init = 3, .budget = 100,
};

enum { FRESH = 10 };                /* hits of a track from look to look, where none is in doubt */

struct tracker {
    tracker_options options;
    track *tracks;                  /* by id */
    tracked_box *seen;              /* room for as many */
    int n, room;
    int64_t last_id;
    double time;                    /* of the last frame; NaN before it */
    lt_arena *scratch;
};

bool track_appearance(const tracker_options *o)
{
    return o->embedding > 0 && o->method != TRACK_IOU;
}

double tracker_look_conf(const tracker_options *o)
{
    return fmax(o->look_conf, o->min_conf);
}

bool track_usable(const track_detection *d)
{
    const float w = d->box[2] - d->box[0], h = d->box[3] - d->box[1];

    /* Sides that are finite and above 0 are the differences of finite corners. */
    return w > 0 && h > 0 && isfinite(w) && isfinite(h) && isfinite(w / h) && isfinite(d->score);
}

/* ---- life ---- */

static lt_status check_options(const tracker_options *o)
{
    const double share[] = { o->min_conf, o->low_conf, o->look_conf, o->max_cosine, o->max_iou, o->overlap_cosine,
                             o->unsure_iou };

    if (!(o->fps > 0) || !isfinite(o->fps))
        return lt_error(LT_EINVAL, "tracker: fps is %g, expected frames a second", o->fps);
    if (o->method == TRACK_DEEPSORT && o->embedding < 1)
        return lt_error(LT_EINVAL, "tracker: deepsort compares embeddings and there are none; use byte or iou");
    if (o->embedding < 0 || o->max_age < 1 || o->n_init < 1 || o->budget < 1)
        return lt_error(LT_EINVAL, "tracker: embedding %d, max_age %d, n_init %d, budget %d, expected no less than 0, "
                        "1, 1, 1", o->embedding, o->max_age, o->n_init, o->budget);
    for (size_t i = 0; i < LT_COUNT(share); i++)
        if (!(share[i] >= 0 && share[i] <= 2))
            return lt_error(LT_EINVAL, "tracker: a score or a distance is limited to %g, expected 0 to 2", share[i]);
    return LT_OK;
}

lt_status tracker_new(const tracker_options *options, tracker **out)
{
    lt_status st = check_options(options);
    tracker *t = NULL;

    if (st)
        return st;
    t = lt_alloc(sizeof(*t));
    if (t) {
        t->options = *options;
        t->time = NAN;
        t->scratch = lt_arena_new();
    }
    if (!t || !t->scratch) {
        tracker_free(t);
        return lt_error(LT_ENOMEM, "no memory for a tracker");
    }
    *out = t;
    return LT_OK;
}

void tracker_free(tracker *t)
{
    if (!t)
        return;
    for (int i = 0; i < t->n; i++)
        gallery_fini(&t->tracks[i].look);
    lt_release(t->tracks);
    lt_release(t->seen);
    lt_arena_free(t->scratch);
    lt_release(t);
}

static lt_status reserve(tracker *t, int more)
{
    const size_t room = 2 * (size_t)(t->n + more);
    track *tracks;
    tracked_box *seen;

    if (t->n + more <= t->room)
        return LT_OK;
    tracks = lt_alloc(room * sizeof(*tracks));
    seen = lt_alloc(room * sizeof(*seen));
    if (!tracks || !seen) {
        lt_release(tracks);
        lt_release(seen);
        return lt_error(LT_ENOMEM, "no memory for %d tracks more", more);
    }
    if (t->n)
        memcpy(tracks, t->tracks, (size_t)t->n * sizeof(*tracks));
    lt_release(t->tracks);
    lt_release(t->seen);
    t->tracks = tracks;
    t->seen = seen;
    t->room = (int)room;
    return LT_OK;
}

/* ---- a frame ---- */

/* All tracks end that are missed for longer than max_age, so more frames than that are as many. */
static int frames_since_last(tracker *t, double time)
{
    const double frames = round((time - t->time) * t->options.fps);

    if (!isfinite(time))
        return 1;
    t->time = time;
    return frames >= 1 ? (int)fmin(frames, t->options.max_age + 1) : 1;
}

static void predict(tracker *t, int frames)
{
    for (int i = 0; i < t->n; i++) {
        for (int k = 0; k < frames; k++)
            motion_predict(&t->tracks[i].motion);
        t->tracks[i].age += frames;
        t->tracks[i].detection = -1;
    }
}

static lt_status make_frame(tracker *t, const track_detection *found, int n, int elapsed, track_frame *f)
{
    const bool appearance = track_appearance(&t->options);
    const size_t size = appearance ? (size_t)t->options.embedding : 0;
    float *unit;

    *f = (track_frame){
        .options = &t->options, .scratch = t->scratch, .tracks = t->tracks, .found = found, .n_tracks = t->n,
        .n_found = n, .elapsed = elapsed, .unit = lt_arena_array(t->scratch, (size_t)n + 1, sizeof(*f->unit)),
        .found_of = lt_arena_array(t->scratch, (size_t)t->n + 1, sizeof(int)),
        .track_of = lt_arena_array(t->scratch, (size_t)n + 1, sizeof(int)),
    };
    unit = lt_arena_array(t->scratch, (size_t)n + 1, size * sizeof(*unit));
    if (!f->unit || !f->found_of || !f->track_of || !unit)
        return lt_error(LT_ENOMEM, "no memory to track %d detections", n);
    for (int i = 0; i < t->n; i++)
        f->found_of[i] = -1;
    for (int j = 0; j < n; j++, unit += size) {
        f->track_of[j] = -1;
        if (appearance && found[j].embedding && (double)found[j].score >= tracker_look_conf(&t->options) &&
            gallery_unit(found[j].embedding, (int)size, unit))
            f->unit[j] = unit;
    }
    return LT_OK;
}

static void hit(const track_frame *f, track *t, int j)
{
    const track_detection *d = &f->found[j];

    motion_update(&t->motion, d->box);
    t->hits++;
    t->age = 0;
    t->detection = j;
    t->score = d->score;
    t->confirmed |= t->hits >= f->options->n_init;
    if (f->unit[j])
        gallery_add(&t->look, f->unit[j]);
}

/* Tracks that were missed for too long end; those that stay close up. */
static void update(tracker *t, const track_frame *f)
{
    int kept = 0;

    for (int i = 0; i < t->n; i++) {
        track *k = &t->tracks[i];

        if (f->found_of[i] >= 0)
            hit(f, k, f->found_of[i]);
        if (k->age > 0 && (!k->confirmed || k->age > t->options.max_age))
            gallery_fini(&k->look);
        else
            t->tracks[kept++] = *k;
    }
    t->n = kept;
}

static lt_status begin(tracker *t, const track_frame *f, int j)
{
    const track_detection *d = &f->found[j];
    track *k = &t->tracks[t->n];
    lt_status st = LT_OK;

    *k = (track){ .id = t->last_id + 1, .cls = d->cls, .detection = j };
    if (track_appearance(&t->options))
        st = gallery_init(&k->look, t->options.budget, t->options.embedding);
    if (st)
        return st;
    motion_begin(&k->motion, d->box);
    k->hits = 1;
    k->score = d->score;
    k->confirmed = t->options.n_init <= 1;
    if (f->unit[j])
        gallery_add(&k->look, f->unit[j]);
    t->last_id++;
    t->n++;
    return LT_OK;
}

static lt_status begin_unmatched(tracker *t, const track_frame *f)
{
    lt_status st = LT_OK;

    for (int j = 0; !st && j < f->n_found; j++)
        if (f->track_of[j] < 0 && (double)f->found[j].score >= t->options.min_conf && track_usable(&f->found[j]))
            st = begin(t, f, j);
    return st;
}

static int report(tracker *t)
{
    int n = 0;

    for (int i = 0; i < t->n; i++) {
        const track *k = &t->tracks[i];
        tracked_box *b = &t->seen[n];
        double box[4];

        if (!k->confirmed || k->age > 1)
            continue;
        *b = (tracked_box){ .id = k->id, .cls = k->cls, .detection = k->detection, .score = k->score };
        motion_box(&k->motion, box);
        for (int c = 0; c < 4; c++)
            b->box[c] = (float)box[c];
        n++;
    }
    return n;
}

lt_status tracker_step(tracker *t, double time, const track_detection *found, int n, const tracked_box **out,
                       int *n_out)
{
    const int elapsed = frames_since_last(t, time);
    track_frame f;
    lt_status st;

    *n_out = 0;
    lt_arena_reset(t->scratch);
    predict(t, elapsed);
    st = reserve(t, n);
    if (!st)
        st = make_frame(t, found, n, elapsed, &f);
    if (!st)
        st = track_match(&f);
    if (st)
        return st;
    update(t, &f);
    st = begin_unmatched(t, &f);
    *out = t->seen;
    *n_out = st ? 0 : report(t);
    return st;
}

void tracker_doubts(const tracker *t, const track_detection *found, int n, bool *doubt)
{
    for (int j = 0; j < n; j++) {
        const track *own = track_alone(&t->options, t->tracks, t->n, found, n, j);

        doubt[j] = !own || (own->hits + own->id) % FRESH == 0;
    }
}
