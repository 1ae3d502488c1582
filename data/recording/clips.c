/* SPDX-License-Identifier: Apache-2.0 */
#include "data/recording/clips.h"

#include "data/action/axes.h"
#include "data/recording/line.h"
#include "libtensor/io/file.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

enum { LEAST_FRAMES = 15 };
static const double SAME_TIME = 1.0 / 30;       /* seconds between a true frame and a line that saw it */
static const double SAME_PERSON = 1;            /* metres between two pelvises */

typedef struct {
    double t;
    const session_person *person;
    int n;
    const session_doing *action;
    int n_actions;
} moment;

typedef struct {
    moment *at;
    size_t n, room;
} moments;

static lt_status no_memory(const char *path)
{
    return lt_error(LT_ENOMEM, "%s: no memory", path);
}

/* ---- lines ---- */

/* The first camera that has a time says when it was. */
static double time_of(const session_line *l)
{
    for (int c = 0; c < RECORDING_CAMERAS; c++)
        if (isfinite(l->t[c]))
            return l->t[c];
    return NAN;
}

/* A last line that is cut off is left out. */
static lt_status read_lines(lt_arena *arena, const char *path, bool truth, moments *out)
{
    lt_file f;
    lt_status st = lt_file_load(&f, path, LT_FILE_MAX);
    const char *at = (const char *)f.bytes, *end = st ? at : at + f.n, *newline;

    for (int64_t number = 1; !st && (newline = memchr(at, '\n', (size_t)(end - at))); number++, at = newline + 1) {
        session_line l;

        st = session_line_parse(arena, path, number, at, (size_t)(newline - at), truth, &l);
        if (st || l.is_sum || isnan(time_of(&l)))
            continue;
        out->at = lt_arena_grow(arena, out->at, out->n, &out->room, sizeof(*out->at));
        if (!out->at)
            st = no_memory(path);
        else
            out->at[out->n++] = (moment){ time_of(&l), l.person, l.n_people, l.action, l.n_actions };
    }
    lt_file_free(&f);
    return st;
}

/* ---- who did what when ---- */

/* The class of what a person does; -1: nothing that is known */
static int class_of(const moment *m, int64_t person)
{
    for (int i = 0; i < m->n_actions; i++)
        for (int c = 0; m->action[i].person == person && c < ACTION_CLASSES; c++)
            if (strcmp(m->action[i].what, action_classes[c]) == 0)
                return c;
    return -1;
}

static const session_person *person_of(const moment *m, int64_t id)
{
    for (int i = 0; i < m->n; i++)
        if (m->person[i].id == id)
            return &m->person[i];
    return NULL;
}

/* The skeleton that was seen when and where a true one was; NULL: none */
static const session_person *seen_of(const moments *seen, double t, const session_person *truth)
{
    const moment *when = NULL;
    const session_person *who = NULL;
    double nearest = SAME_TIME, apart = SAME_PERSON;

    for (size_t i = 0; i < seen->n; i++)
        if (fabs(seen->at[i].t - t) <= nearest) {
            nearest = fabs(seen->at[i].t - t);
            when = &seen->at[i];
        }
    for (int i = 0; when && i < when->n; i++)
        if (lt_vec3_distance(when->person[i].joint[0], truth->joint[0]) < apart) {
            apart = lt_vec3_distance(when->person[i].joint[0], truth->joint[0]);
            who = &when->person[i];
        }
    return who;
}

typedef struct {
    int64_t person;
    int cls, first, n;              /* frames of the truth */
} act;

typedef struct {
    act *at;
    size_t n, room;
} acts;

static lt_status add_act(lt_arena *arena, const act *a, acts *out)
{
    if (a->n < LEAST_FRAMES)
        return LT_OK;
    out->at = lt_arena_grow(arena, out->at, out->n, &out->room, sizeof(*out->at));
    if (!out->at)
        return no_memory("clips");
    out->at[out->n++] = *a;
    return LT_OK;
}

/* A person's acts: as long as the class stays and the person is there, ACTION_MOST_FRAMES at most */
static lt_status find_acts(lt_arena *arena, const moments *truth, int64_t person, acts *out)
{
    act now = { .cls = -1 };
    lt_status st = LT_OK;

    for (int k = 0; k < (int)truth->n && !st; k++) {
        const int cls = person_of(&truth->at[k], person) ? class_of(&truth->at[k], person) : -1;

        if (cls == now.cls && now.n < ACTION_MOST_FRAMES) {
            now.n++;
            continue;
        }
        st = now.cls < 0 ? LT_OK : add_act(arena, &now, out);
        now = (act){ person, cls, k, 1 };
    }
    return st || now.cls < 0 ? st : add_act(arena, &now, out);
}

/* Each person that is in a true frame, once */
static lt_status find_all(lt_arena *arena, const moments *truth, acts *out, int *people)
{
    int64_t *met = NULL;
    size_t n = 0, room = 0;
    lt_status st = LT_OK;

    for (size_t k = 0; k < truth->n; k++)
        for (int i = 0; i < truth->at[k].n && !st; i++) {
            const int64_t id = truth->at[k].person[i].id;
            size_t j = 0;

            while (j < n && met[j] != id)
                j++;
            if (j < n)
                continue;
            met = lt_arena_grow(arena, met, n, &room, sizeof(*met));
            if (!met)
                return no_memory("clips");
            met[n++] = id;
            st = find_acts(arena, truth, id, out);
        }
    *people = (int)n;
    return st;
}

/* ---- clips ---- */

static void put_frame(const double R[9], const session_person *p, int64_t length, int k, float *to)
{
    for (int v = 0; v < ACTION_BODY; v++) {
        double at[3] = { NAN, NAN, NAN };

        if (p)
            lt_mat3_mulvec(R, p->joint[v], at);
        for (int d = 0; d < 3; d++)
            to[(d * length + k) * ACTION_BODY + v] = (float)at[d];
    }
}

/* Frames in which nobody was seen are not finite; how many are */
static int put_act(const double R[9], const moments *truth, const moments *seen, const act *a, int64_t length,
                   float *to)
{
    int there = 0;

    for (int k = 0; k < a->n; k++) {
        const moment *m = &truth->at[a->first + k];
        const session_person *p = person_of(m, a->person);

        p = seen && p ? seen_of(seen, m->t, p) : p;
        there += p != NULL;
        put_frame(R, p, length, k, to);
    }
    return there;
}

static lt_status make_clips(lt_arena *arena, const moments *truth, const moments *seen, const acts *all,
                            const double R[9],
                            action_set *out)
{
    action_clip *clip = lt_arena_array(arena, all->n, sizeof(*clip));
    float *body;

    for (size_t i = 0; i < all->n; i++)
        out->length = all->at[i].n > out->length ? all->at[i].n : out->length;
    body = lt_arena_array(arena, all->n * (size_t)out->length, 3 * ACTION_BODY * sizeof(*body));
    if (!clip || !body)
        return no_memory(out->root);
    for (size_t i = 0; i < all->n; i++) {
        const act *a = &all->at[i];
        float *to = body + out->n * 3 * out->length * ACTION_BODY;

        if (put_act(R, truth, seen, a, out->length, to) < LEAST_FRAMES)
            continue;
        clip[out->n] = (action_clip){ .cls = a->cls, .subject = 0, .frames = a->n, .onset = 0 };
        clip[out->n].name
            = lt_arena_printf(arena, "person %lld at %.2f s", (long long)a->person, truth->at[a->first].t);
        if (!clip[out->n].name)
            return no_memory(out->root);
        action_hold_body(&clip[out->n], to, out->length);
        out->n++;
    }
    out->clip = clip;
    out->body = body;
    return LT_OK;
}

bool recording_clips_probe(const char *root)
{
    char truth[4096];

    return recording_probe(root) && snprintf(truth, sizeof(truth), "%s/truth.ndjson", root) < (int)sizeof(truth) &&
           access(truth, R_OK) == 0;
}

lt_status recording_clips_open(lt_arena *arena, const char *root, const char *seen, action_set *out)
{
    action_set s = { .root = root, .subjects = 1, .whole = true, .difficulty = NAN };
    const char *path = lt_path_join(arena, root, "truth.ndjson"),
        *rig_path = lt_path_join(arena, root, "recording.json");
    moments truth = { .n = 0 }, lines = { .n = 0 };
    acts all = { .n = 0 };
    recording_rig rig;
    double R[9];
    int people = 0;
    lt_status st = path && rig_path ? recording_rig_read(arena, rig_path, &rig) : no_memory(root);

    st = st ? st : read_lines(arena, path, true, &truth);
    if (!st && seen && *seen)
        st = read_lines(arena, seen, false, &lines);
    st = st ? st : find_all(arena, &truth, &all, &people);
    if (st)
        return st;
    action_axes(rig.has_robot ? rig.robot : (const double[3]){ 0, 1, 0 }, R);
    s.synthetic = rig.synthetic;
    st = make_clips(arena, &truth, seen && *seen ? &lines : NULL, &all, R, &s);
    if (!st && !s.n)
        st = lt_error(LT_EINVAL, "%s: of %d persons none is %s while doing one thing for %d frames", path, people,
                      seen && *seen ? "seen" : "there", LEAST_FRAMES);
    if (!st)
        *out = s;
    return st;
}
