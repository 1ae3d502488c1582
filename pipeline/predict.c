/* SPDX-License-Identifier: Apache-2.0 */
/* Image after image: open, solve, write; what cannot be read is named, skipped and counted. */
#include "pipeline/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/film.h"

#include <string.h>

static void say_found(const predict_case *c)
{
    const predict_result *r = c->r;

    if (!r->placed)
        predict_say(c->o, "%s: the hand's position could not be solved (0.05 to 10 m are believed); it is put 0.6 m "
                    "away in its box", c->v->path);
    else if (!predict_trusted(c->v, r))
        predict_say(c->o, "%s: low trust: the hand's 2D and 3D joints differ by %.0f px", c->v->path,
                    r->agreement_px);
    if (c->object && !r->object_found)
        predict_say(c->o, "%s: no pose of %s was found (confidence %.2f)", c->v->path, c->object->name,
                    (double)r->e.object_confidence);
}

/* Whether the trouble is this image's alone, so that the next may do better. */
static bool only_this_image(lt_status st)
{
    return st == LT_EFORMAT || st == LT_EINVAL;
}

/* What all images have in common. */
typedef struct {
    const predict_options *o;
    const predict_object *object;
    predict_solver *solver;
    predict_summary *sum;
    predict_assumed *said;
} predict_job;

/* smoother: NULL: the image has nothing to do with the last one. *unread: the image is to blame, not what is written
 * or the machine. */
static lt_status predict_one(const predict_job *j, lt_arena *arena, predict_smoother *smoother, const predict_input *in,
                             const lt_image *frame, bool *unread)
{
    predict_result *r = lt_arena_alloc(arena, sizeof(*r));
    predict_view v;
    const predict_case c = { j->o, &v, j->object, r };
    lt_status st;

    if (!r)
        return lt_error(LT_ENOMEM, "%s: no memory", in->path);
    st = predict_view_open(arena, j->o, in, frame, &v);
    *unread = only_this_image(st) || st == LT_EIO;
    if (!st)
        predict_say_assumed(j->o, &v, j->said);
    st = st ? st : predict_solve(j->solver, arena, &v, j->object, r);
    if (st && smoother)
        predict_smooth_missed(smoother);
    if (st)
        return st;
    if (smoother)
        predict_smooth(smoother, &v, j->object, r);
    say_found(&c);
    st = predict_write_files(arena, &c);
    *unread = only_this_image(st);          /* a name that is too long */
    return st;
}

/* Counts what was written and what was skipped; an error where nothing after it would do better, or is wanted. */
static lt_status count(const predict_job *j, lt_status st, bool unread)
{
    if (st && !unread)
        return st;
    j->sum->written += !st;
    j->sum->skipped += st != LT_OK;
    if (st)
        predict_say(j->o, "skipped: %s", lt_last_error());
    return j->o->stop && j->o->stop() ? lt_error(LT_ESTOPPED, "predict: stopped") : LT_OK;
}

static lt_status predict_image(const predict_job *j, predict_smoother *smoother, const predict_input *in)
{
    lt_arena *arena = lt_arena_new();
    bool unread = false;
    lt_status st = arena ? predict_one(j, arena, smoother, in, NULL, &unread)
                         : lt_error(LT_ENOMEM, "%s: no memory", in->path);

    st = count(j, st, unread);
    lt_arena_free(arena);
    return st;
}

/* ---- films ----------------------------------------------------------------------------------------------- */

/* Frame k as an input of its own: film.mp4#12, whose results are film-000012.json and so on. */
static lt_status name_frame(lt_arena *arena, const predict_input *film, int k, int orientation, predict_input *out)
{
    *out = (predict_input){
        .path = lt_arena_printf(arena, "%s#%d", film->path, k), .frame = k, .orientation = orientation,
        .name = lt_arena_printf(arena, "%s-%0*d", film->name, PREDICT_FRAME_DIGITS, k),
        .boxes = predict_frame_boxes(film, k),
    };
    if (film->depth)
        out->depth = lt_arena_printf(arena, "%s/%s-%0*d.png", film->depth, film->name, PREDICT_FRAME_DIGITS,
                                    k);
    return out->path && out->name && !film->depth == !out->depth ? LT_OK
                                                                 : lt_error(LT_ENOMEM, "%s: no memory", film->path);
}

/* *more: there was one, and there may be another. A film that cannot be read on ends alone. */
static lt_status predict_frame(const predict_job *j, lt_film *film, predict_smoother *smoother, const predict_input *in,
                               int k, bool *more)
{
    lt_arena *arena = lt_arena_new();
    bool unread = false;
    predict_input frame;
    lt_image img;
    lt_status st = arena ? lt_film_next(film, arena, &img, more) : lt_error(LT_ENOMEM, "%s: no memory", in->path);

    *more = !st && *more;
    if (st) {
        st = count(j, st, only_this_image(st));
    } else if (*more) {
        st = name_frame(arena, in, k, lt_film_orientation(film), &frame);
        st = st ? st : predict_one(j, arena, smoother, &frame, &img, &unread);
        st = count(j, st, unread);
    }
    lt_arena_free(arena);
    return st;
}

/* What a film says of its length is an estimate in some formats. */
static void say_cut(const predict_job *j, const predict_input *in, int64_t read, int64_t frames)
{
    if (read > 0 && read < frames * 9 / 10)
        predict_say(j->o, "%s: says that it has %lld frames, but only %lld could be read: it may be cut off", in->path,
                    (long long)frames, (long long)read);
}

static lt_status predict_film(const predict_job *j, const predict_input *in)
{
    const int before = j->sum->written + j->sum->skipped;
    predict_smoother smoother = { 0 };
    bool more = true;
    int read;
    lt_film *film;
    lt_status st = lt_film_open(in->path, &film);

    if (st)
        return count(j, st, only_this_image(st) || st == LT_EIO);
    if (j->o->fps > 0 || lt_film_fps(film) > 0)
        smoother.dt = 1 / (j->o->fps > 0 ? j->o->fps : lt_film_fps(film));
    else
        predict_say(j->o, "%s: does not say its frames per second, so they are not smoothed; --fps does", in->path);
    for (int k = 1; !st && more; k++)
        st = predict_frame(j, film, smoother.dt > 0 ? &smoother : NULL, in, k, &more);
    read = j->sum->written + j->sum->skipped - before;
    if (!st)
        say_cut(j, in, read, lt_film_frames(film));
    lt_film_close(film);
    if (st || read)
        return st;
    return count(j, lt_error(LT_EFORMAT, "%s: a film without frames", in->path), true);
}

static lt_status predict_all(const predict_job *j, const predict_list *list)
{
    predict_smoother film = { .dt = j->o->fps > 0 ? 1 / j->o->fps : 0 };
    lt_status st = LT_OK;

    for (int i = 0; !st && i < list->n; i++)
        st = list->input[i].film ? predict_film(j, &list->input[i])
                                 : predict_image(j, film.dt > 0 ? &film : NULL, &list->input[i]);
    return st;
}

/* The images, each with its line in --boxes. */
static lt_status list_inputs(lt_arena *arena, const predict_options *o, predict_list *list)
{
    predict_boxes boxes;
    lt_status st = o->boxes ? predict_boxes_read(arena, o->boxes, &boxes) : LT_OK;

    if (!st && o->boxes && boxes.unread)
        predict_say(o, "%s: columns that are not known are not read, the first of them %s", o->boxes, boxes.unread);
    st = st ? st : predict_list_inputs(arena, o, list);
    return st || !o->boxes || !list->n ? st : predict_match_boxes(arena, o, &boxes, list);
}

static lt_status run(lt_arena *arena, const predict_options *o, predict_summary *sum)
{
    predict_assumed said = { 0 };
    predict_object object;
    predict_list list;
    predict_solver *solver = NULL;
    lt_status st = o->object ? predict_object_load(arena, o, &object) : LT_OK;

    if (!st && !o->object)
        predict_say(o, "no --object: the hand alone, no object pose");
    if (!st && o->m->depth && !o->depth)
        predict_say(o, "no --depth: %s %s was trained with it, and sees worse without", o->m->cls->name, o->m->variant);
    st = st ? st : list_inputs(arena, o, &list);
    st = st ? st : lt_make_dirs(o->out);
    st = st ? st : predict_solver_new(o, &solver);
    if (!st) {
        const predict_job job = { o, o->object ? &object : NULL, solver, sum, &said };

        sum->skipped = list.skipped;
        said.many = list.n > 1 || (o->boxes && list.n && list.input[0].film);
        st = predict_all(&job, &list);
    }
    predict_solver_free(solver);
    return st;
}

lt_status predict_images(const predict_options *o, predict_summary *out)
{
    predict_summary sum = { 0 };
    lt_arena *arena;
    lt_status st;

    if (o->n_inputs < 1)
        return lt_error(LT_EINVAL, "predict: no images were named");
    arena = lt_arena_new();
    st = arena ? run(arena, o, &sum) : lt_error(LT_ENOMEM, "predict: no memory");
    lt_arena_free(arena);
    if (out)
        *out = sum;
    if (!st && sum.skipped)
        st = lt_error(LT_EFORMAT, "predict: skipped %d of %d inputs that could not be read", sum.skipped,
                      sum.skipped + sum.written);
    return st;
}
