/* SPDX-License-Identifier: Apache-2.0 */
/* Image after image: open, solve, write; what cannot be read is named, skipped and counted. */
#include "pipeline/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/film.h"

#include <string.h>

/* Whether the trouble is this image's alone, so that the next may do better. */
static bool only_this_image(lt_status st)
{
    return st == LT_EFORMAT || st == LT_EINVAL;
}

/* What all images have in common. */
typedef struct {
    const predict_options *o;
    const predict_object *given;        /* where the boxes name none; may be NULL */
    predict_solver *solver;
    predict_summary *sum;
    predict_said *said;
} predict_job;

static lt_status solve_hands(const predict_job *j, lt_arena *arena, const predict_view *v, int n, predict_result **out)
{
    predict_result *r = lt_arena_array(arena, (size_t)n, sizeof(*r));
    lt_status st = r ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", v->path);

    for (int i = 0; i < n && !st; i++)
        st = predict_solve(j->solver, arena, &v[i], &r[i]);
    *out = r;
    return st;
}

/* film: NULL: the image has nothing to do with the last one. *unread: the image is to blame, not what is written or the
 * machine. */
static lt_status predict_one(const predict_job *j, lt_arena *arena, predict_followed *film, const predict_input *in,
                             const lt_image *frame, bool *unread)
{
    predict_notes notes = { .arena = arena };
    predict_result *r;
    predict_view *v;
    int n;
    lt_status st = predict_view_open(arena, j->o, in, frame, j->given, &notes, &v, &n);

    *unread = only_this_image(st) || st == LT_EIO;
    st = st ? st : solve_hands(j, arena, v, n, &r);
    if (st && film)
        predict_follow_missed(film);
    if (!st && film)
        st = predict_follow(film, v, r, n);
    if (st)
        return st;
    if (in->frame && !film)
        predict_note_add(&notes, NULL, NOTE_NOT_SMOOTHED, "the film does not say its frames per second, so they are "
                         "not smoothed; --fps does");
    for (int i = 0; i < n; i++)
        predict_note_found(&v[i], &r[i], &notes);
    if (notes.lost)
        return lt_error(LT_ENOMEM, "%s: no memory", in->path);
    predict_say_notes(j->o, in->path, &notes, j->said);
    st = predict_write_files(arena, &(predict_case){ j->o, v, r, n, &notes });
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

static lt_status predict_image(const predict_job *j, predict_followed *film, const predict_input *in)
{
    lt_arena *arena = lt_arena_new();
    bool unread = false;
    lt_status st = arena ? predict_one(j, arena, film, in, NULL, &unread)
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
    };
    out->boxes = predict_frame_boxes(film, k, &out->n_boxes);
    if (film->depth)
        out->depth = lt_arena_printf(arena, "%s/%s-%0*d.png", film->depth, film->name, PREDICT_FRAME_DIGITS,
                                    k);
    return out->path && out->name && !film->depth == !out->depth ? LT_OK
                                                                 : lt_error(LT_ENOMEM, "%s: no memory", film->path);
}

/* *more: there was one, and there may be another. A film that cannot be read on ends alone. */
static lt_status predict_frame(const predict_job *j, lt_film *film, predict_followed *hands, const predict_input *in,
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
        st = st ? st : predict_one(j, arena, hands, &frame, &img, &unread);
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

static lt_status predict_frames(const predict_job *j, const predict_input *in, lt_film *film, predict_followed *hands)
{
    const int before = j->sum->written + j->sum->skipped;
    bool more = true;
    lt_status st = LT_OK;
    int read;

    for (int k = 1; !st && more; k++)
        st = predict_frame(j, film, hands->dt > 0 ? hands : NULL, in, k, &more);
    read = j->sum->written + j->sum->skipped - before;
    if (!st)
        say_cut(j, in, read, lt_film_frames(film));
    if (st || read)
        return st;
    return count(j, lt_error(LT_EFORMAT, "%s: a film without frames", in->path), true);
}

static lt_status predict_film(const predict_job *j, const predict_input *in)
{
    predict_followed hands = { .arena = lt_arena_new() };
    lt_film *film;
    lt_status st = lt_film_open(in->path, &film);

    if (st) {
        lt_arena_free(hands.arena);
        return count(j, st, only_this_image(st) || st == LT_EIO);
    }
    if (j->o->fps > 0 || lt_film_fps(film) > 0)
        hands.dt = 1 / (j->o->fps > 0 ? j->o->fps : lt_film_fps(film));
    st = hands.arena ? predict_frames(j, in, film, &hands) : lt_error(LT_ENOMEM, "%s: no memory", in->path);
    lt_film_close(film);
    lt_arena_free(hands.arena);
    return st;
}

static lt_status predict_all(const predict_job *j, lt_arena *arena, const predict_list *list)
{
    predict_followed frames = { .arena = arena, .dt = j->o->fps > 0 ? 1 / j->o->fps : 0 };
    lt_status st = LT_OK;

    for (int i = 0; !st && i < list->n; i++)
        st = list->input[i].film ? predict_film(j, &list->input[i])
                                 : predict_image(j, frames.dt > 0 ? &frames : NULL, &list->input[i]);
    return st;
}

/* The images, each with its lines in --boxes, and the objects. */
static lt_status list_inputs(lt_arena *arena, const predict_options *o, predict_list *list,
                             const predict_object **given)
{
    predict_boxes boxes = { .n = 0 };
    lt_status st = o->boxes ? predict_boxes_read(arena, o->boxes, &boxes) : LT_OK;

    if (!st && boxes.unread)
        predict_say(o, "%s: columns that are not known are not read, the first of them %s", o->boxes, boxes.unread);
    st = st ? st : predict_load_objects(arena, o, &boxes, given);
    st = st ? st : predict_list_inputs(arena, o, list);
    return st || !o->boxes || !list->n ? st : predict_match_boxes(arena, o, &boxes, list);
}

static lt_status run(lt_arena *arena, const predict_options *o, predict_summary *sum)
{
    predict_said said = { 0 };
    const predict_object *given;
    predict_list list;
    predict_solver *solver = NULL;
    lt_status st = list_inputs(arena, o, &list, &given);

    st = st ? st : lt_make_dirs(o->out);
    st = st ? st : predict_solver_new(o, &solver);
    if (!st) {
        const predict_job job = { o, given, solver, sum, &said };

        sum->skipped = list.skipped;
        said.many = list.n > 1 || (o->boxes && list.n && list.input[0].film);
        st = predict_all(&job, arena, &list);
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
