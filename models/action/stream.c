/* SPDX-License-Identifier: Apache-2.0 */
#include "models/action/stream.h"

#include "libtensor/base/arena.h"
#include "libtensor/graph/plan.h"
#include "models/action/skeleton.h"

#include <string.h>

enum { V = SKELETON_BODY };

/* A graph and its plan */
typedef struct {
    lt_graph *g;
    lt_plan *plan;
} recorded;

/* mix: a frame to its neighbours' sums. end: the last `kernel` of these, and the frame in the middle of them, to a
 * result. Frames of x wait until they are in the middle: (kernel / 2 + 1) of (in, V), the newest last. */
typedef struct {
    const stgcn_unit *u;
    recorded mix, end;
    lt_tensor *in, *mixed, *ring, *middle, *out;
    lt_real *waiting;
    int64_t seen;                   /* frames since the beginning */
} unit_stream;

struct action_stream {
    lt_arena *arena;
    const stgcn *m;
    int half, kept;                 /* kernel / 2; results that the feature is the mean of */
    unit_stream unit[STGCN_MOST_UNITS];
    recorded norm;
    lt_tensor *joints, *normed;
    lt_real origin[3];
    bool begun;
    lt_real *mean;                  /* (kept, features) of the last results, the newest at results % kept */
    int64_t results;
};

static lt_status compile(recorded *r)
{
    r->plan = lt_compile(r->g, NULL);
    return r->plan ? LT_OK : lt_last_status();
}

static lt_status record_norm(action_stream *s)
{
    s->norm.g = lt_graph_new();
    if (!s->norm.g)
        return lt_error(LT_ENOMEM, "no memory for a stream");
    s->joints = lt_input(s->norm.g, "joints", LT_F32, 4, (int64_t[]){ 1, 3, 1, V });
    s->normed = lt_output(stgcn_normalise(s->m, s->joints), "normed");
    return compile(&s->norm);
}

static lt_status record_unit(action_stream *s, unit_stream *u)
{
    const int kernel = s->m->kernel;
    lt_status st;

    u->mix.g = lt_graph_new();
    u->end.g = lt_graph_new();
    u->waiting = lt_arena_array(s->arena, (size_t)(s->half + 1) * (size_t)u->u->in * V, sizeof(lt_real));
    if (!u->mix.g || !u->end.g || !u->waiting)
        return lt_error(LT_ENOMEM, "no memory for a stream");
    u->in = lt_input(u->mix.g, "in", LT_F32, 4, (int64_t[]){ 1, u->u->in, 1, V });
    u->mixed = lt_output(stgcn_mix(s->m, u->u, u->in), "mixed");
    u->ring = lt_input(u->end.g, "ring", LT_F32, 4, (int64_t[]){ 1, u->u->out, kernel, V });
    u->middle = lt_input(u->end.g, "middle", LT_F32, 4, (int64_t[]){ 1, u->u->in, 1, V });
    u->out = lt_output(stgcn_unit_end(u->u, u->ring, u->middle, 0), "out");
    st = compile(&u->mix);
    return st ? st : compile(&u->end);
}

/* Moments that a window leaves after the units that halve them */
static int kept_of(const model *m)
{
    const stgcn *g = action_stgcn(m);
    int n = action_frames(m);

    for (int k = 0; k < g->n; k++)
        n = (n - 1) / g->unit[k].stride + 1;
    return n;
}

lt_status action_stream_new(const model *m, action_stream **out)
{
    lt_arena *arena = lt_arena_new();
    action_stream *s = arena ? lt_arena_alloc(arena, sizeof(*s)) : NULL;
    lt_status st;

    *out = s;
    if (!s) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "no memory for a stream");
    }
    *s = (action_stream){ .arena = arena, .m = action_stgcn(m), .half = action_stgcn(m)->kernel / 2,
                          .kept = kept_of(m) };
    s->mean = lt_arena_array(arena, (size_t)s->kept * (size_t)s->m->features, sizeof(*s->mean));
    st = s->mean ? record_norm(s) : lt_error(LT_ENOMEM, "no memory for a stream");
    for (int k = 0; !st && k < s->m->n; k++) {
        s->unit[k].u = &s->m->unit[k];
        st = record_unit(s, &s->unit[k]);
    }
    if (!st)
        return LT_OK;
    action_stream_free(s);
    *out = NULL;
    return st;
}

static void recorded_free(const recorded *r)
{
    lt_plan_free(r->plan);
    lt_graph_free(r->g);
}

void action_stream_free(action_stream *s)
{
    if (!s)
        return;
    recorded_free(&s->norm);
    for (int k = 0; k < s->m->n; k++) {
        recorded_free(&s->unit[k].mix);
        recorded_free(&s->unit[k].end);
    }
    lt_arena_free(s->arena);
}

void action_stream_begin(action_stream *s)
{
    for (int k = 0; k < s->m->n; k++)
        s->unit[k].seen = 0;
    s->results = 0;
    s->begun = false;
}

int action_stream_features(const action_stream *s)
{
    return s->m->features;
}

int action_stream_delay(const action_stream *s)
{
    int delay = 0, step = 1;

    for (int k = 0; k < s->m->n; k++) {
        delay += s->half * step;
        step *= s->m->unit[k].stride;
    }
    return delay;
}

/* A frame behind those of `rows` planes of n frames, whose first one goes */
static void push(lt_real *ring, int64_t rows, int64_t n, const lt_real *frame)
{
    for (int64_t r = 0; r < rows; r++, ring += n * V, frame += V) {
        memmove(ring, ring + V, (size_t)((n - 1) * V) * sizeof(*ring));
        memcpy(ring + (n - 1) * V, frame, V * sizeof(*ring));
    }
}

/* x (in, V) through a unit; NULL: it waits, or this result is one that is left out */
static const lt_real *step(const action_stream *s, unit_stream *u, const lt_real *x)
{
    const size_t frame = (size_t)u->u->in * V * sizeof(*x);
    int64_t middle;

    memcpy(lt_plan_data(u->mix.plan, u->in), x, frame);
    lt_run(u->mix.plan);
    push(lt_plan_data(u->end.plan, u->ring), u->u->out, s->m->kernel, lt_plan_data(u->mix.plan, u->mixed));
    memmove(u->waiting, u->waiting + u->u->in * V, (size_t)s->half * frame);
    memcpy(u->waiting + s->half * (int64_t)u->u->in * V, x, frame);
    middle = ++u->seen - 1 - s->half;
    if (u->seen < s->m->kernel || middle % u->u->stride)
        return NULL;
    memcpy(lt_plan_data(u->end.plan, u->middle), u->waiting, frame);
    lt_run(u->end.plan);
    return lt_plan_data(u->end.plan, u->out);
}

static void add_result(action_stream *s, const lt_real *x, lt_real *feature)
{
    const int C = s->m->features;
    const int64_t n = lt_min_i64(++s->results, s->kept);
    lt_real *to = s->mean + s->results % s->kept * C;

    for (int c = 0; c < C; c++) {
        double sum = 0;

        for (int v = 0; v < V; v++)
            sum += (double)x[c * V + v];
        to[c] = (lt_real)(sum / V);
    }
    for (int c = 0; c < C; c++) {
        double sum = 0;

        for (int64_t k = 0; k < n; k++)
            sum += (double)s->mean[(s->results - k) % s->kept * C + c];
        feature[c] = (lt_real)(sum / (double)n);
    }
}

bool action_stream_body(action_stream *s, const lt_real *joint, lt_real *feature)
{
    lt_real *in = lt_plan_data(s->norm.plan, s->joints);
    const lt_real *x;

    for (int c = 0; c < 3 && !s->begun; c++)
        s->origin[c] = joint[c * V];
    s->begun = true;
    for (int i = 0; i < 3 * V; i++)
        in[i] = joint[i] - s->origin[i / V];
    lt_run(s->norm.plan);
    x = lt_plan_data(s->norm.plan, s->normed);
    for (int k = 0; x && k < s->m->n; k++)
        x = step(s, &s->unit[k], x);
    if (x)
        add_result(s, x, feature);
    return s->results > 0;
}

const lt_real *action_stream_last(const action_stream *s)
{
    const unit_stream *u = &s->unit[s->m->n - 1];

    return s->results ? lt_plan_data(u->end.plan, u->out) : NULL;
}
