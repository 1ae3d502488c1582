/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/world/world.h"

#include "assets/ycb/objects.h"

#include <string.h>

int synth_world_thing(synth_world *w, const synth_thing *thing)
{
    if (w->n_things == SYNTH_THINGS)
        return -1;
    w->thing[w->n_things] = *thing;
    return w->n_things++;
}

void synth_world_place(synth_world *w, int thing, const synth_instance *in)
{
    if (w->n_instances == SYNTH_WORLD_INSTANCES)
        return;
    w->instance[w->n_instances] = *in;
    w->instance[w->n_instances++].label = (uint8_t)(thing + 1);
}

void synth_world_room(synth_world *w, const synth_room *room)
{
    for (int i = 0; i < room->n_instances; i++)
        synth_world_place(w, -1, &room->instance[i]);
}

synth_scene synth_world_scene(const synth_world *w, const synth_room *room, const synth_camera *camera)
{
    synth_scene scene = { .instance = w->instance, .n_instances = w->n_instances, .light = room->light,
                          .n_lights = room->n_lights, .focus_radius = room->focus_radius, .camera = *camera };

    memcpy(scene.sky, room->sky, sizeof(scene.sky));
    memcpy(scene.ground, room->ground, sizeof(scene.ground));
    memcpy(scene.up, room->up, sizeof(scene.up));
    memcpy(scene.focus, room->focus, sizeof(scene.focus));
    return scene;
}

const char *synth_class_name(int kind)
{
    if (kind == SYNTH_PERSON_THING)
        return "person";
    return kind == SYNTH_HAND_THING ? "hand" : synth_object_find(kind - SYNTH_HAND_THING)->name;
}
