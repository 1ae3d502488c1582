/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A ring of batches. Workers take one slot at a time, in order; the caller takes whole batches, in
 * order. Everything that decides what goes where happens under one lock; only fill runs outside it.
 */
#include "data/loader.h"

#include "libtensor/base/rng.h"

#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

enum { STREAM = 0x4f524452 };           /* tells the orders apart from other uses of the seed */

/* A batch on its way. */
typedef struct {
    void *batch;
    loader_position at;                 /* where it starts */
    int64_t end;                        /* and where the next one does */
    int count, issued, done;            /* slots: in all, handed to workers, finished */
    int64_t *index;                     /* sample of each slot */
    lt_status *status;                  /* what became of it */
    char **line;                        /* and why; NULL where all is well */
} entry;

struct loader {
    loader_source source;
    loader_options opt;
    int capacity;                       /* slots in a batch of this rank */

    pthread_mutex_t lock;
    pthread_cond_t work, ready;         /* for workers; for the caller */
    pthread_t *thread;
    int n_threads;
    bool stopping;

    entry *ring;
    int n_ring;
    int64_t opened, delivered;          /* batches given to workers, to the caller, since the start */
    loader_position open_at;            /* where the next batch to open starts */
    uint32_t *order;                    /* of epoch order_epoch */
    uint64_t order_epoch;
    bool has_order;

    /* the caller's alone */
    loader_position where;
    int64_t epoch_skipped;
    char **skipped;
    int64_t *skipped_index;
    int n_skipped;
};

/* ---- what comes next ---- */

static int64_t order_at(loader *l, uint64_t epoch, int64_t i)
{
    if (!l->opt.shuffle)
        return i;
    if (!l->has_order || l->order_epoch != epoch) {
        lt_rng rng = lt_rng_make(l->opt.seed, lt_rng_mix(STREAM, epoch));
        lt_rng_permute(&rng, l->order, (uint32_t)l->source.count);
        l->order_epoch = epoch;
        l->has_order = true;
    }
    return l->order[i];
}

/* Turn the ring's next place into the batch at open_at. */
static void open_batch(loader *l)
{
    entry *e = &l->ring[l->opened % l->n_ring];
    int64_t first, end;

    if (l->open_at.next >= l->source.count)
        l->open_at = (loader_position){ .epoch = l->open_at.epoch + 1 };
    e->at = l->open_at;
    e->end = lt_min_i64(e->at.next + l->opt.batch, l->source.count);
    first = e->at.next + l->opt.first_slot;
    end = lt_min_i64(e->end, first + l->capacity);
    e->count = (int)lt_max_i64(0, end - first);
    e->issued = e->done = 0;
    for (int i = 0; i < e->count; i++)
        e->index[i] = order_at(l, e->at.epoch, first + i);
    l->source.start(e->batch, e->count);
    l->open_at.next = e->end;
    l->opened++;
}

/* The batch that still has slots to hand out; NULL when the ring is full of batches ahead. */
static entry *batch_with_work(loader *l)
{
    for (;;) {
        entry *e = l->opened ? &l->ring[(l->opened - 1) % l->n_ring] : NULL;
        if (e && e->issued < e->count)
            return e;
        /* the last delivered batch is still the caller's: it leaves n_ring - 1 places */
        if (l->opened - l->delivered >= l->n_ring - 1)
            return NULL;
        open_batch(l);
        pthread_cond_signal(&l->ready);         /* it may have no slots at all */
    }
}

/* ---- workers ---- */

static void finish_slot(entry *e, int slot, lt_status st)
{
    e->status[slot] = st;
    free(e->line[slot]);
    e->line[slot] = st ? strdup(lt_last_error()) : NULL;
    e->done++;
}

/* On a worker's thread, without the lock: one sample into its slot. */
static lt_status fill(const loader *l, const entry *e, int slot, lt_arena *scratch)
{
    lt_status st;

    if (!scratch)
        return lt_error(LT_ENOMEM, "loader: no memory");
    st = l->source.fill(l->source.ctx, e->at.epoch, e->index[slot], scratch, e->batch, slot);
    lt_arena_reset(scratch);
    return st;
}

static void *work(void *arg)
{
    loader *l = arg;
    lt_arena *scratch = lt_arena_new();

    pthread_mutex_lock(&l->lock);
    while (!l->stopping) {
        entry *e = batch_with_work(l);
        lt_status st;
        int slot;

        if (!e) {
            pthread_cond_wait(&l->work, &l->lock);
            continue;
        }
        slot = e->issued++;
        pthread_mutex_unlock(&l->lock);
        st = fill(l, e, slot, scratch);
        pthread_mutex_lock(&l->lock);
        finish_slot(e, slot, st);
        if (e->done == e->count)
            pthread_cond_signal(&l->ready);
    }
    pthread_mutex_unlock(&l->lock);
    lt_arena_free(scratch);
    return NULL;
}

/* Signals are for the main thread: these block all of them. */
static lt_status start_threads(loader *l)
{
    sigset_t all, before;

    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    while (l->n_threads < l->opt.threads && !pthread_create(&l->thread[l->n_threads], NULL, work, l))
        l->n_threads++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (l->n_threads < 1)
        return lt_error(LT_ENOMEM, "loader: the system gives no thread");
    return LT_OK;
}

/* ---- life ---- */

static void free_ring(loader *l)
{
    for (int i = 0; l->ring && i < l->n_ring; i++) {
        entry *e = &l->ring[i];
        for (int k = 0; e->line && k < l->capacity; k++)
            free(e->line[k]);
        if (e->batch)
            l->source.batch_free(e->batch);
        free(e->index);
        free(e->status);
        free(e->line);
    }
    free(l->ring);
}

void loader_free(loader *l)
{
    if (!l)
        return;
    pthread_mutex_lock(&l->lock);
    l->stopping = true;
    pthread_cond_broadcast(&l->work);
    pthread_mutex_unlock(&l->lock);
    for (int i = 0; i < l->n_threads; i++)
        pthread_join(l->thread[i], NULL);
    free_ring(l);
    for (int i = 0; i < l->n_skipped; i++)
        free(l->skipped[i]);
    free(l->skipped);
    free(l->skipped_index);
    free(l->order);
    free(l->thread);
    pthread_cond_destroy(&l->work);
    pthread_cond_destroy(&l->ready);
    pthread_mutex_destroy(&l->lock);
    free(l);
}

static bool allocate_ring(loader *l)
{
    const size_t n = (size_t)l->capacity;

    l->ring = calloc((size_t)l->n_ring, sizeof(*l->ring));
    for (int i = 0; l->ring && i < l->n_ring; i++) {
        entry *e = &l->ring[i];
        e->index = calloc(n, sizeof(*e->index));
        e->status = calloc(n, sizeof(*e->status));
        e->line = calloc(n, sizeof(*e->line));
        e->batch = l->source.batch_new(l->source.ctx, l->capacity);
        if (!e->index || !e->status || !e->line || !e->batch)
            return false;
    }
    return l->ring;
}

static lt_status check(const loader_source *s, const loader_options *o, loader_position p)
{
    if (s->count < 1 || s->count > UINT32_MAX)
        return lt_error(LT_EINVAL, "loader: the dataset has %lld samples", (long long)s->count);
    if (o->batch < 1 || o->threads < 1 || o->ahead < 1)
        return lt_error(LT_EINVAL, "loader: batch %d, threads %d, ahead %d: each must be at least 1",
                        o->batch, o->threads, o->ahead);
    if (o->first_slot < 0 || o->n_slots < 0 || o->first_slot + o->n_slots > o->batch)
        return lt_error(LT_EINVAL, "loader: slots %d to %d are not within a batch of %d",
                        o->first_slot, o->first_slot + o->n_slots, o->batch);
    if (p.next < 0 || p.next > s->count)
        return lt_error(LT_EINVAL, "loader: position %lld is not within %lld samples: was it saved "
                        "with another dataset?", (long long)p.next, (long long)s->count);
    return LT_OK;
}

lt_status loader_new(const loader_source *source, const loader_options *options,
                     loader_position start, loader **out)
{
    lt_status st = check(source, options, start);
    loader *l;

    if (st)
        return st;
    l = calloc(1, sizeof(*l));
    if (!l)
        return lt_error(LT_ENOMEM, "loader: no memory");
    l->source = *source;
    l->opt = *options;
    l->capacity = options->n_slots ? options->n_slots : options->batch;
    l->n_ring = options->ahead + 1;
    l->open_at = l->where = start;
    pthread_mutex_init(&l->lock, NULL);
    pthread_cond_init(&l->work, NULL);
    pthread_cond_init(&l->ready, NULL);
    l->thread = calloc((size_t)options->threads, sizeof(*l->thread));
    l->order = calloc((size_t)source->count, sizeof(*l->order));
    if (!l->thread || !l->order || !allocate_ring(l))
        st = lt_error(LT_ENOMEM, "loader: no memory for %d batches of %d samples", l->n_ring, l->capacity);
    else
        st = start_threads(l);
    if (st)
        loader_free(l);
    else
        *out = l;
    return st;
}

/* ---- the caller's side ---- */

/* Keep the line of an unreadable sample, once. */
static lt_status remember(loader *l, int64_t index, const char *line)
{
    char **lines;
    int64_t *where;

    for (int i = 0; i < l->n_skipped; i++)
        if (l->skipped_index[i] == index)
            return LT_OK;
    lines = realloc(l->skipped, (size_t)(l->n_skipped + 1) * sizeof(*lines));
    if (lines)
        l->skipped = lines;
    where = realloc(l->skipped_index, (size_t)(l->n_skipped + 1) * sizeof(*where));
    if (where)
        l->skipped_index = where;
    if (!lines || !where || !(lines[l->n_skipped] = strdup(line)))
        return lt_error(LT_ENOMEM, "loader: no memory");
    where[l->n_skipped++] = index;
    return LT_OK;
}

/* What to do about the slots of e that could not be filled. */
static lt_status judge(loader *l, entry *e)
{
    const double allowed = l->opt.tolerate * (double)l->source.count;

    for (int i = 0; i < e->count; i++) {
        const char *line = e->line[i] ? e->line[i] : "no memory";
        lt_status st;
        if (!e->status[i])
            continue;
        if (l->opt.tolerate <= 0 || e->status[i] == LT_ENOMEM)         /* the machine's fault, not the sample's */
            return lt_error(e->status[i], "%s", line);
        l->source.skip(e->batch, i, e->index[i]);
        st = remember(l, e->index[i], line);
        if (st)
            return st;
        if ((double)++l->epoch_skipped > allowed)
            return lt_error(e->status[i], "more than %g %% of the samples cannot be read (%lld so far); "
                            "the first: %s", 100 * l->opt.tolerate, (long long)l->epoch_skipped,
                            l->skipped[0]);
    }
    return LT_OK;
}

/* Wait for the batch after the last delivered one. */
static entry *wait_ready(loader *l)
{
    entry *e;

    pthread_mutex_lock(&l->lock);
    for (;;) {
        e = &l->ring[l->delivered % l->n_ring];
        if (l->opened > l->delivered && e->done == e->count)
            break;
        pthread_cond_wait(&l->ready, &l->lock);
    }
    pthread_mutex_unlock(&l->lock);
    return e;
}

/* The caller is done with the batch before e: its place is free. */
static void take(loader *l)
{
    pthread_mutex_lock(&l->lock);
    l->delivered++;
    pthread_cond_broadcast(&l->work);
    pthread_mutex_unlock(&l->lock);
}

lt_status loader_next(loader *l, void **batch)
{
    lt_status st;
    entry *e;

    *batch = NULL;
    if (l->where.next >= l->source.count) {
        l->where = (loader_position){ .epoch = l->where.epoch + 1 };
        l->epoch_skipped = 0;
        return LT_OK;
    }
    e = wait_ready(l);
    st = judge(l, e);
    if (st)
        return st;
    take(l);
    l->where = (loader_position){ .epoch = e->at.epoch, .next = e->end };
    *batch = e->batch;
    return LT_OK;
}

loader_position loader_where(const loader *l)
{
    return l->where;
}

int loader_skipped(const loader *l)
{
    return l->n_skipped;
}

const char *loader_skipped_line(const loader *l, int i)
{
    return l->skipped[i];
}
