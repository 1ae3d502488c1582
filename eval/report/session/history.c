/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/report/session/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/records.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

static const double GAP = 0.5;                  /* seconds for which what is not seen goes on */
static const double AT_ONCE = 0.05, NEAR = 0.7; /* seconds, metres: whom the truth means */

enum { MOST_PERSONS = 16 };

static lt_status no_memory(void)
{
    return lt_error(LT_ENOMEM, "no memory for the session");
}

/* ---- lanes ---- */

static lane *find_lane(const history *h, lane_kind kind, int64_t id, const char *cls)
{
    for (int i = 0; i < h->n_lanes; i++)
        if (h->lane[i].kind == kind && h->lane[i].id == id && (kind != LANE_CONTACT || !strcmp(h->lane[i].cls, cls)))
            return &h->lane[i];
    return NULL;
}

static lt_status new_lane(history *h, lane_kind kind, int64_t id, const char *cls, lane **out)
{
    if (h->n_lanes == SESSION_MOST_LANES) {
        h->lanes_left_out = true;
        return LT_OK;
    }
    *out = &h->lane[h->n_lanes];
    **out = (lane){ .kind = kind, .id = id, .cls = lt_arena_strdup(h->arena, cls) };
    if (!(*out)->cls)
        return no_memory();
    h->n_lanes++;
    return LT_OK;
}

static lt_status new_span(history *h, lane *l, double time, const char *label, bool pale)
{
    lane_span *all = lt_arena_grow(h->arena, l->span, (size_t)l->n, &l->room, sizeof(*all));
    const char *copy = lt_arena_strdup(h->arena, label);

    if (!all || !copy)
        return no_memory();
    l->span = all;
    l->span[l->n++] = (lane_span){ time, time, copy, pale };
    return LT_OK;
}

/* The lane goes on with what it had, or turns into something else. */
static lt_status put(history *h, lane_kind kind, int64_t id, const char *cls, double time, const char *label, bool pale)
{
    lane *l = find_lane(h, kind, id, cls);
    lane_span *last;
    lt_status st = LT_OK;

    if (!l)
        st = new_lane(h, kind, id, cls, &l);
    if (st || !l)
        return st;
    last = l->n ? &l->span[l->n - 1] : NULL;
    if (last && time - last->to <= GAP) {
        last->to = fmax(last->to, time);
        if (last->pale == pale && strcmp(last->label, label) == 0)
            return LT_OK;
    }
    return new_span(h, l, time, label, pale);
}

/* ---- a set ---- */

static const session_hand *find_hand(const session_line *l, int64_t id)
{
    for (int i = 0; i < l->n_hands; i++)
        if (l->hand[i].id == id)
            return &l->hand[i];
    return NULL;
}

static lt_status put_contact(history *h, const session_line *l, const session_contact *c, double time)
{
    const session_hand *hand = find_hand(l, c->hand);
    const lane *thing = find_lane(h, LANE_TRACK, c->object, "");

    return put(h, LANE_CONTACT, hand ? hand->person : 0, !hand ? "" : hand->left ? "left" : "right", time,
               thing ? thing->cls : "object", false);
}

static lt_status put_things(history *h, const session_line *l, double time)
{
    lt_status st = LT_OK;

    for (int i = 0; i < l->n_tracks && !st; i++)
        st = put(h, LANE_TRACK, l->track[i].id, l->track[i].cls, time, l->track[i].cls, false);
    for (int i = 0; i < l->n_hands && !st; i++)
        st = put(h, LANE_HAND, l->hand[i].id, l->hand[i].left ? "left" : "right", time,
                 l->hand[i].coasts ? "predicted" : "followed", l->hand[i].coasts);
    for (int i = 0; i < l->n_objects && !st; i++)
        st = put(h, LANE_OBJECT, l->object[i].id, l->object[i].cls, time,
                 l->object[i].coasts ? "predicted" : "followed", l->object[i].coasts);
    for (int i = 0; i < l->n_contacts && !st; i++)
        st = put_contact(h, l, &l->contact[i], time);
    return st;
}

static lt_status put_whereabouts(history *h, trail *t, const session_line *l, double time)
{
    for (int i = 0; i < l->n_people; i++) {
        const double *x = l->person[i].joint[0];
        whereabouts *all = lt_arena_grow(h->arena, t->at, t->n, &t->room, sizeof(*all));

        if (!all)
            return no_memory();
        t->at = all;
        t->at[t->n++] = (whereabouts){ time, { x[0], x[1], x[2] }, l->person[i].id };
    }
    return LT_OK;
}

static lt_status put_people(history *h, const session_line *l, double time, bool truth)
{
    const lane_kind action = truth ? LANE_TRUE_ACTION : LANE_ACTION;
    const lane_kind state = truth ? LANE_TRUE_INTERACTION : LANE_INTERACTION;
    lt_status st = put_whereabouts(h, truth ? &h->truth : &h->seen, l, time);

    for (int i = 0; i < l->n_actions && !st; i++)
        st = put(h, action, l->action[i].person, "", time, l->action[i].what, false);
    for (int i = 0; i < l->n_interactions && !st; i++)
        if (strcmp(l->interaction[i].what, "none") != 0)
            st = put(h, state, l->interaction[i].person, "", time, l->interaction[i].what, false);
    return st;
}

static lt_status add_point(history *h, report_series *s, double x, double y)
{
    double *xs, *ys;

    if (!isfinite(y))
        return LT_OK;
    xs = lt_arena_grow(h->arena, s->x, (size_t)s->n, &s->x_room, sizeof(*xs));
    ys = lt_arena_grow(h->arena, s->y, (size_t)s->n, &s->y_room, sizeof(*ys));
    if (!xs || !ys)
        return no_memory();
    s->x = xs;
    s->y = ys;
    s->x[s->n] = x;
    s->y[s->n++] = y;
    return LT_OK;
}

static lt_status put_numbers(history *h, const session_line *l, double time)
{
    lt_status st = add_point(h, &h->age, time, l->age_ms);

    if (!st)
        st = add_point(h, &h->pair, time, l->pair_ms);
    for (int k = 0; k < SESSION_STAGES && !st; k++)
        st = add_point(h, &h->stage[k], time, l->stage_ms[k]);
    for (int c = 0; c < h->r.rig.n && !st; c++) {
        const report_series *s = &h->drops[c];

        st = add_point(h, &h->drops[c], time, (s->n ? s->y[s->n - 1] : 0) + l->dropped[c]);
    }
    return st;
}

/* Seconds since the first set, by the first camera whose clock was seen before; the others' clocks are set by it. */
static double time_of(history *h, const session_line *l)
{
    double time = h->n ? h->time[h->n - 1] : 0;

    for (int c = 0; c < RECORDING_CAMERAS; c++)
        if (isfinite(l->t[c]) && isfinite(h->clock[c])) {
            time = fmax(time, l->t[c] - h->clock[c]);
            break;
        }
    for (int c = RECORDING_CAMERAS - 1; c >= 0; c--)
        if (isfinite(l->t[c])) {
            h->origin = h->n ? h->origin : l->t[c];
            h->clock[c] = isfinite(h->clock[c]) ? h->clock[c] : l->t[c] - time;
        }
    return time;
}

static lt_status take_set(history *h, const session_line *l, const char *text, size_t n, int64_t number)
{
    const double time = time_of(h, l);
    const int64_t k = h->n++;
    lt_status st;

    h->line[k] = text;
    h->length[k] = n;
    h->number[k] = number;
    h->time[k] = time;
    st = put_numbers(h, l, time);
    if (!st)
        st = put_things(h, l, time);
    return st ? st : put_people(h, l, time, false);
}

/* ---- files ---- */

static lt_status read_file(history *h, const char *name, const char **path, const char **text, size_t *n)
{
    uint8_t *bytes;
    lt_status st;

    *path = lt_path_join(h->arena, h->r.root, name);
    if (!*path)
        return no_memory();
    st = lt_read_file(h->arena, *path, LT_FILE_MAX, &bytes, n);
    if (!st)
        *text = (const char *)bytes;
    return st;
}

/* visit is called for each whole line. */
static lt_status each_line(history *h, const char *path, const char *text, size_t n, bool truth,
                           lt_status (*visit)(history *h, const session_line *l, const char *line, size_t length,
                                              int64_t number))
{
    lt_arena *scratch = lt_arena_new();
    lt_records in = lt_records_of(text, n);
    size_t length;
    lt_status st = scratch ? LT_OK : no_memory();

    for (const char *line; !st && (line = lt_next_record(&in, &length)); ) {
        session_line l;

        lt_arena_reset(scratch);
        st = session_line_parse(scratch, path, in.number, line, length, truth, &l);
        if (!st)
            st = visit(h, &l, line, length, in.number);
    }
    lt_arena_free(scratch);
    return st;
}

static lt_status take_line(history *h, const session_line *l, const char *line, size_t length, int64_t number)
{
    if (!l->is_sum)
        return take_set(h, l, line, length, number);
    h->sum = l->sum;
    h->sum.crc = lt_arena_strdup(h->arena, l->sum.crc);
    h->has_sum = true;
    return h->sum.crc ? LT_OK : no_memory();
}

static lt_status take_truth(history *h, const session_line *l, const char *line, size_t length, int64_t number)
{
    double time = NAN;

    (void)line, (void)length, (void)number;
    for (int c = RECORDING_CAMERAS - 1; c >= 0; c--)
        time = isfinite(l->t[c]) ? l->t[c] - h->origin : time;
    if (isnan(time))
        return LT_OK;
    return put_people(h, l, time, true);
}

static lt_status read_session(history *h)
{
    const char *path;
    size_t lines;
    lt_status st = read_file(h, "session.ndjson", &path, &h->text, &h->bytes);

    if (st == LT_EIO)
        return lt_error(LT_EIO, "%s: was not watched yet, or without --record: there is no session.ndjson", h->r.root);
    if (st)
        return st;
    lines = (size_t)lt_count_records(h->text, h->bytes);
    h->line = lt_arena_array(h->arena, lines, sizeof(*h->line));
    h->length = lt_arena_array(h->arena, lines, sizeof(*h->length));
    h->number = lt_arena_array(h->arena, lines, sizeof(*h->number));
    h->time = lt_arena_array(h->arena, lines, sizeof(*h->time));
    h->lane = lt_arena_array(h->arena, SESSION_MOST_LANES, sizeof(*h->lane));
    if (!h->line || !h->length || !h->number || !h->time || !h->lane)
        return no_memory();
    return each_line(h, path, h->text, h->bytes, false, take_line);
}

static lt_status read_truth(history *h)
{
    const char *path = lt_path_join(h->arena, h->r.root, "truth.ndjson"), *text;
    size_t n;
    lt_status st;

    if (!path)
        return no_memory();
    h->has_truth = access(path, F_OK) == 0;
    if (!h->has_truth)
        return LT_OK;
    st = read_file(h, "truth.ndjson", &path, &text, &n);
    return st ? st : each_line(h, path, text, n, true, take_truth);
}

/* ---- whom the truth means ---- */

/* Its place among the persons met so far; -1: there are too many */
static int person_index(int64_t *met, int *n, int64_t id)
{
    for (int i = 0; i < *n; i++)
        if (met[i] == id)
            return i;
    if (*n == MOST_PERSONS)
        return -1;
    met[(*n)++] = id;
    return *n - 1;
}

/* The true person that is nearest to one that was seen, at the same time, over the floor; NULL: none is near */
static const whereabouts *nearest(const trail *truth, size_t from, const whereabouts *seen)
{
    const whereabouts *best = NULL;
    double least = NEAR;

    for (size_t i = from; i < truth->n && truth->at[i].time <= seen->time + AT_ONCE; i++) {
        const double away = hypot(truth->at[i].x[0] - seen->x[0], truth->at[i].x[1] - seen->x[1]);

        if (away < least) {
            least = away;
            best = &truth->at[i];
        }
    }
    return best;
}

/* Each true person's lanes stand beside those of whom it was most often near. */
static void match_truth(history *h)
{
    int64_t seen[MOST_PERSONS], truth[MOST_PERSONS];
    int votes[MOST_PERSONS][MOST_PERSONS] = { { 0 } }, n_seen = 0, n_truth = 0;
    size_t from = 0;

    for (size_t i = 0; i < h->seen.n; i++) {
        const whereabouts *w = &h->seen.at[i], *t;
        int a, b;

        while (from < h->truth.n && h->truth.at[from].time < w->time - AT_ONCE)
            from++;
        t = nearest(&h->truth, from, w);
        a = t ? person_index(truth, &n_truth, t->id) : -1;
        b = t ? person_index(seen, &n_seen, w->id) : -1;
        if (a >= 0 && b >= 0)
            votes[a][b]++;
    }
    for (int i = 0; i < h->n_lanes; i++)
        for (int a = 0; a < n_truth; a++) {
            lane *l = &h->lane[i];
            int best = 0;

            for (int b = 1; b < n_seen; b++)
                best = votes[a][b] > votes[a][best] ? b : best;
            if ((l->kind == LANE_TRUE_ACTION || l->kind == LANE_TRUE_INTERACTION) && l->id == truth[a])
                l->beside = seen[best];
        }
}

/* ---- the whole ---- */

lt_status history_read(lt_arena *arena, const char *root, history *out)
{
    history *h = out;
    lt_status st;

    *h = (history){ .arena = arena };
    for (int c = 0; c < RECORDING_CAMERAS; c++)
        h->clock[c] = NAN;
    st = recording_open(arena, root, &h->r);
    if (!st)
        st = read_session(h);
    if (!st)
        st = read_truth(h);
    if (!st)
        match_truth(h);
    return st;
}

lt_status history_line(const history *h, lt_arena *arena, int64_t k, session_line *out)
{
    return session_line_parse(arena, "session.ndjson", h->number[k], h->line[k], h->length[k], false, out);
}
