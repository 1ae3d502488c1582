/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/reid/follow.h"

#include "tasks/reid/looks.h"
#include "vision/picture.h"

#include <math.h>

typedef struct {
    lt_arena *arena, *scratch;      /* of the results, of a frame */
    const mot_sequence *s;
    embedder *e;
    tracker *tracker[TRACK_METHODS];
    int n;
    double least;                   /* score of what any of them looks at */
} following;

static lt_status no_memory(const following *f)
{
    return lt_error(LT_ENOMEM, "%s: no memory to follow what is in it", f->s->name);
}

static lt_status look_at(const following *f, const mot_frame *detections, int64_t k, track_detection *found)
{
    const bool person = looks_person(f->s);
    float *embedding = lt_arena_array(f->scratch, (size_t)detections->n * REID_EMBEDDING + 1, sizeof(*embedding));
    const char *picture = mot_picture(f->scratch, f->s, k);
    lt_image rgb;
    lt_status st = !embedding || !picture ? no_memory(f) : !detections->n ? LT_OK
                   : picture_read_rgb(f->scratch, picture, f->s->width, f->s->height, &rgb);

    for (int i = 0; !st && i < detections->n; i++, embedding += REID_EMBEDDING) {
        const mot_box *b = &detections->box[i];

        found[i] = (track_detection){ .score = (float)b->score, .cls = MOT_PEDESTRIAN };
        for (int c = 0; c < 4; c++)
            found[i].box[c] = (float)b->box[c];
        if (b->score >= f->least && embedder_run(f->e, &rgb, found[i].box, person, embedding))
            found[i].embedding = embedding;
    }
    return st;
}

/* A track's box is that of its detection, as predict and watch show it: the filter lags behind who swings his legs.
 * What is missed is where the filter expects it. */
static lt_status keep(const following *f, const track_detection *found, const tracked_box *box, int n, mot_frame *out)
{
    mot_box *to = lt_arena_array(f->arena, (size_t)n + 1, sizeof(*to));

    if (!to)
        return no_memory(f);
    *out = (mot_frame){ to, n };
    for (int i = 0; i < n; i++) {
        const float *b = box[i].detection >= 0 ? found[box[i].detection].box : box[i].box;

        to[i] = (mot_box){ .id = box[i].id, .score = (double)box[i].score, .cls = MOT_PEDESTRIAN, .scored = true,
                           .visible = 1 };
        for (int c = 0; c < 4; c++)
            to[i].box[c] = (double)b[c];
    }
    return LT_OK;
}

static lt_status follow_frame(const following *f, const mot_frame *detections, int64_t k, mot_frame **out)
{
    track_detection *found;
    lt_status st;

    lt_arena_reset(f->scratch);
    found = lt_arena_array(f->scratch, (size_t)detections->n + 1, sizeof(*found));
    st = found ? look_at(f, detections, k, found) : no_memory(f);
    for (int i = 0; !st && i < f->n; i++) {
        const tracked_box *box;
        int n;

        st = tracker_step(f->tracker[i], f->s->time[k], found, detections->n, &box, &n);
        if (!st)
            st = keep(f, found, box, n, &out[i][k]);
    }
    return st;
}

static lt_status open_trackers(following *f, const tracker_options *options, int n, mot_frame **out)
{
    lt_status st = f->scratch ? LT_OK : no_memory(f);

    for (int i = 0; !st && i < n; i++) {
        out[i] = lt_arena_array(f->arena, (size_t)f->s->frames, sizeof(**out));
        st = out[i] ? tracker_new(&options[i], &f->tracker[i]) : no_memory(f);
        f->n += !st;
        f->least = fmin(f->least, tracker_look_conf(&options[i]));
    }
    return st;
}

lt_status follow(lt_arena *arena, const mot_sequence *s, embedder *e, const tracker_options *options, int n,
                 bool (*seen)(void *ctx), void *ctx, mot_frame **out)
{
    following f = { .arena = arena, .scratch = lt_arena_new(), .s = s, .e = e, .least = 1 };
    mot_frame *detections = NULL;
    lt_status st = s->detections ? mot_read(arena, s->detections, MOT_DETECTIONS, s->frames, &detections)
                                 : lt_error(LT_EIO, "%s: has no det/det.txt to follow", s->folder);

    if (!st)
        st = open_trackers(&f, options, n, out);
    for (int64_t k = 0; !st && k < s->frames; k++) {
        st = follow_frame(&f, &detections[k], k, out);
        if (!st && seen && !seen(ctx))
            st = lt_error(LT_ESTOPPED, "stopped");
    }
    for (int i = 0; i < f.n; i++)
        tracker_free(f.tracker[i]);
    lt_arena_free(f.scratch);
    return st;
}
