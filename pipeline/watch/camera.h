/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Something that gives one picture after the other: a camera, a film, a folder of images, one camera of a recording.
 */
#ifndef PIPELINE_WATCH_CAMERA_H
#define PIPELINE_WATCH_CAMERA_H

#include "data/recording/recording.h"

/* What a camera saw at a moment. Memory is the arena's that it was asked with. */
typedef struct {
    double t;                       /* seconds, by the camera's own clock */
    lt_image rgb;
    const uint16_t *depth;          /* (height, width) steps of the camera's depth_scale, or NULL */
    double came;                    /* when it was there: seconds of this machine's clock */
    int64_t line;                   /* of a recording's frames.jsonl; -1: of none */
} watch_picture;

typedef struct {
    /* The next picture; waits until there is one. *more false: it has ended. An error is an end too: a camera that was
     * unplugged, a film that breaks off. */
    lt_status (*next)(void *state, lt_arena *arena, watch_picture *out, bool *more);
    void (*close)(void *state);
} watch_camera_kind;

typedef struct {
    const watch_camera_kind *kind;
    void *state;
    const char *source;             /* what it was opened by, for messages */
    bool live;                      /* pictures come when they come; else as their times say, or as fast as can be */
    bool has_first;                 /* a picture was taken already, to know how large they are */
    watch_picture first;
} watch_camera;

/**
 * watch_cameras_open - the cameras that sources name
 *
 *   sources   n of them, up to four: films, folders of images, or numbers of cameras ("0") or their
 *             devices ("/dev/video0")
 *   rig       of the sources in their order, as --calibration has it; n 0: nothing is known, and it is set from first
 *             pictures
 *   out       (RECORDING_CAMERAS) as many as rig->n says; watch_camera_close ends each
 *
 * Errors: a source that is none of these, a recording (recording_open), more than four; LT_EIO, LT_EFORMAT, LT_ENOMEM.
 */
lt_status watch_cameras_open(lt_arena *arena, const char *const *sources, int n, recording_rig *rig, watch_camera *out);
void watch_camera_close(watch_camera *c);

/* watch_camera_next - the kind's next. Errors: LT_EFORMAT: it is not of the size that camera has */
lt_status watch_camera_next(watch_camera *c, const recording_camera *camera, lt_arena *arena, watch_picture *out,
                            bool *more);

/* watch_recording_camera - number `camera` of a recording, which outlives it */
lt_status watch_recording_camera(lt_arena *arena, const recording *r, int camera, watch_camera *out);

#endif
