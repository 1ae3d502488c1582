/* SPDX-License-Identifier: Apache-2.0 */
/* S3: which tracks of different cameras are of one thing. */
#include "pipeline/watch/internal.h"

#include "libtensor/geometry/mat3.h"
#include "vision/assignment.h"

#include <math.h>
#include <string.h>

/* Metres between two middles of one thing; of a person along the floor, as one camera sees a half of him */
static const double GATE = 0.15, GATE_PERSON = 0.5;
static const double FORGET = 3;                             /* seconds without being seen */
static const double FAR = 1e6;

watch_thing *watch_thing_of(watch_world *w, int64_t id)
{
    for (int i = 0; i < w->n_things; i++)
        if (w->thing[i].id == id)
            return &w->thing[i];
    return NULL;
}

static watch_thing *thing_of_track(watch_world *w, int camera, int64_t track, int cls)
{
    for (int i = 0; i < w->n_things; i++)
        if (w->thing[i].track[camera] == track && w->thing[i].cls == cls)
            return &w->thing[i];
    return NULL;
}

/* Things that nobody has seen for long make place for others. */
static void forget(watch_world *w, double t)
{
    int kept = 0;

    for (int i = 0; i < w->n_things; i++)
        if (t - w->thing[i].seen <= FORGET)
            w->thing[kept++] = w->thing[i];
    w->n_things = kept;
}

static watch_thing *add_thing(watch_world *w, const watch_sight *s, double t)
{
    watch_thing *new;

    if (w->n_things == WATCH_THINGS)
        return NULL;
    new = &w->thing[w->n_things++];
    *new = (watch_thing){ .id = ++w->last_id, .kind = s->seen.kind, .cls = s->seen.cls, .name = s->seen.name, .seen = t,
                          .support = NAN, .placed = s->placed };
    memcpy(new->centre.x, s->centre, sizeof(new->centre.x));
    return new;
}

/* Whether this camera sees the thing already, as another track of this set */
static bool is_taken(const watch_eye *e, int camera, const watch_thing *thing)
{
    for (int i = 0; i < e->n; i++)
        if (thing->track[camera] && e->sight[i].seen.track == thing->track[camera] &&
            e->sight[i].seen.cls == thing->cls)
            return true;
    return false;
}

static double cost(const watch_eye *e, int camera, const watch_sight *s, const watch_thing *thing)
{
    const bool person = s->seen.kind == DETECTED_PERSON;
    double d;

    if (!s->placed || !thing->placed || thing->cls != s->seen.cls || is_taken(e, camera, thing))
        return FAR;
    d = person ? hypot(s->centre[0] - thing->centre.x[0], s->centre[1] - thing->centre.x[1])
               : lt_vec3_distance(s->centre, thing->centre.x);
    return d <= (person ? GATE_PERSON : GATE) ? d : FAR;
}

static void join(watch_sight *s, watch_thing *thing, int camera)
{
    thing->track[camera] = s->seen.track;
    s->id = thing->id;
}

/* Tracks that are new in this camera go with things that others see at the same place, or are new things. */
static lt_status match_new(watch_world *w, int camera, watch_sight *const *new, int n, double t)
{
    const watch_eye *e = &w->eye[camera];
    const int things = w->n_things;
    double *table = lt_arena_array(w->arena, (size_t)n * (size_t)things, sizeof(*table));
    int *column = lt_arena_array(w->arena, (size_t)n, sizeof(*column));
    lt_status st = table && column ? LT_OK : lt_error(LT_ENOMEM, "no memory for tracks");

    for (int i = 0; i < n && !st; i++)
        for (int k = 0; k < things; k++)
            table[i * things + k] = cost(e, camera, new[i], &w->thing[k]);
    if (!st)
        st = assignment_solve(w->arena, table, n, things, column);
    for (int i = 0; i < n && !st; i++) {
        const int k = things ? column[i] : -1;
        watch_thing *thing = k >= 0 && table[i * things + k] < FAR ? &w->thing[k] : add_thing(w, new[i], t);

        if (thing)
            join(new[i], thing, camera);
    }
    return st;
}

static lt_status join_camera(watch_world *w, int camera, double t)
{
    watch_eye *e = &w->eye[camera];
    watch_sight **new = lt_arena_array(w->arena, (size_t)e->n, sizeof(watch_sight *));
    int n = 0;

    if (!new)
        return lt_error(LT_ENOMEM, "no memory for tracks");
    for (int i = 0; i < e->n; i++) {
        watch_sight *s = &e->sight[i];
        const watch_thing *thing = s->seen.track ? thing_of_track(w, camera, s->seen.track, s->seen.cls) : NULL;

        if (thing)
            s->id = thing->id;
        else if (s->seen.track)
            new[n++] = s;
    }
    return match_new(w, camera, new, n, t);
}

/* The middle of a thing that several cameras see is the mean of theirs. */
static void place(watch_world *w, watch_thing *thing, double t)
{
    double sum[3] = { 0 };
    int n = 0;

    for (int c = 0; c < w->o->rig.n; c++)
        for (int i = 0; i < w->eye[c].n && w->eye[c].fresh; i++) {
            const watch_sight *s = &w->eye[c].sight[i];

            if (s->id != thing->id)
                continue;
            thing->seen = t;
            thing->score = s->seen.score;
            if (s->seen.side != PREDICT_ANY_SIDE)
                thing->side = s->seen.side;
            for (int d = 0; s->placed && d < 3; d++)
                sum[d] += s->centre[d];
            n += s->placed;
        }
    for (int d = 0; d < 3 && n; d++)
        sum[d] /= n;
    lt_point_filter_step(&thing->centre, w->dt, n ? sum : NULL);
    thing->placed = thing->centre.started;
}

lt_status watch_together_run(watch_world *w, const watch_set *set)
{
    lt_status st = LT_OK;

    forget(w, set->t);
    for (int c = 0; c < w->o->rig.n && !st; c++)
        if (w->eye[c].fresh)
            st = join_camera(w, c, set->t);
    for (int i = 0; i < w->n_things && !st; i++)
        place(w, &w->thing[i], set->t);
    return st;
}
