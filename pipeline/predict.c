/* SPDX-License-Identifier: Apache-2.0 */
/* Frame after frame through the stages; what cannot be read is named, skipped and counted. */
#include "pipeline/internal.h"
#include "pipeline/source.h"
#include "pipeline/stage.h"

#include "libtensor/io/file.h"

/* name: NULL-terminated */
static void add_names(const char **row, const char *const *name)
{
    while (*row)
        row++;
    for (; *name; name++)
        *row++ = *name;
}

static lt_status open_stages(const predict_options *o, pipeline **out)
{
    static const char *const detect[] = { "detect", "track", NULL }, *const look[] = { "look", NULL };
    static const char *const hands[] = { "estimate", "solve", "smooth", NULL };
    static const char *const bodies[] = { "body", NULL };
    static const char *const judge[] = { "judge", NULL }, *const draw[] = { "draw", NULL };
    static const char *const write[] = { "write", NULL }, *const print[] = { "print", NULL };
    const char *row[MOST_STAGES + 1] = { "read" };

    if (o->detector)
        add_names(row, detect);
    add_names(row, look);
    if (o->m)
        add_names(row, hands);
    if (o->body)
        add_names(row, bodies);
    add_names(row, judge);
    if (o->out && !o->numbers)
        add_names(row, draw);
    if (o->out)
        add_names(row, write);
    if (o->lines)
        add_names(row, print);
    return pipeline_open(o, 0, row, out);
}

/* Counts what was written and what was skipped; an error where nothing after it would do better, or is wanted. */
static lt_status count(const predict_frame *f, lt_status st, predict_summary *sum)
{
    if (st && !f->forgiven)
        return st;
    sum->written += !st;
    sum->skipped += st != LT_OK;
    if (st)
        predict_say(f->o, "skipped: %s", lt_last_error());
    return f->o->stop && f->o->stop() ? lt_error(LT_ESTOPPED, "predict: stopped") : LT_OK;
}

static lt_status walk(frame_source *s, pipeline *p, predict_summary *sum)
{
    lt_status st = LT_OK;

    while (!st) {
        bool more = true;
        predict_frame f;

        st = frame_source_next(s, &f, &more);
        if (!st && !more)
            break;
        st = st ? st : pipeline_run(p, &f);
        st = count(&f, st, sum);
    }
    return st;
}

lt_status predict_images(const predict_options *o, predict_summary *out)
{
    predict_summary sum = { 0 };
    frame_source *from = NULL;
    pipeline *through = NULL;
    lt_status st = o->n_inputs < 1 && !o->pipe ? lt_error(LT_EINVAL, "predict: no images were named")
                                                : frame_source_open(o, &from, &sum.skipped);

    if (!st && o->out)
        st = lt_make_dirs(o->out);
    st = st ? st : open_stages(o, &through);
    st = st ? st : walk(from, through, &sum);
    pipeline_close(through);
    frame_source_close(from);
    if (out)
        *out = sum;
    if (!st && sum.skipped)
        st = lt_error(LT_EFORMAT, "predict: skipped %d of %d inputs that could not be read", sum.skipped,
                      sum.skipped + sum.written);
    return st;
}
