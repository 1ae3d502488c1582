/* SPDX-License-Identifier: Apache-2.0 */
/* Sets of frames: as they were chosen when they were recorded, as fast as they can be read, or the newest there are. */
#include "pipeline/watch/internal.h"

#include "libtensor/base/clock.h"

#include <math.h>
#include <string.h>
#include <time.h>

static const double PATIENCE = 0.1;         /* seconds, between questions whether to stop */
static const double FAR_CLOCK = 0.5;        /* seconds that are worth a word */

/* One camera that is read as fast as can be: the frame at hand and the one behind it */
typedef struct {
    lt_arena *arena[2];
    watch_picture picture[2];
    bool there[2], ended;
    int at;                         /* which of the two is at hand */
} lane;

struct feed {
    const watch_options *o;
    pairing pair;
    watch_camera camera[WATCH_CAMERAS];
    capture *live;                  /* NULL: replayed or fast */
    lane lane[WATCH_CAMERAS];       /* fast */
    lt_arena *arena;                /* replayed: of a set */
    int64_t set;                    /* replayed: the next one */
    int64_t last_line[WATCH_CAMERAS];
    int64_t sets, captured, taken;  /* captured: of cameras that are not live */
    int64_t since[WATCH_CAMERAS];   /* dropped since the last set; live: dropped before it */
    double first_t, start;
    bool told[WATCH_CAMERAS];
};

static bool is_stopped(const feed *f)
{
    return f->o->stop && f->o->stop();
}

/* The camera that faces the person, else the first */
static int choose_reference(const recording_rig *rig)
{
    for (int c = 0; c < rig->n; c++)
        if (rig->camera[c].role == RECORDING_FRONT)
            return c;
    return 0;
}

/* Another one, as its has ended; what was known of clocks went by that */
static bool change_reference(feed *f, int to)
{
    f->first_t += pairing_offset(&f->pair, to);
    memset(f->pair.n_seen, 0, sizeof(f->pair.n_seen));
    f->pair.reference = to;
    return true;
}

static void tell_of_clock(feed *f, int camera)
{
    const double off = pairing_offset(&f->pair, camera);
    const recording_rig *rig = &f->o->rig;

    if (f->told[camera] || fabs(off) < FAR_CLOCK)
        return;
    f->told[camera] = true;
    watch_say(f->o, "camera %s: its clock is %.2f s %s that of %s; its frames are paired as if it were not",
              rig->camera[camera].name, fabs(off), off > 0 ? "ahead of" : "behind",
                  rig->camera[f->pair.reference].name);
}

/* ---- replayed ---- */

static int64_t lines_between(const recording *r, int camera, int64_t from, int64_t to)
{
    int64_t n = 0;

    for (int64_t k = from + 1; k < to; k++)
        n += r->frame[k].camera == camera;
    return n;
}

static lt_status read_frame(feed *f, int camera, int64_t line, watch_set *out)
{
    const recording *r = f->o->replayed;
    watch_picture *p = &out->picture[camera];
    lt_image depth;
    lt_status st;

    *p = (watch_picture){ .t = r->frame[line].t, .line = line, .came = lt_clock() };
    st = recording_colour(r, line, f->arena, &p->rgb);
    if (!st && r->frame[line].depth) {
        st = recording_depth(r, line, f->arena, &depth);
        p->depth = st ? NULL : (const uint16_t *)depth.data;
    }
    out->there[camera] = !st;
    out->dropped[camera] = lines_between(r, camera, f->last_line[camera], line);
    f->captured += 1 + out->dropped[camera];
    f->last_line[camera] = line;
    return st;
}

static lt_status next_replayed(feed *f, watch_set *out, bool *more)
{
    const recording *r = f->o->replayed;
    lt_status st = LT_OK;

    *more = f->set < r->n_sets;
    if (!*more)
        return LT_OK;
    lt_arena_reset(f->arena);
    for (int c = 0; c < f->o->rig.n && !st; c++)
        if (r->set[f->set].frame[c] >= 0)
            st = read_frame(f, c, r->set[f->set].frame[c], out);
    f->set++;
    out->reference = f->pair.reference;
    for (int c = 0; c < f->o->rig.n && !out->there[out->reference]; c++)
        out->reference = out->there[c] ? c : out->reference;
    return st;
}

/* ---- as fast as can be ---- */

/* Read ahead, so that there is a frame behind the one at hand. An error ends the camera. */
static void read_ahead(feed *f, int c)
{
    lane *l = &f->lane[c];
    const int to = l->there[l->at] ? 1 - l->at : l->at;
    lt_status st;
    bool more;

    if (l->ended || l->there[to])
        return;
    lt_arena_reset(l->arena[to]);
    st = watch_camera_next(&f->camera[c], &f->o->rig.camera[c], l->arena[to], &l->picture[to], &more);
    if (st)
        watch_say(f->o, "camera %s: %s; the others go on", f->o->rig.camera[c].name, lt_last_error());
    l->there[to] = !st && more;
    l->ended = !l->there[to];
    f->captured += l->there[to];
}

static void pass(feed *f, int c)
{
    lane *l = &f->lane[c];

    l->there[l->at] = false;
    l->at = 1 - l->at;
    f->since[c]++;
}

/* Frames that stand beside each other in a recording came at the same time, whatever their stamps say. */
static void compare_clocks(feed *f, int c, const watch_picture *p, const watch_picture *reference)
{
    const int64_t apart = p->line - reference->line;

    if (p->line >= 0 && reference->line >= 0 && apart <= f->o->rig.n && apart >= -f->o->rig.n)
        pairing_note(&f->pair, c, p->t, reference->t);
    tell_of_clock(f, c);
}

/* The frame of a camera that is nearest to the reference's; false: none is near enough */
static bool find_partner(feed *f, int c, const watch_picture *reference)
{
    lane *l = &f->lane[c];
    double apart;

    read_ahead(f, c);
    if (l->there[l->at])
        compare_clocks(f, c, &l->picture[l->at], reference);
    for (read_ahead(f, c); l->there[l->at]; read_ahead(f, c)) {
        const double now = pairing_apart(&f->pair, c, l->picture[l->at].t, reference->t);
        const double then = pairing_apart(&f->pair, c, l->picture[1 - l->at].t, reference->t);

        if (l->there[1 - l->at] ? fabs(then) > fabs(now) : pairing_fits(&f->pair, now) || now > 0)
            break;
        pass(f, c);
    }
    apart = l->there[l->at] ? pairing_apart(&f->pair, c, l->picture[l->at].t, reference->t) : INFINITY;
    return pairing_fits(&f->pair, apart);
}

/* What was taken stays where it is until the next set. */
static void take(feed *f, int c, watch_set *out)
{
    lane *l = &f->lane[c];

    out->there[c] = true;
    out->picture[c] = l->picture[l->at];
    out->picture[c].came = lt_clock();
}

/* Those of the last set are done with. */
static void let_go(feed *f, const watch_set *last)
{
    for (int c = 0; c < f->o->rig.n; c++)
        if (last->there[c]) {
            f->lane[c].there[f->lane[c].at] = false;
            f->lane[c].at = 1 - f->lane[c].at;
        }
}

static bool find_reference_fast(feed *f)
{
    const int now = f->pair.reference;

    read_ahead(f, now);
    if (f->lane[now].there[f->lane[now].at])
        return true;
    for (int c = 0; c < f->o->rig.n; c++) {
        read_ahead(f, c);
        if (f->lane[c].there[f->lane[c].at])
            return change_reference(f, c);
    }
    return false;
}

static lt_status next_fast(feed *f, watch_set *out, bool *more)
{
    const watch_picture *reference;

    *more = find_reference_fast(f);
    if (!*more)
        return LT_OK;
    out->reference = f->pair.reference;
    take(f, out->reference, out);
    reference = &out->picture[out->reference];
    for (int c = 0; c < f->o->rig.n; c++)
        if (c != out->reference && find_partner(f, c, reference))
            take(f, c, out);
    memcpy(out->dropped, f->since, sizeof(out->dropped));
    memset(f->since, 0, sizeof(f->since));
    return LT_OK;
}

/* ---- the newest there are ---- */

static bool find_reference_live(feed *f)
{
    if (!capture_ended(f->live, f->pair.reference))
        return true;
    for (int c = 0; c < f->o->rig.n; c++)
        if (!capture_ended(f->live, c))
            return change_reference(f, c);
    return false;
}

/* Its frame of the same time, which may be on its way yet. Older ones are dropped, a newer one waits for its set. */
static void take_partner(feed *f, int c, double reference_t, watch_set *out)
{
    const double until = lt_clock() + f->pair.period / 2;
    double t, nearest = INFINITY, left = f->pair.period / 2;

    while (!out->there[c] && capture_wait(f->live, c, fmax(0, left), &t)) {
        const double apart = pairing_apart(&f->pair, c, t, reference_t);

        nearest = fabs(t - reference_t) < fabs(nearest) ? t - reference_t : nearest;
        if (apart > f->pair.period / 2)
            break;
        if (pairing_fits(&f->pair, apart))
            out->there[c] = capture_take(f->live, c, t, &out->picture[c]);
        else
            capture_drop(f->live, c);
        left = until - lt_clock();
    }
    if (isfinite(nearest))
        pairing_note(&f->pair, c, reference_t + nearest, reference_t);
    tell_of_clock(f, c);
}

static void count_live(feed *f, watch_set *out)
{
    for (int c = 0; c < f->o->rig.n; c++) {
        int64_t captured, dropped;

        capture_count(f->live, c, &captured, &dropped);
        out->dropped[c] = dropped - f->since[c];
        f->since[c] = dropped;
    }
}

static lt_status next_live(feed *f, watch_set *out, bool *more)
{
    int reference = f->pair.reference;
    bool taken = false;
    double t;

    while (!taken) {
        *more = !is_stopped(f) && find_reference_live(f);
        if (!*more)
            return LT_OK;
        reference = f->pair.reference;
        taken = capture_wait(f->live, reference, PATIENCE, &t)
                && capture_take(f->live, reference, t, &out->picture[reference]);
    }
    out->reference = reference;
    out->there[reference] = true;
    for (int c = 0; c < f->o->rig.n; c++)
        if (c != reference)
            take_partner(f, c, out->picture[reference].t, out);
    count_live(f, out);
    return LT_OK;
}

/* ---- any of them ---- */

lt_status feed_open(const watch_options *o, feed **out)
{
    feed *f = lt_alloc(sizeof(*f));
    lt_status st = LT_OK;

    *out = f;
    if (!f)
        return lt_error(LT_ENOMEM, "no memory for the cameras");
    f->o = o;
    f->pair = (pairing){ .n = o->rig.n, .reference = choose_reference(&o->rig), .period = 1 / o->rig.fps };
    memcpy(f->camera, o->camera, sizeof(f->camera));
    for (int c = 0; c < WATCH_CAMERAS; c++)
        f->last_line[c] = -1;
    if (o->replayed && o->replayed->set) {
        f->arena = lt_arena_new();
        return f->arena ? LT_OK : lt_error(LT_ENOMEM, "no memory for the cameras");
    }
    if (!o->fast)
        return capture_open(o, &f->live);
    for (int c = 0; c < o->rig.n && !st; c++)
        for (int k = 0; k < 2 && !st; k++)
            if (!(f->lane[c].arena[k] = lt_arena_new()))
                st = lt_error(LT_ENOMEM, "no memory for the cameras");
    return st;
}

void feed_close(feed *f)
{
    if (!f)
        return;
    capture_close(f->live);
    for (int c = 0; c < WATCH_CAMERAS; c++)
        for (int k = 0; k < 2; k++)
            lt_arena_free(f->lane[c].arena[k]);
    lt_arena_free(f->arena);
    lt_release(f);
}

static void measure_pair(const feed *f, watch_set *out)
{
    const double t = out->picture[out->reference].t;
    double lo = 0, hi = 0;

    for (int c = 0; c < f->o->rig.n; c++)
        if (out->there[c]) {
            const double apart = pairing_apart(&f->pair, c, out->picture[c].t, t);

            lo = fmin(lo, apart);
            hi = fmax(hi, apart);
        }
    out->pair_ms = 1000 * (hi - lo);
}

/* What was recorded comes at its own pace where it is not wanted fast. */
static void keep_pace(feed *f, watch_set *out)
{
    const double due = f->start + out->t;

    while (!is_stopped(f) && lt_clock() < due) {
        const double wait = fmin(PATIENCE, due - lt_clock());
        const struct timespec nap = { .tv_nsec = (long)(1e9 * fmax(0, wait)) };

        nanosleep(&nap, NULL);
    }
    for (int c = 0; c < WATCH_CAMERAS; c++)
        out->picture[c].came = due;
}

lt_status feed_next(feed *f, watch_set *set, bool *more)
{
    const watch_set last = *set;
    lt_status st;

    *set = (watch_set){ .number = f->sets };
    *more = !is_stopped(f);
    if (!*more)
        return LT_OK;
    if (f->arena) {
        st = next_replayed(f, set, more);
    } else if (f->live) {
        st = next_live(f, set, more);
    } else {
        if (f->sets)
            let_go(f, &last);
        st = next_fast(f, set, more);
    }
    if (st || !*more)
        return st;
    if (!f->sets++) {
        f->first_t = set->picture[set->reference].t;
        f->start = lt_clock();
    }
    for (int c = 0; c < f->o->rig.n; c++)
        f->taken += set->there[c];
    set->t = set->picture[set->reference].t - f->first_t;
    measure_pair(f, set);
    if (f->arena && !f->o->fast)
        keep_pace(f, set);
    return LT_OK;
}

void feed_counts(const feed *f, int64_t *captured, int64_t *taken)
{
    *captured = f->captured;
    *taken = f->taken;
    for (int c = 0; f->live && c < f->o->rig.n; c++) {
        int64_t came, dropped;

        capture_count(f->live, c, &came, &dropped);
        *captured += came;
    }
}
