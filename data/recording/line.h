/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What was said of a set of frames: a line of palmar.set/1 (docs/formats.md), or of the truth of a drawn world.
 */
#ifndef DATA_RECORDING_LINE_H
#define DATA_RECORDING_LINE_H

#include "data/action/action.h"
#include "data/recording/recording.h"
#include "libtensor/geometry/hand/model.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SESSION_STAGES = 9 };

typedef struct {
    int64_t id;
    const char *cls;
    int camera;
    float box[4];
} session_track;

typedef struct {
    int64_t id, person;             /* person 0: nobody's that is known */
    int camera;                     /* that saw it; -1: not told */
    bool left, coasts;
    double joint[LT_HAND_KEYPOINTS][3];         /* world; NaN: not known */
} session_hand;

typedef struct {
    int64_t id;
    const char *cls;
    bool coasts;
    double R[9], t[3];
} session_object;

typedef struct {
    int64_t id;
    int camera;                     /* that saw it; -1: not told */
    double joint[ACTION_BODY][3];
} session_person;

typedef struct { int64_t hand, object; } session_contact;

/* An action, or a state of interaction */
typedef struct {
    int64_t person, object;         /* object 0: none */
    const char *what;
    double p;                       /* NaN: not told */
} session_doing;

typedef struct {
    double captured, taken, dropped, fps, age_p50, age_p95, rss_first, rss_last;        /* NaN: not told */
    const char *crc;                /* "": not told */
} session_sum;

/* What is not in the line is NaN, or a list of none. */
typedef struct {
    bool is_sum;                    /* the last one, which has nothing but sum */
    session_sum sum;
    double t[RECORDING_CAMERAS], dropped[RECORDING_CAMERAS];
    double pair_ms, age_ms, stage_ms[SESSION_STAGES];
    session_track *track;
    session_hand *hand;
    session_object *object;
    session_person *person;
    session_contact *contact;
    session_doing *action, *interaction;
    int n_tracks, n_hands, n_objects, n_people, n_contacts, n_actions, n_interactions;
} session_line;

/**
 * session_line_parse - n bytes of text, into the arena
 *
 *   name, number   for the error line: "session.ndjson:12: ..."
 *   truth          of truth.ndjson: its time, which may be one number, its people and what they do, and nothing else
 *
 * Errors: LT_EFORMAT: no JSON, another schema, a key with something else in it than belongs there; LT_ENOMEM.
 */
lt_status session_line_parse(lt_arena *arena, const char *name, int64_t number, const char *text, size_t n, bool truth,
                             session_line *out);

#ifdef __cplusplus
}
#endif
#endif
