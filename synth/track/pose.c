/* SPDX-License-Identifier: Apache-2.0 */
/* Where everything is at a frame. */
#include "synth/track/script.h"

#include "libtensor/geometry/mat3.h"

#include <math.h>
#include <string.h>

static const double ARM = 0.75;                 /* metres of an arm that comes from above the picture */

static double swing_of(const track_script *s, const track_actor *a, int k)
{
    return fmin(1, fabs(a->path[k].speed) * s->stage.half[a->lane]);
}

/* He looks where he goes, and to the camera where he stands. */
static synth_stance stance_at(const track_script *s, const track_actor *a, int k)
{
    const double speed = a->path[k].speed * s->stage.half[a->lane], swing = 0.45 * swing_of(s, a, k);
    const double half = s->stage.half[a->lane];
    synth_stance st = { .at = { a->path[k].x * half, s->stage.lane[a->lane], 0 }, .facing = atan2(-0.3, speed),
                        .lean = 0.04, .nod = 0.05 };

    st.look = 0.3 * sin(0.9 * s->time[k] + a->phase);
    st.stride[0] = swing * sin(a->stride[k] + a->phase);
    st.stride[1] = -st.stride[0];
    st.at[2] = -0.5 * (1 - cos(st.stride[0])) * a->person.stature * 0.49;
    return st;
}

/* An arm that carries something is bent; the other swings against the legs. */
static void wrist_at(const track_script *s, const track_actor *a, const synth_stance *st, const synth_reach *reach,
                     int arm, int k, double out[3])
{
    const bool carries = a->grip[arm].prop;
    const double swing = carries ? 0.02 * sin(2 * s->time[k] + a->phase) : -0.9 * st->stride[arm];
    const double length = 0.94 * (reach->upper + reach->fore);
    const double ahead = carries ? 0.22 : length * sin(swing) + 0.03;
    const double up = carries ? -0.24 + swing : -length * cos(swing);
    const double out_of = carries ? -0.03 : 0.08;

    for (int i = 0; i < 3; i++)
        out[i] = reach->shoulder[arm][i] + ahead * reach->forward[i] + (arm ? -1 : 1) * out_of * reach->left[i] +
                 (i == 2) * up;
}

/* The hand's place from its wrist's. */
static void hold_at(const double wrist[3], synth_held *h)
{
    double shift[3];

    lt_mat3_mulvec(h->R, h->grip->wrist, shift);
    lt_vec3_sub(wrist, shift, h->t);
}

static synth_held held_of(const track_script *s, const track_actor *a, int arm)
{
    const synth_prop *p = a->grip[arm].prop;

    return (synth_held){ .hand = s->hand, .who = &a->person.subject, .grip = &a->grip[arm], .cloth = a->person.shirt,
                         .owner = -1, .identity = 2 * a->identity + arm, .object_identity = p ? p->id : 0,
                         .seed = a->person.seed, .stream = a->person.stream + (uint64_t)arm };
}

static lt_status pose_person(lt_arena *arena, const track_script *s, const track_actor *a, int k, synth_world *w)
{
    const synth_stance stance = stance_at(s, a, k);
    synth_held held[2];
    synth_reach reach;
    double elbow[2][3];
    int thing;
    lt_status st;

    synth_person_reach(&a->person, &stance, &reach);
    for (int arm = 0; arm < 2; arm++) {
        synth_held *h = &held[arm];
        double wrist[3];
        *h = held_of(s, a, arm);
        h->arm = reach.fore + 0.012;
        h->far = true;
        wrist_at(s, a, &stance, &reach, arm, k, wrist);
        synth_reach_elbow(&reach, arm, 0.25, wrist, elbow[arm]);
        lt_vec3_sub(elbow[arm], wrist, h->elbow);
        lt_vec3_unit(h->elbow);
        synth_grip_turn(h->grip, h->elbow, reach.left, a->roll, h->R);
        hold_at(wrist, h);
    }
    st = synth_person_place(arena, &a->person, &stance, elbow, a->identity, w, &thing);
    for (int arm = 0; !st && arm < 2; arm++) {
        held[arm].owner = thing;
        st = synth_held_place(arena, &held[arm], w);
    }
    return st;
}

/* How far the grip reaches below its wrist. */
static double below(const synth_grip *g, const double R[9])
{
    double least = 0;

    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        double d[3];
        lt_vec3_sub(g->vertices[i], g->wrist, d);
        least = fmin(least, lt_vec3_dot(R + 6, d));
    }
    for (int i = 0; g->prop && i < g->prop->mesh.n_vertices; i++) {
        const float *v = g->prop->mesh.vertex[i];
        double d[3] = { v[0], v[1], v[2] };
        lt_vec3_sub(d, g->wrist, d);
        least = fmin(least, lt_vec3_dot(R + 6, d));
    }
    return -least;
}

/* A hand over the table, whose arm comes from above and sways. */
static lt_status pose_hand(lt_arena *arena, const track_script *s, const track_actor *a, int k, synth_world *w)
{
    static const double side[3] = { 0, 1, 0 };
    const double t = s->time[k], sway = 0.25 * sin(0.8 * t + a->phase);
    const double roll = a->roll + 0.7 * sin(0.6 * t + 2 * a->phase);
    synth_held h = held_of(s, a, a->left ? 0 : 1);
    double wrist[3] = { a->path[k].x * s->stage.half[a->lane], s->stage.lane[a->lane], 0 };

    h.arm = ARM;
    h.elbow[0] = sway;
    h.elbow[1] = -0.15;
    h.elbow[2] = 1;
    lt_vec3_unit(h.elbow);
    synth_grip_turn(h.grip, h.elbow, side, roll, h.R);
    wrist[2] = below(h.grip, h.R) + 0.015 + 0.02 * (1 + sin(1.1 * t + a->phase));
    hold_at(wrist, &h);
    return synth_held_place(arena, &h, w);
}

lt_status track_script_pose(lt_arena *arena, const track_script *s, int k, synth_world *w)
{
    lt_status st = LT_OK;

    memset(w, 0, sizeof(*w));
    synth_world_room(w, s->stage.room);
    for (int i = 0; !st && i < TRACK_LANES; i++)
        st = (s->hall ? pose_person : pose_hand)(arena, s, &s->actor[i], k, w);
    return st;
}
