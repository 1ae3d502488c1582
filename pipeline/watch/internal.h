/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of this folder share: a set of frames, and what is known of the world. */
#ifndef PIPELINE_WATCH_INTERNAL_H
#define PIPELINE_WATCH_INTERNAL_H

#include "data/action/action.h"
#include "libtensor/geometry/kalman/kalman.h"
#include "pipeline/internal.h"
#include "pipeline/stage.h"
#include "pipeline/watch/interaction.h"
#include "pipeline/watch/watch.h"

enum { WATCH_CAMERAS = RECORDING_CAMERAS, WATCH_STAGES = 9, WATCH_PEOPLE = 3, WATCH_THINGS = 64, WATCH_CONTACTS = 32 };

/* watch_say - one line to o->messages */
void watch_say(const watch_options *o, const char *fmt, ...) LT_PRINTF(2, 3);

/* ---- pairing.c: which frames were taken at the same time --------------------------------------------------- */

enum { PAIRING_REMEMBERED = 31 };

/* How far each camera's clock is ahead of the reference's: the median of what frames that came together differed */
typedef struct {
    int n, reference;
    double period;                  /* seconds from frame to frame */
    double seen[WATCH_CAMERAS][PAIRING_REMEMBERED];
    int64_t n_seen[WATCH_CAMERAS];
} pairing;

/* pairing_offset - of a camera's clock, seconds; 0 as long as it is within half a period */
double pairing_offset(const pairing *p, int camera);

/* pairing_note - frames of a camera and of the reference that came at the same time are stamped so */
void pairing_note(pairing *p, int camera, double t, double reference_t);

/* pairing_apart - by how much a frame is later than the reference's, seconds; of a pair it is half a period at most */
double pairing_apart(const pairing *p, int camera, double t, double reference_t);
bool pairing_fits(const pairing *p, double apart);

/* ---- feed.c: sets of frames, by whatever way they come ------------------------------------------------------ */

typedef struct {
    int64_t number;
    int reference;                  /* camera by whose frame it was chosen */
    bool there[WATCH_CAMERAS];
    watch_picture picture[WATCH_CAMERAS];
    double t;                       /* seconds since the first set, by the reference's clock */
    double pair_ms;                 /* how far apart the farthest two are */
    int64_t dropped[WATCH_CAMERAS]; /* frames since the last set that went with none */
} watch_set;

typedef struct feed feed;

/* feed_open - o outlives it; feed_close ends what it began. LT_ENOMEM */
lt_status feed_open(const watch_options *o, feed **out);
void feed_close(feed *f);

/* feed_next - the next set; valid until the next call, before the first of which *out is zeroed. *more false: all
 * cameras have ended, or it was stopped */
lt_status feed_next(feed *f, watch_set *out, bool *more);

/* feed_counts - frames that came so far, and those of them that were in a set; the others were dropped */
void feed_counts(const feed *f, int64_t *captured, int64_t *taken);

/* ---- capture.c: a thread for each camera, and the newest frame of each --------------------------------------- */

typedef struct capture capture;

/* capture_open - begins; capture_close - ends and waits. LT_ENOMEM */
lt_status capture_open(const watch_options *o, capture **out);
void capture_close(capture *c);

/* capture_wait - until a camera has a new frame, at most so many seconds; false: it has none. *t: its stamp */
bool capture_wait(capture *c, int camera, double seconds, double *t);

/* capture_ended - whether a camera gives no more */
bool capture_ended(capture *c, int camera);

/* capture_take - the frame that waits, if it is still the one of stamp t; valid until the next take of that camera.
 * capture_drop - throw it away */
bool capture_take(capture *c, int camera, double t, watch_picture *out);
void capture_drop(capture *c, int camera);

/* capture_count - frames of a camera that came, and that were dropped, so far */
void capture_count(capture *c, int camera, int64_t *captured, int64_t *dropped);

/* ---- what is known of the world ------------------------------------------------------------------------------ */

/* Something that one camera sees, as of when it was searched last */
typedef struct {
    predict_detection seen;         /* of the camera's arena; seen.track is the camera's own number */
    int64_t id;                     /* the same in all cameras; 0: not tracked yet */
    bool placed;
    double centre[3];               /* world: the median of what is measured of it */
} watch_sight;

typedef struct {
    lt_arena *arena;                /* of what it sees, until it is searched again */
    lt_arena *scratch;              /* of the frame that is searched, until the next */
    predict_options options;
    pipeline *detect, *track;       /* NULL without a detector */
    predict_followed film;          /* the times that its tracker goes by */
    watch_sight *sight;
    int n;
    bool fresh;                     /* searched in this set */
    float *metres;                  /* (height, width) of this set's picture, in the set's arena; NULL: none */
} watch_eye;

/* A thing among all cameras: an object, a hand or a person */
typedef struct {
    int64_t id;
    predict_kind kind;
    int cls;
    const char *name;
    int64_t track[WATCH_CAMERAS];   /* each camera's number of it; 0: none */
    bool placed;
    lt_point_filter centre;         /* world */
    double seen;                    /* when it was seen last, t of a set */
    double support;                 /* of an object: the least height at which it was at rest; NaN: not known */
    lt_pose_filter pose;            /* of an object, in the axes of its model, which is there where the pose is */
    const predict_object *model;
    int64_t person;                 /* of a hand: whose it is; 0: not known */
    predict_side side;
    lt_point_filter joint[LT_HAND_KEYPOINTS];   /* of a hand: world */
    lt_filter_state state;          /* of the joints */
    int coasted;                    /* frames */
    int camera;                     /* that the pose was estimated from */
    double score;
} watch_thing;

typedef struct {
    int64_t hand, object;           /* things */
    int camera;                     /* in which the overlap is largest */
    double overlap;                 /* IoU there, in this set */
    int positive, negative;         /* sets in a row */
    bool touching;                  /* in this set */
    double looked;                  /* when a camera saw both last */
    bool on;
    double since;
} watch_contact;

typedef struct watch_actions watch_actions;

typedef struct {
    int cls;                        /* -1: not known yet */
    double p;                       /* its probability; */
    double onset;                   /* since when */
} watch_action;

typedef struct {
    int64_t id;
    int camera;
    lt_filter_state state;          /* in this set; on: the body was estimated; coast: seen, but not his turn; off */
    double t;                       /* when it was seen last */
    double looked;                  /* when the body was estimated last */
    double joint[ACTION_BODY][3];   /* world, as it was then */
    float box[4];
    watch_actions *actions;
    watch_action action;
    interaction interaction;
} watch_person;

typedef struct {
    const watch_options *o;
    lt_arena *arena;                /* of a set */
    watch_eye eye[WATCH_CAMERAS];
    watch_thing thing[WATCH_THINGS];
    int n_things;
    int64_t last_id;
    watch_contact contact[WATCH_CONTACTS];
    int n_contacts;
    watch_person person[WATCH_PEOPLE];
    int n_people;
    pipeline *estimate, *solve;     /* of hands; NULL without an estimator */
    predict_options hand_options;
    compiled act;                   /* the network for actions; plan NULL: none */
    double dt;                      /* seconds since the last set */
    double stage_ms[WATCH_STAGES];
} watch_world;

/* watch_spent - time since *begin goes to stage number 1 to 9; *begin is now */
void watch_spent(watch_world *w, int stage_number, double *begin);

/* watch_thing_of - by its id; NULL: there is none */
watch_thing *watch_thing_of(watch_world *w, int64_t id);

/* watch_to_world, watch_to_camera - a point; of a camera without a place the world is its own axes */
void watch_to_world(const recording_camera *c, const double p[3], double out[3]);
void watch_to_camera(const recording_camera *c, const double p[3], double out[3]);

/* watch_shows - whether a pixel is of what is seen: of its mask, or without one of the middle of its box */
bool watch_shows(const predict_detection *d, int x, int y);

/* Each stage takes the set one step further. LT_ENOMEM. */
lt_status watch_eyes_open(watch_world *w);                                /* S1, S2 */
lt_status watch_eyes_run(watch_world *w, const watch_set *set);
void watch_eyes_close(watch_world *w);
lt_status watch_together_run(watch_world *w, const watch_set *set);       /* S3 */
lt_status watch_people_run(watch_world *w, const watch_set *set);         /* S4 */
lt_status watch_contact_run(watch_world *w, const watch_set *set);        /* S5 */
lt_status watch_hands_open(watch_world *w);                               /* S6, S7, S8 */
lt_status watch_hands_run(watch_world *w, const watch_set *set);
lt_status watch_actions_open(watch_world *w);                             /* S9 */
lt_status watch_actions_run(watch_world *w, const watch_set *set);
lt_status watch_interactions_run(watch_world *w, const watch_set *set);
void watch_actions_close(watch_world *w);

/* ---- contact.c ----------------------------------------------------------------------------------------------- */

/* watch_contact_step - one more set in which a hand and an object touch, or do not; k->on is what holds then */
void watch_contact_step(watch_contact *k, bool touching, double t);

/* ---- actions.c: what a person does ------------------------------------------------------------------------- */

lt_status watch_actions_new(watch_actions **out);
void watch_actions_free(watch_actions *a);

/* ---- line.c: the record of a set; show.c: the picture of it --------------------------------------------------- */

struct cJSON;

/* watch_line_of - the record but for ages and times of stages, which are the machine's, not the world's. NULL: no
 * memory is left */
struct cJSON *watch_line_of(const watch_world *w, const watch_set *set);

/* watch_draw - a set's pictures beside each other with what is known drawn in, in the world's arena. LT_ENOMEM */
lt_status watch_draw(const watch_world *w, const watch_set *set, lt_image *out);

#endif
