/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: what a session's page is made of.
 */
#ifndef EVAL_REPORT_SESSION_INTERNAL_H
#define EVAL_REPORT_SESSION_INTERNAL_H

#include "data/recording/line.h"
#include "eval/report/internal.h"

/* ---- history.c: what was when ---------------------------------------------------------------------------------- */

typedef enum {
    LANE_ACTION, LANE_TRUE_ACTION, LANE_INTERACTION, LANE_TRUE_INTERACTION, LANE_CONTACT, LANE_HAND, LANE_OBJECT,
    LANE_TRACK,
} lane_kind;

typedef struct {
    double from, to;                /* seconds since the first set */
    const char *label;
    bool pale;                      /* predicted, not seen */
} lane_span;

/* When something was so: of a person, a hand, an object, a track */
typedef struct {
    lane_kind kind;
    int64_t id;                     /* of a contact, the person whose hand it is, 0: nobody's that is known */
    const char *cls;                /* of a track or an object; "left", "right" of a hand or a contact; else "" */
    int64_t beside;                 /* of a true lane: the person of the session that it is of; 0: nobody */
    lane_span *span;
    int n;
    size_t room;
} lane;

enum { SESSION_MOST_LANES = 2000 };

/* Where somebody was: the pelvis, in the world */
typedef struct {
    double time, x[3];
    int64_t id;
} whereabouts;

typedef struct {
    whereabouts *at;
    size_t n, room;
} trail;

typedef struct {
    lt_arena *arena;
    recording r;
    const char *text;               /* of session.ndjson */
    size_t bytes;
    int64_t n;                      /* sets */
    const char **line;              /* (n) where each begins in text, */
    size_t *length;                 /* and how long it is */
    int64_t *number;                /* of the line in the file */
    double *time;                   /* (n) seconds since the first set, never less than before */
    lane *lane;
    int n_lanes;
    bool has_truth, lanes_left_out;
    trail seen, truth;              /* in the order of time */
    double origin;                  /* the first set's stamp */
    double clock[RECORDING_CAMERAS];            /* of each camera at the first set; NaN: it had no frame yet */
    report_series age, pair, drops[RECORDING_CAMERAS], stage[SESSION_STAGES];       /* ms, frames since the beginning */
    session_sum sum;
    bool has_sum;
} history;

/* history_read - of a folder. Errors: those of session_report_write */
lt_status history_read(lt_arena *arena, const char *root, history *out);

/* history_line - set k once more. LT_ENOMEM */
lt_status history_line(const history *h, lt_arena *arena, int64_t k, session_line *out);

/* ---- agreement.c: beside the truth ----------------------------------------------------------------------------- */

enum { AGREEMENT_WORDS = 16 };

typedef struct {
    int all, right;                 /* sets of persons whom the truth knows and a session's person stands beside */
    int settled, settled_right;     /* those more than five frames of 30 a second from a change of the truth */
    struct { const char *word; int all, right; } word[AGREEMENT_WORDS];        /* of each true word */
    int n_words;
    double *delay;                  /* (n_delays) seconds from a true onset to where its word is said */
    int n_delays, missed;           /* missed: onsets whose word is never said */
    size_t room;
    double median_delay;            /* NaN: there is none */
} agreement;

/* agreement_of - of LANE_TRUE_ACTION or LANE_TRUE_INTERACTION, in the history's arena. LT_ENOMEM */
lt_status agreement_of(const history *h, lane_kind truth, agreement *out);

/* agreement_put - as tables; nothing where there is no truth. LT_ENOMEM */
lt_status agreement_put(FILE *f, const history *h);

/* ---- timeline.c, pictures.c: parts of the page ------------------------------------------------------------------ */

/* timeline_put - lanes as bars over time */
void timeline_put(FILE *f, const history *h);

/* pictures_put - sets of frames with what was found in them; the script that shows one at a time has this nonce */
lt_status pictures_put(FILE *f, const history *h, const char *nonce);

#endif
