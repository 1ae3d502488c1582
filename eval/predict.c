/* SPDX-License-Identifier: Apache-2.0 */
/* Image after image: open, solve, write; what cannot be read is named, skipped and counted. */
#include "eval/predict_internal.h"

#include "libtensor/io/file.h"

#include <stdarg.h>
#include <string.h>

void predict_say(const predict_options *o, const char *fmt, ...)
{
    char line[1024];
    va_list args;

    if (!o->messages)
        return;
    va_start(args, fmt);
    vsnprintf(line, sizeof(line), fmt, args);
    va_end(args);
    for (char *p = line; *p; p++)
        if ((unsigned char)*p < ' ' || *p == 127)
            *p = '?';
    fprintf(o->messages, "%s\n", line);
}

static void say_found(const predict_case *c)
{
    const predict_result *r = c->r;

    if (!r->placed)
        predict_say(c->o, "%s: the hand's position could not be solved (0.05 to 10 m are believed); it is put 0.6 m away in its box",
                    c->v->path);
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

/* *unread: the image is to blame, not what is written or the machine. */
static lt_status predict_one(predict_solver *solver, predict_smoother *film, const predict_options *o,
                             const predict_object *object, const predict_input *in, bool *unread)
{
    lt_arena *arena = lt_arena_new();
    predict_result *r = arena ? lt_arena_alloc(arena, sizeof(*r)) : NULL;
    predict_view v;
    lt_status st = r ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", in->path);

    if (!st) {
        st = predict_view_open(arena, o, in, &v);
        *unread = only_this_image(st) || st == LT_EIO;
    }
    st = st ? st : predict_solve(solver, arena, o, &v, object, r);
    if (!st) {
        const predict_case c = { o, &v, object, r };

        if (film)
            predict_smooth(film, &v, r);
        say_found(&c);
        st = predict_write_files(arena, &c);
    }
    lt_arena_free(arena);
    return st;
}

static lt_status predict_all(predict_solver *solver, const predict_options *o, const predict_object *object,
                             const predict_list *list, predict_summary *sum)
{
    predict_smoother film = { .dt = o->fps > 0 ? 1 / o->fps : 0 };

    for (int i = 0; i < list->n; i++) {
        bool unread = false;
        const lt_status st = predict_one(solver, o->fps > 0 ? &film : NULL, o, object, &list->input[i], &unread);

        if (st && !unread)
            return st;
        sum->written += !st;
        sum->skipped += st != LT_OK;
        if (st)
            predict_say(o, "skipped: %s", lt_last_error());
    }
    return LT_OK;
}

static lt_status run(lt_arena *arena, const predict_options *o, predict_summary *sum)
{
    predict_object object;
    predict_list list;
    predict_solver *solver = NULL;
    lt_status st = o->object ? predict_object_load(arena, o, &object) : LT_OK;

    if (!st && !o->object)
        predict_say(o, "no --object: the hand alone, no object pose");
    if (!st && o->m->depth && !o->depth)
        predict_say(o, "no --depth: %s %s was trained with it, and sees worse without", o->m->cls->name, o->m->variant);
    st = st ? st : predict_list_inputs(arena, o, &list);
    st = st ? st : lt_make_dirs(o->out);
    st = st ? st : predict_solver_new(o, &solver);
    if (!st) {
        sum->skipped = list.skipped;
        st = predict_all(solver, o, o->object ? &object : NULL, &list, sum);
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
