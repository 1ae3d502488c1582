/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An event file is a list of records: length, its checksum, an Event message, its checksum.
 */
#include "libtensor/io/events.h"

#include "libtensor/io/file.h"
#include "libtensor/io/protobuf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { EVENT_TIME = 1, EVENT_STEP = 2, EVENT_VERSION = 3, EVENT_SUMMARY = 5, EVENT_SESSION = 7 };
enum { SUMMARY_VALUE = 1, VALUE_TAG = 1, VALUE_SIMPLE = 2 };
enum { SESSION_STATUS = 1, SESSION_START = 1 };

typedef struct {
    double time;
    int64_t step;
    const char *version;            /* of the first event of a file; NULL elsewhere */
    bool starts;                    /* what was written for this step and later ones is void */
    const lt_event_scalar *list;
    int n;
} event;

uint32_t lt_crc32c(const void *bytes, size_t n)
{
    const uint8_t *p = bytes;
    uint32_t crc = 0xffffffff;

    for (size_t i = 0; i < n; i++) {
        crc ^= p[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0x82f63b78 : 0);
    }
    return ~crc;
}

/* ---- messages -------------------------------------------------------------------------------------------------- */

static void put_value(pb_sink *s, const void *what)
{
    const lt_event_scalar *x = what;

    pb_put_text(s, VALUE_TAG, x->tag);
    pb_put_float(s, VALUE_SIMPLE, (float)x->value);
}

static void put_summary(pb_sink *s, const void *what)
{
    const event *e = what;

    for (int i = 0; i < e->n; i++)
        if (isfinite(e->list[i].value))
            pb_put_message(s, SUMMARY_VALUE, put_value, &e->list[i]);
}

static void put_session(pb_sink *s, const void *what)
{
    (void)what;
    pb_put_int(s, SESSION_STATUS, SESSION_START);
}

static void put_event(pb_sink *s, const event *e)
{
    pb_put_double(s, EVENT_TIME, e->time);
    pb_put_int(s, EVENT_STEP, e->step);
    if (e->version)
        pb_put_text(s, EVENT_VERSION, e->version);
    if (e->n)
        pb_put_message(s, EVENT_SUMMARY, put_summary, e);
    if (e->starts)
        pb_put_message(s, EVENT_SESSION, put_session, e);
}

/* ---- records ----------------------------------------------------------------------------------------------------- */

static void put_number(FILE *f, uint64_t x, int bytes)
{
    for (int i = 0; i < bytes; i++)
        putc((int)(x >> (8 * i) & 0xff), f);
}

/* A checksum of data that holds checksums would be weak, so they are turned and shifted. */
static void put_checksum(FILE *f, const void *bytes, size_t n)
{
    const uint32_t crc = lt_crc32c(bytes, n);

    put_number(f, (uint32_t)((crc >> 15 | crc << 17) + 0xa282ead8), 4);
}

static void write_event(FILE *f, event e)
{
    uint8_t length[8];
    struct timespec now;
    char *bytes = NULL;
    size_t n = 0;
    pb_sink s = { open_memstream(&bytes, &n), 0 };

    if (!s.f)
        return;
    clock_gettime(CLOCK_REALTIME, &now);
    e.time = (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
    put_event(&s, &e);
    fclose(s.f);
    for (int i = 0; i < 8; i++)
        length[i] = (uint8_t)((uint64_t)n >> (8 * i));
    fwrite(length, 1, sizeof(length), f);
    put_checksum(f, length, sizeof(length));
    fwrite(bytes, 1, n, f);
    put_checksum(f, bytes, n);
    fflush(f);
    free(bytes);
}

lt_status lt_events_open(lt_arena *arena, const char *folder, int64_t step, FILE **out)
{
    const char *name = lt_arena_printf(arena, "events.out.tfevents.%010lld.palmar", (long long)time(NULL));
    const char *path = name ? lt_path_join(arena, folder, name) : NULL;
    FILE *f;
    lt_status st;

    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", folder);
    st = lt_append_own(path, &f);
    if (st)
        return st;
    if (fseek(f, 0, SEEK_END) == 0 && ftell(f) == 0)
        write_event(f, (event){ .version = "brain.Event:2" });
    write_event(f, (event){ .step = step + 1, .starts = true });
    *out = f;
    return LT_OK;
}

void lt_events_scalars(FILE *f, int64_t step, const lt_event_scalar *list, int n)
{
    write_event(f, (event){ .step = step, .list = list, .n = n });
}
