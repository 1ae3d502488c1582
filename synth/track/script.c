/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/track/script.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SCRIPT = 0x53435249, GRASP = 0x47524153, TWINS = 8 };

static const double RATE = 30;                  /* frames a second, but for drops */
static const double SLOW = 3;                   /* times as long between frames */
static const double CARRIES = 0.5;              /* share of hands that carry something */

/* ---- who ---- */

/* Of the persons of a split, the last ones have a twin among the first: half of them his shape, half his clothes. */
void track_identity(int number, int *body, int *clothes)
{
    const bool new = number >= TRACK_TRAIN_PEOPLE;
    const int first = new ? TRACK_TRAIN_PEOPLE : 0, twins = new ? 4 : TWINS;
    const int n = new ? TRACK_NEW_PEOPLE : TRACK_TRAIN_PEOPLE, k = number - first - (n - twins);

    *body = *clothes = number;
    if (k >= 0 && k < twins / 2)
        *body = first + k;
    else if (k >= 0)
        *clothes = first + k;
}

/* A hall's persons: two twins, while there are any, and others. */
static void cast_hall(int number, int identity[TRACK_LANES])
{
    const bool new = number >= TRACK_TRAIN_HALLS;
    const int first = new ? TRACK_TRAIN_PEOPLE : 0, twins = new ? 4 : TWINS;
    const int n = new ? TRACK_NEW_PEOPLE : TRACK_TRAIN_PEOPLE, s = new ? number - TRACK_TRAIN_HALLS : number;
    const int singles = n - 2 * twins;          /* behind those who have a twin */
    int k = 0;

    if (s < twins) {
        identity[k++] = first + s;
        identity[k++] = first + n - twins + s;
    }
    for (int i = 0; k < TRACK_LANES; i++) {
        const int pick = i < singles && i < 3 ? first + twins + (3 * s + i) % singles : first + (s + 1 + i) % twins;
        bool there = false;
        for (int j = 0; j < k; j++)
            there = there || identity[j] == pick;
        if (!there)
            identity[k++] = pick;
    }
}

/* A table's hands are those of persons of the split. */
static void cast_table(lt_rng *r, bool evaluation, int identity[TRACK_LANES])
{
    uint32_t order[TRACK_TRAIN_PEOPLE];
    const uint32_t n = evaluation ? TRACK_NEW_PEOPLE : TRACK_TRAIN_PEOPLE;

    lt_rng_permute(r, order, n);
    for (int i = 0; i < TRACK_LANES; i++)
        identity[i] = (int)order[i] + (evaluation ? TRACK_TRAIN_PEOPLE : 0);
}

/* An object that the split shows: every third is kept for evaluation. No two of a film are alike. */
static const synth_prop_pair *pick_object(const track_script *s, int film, int actor)
{
    const int n = s->evaluation ? YCB_COUNT / 3 : YCB_COUNT - YCB_COUNT / 3, k = (5 * film + actor) % n;

    return &s->prop[s->evaluation ? 3 * k + 2 : k / 2 * 3 + k % 2];
}

/* ---- when ---- */

/* Thirty frames a second, but for three stretches in which two of three are lost. */
static double *draw_times(lt_arena *arena, lt_rng *r, int frames)
{
    double *time = lt_arena_array(arena, (size_t)frames, sizeof(*time));
    const int length = frames / 15;
    int begins[TRACK_DROPS];

    for (int i = 0; i < TRACK_DROPS; i++)
        begins[i] = (int)((i + lt_rng_range(r, 0.2, 0.7)) * frames / TRACK_DROPS);
    for (int k = 1; time && k < frames; k++) {
        bool slow = false;
        for (int i = 0; i < TRACK_DROPS; i++)
            slow = slow || (k > begins[i] && k <= begins[i] + length);
        time[k] = time[k - 1] + (slow ? SLOW : 1) / RATE;
    }
    return time;
}

/* ---- what each does ---- */

static lt_status draw_grip(const track_script *s, int film, int actor, int side, bool carries, lt_rng *r,
                           synth_grip *out)
{
    const uint64_t stream = lt_rng_mix(lt_rng_mix(GRASP, (uint64_t)film), (uint64_t)(2 * actor + side));
    const synth_subject *who = &s->actor[actor].person.subject;
    lt_status st = LT_ENUMERIC;

    if (carries)
        st = synth_grip_hold(s->hand, who, pick_object(s, film, actor), side == 0, lt_rng_mix(s->seed, stream), out);
    if (st != LT_ENUMERIC)
        return st;
    synth_grip_bare(s->hand, who, side == 0, r, out);
    return LT_OK;
}

/* The distance walked as radians of gait: two steps a turn. */
static double *walk(lt_arena *arena, const track_script *s, const track_actor *a)
{
    double *stride = lt_arena_array(arena, (size_t)s->frames, sizeof(*stride));

    for (int k = 1; stride && k < s->frames; k++)
        stride[k] = stride[k - 1] + 2 * M_PI * s->stage.half[a->lane] * fabs(a->path[k].x - a->path[k - 1].x) /
                                        (0.8 * a->person.stature);
    return stride;
}

static lt_status draw_actor(lt_arena *arena, int film, int i, int identity, int lane, lt_rng *r, track_script *s)
{
    static const track_act first[TRACK_LANES] = { TRACK_CROSS, TRACK_CROSS, TRACK_HIDE, TRACK_LEAVE, TRACK_HIDE };
    track_actor *a = &s->actor[i];
    track_point *path = lt_arena_array(arena, (size_t)s->frames, sizeof(*path));
    const bool carries = s->hall ? lt_rng_uniform(r) < CARRIES : i > 0;
    int body, clothes;
    lt_status st;

    if (!path)
        return lt_error(LT_ENOMEM, "synth: no memory for a film");
    *a = (track_actor){ .lane = lane, .identity = identity, .path = path };
    a->left = lt_rng_below(r, 2);
    a->phase = lt_rng_range(r, 0, 2 * M_PI);
    a->roll = lt_rng_range(r, -M_PI, M_PI);
    track_path_draw(r, lane, s->stage.screen, first[i], s->time, s->frames, path);
    track_identity(identity, &body, &clothes);
    st = synth_person_draw(arena, s->hand, s->seed, body, clothes, &a->person);
    for (int side = 0; !st && side < 2; side++)
        st = draw_grip(s, film, i, side, carries && (a->left ? side == 0 : side == 1), r, &a->grip[side]);
    a->stride = walk(arena, s, a);
    return st ? st : a->stride ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for a film");
}

lt_status track_script_new(lt_arena *arena, int number, track_script *s)
{
    const uint64_t stream = lt_rng_mix(SCRIPT, (uint64_t)number);
    lt_rng r = lt_rng_make(s->seed, stream);
    const int table = number - TRACK_HALLS;
    int identity[TRACK_LANES];
    uint32_t lane[TRACK_LANES];
    lt_status st;

    s->hall = table < 0;
    s->evaluation = s->hall ? number >= TRACK_TRAIN_HALLS : table >= TRACK_TRAIN_TABLES;
    snprintf(s->name, sizeof(s->name), s->hall ? "hall-%02d" : "table-%02d", (s->hall ? number : table) + 1);
    s->time = draw_times(arena, &r, s->frames);
    if (!s->time)
        return lt_error(LT_ENOMEM, "synth: no memory for a film");
    st = (s->hall ? track_hall_new : track_table_new)(arena, s->seed, stream, &s->stage);
    if (s->hall)
        cast_hall(number, identity);
    else
        cast_table(&r, s->evaluation, identity);
    lt_rng_permute(&r, lane, TRACK_LANES);
    for (int i = 0; !st && i < TRACK_LANES; i++)
        st = draw_actor(arena, number, i, identity[i], (int)lane[i], &r, s);
    return st;
}
