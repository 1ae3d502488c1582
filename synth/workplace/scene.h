/* SPDX-License-Identifier: Apache-2.0 */
/* A frame of a script as a scene to draw, and the cameras that see it. */
#ifndef SYNTH_WORKPLACE_SCENE_H
#define SYNTH_WORKPLACE_SCENE_H

#include "data/recording/recording.h"
#include "synth/workplace/script.h"
#include "synth/world/world.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { WORKPLACE_WIDTH = 640, WORKPLACE_HEIGHT = 480 };

#define WORKPLACE_DEPTH_STEP 0.001

/* Things of the world: persons, then of each person the left and the right hand, then objects. */
typedef struct {
    const workplace_script *script;
    int k;
    workplace_moment who[WORKPLACE_PEOPLE];
    double (*vertex[WORKPLACE_PEOPLE])[3];      /* (BODY_VERTICES) posed */
    synth_settled object[WORKPLACE_OBJECTS];
    int owner[WORKPLACE_OBJECTS];               /* who has it, -1: nobody */
    synth_world world;
} workplace_scene;

/* workplace_room - where the script takes place; lives in the arena, all its textures are painted. LT_ENOMEM. */
lt_status workplace_room(lt_arena *arena, const workplace_script *s, synth_room **out);

/* workplace_scene_at - frame k; lives in the arena. LT_ENOMEM. */
lt_status workplace_scene_at(lt_arena *arena, const workplace_script *s, const synth_room *room, int k,
                             workplace_scene **out);

/* workplace_scene_draw - as camera sees it, without a sensor. LT_ENOMEM. */
lt_status workplace_scene_draw(const workplace_scene *scene, const synth_room *room, const synth_camera *camera,
                               synth_frame *frame);

/* workplace_rig - n cameras: the one that faces the persons, two that look down on the table, one at the side; pictures
 * are shrunk so many times */
void workplace_rig(const workplace_script *s, int n, int shrink, recording_rig *out);

/* workplace_camera - of a rig, for the renderer */
synth_camera workplace_camera(const recording_camera *c);

#ifdef __cplusplus
}
#endif
#endif
