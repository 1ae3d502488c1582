/* SPDX-License-Identifier: Apache-2.0 */
/* Set after set through S1 to S9, and what is left of each: a line, a frame of a film, a recording. */
#include "pipeline/watch/internal.h"

#include "libtensor/base/clock.h"
#include "libtensor/base/order.h"
#include "libtensor/base/resident.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/film.h"
#include "libtensor/io/text/json.h"
#include "pipeline/window/window.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

enum { KEPT_AGES = 4096 };              /* of the last sets, for percentiles */

typedef struct {
    const watch_options *o;
    watch_world world;
    feed *feed;
    recording_writer *recorder;
    FILE *session;                      /* the records, beside what is recorded */
    lt_film_writer *film;
    window *window;
    bool closed;                        /* the window, by whoever looked */
    int64_t stored[WATCH_CAMERAS];      /* frames of each camera that were recorded */
    int64_t film_frames;
    double age[KEPT_AGES];
    double began, last_t;
    watch_summary sum;
} session;

void watch_say(const watch_options *o, const char *fmt, ...)
{
    char line[1024];
    va_list args;

    if (!o->messages)
        return;
    va_start(args, fmt);
    vsnprintf(line, sizeof(line), fmt, args);
    va_end(args);
    fprintf(o->messages, "palmar: %s\n", line);
}

/* ---- stages ---- */

static lt_status open_stages(watch_world *w)
{
    lt_status st = watch_eyes_open(w);

    st = st ? st : watch_hands_open(w);
    return st ? st : watch_actions_open(w);
}

static void close_stages(watch_world *w)
{
    watch_actions_close(w);
    pipeline_close(w->solve);
    pipeline_close(w->estimate);
    watch_eyes_close(w);
    lt_arena_free(w->arena);
}

void watch_spent(watch_world *w, int stage_number, double *begin)
{
    const double now = lt_clock();

    w->stage_ms[stage_number - 1] += 1000 * (now - *begin);
    *begin = now;
}

/* Numbered 0: those that count their own time, for more than one stage */
static lt_status run_stages(watch_world *w, const watch_set *set)
{
    static const struct { int number; lt_status (*run)(watch_world *w, const watch_set *set); } row[] = {
        { 0, watch_eyes_run }, { 3, watch_together_run }, { 4, watch_people_run }, { 5, watch_contact_run },
        { 0, watch_hands_run }, { 9, watch_actions_run }, { 9, watch_interactions_run },
    };
    lt_status st = LT_OK;

    memset(w->stage_ms, 0, sizeof(w->stage_ms));
    for (size_t i = 0; i < LT_COUNT(row) && !st; i++) {
        double begin = lt_clock();

        st = row[i].run(w, set);
        if (row[i].number)
            watch_spent(w, row[i].number, &begin);
    }
    return st;
}

/* ---- records ---- */

static char *text_of(const cJSON *line, size_t *n)
{
    char *text = NULL;
    FILE *f = open_memstream(&text, n);

    if (!f)
        return NULL;
    lt_json_print(f, line);
    fputc('\n', f);
    return fclose(f) == 0 ? text : NULL;
}

/* Ages and times are behind the count of what makes two replays equal. */
static void add_times(const session *s, const watch_set *set, cJSON *line)
{
    cJSON *stages;

    cJSON_AddNumberToObject(line, "age_ms", round(1e4 * (lt_clock() - set->picture[set->reference].came)) / 10);
    stages = cJSON_AddObjectToObject(line, "stages_ms");
    for (int i = 0; i < WATCH_STAGES; i++) {
        const char name[] = { 'S', (char)('1' + i), '\0' };

        cJSON_AddNumberToObject(stages, name, round(100 * s->world.stage_ms[i]) / 100);
    }
}

static lt_status put_text(FILE *to, const char *what, const char *text)
{
    if (!to)
        return LT_OK;
    fputs(text, to);
    return fflush(to) == 0 && !ferror(to) ? LT_OK : lt_error(lt_errno_status(errno), "%s: %s", what, strerror(errno));
}

static lt_status put_line(session *s, const cJSON *line)
{
    size_t n = 0;
    char *text = text_of(line, &n);
    lt_status st = text ? put_text(s->o->lines, "standard output", text)
        : lt_error(LT_ENOMEM, "no memory for a record");

    st = st ? st : put_text(s->session, s->o->record, text);
    free(text);
    return st;
}

static lt_status report(session *s, const watch_set *set)
{
    cJSON *line = watch_line_of(&s->world, set);
    size_t n = 0;
    char *text = line ? text_of(line, &n) : NULL;
    lt_status st;

    if (!text) {
        cJSON_Delete(line);
        return lt_error(LT_ENOMEM, "no memory for a record");
    }
    s->sum.crc32 = (uint32_t)crc32(s->sum.crc32, (const Bytef *)text, (uInt)n);
    free(text);
    s->age[s->sum.sets % KEPT_AGES] = 1000 * (lt_clock() - set->picture[set->reference].came);
    add_times(s, set, line);
    st = put_line(s, line);
    cJSON_Delete(line);
    return st;
}

/* ---- recordings and films ---- */

/* What is known of a drawn world goes along with what was seen of it. */
static lt_status copy_truth(const session *s)
{
    const recording *from = s->o->replayed;
    const char *path = from ? lt_path_join(s->world.arena, from->root, "truth.ndjson") : NULL;
    const char *to = lt_path_join(s->world.arena, s->o->record, "truth.ndjson");
    uint8_t *bytes;
    size_t n;
    lt_status st;

    if (!path || access(path, R_OK) != 0)
        return LT_OK;
    st = to ? lt_read_file(s->world.arena, path, LT_FILE_MAX, &bytes, &n) : lt_error(LT_ENOMEM, "%s: no memory", path);
    return st ? st : lt_write_file(to, bytes, n);
}

static lt_status open_recording(session *s)
{
    char path[4096];
    lt_status st;

    if (!s->o->record)
        return LT_OK;
    st = recording_create(s->o->record, &s->o->rig, &s->recorder);
    if (st || snprintf(path, sizeof(path), "%s/session.ndjson", s->o->record) >= (int)sizeof(path))
        return st ? st : lt_error(LT_EINVAL, "%s: too long a name", s->o->record);
    st = copy_truth(s);
    return st ? st : lt_append_own(path, &s->session);
}

static lt_status record_set(session *s, const watch_set *set)
{
    recording_set lines;
    lt_status st = LT_OK;

    for (int c = 0; c < WATCH_CAMERAS; c++)
        lines.frame[c] = -1;
    for (int c = 0; c < s->o->rig.n && !st; c++) {
        const watch_picture *p = &set->picture[c];

        if (!set->there[c])
            continue;
        st = recording_store(s->recorder, c, ++s->stored[c],
                             &(recording_pictures){ .colour = &p->rgb, .depth = p->depth });
        st = st ? st : recording_add(s->recorder, c, s->stored[c], p->t, p->depth != NULL, &lines.frame[c]);
    }
    return st ? st : recording_add_set(s->recorder, &lines);
}

/* A film has as many frames a second as the cameras; one that was long looked at stands as long. */
static lt_status film_set(session *s, const watch_set *set, const lt_image *sheet)
{
    const double fps = s->o->rig.fps;
    lt_status st = s->film ? LT_OK : lt_film_create(s->o->film, sheet->width, sheet->height, fps, &s->film);

    if (!st && s->film_frames == 0)
        s->film_frames = lrint(set->t * fps);
    do {
        st = st ? st : lt_film_put(s->film, sheet);
        s->film_frames++;
    } while (!st && (double)s->film_frames <= set->t * fps);
    return st;
}

static lt_status show(session *s, const watch_set *set)
{
    const bool first = s->sum.sets == 0;
    lt_image sheet;
    lt_status st;

    if (!s->o->film && !s->window && !(first && s->o->window))
        return LT_OK;
    st = watch_draw(&s->world, set, &sheet);
    if (!st && first && s->o->window)
        s->window = window_open("palmar watch", sheet.width, sheet.height);
    if (!st && s->window)
        s->closed = !window_show(s->window, &sheet);
    return st || !s->o->film ? st : film_set(s, set, &sheet);
}

static lt_status keep(session *s, const watch_set *set)
{
    lt_status st = s->recorder ? record_set(s, set) : LT_OK;

    st = st ? st : report(s, set);
    return st ? st : show(s, set);
}

/* ---- the loop ---- */

static lt_status open_session(session *s)
{
    lt_status st;

    s->world.o = s->o;
    s->world.arena = lt_arena_new();
    st = s->world.arena ? open_stages(&s->world) : lt_error(LT_ENOMEM, "no memory to watch with");
    st = st ? st : open_recording(s);
    return st ? st : feed_open(s->o, &s->feed);
}

static lt_status walk(session *s)
{
    const watch_options *o = s->o;
    watch_world *w = &s->world;
    watch_set set = { .number = 0 };
    lt_status st = LT_OK;
    bool more = true;

    s->began = lt_clock();
    while (!st && !s->closed) {
        st = feed_next(s->feed, &set, &more);
        if (st || !more || (o->seconds > 0 && set.t >= o->seconds))
            break;
        lt_arena_reset(w->arena);
        w->dt = set.number ? fmax(0, set.t - s->last_t) : 1 / o->rig.fps;
        s->last_t = set.t;
        st = run_stages(w, &set);
        st = st ? st : keep(s, &set);
        if (!st && ++s->sum.sets == 1)
            s->sum.rss_first_mb = 1e-6 * (double)lt_resident();
        if (!st && o->progress)
            o->progress(s->sum.sets, set.t);
    }
    return st;
}

static void sum_up(session *s)
{
    const int64_t n = lt_min_i64(s->sum.sets, KEPT_AGES);
    watch_summary *sum = &s->sum;

    feed_counts(s->feed, &sum->captured, &sum->taken);
    sum->dropped = sum->captured - sum->taken;
    sum->fps = sum->sets ? (double)sum->sets / fmax(1e-9, lt_clock() - s->began) : 0;
    sum->rss_last_mb = 1e-6 * (double)lt_resident();
    qsort(s->age, (size_t)n, sizeof(*s->age), lt_ascending);
    sum->age_p50_ms = n ? s->age[n / 2] : NAN;
    sum->age_p95_ms = n ? s->age[lt_min_i64(n - 1, n * 95 / 100)] : NAN;
}

static lt_status put_summary(session *s)
{
    const watch_summary *sum = &s->sum;
    cJSON *line = cJSON_CreateObject(), *age, *rss;
    char crc[16];
    lt_status st;

    snprintf(crc, sizeof(crc), "%08x", (unsigned)sum->crc32);
    cJSON_AddNumberToObject(line, "summary", 1);
    cJSON_AddNumberToObject(line, "captured", (double)sum->captured);
    cJSON_AddNumberToObject(line, "taken", (double)sum->taken);
    cJSON_AddNumberToObject(line, "dropped", (double)sum->dropped);
    cJSON_AddNumberToObject(line, "fps", round(100 * sum->fps) / 100);
    age = cJSON_AddObjectToObject(line, "age_ms");
    cJSON_AddNumberToObject(age, "p50", round(10 * sum->age_p50_ms) / 10);
    cJSON_AddNumberToObject(age, "p95", round(10 * sum->age_p95_ms) / 10);
    rss = cJSON_AddObjectToObject(line, "rss_mb");
    cJSON_AddNumberToObject(rss, "first", round(10 * sum->rss_first_mb) / 10);
    cJSON_AddNumberToObject(rss, "last", round(10 * sum->rss_last_mb) / 10);
    cJSON_AddStringToObject(line, "crc32", crc);
    st = put_line(s, line);
    cJSON_Delete(line);
    return st;
}

/* Whatever happened, what was recorded and filmed until then is whole. */
static lt_status close_session(session *s, lt_status st)
{
    lt_status closed;

    if (s->session && fclose(s->session) != 0 && !st)
        st = lt_error(lt_errno_status(errno), "%s: %s", s->o->record, strerror(errno));
    closed = recording_close(s->recorder);
    st = st ? st : closed;
    closed = s->film ? lt_film_finish(s->film) : LT_OK;
    st = st ? st : closed;
    window_close(s->window);
    feed_close(s->feed);
    close_stages(&s->world);
    return st;
}

lt_status watch_run(const watch_options *o, watch_summary *out)
{
    session *s = lt_alloc(sizeof(*s));
    lt_status st;

    if (!s)
        return lt_error(LT_ENOMEM, "no memory to watch with");
    s->o = o;
    st = open_session(s);
    st = st ? st : walk(s);
    if (s->feed)
        sum_up(s);
    if (!st)
        st = put_summary(s);
    st = close_session(s, st);
    *out = s->sum;
    lt_release(s);
    return st;
}
