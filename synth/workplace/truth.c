/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/workplace/truth.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>

enum { LEFT_HAND_NODES = 25, HAND_NODES = 20, WRIST_NODE = 12, LEAST = 12 };

static const double TOUCHES = 0.005;            /* metres */

static const char *const state_names[] = { "none", "approach", "contact", "hold", "handover", "receive", "place" };

/* ---- what is computed -------------------------------------------------------------------------------------- */

double truth_contact(const workplace_scene *c, int person, int side, int object)
{
    const synth_settled *at = &c->object[object];
    const synth_sdf *sdf = &c->script->object[object].prop->right.sdf;
    const int32_t *row = c->script->body->hand[side];
    double back[9], least = INFINITY;

    lt_mat3_transpose(at->R, back);
    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        double x[3];

        lt_vec3_sub(c->vertex[person][row[i]], at->t, x);
        lt_mat3_mulvec(back, x, x);
        least = fmin(least, synth_sdf_at(sdf, x, NULL));
    }
    return least;
}

/* ---- printing ---------------------------------------------------------------------------------------------- */

static void put_numbers(FILE *f, const double *x, int n)
{
    for (int i = 0; i < n; i++)
        fprintf(f, "%s%.6f", i ? "," : "[", x[i] == 0 ? 0.0 : x[i]);
    fputc(']', f);
}

static void put_points(FILE *f, const double (*x)[3], int n)
{
    fputc('[', f);
    for (int i = 0; i < n; i++) {
        fputs(i ? "," : "", f);
        put_numbers(f, x[i], 3);
    }
    fputc(']', f);
}

static void put_box(FILE *f, const char *key, const synth_pixels *b)
{
    fprintf(f, ",\"%s\":[%d,%d,%d,%d]", key, b->x0, b->y0, b->x1, b->y1);
}

static void centre_of(const workplace_scene *c, int thing, double out[3])
{
    const int people = c->script->n_people, hands = 2 * people;

    if (thing < people)
        memcpy(out, c->who[thing].body.joint[BODY_PELVIS], sizeof(double[3]));
    else if (thing < people + hands) {
        const int i = thing - people;
        const double (*joint)[3] = c->who[i / 2].body.joint;

        memcpy(out, joint[BODY_FINGERS + i % 2 * BODY_HAND_JOINTS + 3], sizeof(double[3]));
    } else {
        const int i = thing - people - hands;

        lt_rigid_apply(c->object[i].R, c->object[i].t, c->script->object[i].middle, out);
    }
}

/* Boxes are around what is seen, and around all of it as if nothing hid it; "mask" is its value in masks. */
static void put_tracks(FILE *f, const workplace_scene *c, const recording_rig *rig, const workplace_views *views)
{
    bool first = true;

    fputs("\"tracks\":[", f);
    for (int v = 0; v < rig->n; v++)
        for (int i = 0; views->seen[v] && i < c->world.n_things; i++) {
            const synth_seen *s = &views->seen[v][i];
            double centre[3];

            if (s->whole < LEAST)
                continue;
            centre_of(c, i, centre);
            fprintf(f, "%s{\"id\":%d,\"class\":\"%s\",\"camera\":%d", first ? "" : ",", c->world.thing[i].identity,
                    synth_class_name(c->world.thing[i].kind), v);
            put_box(f, "box", &s->box);
            put_box(f, "amodal", &s->whole_box);
            fprintf(f, ",\"visible\":%.4f,\"mask\":%d,\"centre\":", synth_seen_share(s), i + 1);
            put_numbers(f, centre, 3);
            fputc('}', f);
            first = false;
        }
    fputc(']', f);
}

/* Global orientation of the wrist, then the fingers'; of a hand of its own side. */
static void put_mano(FILE *f, const workplace_scene *c, int person, int side)
{
    const synth_body_pose *b = &c->who[person].body;
    double pose[LT_HAND_JOINTS][3];

    lt_rot_to_axis_angle(b->world[BODY_WRIST + side], pose[0]);
    for (int j = 0; j < BODY_HAND_JOINTS; j++)
        lt_rot_to_axis_angle(b->R[BODY_FINGERS + side * BODY_HAND_JOINTS + j], pose[1 + j]);
    fputs(",\"pose\":", f);
    put_numbers(f, pose[0], 3 * LT_HAND_JOINTS);
}

static void put_hands(FILE *f, const workplace_scene *c, double (*node)[BODY_NODES][3])
{
    fputs(",\"hands\":[", f);
    for (int i = 0; i < 2 * c->script->n_people; i++) {
        const int side = i % 2;
        double joint[21][3];

        memcpy(joint[0], node[i / 2][WRIST_NODE + side], sizeof(joint[0]));
        memcpy(joint[1], node[i / 2][LEFT_HAND_NODES + side * HAND_NODES], HAND_NODES * sizeof(joint[0]));
        fprintf(f, "%s{\"id\":%d,\"side\":\"%s\",\"person\":%d,\"joints\":", i ? "," : "", 11 + i,
                side ? "right" : "left", 1 + i / 2);
        put_points(f, (const double (*)[3])joint, 21);
        put_mano(f, c, i / 2, side);
        fputc('}', f);
    }
    fputc(']', f);
}

static void put_objects(FILE *f, const workplace_scene *c)
{
    fputs(",\"objects\":[", f);
    for (int i = 0; i < c->script->n_objects; i++) {
        fprintf(f, "%s{\"id\":%d,\"class\":\"%s\",\"R\":", i ? "," : "", 21 + i, c->script->object[i].prop->right.name);
        put_numbers(f, c->object[i].R, 9);
        fputs(",\"t\":", f);
        put_numbers(f, c->object[i].t, 3);
        if (c->owner[i] >= 0)
            fprintf(f, ",\"held_by\":%d}", 1 + c->owner[i]);
        else
            fputs(",\"held_by\":null}", f);
    }
    fputc(']', f);
}

static void put_people(FILE *f, const workplace_scene *c, double (*node)[BODY_NODES][3])
{
    fputs(",\"people\":[", f);
    for (int i = 0; i < c->script->n_people; i++) {
        const synth_body_pose *b = &c->who[i].body;
        double pose[BODY_JOINTS][3];

        for (int j = 0; j < BODY_JOINTS; j++)
            lt_rot_to_axis_angle(b->R[j], pose[j]);
        fprintf(f, "%s{\"id\":%d,\"joints\":", i ? "," : "", 1 + i);
        put_points(f, (const double (*)[3])node[i], BODY_NODES);
        fputs(",\"pose\":", f);
        put_numbers(f, pose[0], 3 * BODY_JOINTS);
        fputs(",\"trans\":", f);
        put_numbers(f, b->trans, 3);
        fputc('}', f);
    }
    fputc(']', f);
}

static void put_contact(FILE *f, const workplace_scene *c, workplace_tally *tally)
{
    bool first = true;

    fputs(",\"contact\":[", f);
    for (int o = 0; o < c->script->n_objects; o++) {
        bool touched = false;

        for (int i = 0; i < 2 * c->script->n_people; i++) {
            const double d = truth_contact(c, i / 2, i % 2, o);

            if (d > TOUCHES)
                continue;
            touched = touched || c->owner[o] == i / 2;
            fprintf(f, "%s{\"hand\":%d,\"object\":%d,\"distance\":%.5f}", first ? "" : ",", 11 + i, 21 + o, d);
            first = false;
        }
        tally->held += c->owner[o] >= 0;
        tally->touched += c->owner[o] >= 0 && touched;
    }
    fputc(']', f);
}

static void put_action(FILE *f, const workplace_scene *c)
{
    bool first = true;

    fputs(",\"action\":[", f);
    for (int i = 0; i < c->script->n_people; i++) {
        const workplace_act *a = c->who[i].act;

        if (!a)
            continue;
        fprintf(f, "%s{\"person\":%d,\"class\":\"%s\",\"onset\":%.5f}", first ? "" : ",", 1 + i,
                action_classes[a->draw.cls], workplace_time(a->onset));
        first = false;
    }
    fputs("],\"interaction\":[", f);
    for (int i = 0; i < c->script->n_people; i++) {
        const workplace_moment *m = &c->who[i];

        fprintf(f, "%s{\"person\":%d,\"state\":\"%s\",", i ? "," : "", 1 + i, state_names[m->state]);
        if (m->object >= 0)
            fprintf(f, "\"object\":%d,\"side\":\"%s\"", 21 + m->object,
                    c->script->person[i].style.arm == RIGHT ? "right" : "left");
        else
            fputs("\"object\":null,\"side\":null", f);
        fprintf(f, ",\"since\":%.5f}", workplace_time(m->since));
    }
    fputc(']', f);
}

void truth_print(FILE *f, const workplace_scene *c, const recording_rig *rig, const workplace_views *views,
                 workplace_tally *tally)
{
    double node[WORKPLACE_PEOPLE][BODY_NODES][3];

    *tally = (workplace_tally){ 0 };
    for (int i = 0; i < c->script->n_people; i++) {
        body_nodes(c->vertex[i][0], c->who[i].body.joint[0], node[i]);
        tally->miss += c->who[i].miss[0] + c->who[i].miss[1];
        tally->wrists += 2;
        if (views->seen[0] && views->seen[0][i].whole >= LEAST) {
            tally->seen += synth_seen_share(&views->seen[0][i]);
            tally->people++;
        }
    }
    put_tracks(f, c, rig, views);
    put_hands(f, c, node);
    put_objects(f, c);
    put_people(f, c, node);
    put_contact(f, c, tally);
    put_action(f, c);
}

/* ---- what does not change ----------------------------------------------------------------------------------- */

static cJSON *floats(const float *x, int n)
{
    return cJSON_CreateFloatArray(x, n);
}

static void add_people(cJSON *to, const workplace_script *s)
{
    cJSON *people = cJSON_AddArrayToObject(to, "people");

    for (int i = 0; i < s->n_people; i++) {
        const workplace_person *p = &s->person[i];
        cJSON *one = cJSON_CreateObject(), *acts;

        cJSON_AddNumberToObject(one, "id", 1 + i);
        cJSON_AddItemToObject(one, "shape", cJSON_CreateDoubleArray(p->body.shape, BODY_SHAPES));
        cJSON_AddNumberToObject(one, "stature", p->body.stature);
        cJSON_AddStringToObject(one, "arm", p->style.arm == RIGHT ? "right" : "left");
        acts = cJSON_AddArrayToObject(one, "acts");
        for (int k = 0; k < p->n_acts && p->act[k].first < s->frames; k++) {
            cJSON *act = cJSON_CreateObject();

            cJSON_AddStringToObject(act, "class", action_classes[p->act[k].draw.cls]);
            cJSON_AddNumberToObject(act, "first", p->act[k].first);
            cJSON_AddNumberToObject(act, "onset", p->act[k].onset);
            cJSON_AddNumberToObject(act, "end", p->act[k].last);
            cJSON_AddItemToArray(acts, act);
        }
        cJSON_AddItemToArray(people, one);
    }
}

static void add_light(cJSON *to, const synth_room *room, const recording_rig *rig, const synth_sensor *sensor)
{
    cJSON *light = cJSON_AddObjectToObject(to, "light"), *lamps, *sensors;

    cJSON_AddItemToObject(light, "sky", floats(room->sky, 3));
    cJSON_AddItemToObject(light, "ground", floats(room->ground, 3));
    lamps = cJSON_AddArrayToObject(light, "lamps");
    for (int i = 0; i < room->n_lights; i++) {
        cJSON *one = cJSON_CreateObject();

        cJSON_AddItemToObject(one, "position", cJSON_CreateDoubleArray(room->light[i].position, 3));
        cJSON_AddNumberToObject(one, "radius", room->light[i].radius);
        cJSON_AddItemToObject(one, "color", floats(room->light[i].color, 3));
        cJSON_AddItemToArray(lamps, one);
    }
    sensors = cJSON_AddArrayToObject(to, "sensors");
    for (int i = 0; i < rig->n; i++) {
        cJSON *one = cJSON_CreateObject();

        cJSON_AddNumberToObject(one, "exposure", sensor[i].exposure);
        cJSON_AddItemToObject(one, "white", floats(sensor[i].white, 3));
        cJSON_AddNumberToObject(one, "gamma", sensor[i].gamma);
        cJSON_AddNumberToObject(one, "noise", sensor[i].noise);
        cJSON_AddItemToArray(sensors, one);
    }
}

lt_status truth_world(const char *path, const workplace_script *s, const synth_room *room, const recording_rig *rig,
                      const workplace_clock *clock, const synth_sensor *sensor)
{
    cJSON *j = cJSON_CreateObject(), *objects, *own;
    lt_status st;

    cJSON_AddStringToObject(j, "schema", "palmar.world/1");
    cJSON_AddItemToObject(j, "table", cJSON_CreateDoubleArray(s->table, 4));
    cJSON_AddNumberToObject(j, "floor", WORKPLACE_FLOOR);
    add_people(j, s);
    objects = cJSON_AddArrayToObject(j, "objects");
    for (int i = 0; i < s->n_objects; i++) {
        cJSON *one = cJSON_CreateObject();

        cJSON_AddNumberToObject(one, "id", 21 + i);
        cJSON_AddStringToObject(one, "class", s->object[i].prop->right.name);
        cJSON_AddItemToArray(objects, one);
    }
    own = cJSON_AddObjectToObject(j, "clock");
    cJSON_AddItemToObject(own, "lag", cJSON_CreateDoubleArray(clock->lag, clock->n));
    add_light(j, room, rig, sensor);
    st = j ? lt_json_write(path, j) : lt_error(LT_ENOMEM, "%s: no memory", path);
    cJSON_Delete(j);
    return st;
}
