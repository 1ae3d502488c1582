/* SPDX-License-Identifier: Apache-2.0 */
/* The robot: an arm at the table's other side that takes what it is handed, keeps it, and gives it back. */
#ifndef SYNTH_WORKPLACE_ROBOT_H
#define SYNTH_WORKPLACE_ROBOT_H

#include "synth/workplace/script.h"
#include "synth/world/world.h"

/* robot_takes, robot_gives - where an object is after a hold that ends with the robot, and before one that begins with
 * it; *at is where it was */
void robot_takes(const workplace_script *s, const workplace_hold *h, int k, synth_settled *at);
void robot_gives(const workplace_script *s, const workplace_hold *h, int k, synth_settled *at);

/* robot_place - the arm at frame k becomes part of the world; meshes live in the arena. LT_ENOMEM. */
lt_status robot_place(lt_arena *arena, const workplace_script *s, int k, synth_world *w);

#endif
