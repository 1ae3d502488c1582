/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Who is at a table with a robot's side, and what everybody does there: persons who act one program after the other
 * (synth/actions), objects that they pick, place, hand over and receive, the robot's arm. A script is drawn once; what
 * is where at frame k is a function of the script and k.
 *
 * World: the room's axes, z up, metres, the table's top at z = 0; persons stand at +y and face -y, where the robot is.
 */
#ifndef SYNTH_WORKPLACE_SCRIPT_H
#define SYNTH_WORKPLACE_SCRIPT_H

#include "synth/actions/program.h"
#include "synth/body/appearance.h"
#include "synth/body/follow.h"
#include "synth/take/settle.h"
#include "synth/world/grip.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { WORKPLACE_PEOPLE = 3, WORKPLACE_OBJECTS = 4, WORKPLACE_CAST = 7, WORKPLACE_FPS = 30 };

#define WORKPLACE_FLOOR (-0.75)

/* What the truth calls what somebody does with an object (unified perception's interaction states) */
typedef enum {
    WORKPLACE_NONE, WORKPLACE_APPROACH, WORKPLACE_CONTACT, WORKPLACE_HOLD, WORKPLACE_HANDOVER, WORKPLACE_RECEIVE,
    WORKPLACE_PLACE,
} workplace_state;

/* One program, in the frames from first to before last; the next one begins some frames later, and joints move over. */
typedef struct {
    action_draw draw;
    int first, last, onset;
    int object;                     /* of the script's; -1: none */
    double lean;                    /* radians more than the program's, to reach the table */
} workplace_act;

/* A hand has an object from the frame `from` to before `to`. */
typedef struct {
    int object, from, to;
    bool picked, placed;            /* from the table, on it; else from and to the robot */
    double hand[9];                 /* the wrist's frame in the world, while nothing keeps it from that */
    double wrist[2][3];             /* where the wrist is when it picks and when it places */
    synth_settled begin, end;       /* where the object is then */
} workplace_hold;

typedef struct {
    synth_follower body;
    synth_appearance look;
    action_style style;
    double stand[2], facing;
    workplace_act *act;
    int n_acts;
    workplace_hold *hold;
    int n_holds;
    synth_grip grip;                /* of the hand that has objects: style.arm; prop NULL: he has none */
} workplace_person;

typedef struct {
    const synth_prop_pair *prop;
    synth_settled at;               /* before anybody touches it */
    synth_settled kept;             /* on the robot's side */
    double middle[3], radius;       /* of the model's box; of the upright cylinder around it */
} workplace_object;

typedef struct {
    /* set before */
    const synth_body *body;
    const lt_hand_model *hand;
    const synth_prop_pair *prop;    /* (YCB_COUNT) by number less one; those of workplace_cast are there */
    uint64_t seed;
    int frames;
    double difficulty;              /* how late reaching and receiving part, 0 to 1 */
    /* drawn */
    synth_hand_frames hand_frames;
    double table[4];                /* x0 y0 x1 y1 */
    double robot[4];                /* the robot's side is where robot[0..2] . x > robot[3] */
    double base[2];                 /* where its arm stands */
    workplace_person person[WORKPLACE_PEOPLE];
    int n_people;
    workplace_object object[WORKPLACE_OBJECTS];
    int n_objects;
} workplace_script;

/* workplace_cast - YCB numbers of objects among which a script chooses */
void workplace_cast(uint64_t seed, int number[WORKPLACE_CAST]);

/* workplace_script_new - draw it; lives in the arena. LT_ENOMEM. */
lt_status workplace_script_new(lt_arena *arena, workplace_script *s);

/* ---- a frame ---- */

/* Somebody at a frame. */
typedef struct {
    synth_body_pose body;
    double miss[2];                 /* metres that wrists are off where the programs or grasps have them */
    const workplace_act *act;       /* NULL: on the way from one to the next */
    const workplace_hold *hold;     /* NULL: his hands are empty */
    workplace_state state;
    int object, since;              /* that the state is about, -1: none; its first frame */
} workplace_moment;

/* workplace_person_at - of frame k */
void workplace_person_at(const workplace_script *s, int person, int k, workplace_moment *out);

/* workplace_object_at - where an object is, of where everybody is; *who: who has it, -1: nobody */
void workplace_object_at(const workplace_script *s, const workplace_moment *who, int object, int k, synth_settled *out,
                         int *owner);

#ifdef __cplusplus
}
#endif
#endif
