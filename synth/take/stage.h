/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Everything that one take needs to be filmed: who, what, where, the motion, the cameras.
 */
#ifndef SYNTH_TAKE_STAGE_H
#define SYNTH_TAKE_STAGE_H

#include "synth/room/room.h"
#include "synth/take/light.h"
#include "synth/take/prop.h"
#include "synth/take/sequence.h"
#include "synth/take/settle.h"
#include "synth/take/subject.h"
#include "synth/take/view.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SYNTH_MAX_CAMERAS = 8, SYNTH_STAGE_OTHERS = 4 };

/* What a dataset's layout asks of its takes. */
typedef struct {
    const synth_camera *camera;                 /* where the cameras are; NULL: chosen to see the take well */
    const synth_prop *other[SYNTH_STAGE_OTHERS];        /* stand on the table, if there is a place for them */
    int n_others;
    double depth_unit;                          /* metres in a step of its depth images */
    int shrink;                                 /* pictures are 640 x 480 over this; 0: as they are */
    bool apart;                                 /* hand and object share no space in the frames that are kept */
    const synth_light_spec *light;              /* instead of the room's lamps and the cameras' moods; NULL: these */
} synth_setting;

/* A subject handles a prop. */
typedef struct {
    const lt_hand_model *hand;
    const synth_subject *subject;
    const synth_prop *prop;
    const synth_grasp *grasp;                   /* n_grasps in the prop's frame, for this subject's hand: the object is
                                                 * taken with one after the other */
    int n_grasps;
    int n_frames;                               /* to keep, spread evenly over the motion */
    int n_cameras;                              /* several stand still; one alone is in somebody's hand, who walks on
                                                 * from grasp to grasp */
    int number;                                 /* of the take in its dataset */
    synth_setting setting;                      /* of its layout */
    uint64_t seed, stream;
} synth_stage_spec;

/* A take. Read-only once made: frames of it can be drawn on any number of threads. */
typedef struct {
    const lt_hand_model *hand;
    const synth_subject *subject;
    const synth_prop *prop;
    const synth_prop *other[SYNTH_STAGE_OTHERS];
    synth_settled at[SYNTH_STAGE_OTHERS];       /* of the others */
    int n_others;
    double depth_unit;
    const synth_room *room;
    synth_texture *cloth;                       /* of the subject's sleeve */
    synth_sequence sequence;
    const int *kept;                            /* n_kept moments that become frames */
    int n_kept;
    const synth_camera *camera;                 /* (n_cameras, n_views); a frame's: synth_stage_view */
    const synth_sensor *sensor;
    bool lit;                                   /* by light */
    synth_light_spec light;
    int n_cameras, n_views;                     /* views: where each camera stands, one after the other */
    uint64_t seed, stream;
} synth_stage;

/* synth_choose_grasps - the spec's n_grasps, a function of its seed and stream; the arena is for what they are drawn
 * with. Errors: LT_ENOMEM; LT_ENUMERIC where none lies on the prop. */
lt_status synth_choose_grasps(lt_arena *arena, const synth_stage_spec *spec, synth_grasp *out);

/* synth_stage_new - the take of a specification, of which alone it is a function; it lives in the arena, and subject,
 * prop and hand must outlive it. Errors: LT_ENOMEM; LT_ENUMERIC where too few moments are apart. */
lt_status synth_stage_new(lt_arena *arena, const synth_stage_spec *spec, synth_stage *out);

/* synth_stage_view - the index in camera and sensor of frame k of a camera */
int synth_stage_view(const synth_stage *s, int camera, int k);

/* synth_stage_pose - the hand at a moment, in the world */
void synth_stage_pose(const synth_stage *s, const synth_moment *m, synth_posed_hand *out);

/**
 * synth_stage_film - frame number k of a camera: all planes of out, rgb included
 *
 *   hand     synth_stage_pose at that moment
 *   depth    (height, width) as the depth camera measures it
 *
 * Errors: LT_ENOMEM.
 */
lt_status synth_stage_film(const synth_stage *s, int camera, int k, const synth_posed_hand *hand,
                           synth_frame *out, float *depth);

/**
 * synth_stage_light_parts - what global and local light do to the pixels of hand and object in one frame of a stage
 * that is lit
 *
 * The picture without noise is compared with that in synth_light_still: with the frame's global light alone, and with
 * its local light alone. part gets the sums of squared differences in 8-bit levels; frame is drawn into.
 * Errors: LT_ENOMEM.
 */
lt_status synth_stage_light_parts(const synth_stage *s, int camera, int k, const synth_posed_hand *hand,
                                  synth_frame *frame, double part[2]);

#ifdef __cplusplus
}
#endif
#endif
