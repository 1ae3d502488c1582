/* SPDX-License-Identifier: Apache-2.0 */
#include "pipeline/stage.h"

#include "pipeline/stages/stages.h"

#include <string.h>

struct pipeline {
    struct { const stage *stage; void *state; } step[MOST_STAGES];
    int n;
};

static const stage *find(const char *name)
{
    for (const stage *const *s = stages; *s; s++)
        if (strcmp((*s)->name, name) == 0)
            return *s;
    return NULL;
}

static lt_status add(pipeline *p, const predict_options *o, const char *name, unsigned has)
{
    const stage *s = find(name);
    void *state = NULL;
    lt_status st;

    if (!s || p->n == MOST_STAGES)
        return lt_error(LT_EINVAL, "pipeline: %s \"%s\"", s ? "no room for stage" : "no stage is called", name);
    if (s->needs & ~has)
        return lt_error(LT_EINVAL, "pipeline: stage \"%s\" needs what no stage before it gives (parts %#x)", name,
                        s->needs & ~has);
    st = s->open ? s->open(o, &state) : LT_OK;
    if (st)
        return st;
    p->step[p->n].stage = s;
    p->step[p->n++].state = state;
    return LT_OK;
}

lt_status pipeline_open(const predict_options *o, unsigned given, const char *const *names, pipeline **out)
{
    pipeline *p = lt_alloc(sizeof(*p));
    lt_status st = p ? LT_OK : lt_error(LT_ENOMEM, "no memory for a pipeline");

    for (; !st && *names; names++) {
        st = add(p, o, *names, given);
        given |= st ? 0 : p->step[p->n - 1].stage->gives;
    }
    if (st) {
        pipeline_close(p);
        return st;
    }
    *out = p;
    return LT_OK;
}

lt_status pipeline_run(pipeline *p, predict_frame *f)
{
    lt_status st = LT_OK;

    for (int i = 0; i < p->n; i++) {
        const stage *s = p->step[i].stage;

        if (st) {
            if (s->miss)
                s->miss(p->step[i].state, f);
            continue;
        }
        st = s->run(p->step[i].state, f);
        f->has |= st ? 0 : s->gives;
        f->forgiven = st && s->forgives && s->forgives(st);
    }
    return st;
}

void pipeline_close(pipeline *p)
{
    for (int i = p ? p->n : 0; i-- > 0; )
        if (p->step[i].stage->close)
            p->step[i].stage->close(p->step[i].state);
    lt_release(p);
}
