/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What `palmar watch` does: sets of frames that up to four cameras took at the same time go through detection,
 * tracking, bodies, contact, hands and objects, filters and actions; each set leaves one record.
 *
 * Source: Bandi and Thomas 2025, "Action recognition via multi-view perception feature tracking for human-robot
 * interaction", figures 1 and 2; the stages are called S1 to S9 as there.
 */
#ifndef PIPELINE_WATCH_WATCH_H
#define PIPELINE_WATCH_WATCH_H

#include "estimate/body/estimator.h"
#include "estimate/detection/detector.h"
#include "estimate/embedder.h"
#include "estimate/trained.h"
#include "pipeline/watch/camera.h"
#include "vision/track/tracker.h"

#include <stdio.h>

typedef enum {
    WATCH_CPU,                      /* of several cameras one is searched in each set, of several bodies one estimated,
                                     * in turn */
    WATCH_FULL,                     /* every camera and every body in each set */
} watch_profile;

/* Each model may be NULL: what needs it is left out. */
typedef struct {
    detector *detector;
    embedder *embedder;             /* how things look; NULL: tracks go by overlap */
    const trained *estimator;       /* of a hand and what it holds */
    body_estimator *body;
    const trained *action;
} watch_models;

typedef struct {
    recording_rig rig;
    watch_camera camera[RECORDING_CAMERAS];     /* rig.n */
    const recording *replayed;      /* its sets are taken as they were chosen; NULL: sets are chosen here */
    watch_models models;
    watch_profile profile;
    bool fast;                      /* as fast as can be, and nothing is dropped but what goes with nothing */
    double seconds;                 /* of the cameras' time, then it ends; 0: not */
    const char *record;             /* a folder; NULL: nothing is recorded */
    const char *film;               /* an .mp4; NULL: none */
    bool window;                    /* show what is seen where there is a display; it ends when that is closed */
    FILE *lines;                    /* a record each; NULL: nowhere */
    FILE *messages;                 /* what is to be said; NULL: nobody is told */
    bool (*stop)(void);             /* asked between sets; NULL: never */
    void (*progress)(int64_t sets, double t);   /* NULL: nobody is told */
} watch_options;

typedef struct {
    int64_t captured, taken, dropped;           /* frames of all cameras: captured = taken + dropped */
    int64_t sets;
    double fps;                     /* sets in a second */
    double age_p50_ms, age_p95_ms;  /* NaN: no sets */
    double rss_first_mb, rss_last_mb;
    uint32_t crc32;                 /* of all records but for ages and times of stages */
} watch_summary;

/**
 * watch_run - until the cameras end, o->seconds are over, or o->stop says so
 *
 * A camera that fails is said, and the others go on. What is recorded and filmed is whole in any case. The same
 * pictures give the same records, with any number of threads, where sets are replayed or taken fast.
 *
 * Errors: LT_EINVAL: o->record has a recording in it; LT_EIO, LT_ENOSPC; LT_ENOMEM; LT_EFORMAT: a frame of a recording
 * cannot be read, and there are no others. Being stopped is none.
 */
lt_status watch_run(const watch_options *o, watch_summary *out);

#endif
