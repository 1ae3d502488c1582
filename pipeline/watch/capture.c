/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A thread for each camera, and a queue of one: what waits is the newest frame, and the one that it replaces is counted
 * as dropped. So the delay does not grow, however slow the rest is.
 */
#include "pipeline/watch/internal.h"

#include "libtensor/base/clock.h"

#include <errno.h>
#include <pthread.h>
#include <string.h>
#include <time.h>

/* A frame that is being read, the one that waits, and the one that was taken */
enum { READING, WAITING, TAKEN, ROOMS };

typedef struct {
    capture *all;
    int number;
    watch_camera *camera;
    pthread_t thread;
    bool started;

    /* under the lock but for what is read into */
    lt_arena *room[ROOMS];
    watch_picture waiting;
    bool waits, ended;
    int64_t captured, dropped;
} lane;

struct capture {
    const watch_options *o;
    watch_camera camera[WATCH_CAMERAS];
    pthread_mutex_t lock;
    pthread_cond_t changed;
    bool closing;
    double start;                   /* 0: no frame came yet */
    double start_t;                 /* the stamp that start goes with */
    lane lane[WATCH_CAMERAS];
};

static void swap(lane *l, int a, int b)
{
    lt_arena *kept = l->room[a];

    l->room[a] = l->room[b];
    l->room[b] = kept;
}

static struct timespec moment(double seconds)
{
    return (struct timespec){ .tv_sec = (time_t)seconds, .tv_nsec = (long)(1e9 * (seconds - (double)(time_t)seconds)) };
}

/* Of a film: wait until its time has come, by the clock of the first frame of all. Under the lock. */
static void keep_pace(lane *l, watch_picture *p)
{
    capture *c = l->all;

    if (l->camera->live) {
        p->came = lt_clock();
        return;
    }
    if (!(c->start > 0)) {
        c->start = lt_clock();
        c->start_t = p->t;
    }
    p->came = c->start + p->t - c->start_t;
    while (!c->closing && lt_clock() < p->came) {
        const struct timespec until = moment(p->came);

        pthread_cond_timedwait(&c->changed, &c->lock, &until);
    }
}

static void put(lane *l, const watch_picture *p)
{
    l->captured++;
    l->dropped += l->waits;
    l->waiting = *p;
    l->waits = true;
    swap(l, READING, WAITING);
    pthread_cond_broadcast(&l->all->changed);
}

static void *capture_thread(void *arg)
{
    lane *l = arg;
    capture *c = l->all;
    bool more = true;

    pthread_mutex_lock(&c->lock);
    while (more && !c->closing) {
        lt_arena *room = l->room[READING];
        watch_picture p;
        lt_status st;

        pthread_mutex_unlock(&c->lock);
        lt_arena_reset(room);
        st = watch_camera_next(l->camera, &c->o->rig.camera[l->number], room, &p, &more);
        if (st)
            watch_say(c->o, "camera %s: %s; the others go on", c->o->rig.camera[l->number].name, lt_last_error());
        more = more && !st;
        pthread_mutex_lock(&c->lock);
        if (more)
            keep_pace(l, &p);
        if (more && !c->closing)
            put(l, &p);
    }
    l->ended = true;
    pthread_cond_broadcast(&c->changed);
    pthread_mutex_unlock(&c->lock);
    return NULL;
}

static lt_status open_lane(capture *c, int number)
{
    lane *l = &c->lane[number];

    *l = (lane){ .all = c, .number = number, .camera = &c->camera[number] };
    for (int i = 0; i < ROOMS; i++)
        l->room[i] = lt_arena_new();
    if (!l->room[READING] || !l->room[WAITING] || !l->room[TAKEN])
        return lt_error(LT_ENOMEM, "no memory for a camera");
    l->started = pthread_create(&l->thread, NULL, capture_thread, l) == 0;
    return l->started ? LT_OK : lt_error(LT_ENOMEM, "no thread for a camera");
}

/* Waits go by the clock that never jumps. */
static void make_condition(pthread_cond_t *c)
{
    pthread_condattr_t how;

    pthread_condattr_init(&how);
    pthread_condattr_setclock(&how, CLOCK_MONOTONIC);
    pthread_cond_init(c, &how);
    pthread_condattr_destroy(&how);
}

lt_status capture_open(const watch_options *o, capture **out)
{
    capture *c = lt_alloc(sizeof(*c));
    lt_status st = LT_OK;

    *out = c;
    if (!c)
        return lt_error(LT_ENOMEM, "no memory for the cameras");
    c->o = o;
    memcpy(c->camera, o->camera, sizeof(c->camera));
    pthread_mutex_init(&c->lock, NULL);
    make_condition(&c->changed);
    for (int i = 0; i < o->rig.n && !st; i++)
        st = open_lane(c, i);
    return st;
}

void capture_close(capture *c)
{
    if (!c)
        return;
    pthread_mutex_lock(&c->lock);
    c->closing = true;
    pthread_cond_broadcast(&c->changed);
    pthread_mutex_unlock(&c->lock);
    for (int i = 0; i < c->o->rig.n; i++) {
        if (c->lane[i].started)
            pthread_join(c->lane[i].thread, NULL);
        for (int k = 0; k < ROOMS; k++)
            lt_arena_free(c->lane[i].room[k]);
    }
    pthread_cond_destroy(&c->changed);
    pthread_mutex_destroy(&c->lock);
    lt_release(c);
}

/* ---- for who takes them ---------------------------------------------------------------------------------- */

bool capture_wait(capture *c, int camera, double seconds, double *t)
{
    const struct timespec until = moment(lt_clock() + seconds);
    lane *l = &c->lane[camera];
    int late = 0;
    bool waits;

    pthread_mutex_lock(&c->lock);
    while (!l->waits && !l->ended && late != ETIMEDOUT)
        late = pthread_cond_timedwait(&c->changed, &c->lock, &until);
    waits = l->waits;
    *t = l->waiting.t;
    pthread_mutex_unlock(&c->lock);
    return waits;
}

bool capture_ended(capture *c, int camera)
{
    bool ended;

    pthread_mutex_lock(&c->lock);
    ended = c->lane[camera].ended && !c->lane[camera].waits;
    pthread_mutex_unlock(&c->lock);
    return ended;
}

bool capture_take(capture *c, int camera, double t, watch_picture *out)
{
    lane *l = &c->lane[camera];
    bool same;

    pthread_mutex_lock(&c->lock);
    same = l->waits && !(l->waiting.t > t);
    if (same) {
        *out = l->waiting;
        l->waits = false;
        swap(l, WAITING, TAKEN);
    }
    pthread_mutex_unlock(&c->lock);
    return same;
}

void capture_drop(capture *c, int camera)
{
    pthread_mutex_lock(&c->lock);
    c->lane[camera].dropped += c->lane[camera].waits;
    c->lane[camera].waits = false;
    pthread_mutex_unlock(&c->lock);
}

void capture_count(capture *c, int camera, int64_t *captured, int64_t *dropped)
{
    pthread_mutex_lock(&c->lock);
    *captured = c->lane[camera].captured;
    *dropped = c->lane[camera].dropped;
    pthread_mutex_unlock(&c->lock);
}
