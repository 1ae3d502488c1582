/* SPDX-License-Identifier: Apache-2.0 */
/* Images and films in the order in which they were named, a film's frames one by one. */
#include "pipeline/source.h"

#include "libtensor/io/image/film.h"
#include "pipeline/internal.h"
#include "pipeline/objects/objects.h"
#include "pipeline/pipe.h"

struct frame_source {
    const predict_options *o;
    lt_arena *arena;                /* of everything that lives as long as the frame_source */
    lt_arena *scratch;              /* of the frame */
    predict_list list;
    const predict_object *object;   /* where the boxes name none; may be NULL */
    bool many;                      /* frames are likely to come */
    int next;                       /* input */
    lt_image picture;
    predict_followed images;        /* the images, where they are a film's frames */

    const predict_input *in;        /* the film that is open; NULL: none */
    lt_film *film;                  /* or, of frames from a pipe: */
    pipe_reader *pipe;
    predict_followed hands;         /* of the film */
    int films;                      /* opened so far */
    int frame;                      /* the last one, from 1 */
    bool broken;                    /* nothing after that one can be read */
};

/* ---- opening --------------------------------------------------------------------------------------------- */

/* The images, each with its lines in --boxes, and the objects. */
static lt_status list_inputs(frame_source *s)
{
    const predict_options *o = s->o;
    predict_boxes boxes = { .n = 0 };
    lt_status st = o->boxes ? predict_boxes_read(s->arena, o->boxes, &boxes) : LT_OK;

    if (!st && boxes.unread)
        predict_say(o, "%s: columns that are not known are not read, the first of them %s", o->boxes, boxes.unread);
    st = st ? st : predict_load_objects(s->arena, o, &boxes, &s->object);
    st = st ? st : predict_list_inputs(s->arena, o, &s->list);
    if (!st && o->boxes && s->list.n)
        st = predict_match_boxes(s->arena, o, &boxes, &s->list);
    s->many = s->list.n > 1 || (o->boxes && s->list.n && s->list.input[0].film);
    return st;
}

lt_status frame_source_open(const predict_options *o, frame_source **out, int *skipped)
{
    frame_source *s = lt_alloc(sizeof(*s));
    lt_status st;

    if (!s)
        return lt_error(LT_ENOMEM, "predict: no memory");
    *s = (frame_source){ .o = o, .arena = lt_arena_new(), .scratch = lt_arena_new(), .hands.arena = lt_arena_new() };
    s->images = (predict_followed){ .arena = s->arena, .dt = o->fps > 0 ? 1 / o->fps : 0 };
    st = s->arena && s->scratch && s->hands.arena ? list_inputs(s) : lt_error(LT_ENOMEM, "predict: no memory");
    if (st) {
        frame_source_close(s);
        return st;
    }
    *skipped = s->list.skipped;
    *out = s;
    return LT_OK;
}

static void close_film(frame_source *s)
{
    lt_film_close(s->film);
    pipe_close(s->pipe);
    s->film = NULL;
    s->pipe = NULL;
    s->in = NULL;
}

void frame_source_close(frame_source *s)
{
    if (!s)
        return;
    close_film(s);
    lt_arena_free(s->hands.arena);
    lt_arena_free(s->scratch);
    lt_arena_free(s->arena);
    lt_release(s);
}

/* ---- films ----------------------------------------------------------------------------------------------- */

/* Whether the trouble is this input's alone, so that the next may do better. */
static bool only_this(lt_status st)
{
    return st == LT_EFORMAT || st == LT_EINVAL;
}

static lt_status open_film(frame_source *s, const predict_input *in, predict_frame *f)
{
    const lt_status st = in->pipe ? pipe_open(s->o->stop, &s->pipe) : lt_film_open(in->path, &s->film);
    const double fps = s->o->fps > 0 || st || in->pipe ? s->o->fps : lt_film_fps(s->film);

    f->forgiven = only_this(st) || st == LT_EIO;
    if (st)
        return st;
    lt_arena_reset(s->hands.arena);
    s->hands = (predict_followed){ .arena = s->hands.arena, .which = ++s->films, .dt = fps > 0 ? 1 / fps : 0 };
    s->in = in;
    s->frame = 0;
    s->broken = false;
    return LT_OK;
}

/* Frame k as an input of its own: film.mp4#12, whose results are film-000012.json and so on. */
static lt_status name_frame(lt_arena *arena, const predict_input *film, int k, int orientation, predict_input *out)
{
    *out = (predict_input){
        .path = lt_arena_printf(arena, "%s#%d", film->path, k), .frame = k, .orientation = orientation,
        .name = lt_arena_printf(arena, "%s-%0*d", film->name, PREDICT_FRAME_DIGITS, k),
    };
    out->boxes = predict_frame_boxes(film, k, &out->n_boxes);
    if (film->depth)
        out->depth = lt_arena_printf(arena, "%s/%s-%0*d.png", film->depth, film->name, PREDICT_FRAME_DIGITS,
                                    k);
    return out->path && out->name && !film->depth == !out->depth ? LT_OK
                                                                 : lt_error(LT_ENOMEM, "%s: no memory", film->path);
}

/* What a film says of its length is an estimate in some formats. */
static void say_cut(const frame_source *s)
{
    const int64_t frames = s->film ? lt_film_frames(s->film) : 0;

    if (s->frame > 0 && s->frame < frames * 9 / 10)
        predict_say(s->o, "%s: says that it has %lld frames, but only %d could be read: it may be cut off", s->in->path,
                    (long long)frames, s->frame);
}

static lt_status end_film(frame_source *s, predict_frame *f)
{
    const char *path = s->in->path;
    const bool none = s->frame == 0;

    say_cut(s);
    close_film(s);
    f->forgiven = none;
    return none ? lt_error(LT_EFORMAT, "%s: a film without frames", path) : LT_OK;
}

/* *more false: the film is over, and was closed */
static lt_status next_of_film(frame_source *s, predict_frame *f, bool *more)
{
    lt_status st = LT_OK;
    bool readable = !s->broken;

    if (readable)
        st = s->pipe ? pipe_next(s->pipe, s->scratch, &s->picture, &readable)
                     : lt_film_next(s->film, s->scratch, &s->picture, &readable);
    *more = st || readable;
    if (!*more)
        return end_film(s, f);
    s->frame++;
    s->hands.time = s->frame * s->hands.dt;
    if (st) {
        s->broken = !(s->pipe && readable);
        f->forgiven = only_this(st);
        predict_follow_missed(&s->hands);
        return s->pipe && f->forgiven ? lt_error_prefix(st, "%s#%d", s->in->path, s->frame) : st;
    }
    f->picture = &s->picture;
    f->film = s->hands.dt > 0 ? &s->hands : NULL;
    return name_frame(s->scratch, s->in, s->frame, s->film ? lt_film_orientation(s->film) : 1, &f->input);
}

static void next_image(frame_source *s, const predict_input *in, predict_frame *f)
{
    f->input = *in;
    s->images.time += s->images.dt;
    f->film = s->images.dt > 0 ? &s->images : NULL;
}

lt_status frame_source_next(frame_source *s, predict_frame *f, bool *more)
{
    lt_arena_reset(s->scratch);
    *f = (predict_frame){
        .o = s->o, .arena = s->scratch, .notes.arena = s->scratch, .object = s->object, .among_many = s->many,
    };
    while (s->in || s->next < s->list.n) {
        const predict_input *in = s->in ? s->in : &s->list.input[s->next++];
        lt_status st;

        if (!in->film) {
            next_image(s, in, f);
            *more = true;
            return LT_OK;
        }
        st = s->in ? LT_OK : open_film(s, in, f);
        st = st ? st : next_of_film(s, f, more);
        if (st || *more)
            return st;
    }
    *more = false;
    return LT_OK;
}
