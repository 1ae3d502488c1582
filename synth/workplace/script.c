/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/workplace/script.h"

#include "synth/workplace/act.h"
#include "synth/workplace/choose.h"

#include <math.h>
#include <string.h>

enum { SCRIPT = 0x574b5343, STYLE = 0x574b5354, LOOK = 0x574b4c4b, CAST = 0x574b4354, ACTS = 0x574b4143,
       PLACES_TRIED = 40 };

static const double EDGE = 0.35;                /* y of the table's edge where persons are */
static const double BEFORE = 0.33;              /* metres that they stand before it */
static const double APART = 0.82;               /* metres from one to the next */
static const double ROBOT = 0.1;                /* where the robot's side begins: y below -ROBOT */
static const double BACK = 0.14;                /* metres that somebody steps back who will step to the table */

typedef struct {
    lt_arena *arena;
    lt_rng r;
    workplace_script *s;
    int cast[WORKPLACE_CAST];                   /* 0: it is on the table */
} writing;

/* ---- objects ------------------------------------------------------------------------------------------------ */

/* The model's box, and the model on the table somewhere */
static void measure_object(workplace_object *o)
{
    const lt_mesh *m = &o->prop->right.mesh;
    double lo[3] = { INFINITY, INFINITY, INFINITY }, hi[3] = { -INFINITY, -INFINITY, -INFINITY };

    for (int v = 0; v < m->n_vertices; v++)
        for (int k = 0; k < 3; k++) {
            lo[k] = fmin(lo[k], m->vertex[v][k]);
            hi[k] = fmax(hi[k], m->vertex[v][k]);
        }
    for (int k = 0; k < 3; k++)
        o->middle[k] = (lo[k] + hi[k]) / 2;
    o->radius = hypot(hi[0] - lo[0], hi[1] - lo[1]) / 2;
    o->at = (synth_settled){ .R = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, .t = { 0, 0, -lo[2] } };
}

/* An object that stands here, turned somehow */
static void stand_object(const workplace_object *o, double x, double y, double turn, synth_settled *out)
{
    const double c = cos(turn), s = sin(turn), t[3] = { x - (c * o->middle[0] - s * o->middle[1]),
                                                        y - (s * o->middle[0] + c * o->middle[1]), o->at.t[2] };
    const double R[9] = { c, -s, 0, s, c, 0, 0, 0, 1 };

    memcpy(out->R, R, sizeof(R));
    memcpy(out->t, t, sizeof(t));
}

/* Where its middle is, over the table */
static void over(const workplace_object *o, const synth_settled *at, double out[2])
{
    for (int k = 0; k < 2; k++)
        out[k] = at->R[3 * k] * o->middle[0] + at->R[3 * k + 1] * o->middle[1] + at->t[k];
}

/* Whether an object at x, y is clear of the others, of where they are at first and where the robot keeps them */
static bool is_free(const workplace_script *s, const workplace_object *o, const double at[2])
{
    for (int i = 0; i < s->n_objects; i++) {
        double other[2][2];

        if (&s->object[i] == o)
            continue;
        over(&s->object[i], &s->object[i].at, other[0]);
        over(&s->object[i], &s->object[i].kept, other[1]);
        for (int k = 0; k < 2; k++)
            if (hypot(at[0] - other[k][0], at[1] - other[k][1]) < o->radius + s->object[i].radius + 0.03)
                return false;
    }
    return true;
}

/* One that nobody touches stands about on the robot's side or between persons. */
static void scatter(writing *w, workplace_object *o)
{
    const double *t = w->s->table;

    for (int i = 0; i < PLACES_TRIED; i++) {
        const double x = lt_rng_range(&w->r, t[0] + 0.12, t[2] - 0.12), y = lt_rng_range(&w->r, t[1] + 0.1, 0.02);
        const double turn = lt_rng_range(&w->r, -M_PI, M_PI);
        const double at[2] = { x, y };

        stand_object(o, x, y, turn, &o->at);
        o->kept = o->at;
        if (fabs(x - w->s->base[0]) > 0.25 && is_free(w->s, o, at))
            return;
    }
    stand_object(o, t[0] + 0.1, t[1] + 0.1, 0, &o->at);
    o->kept = o->at;
}

/* Where the robot keeps it: on its side, next to its arm */
static void find_keep(writing *w, workplace_object *o)
{
    const double aside = lt_rng_range(&w->r, 0.14, 0.3), turn = lt_rng_range(&w->r, -M_PI, M_PI);
    const double to = w->s->person[0].stand[0] > w->s->base[0] ? -1 : 1;

    stand_object(o, w->s->base[0] + to * aside, w->s->table[1] + 0.14, turn, &o->kept);
}

/* ---- persons ------------------------------------------------------------------------------------------------ */

static lt_status draw_person(writing *w, int i)
{
    workplace_person *p = &w->s->person[i];
    const uint64_t number = lt_rng_mix(STYLE, (uint64_t)i);
    lt_rng style = lt_rng_make(w->s->seed, number);
    double shape[BODY_SHAPES];

    for (int k = 0; k < BODY_SHAPES; k++)
        shape[k] = fmax(-2, fmin(2, lt_rng_normal(&w->r)));
    synth_follower_init(w->s->body, shape, &p->body);
    action_style_draw(&style, &p->style);
    p->style.stature = p->body.stature;
    p->style.speed = 0.7 + 0.5 * (p->style.speed - 0.7);        /* no faster: there is a wall behind him */
    p->style.amplitude = fmin(p->style.amplitude, 1.05);
    p->facing = -M_PI / 2;
    p->stand[0] = APART * (i - 0.5 * (w->s->n_people - 1)) + lt_rng_range(&w->r, -0.04, 0.04);
    p->stand[1] = EDGE + BEFORE + lt_rng_range(&w->r, 0, 0.03);
    return synth_appearance_draw(w->arena, w->s->hand, lt_rng_mix(w->s->seed, LOOK), (int)(w->s->seed % 1000) * 3 + i,
                                 &p->look);
}

/* The first of the cast that he can grasp, if there is one, becomes object i, and is taken from the cast. */
static lt_status give_object(writing *w, workplace_person *p, int i, workplace_hold *how, double *lean, bool *found)
{
    workplace_object *o = &w->s->object[i];

    *found = false;
    for (int k = 0; k < WORKPLACE_CAST && !*found; k++) {
        lt_status st;

        if (!w->cast[k])
            continue;
        o->prop = &w->s->prop[w->cast[k] - 1];
        measure_object(o);
        st = choose_grasp(w->s, p, o, &w->r, how, lean, found);
        if (st)
            return st;
        if (*found)
            w->cast[k] = 0;
    }
    return LT_OK;
}

/* ---- acts --------------------------------------------------------------------------------------------------- */

/* What may come next: one program, or two that belong together. */
typedef enum { DOES, PICKS_AND_PLACES, PICKS_AND_HANDS_OVER, RECEIVES_AND_PLACES } unit;

typedef struct {
    workplace_person *p;
    workplace_hold how;             /* of the first picking */
    double lean;
    int object;                     /* -1: none */
    bool robot;                     /* the robot works with him */
    bool kept;                      /* the robot has the object */
    synth_settled at;               /* where it stands on the table */
} acting;

static workplace_act *begin_act(writing *w, acting *a, int cls)
{
    workplace_person *p = a->p;
    workplace_act *act = &p->act[p->n_acts];

    *act = (workplace_act){ .object = -1, .first = p->n_acts ? act[-1].last + ACT_GAP : 0 };
    action_draw_new(&w->r, cls, w->s->difficulty, &p->style, &act->draw);
    act->draw.yaw *= 0.25;
    for (int k = 0; k < 2; k++)
        act->draw.place[k] *= 0.06;
    if (cls >= ACTION_WITH_OBJECT)
        act->draw.arm = p->style.arm;
    act->last = act->first + act->draw.frames;
    act->onset = act->first + (int)ceil(act->draw.begin * act->draw.frames);
    p->n_acts++;
    return act;
}

/* He comes from behind, and ends where he stands. */
static void come_walking(writing *w, acting *a)
{
    workplace_act *act = begin_act(w, a, ACT_WALK);
    body_pose end;

    act->draw.frames = 62;
    act->last = act->first + act->draw.frames;
    act->onset = act->first + (int)ceil(act->draw.begin * act->draw.frames);
    action_pose(&a->p->style, &act->draw, act->draw.frames, &end);
    act->draw.place[0] -= end.place[0];
    act->draw.place[1] -= end.place[1] + 0.1;
}

static workplace_hold *begin_hold(acting *a, const workplace_act *act)
{
    workplace_hold *h = &a->p->hold[a->p->n_holds++];

    *h = (workplace_hold){ .object = a->object, .from = act_meets(act), .picked = act->draw.cls == ACT_PICK };
    memcpy(h->hand, a->how.hand, sizeof(h->hand));
    return h;
}

static workplace_hold *pick(writing *w, acting *a)
{
    workplace_act *act = begin_act(w, a, ACT_PICK);
    workplace_hold *h;

    act->object = a->object;
    act->lean = a->lean;
    h = begin_hold(a, act);
    h->begin = a->at;
    choose_wrist(a->p, &a->at, h->wrist[0], h->hand);
    act_target(a->p, act, h->from, h->wrist[0]);
    return h;
}

static workplace_hold *receive(writing *w, acting *a)
{
    workplace_act *act = begin_act(w, a, ACT_RECEIVE);

    act->object = a->object;
    a->kept = false;
    return begin_hold(a, act);
}

/* A free spot near where the object stood at first, that the hand reaches as it is turned */
static void find_spot(writing *w, acting *a, workplace_act *act, workplace_hold *h)
{
    const workplace_object *o = &w->s->object[a->object];
    double best = INFINITY;

    for (int i = 0; i < PLACES_TRIED && best > 0.004; i++) {
        const double dx = lt_rng_range(&w->r, -0.16, 0.16), dy = lt_rng_range(&w->r, -0.04, 0.05);
        synth_settled at = o->at;
        double wrist[3], hand[9], spot[2], miss;

        at.t[0] += dx;
        at.t[1] += dy;
        over(o, &at, spot);
        if (i > 0 && (!is_free(w->s, o, spot) || spot[1] + o->radius > w->s->table[3]))
            continue;
        choose_wrist(a->p, &at, wrist, hand);
        miss = choose_miss(w->s, a->p, act, act_leaves(act) - 1, wrist, hand);
        if (miss < best) {
            best = miss;
            a->at = h->end = at;
            memcpy(h->wrist[1], wrist, sizeof(wrist));
        }
    }
}

static void place(writing *w, acting *a, workplace_hold *h)
{
    workplace_act *act = begin_act(w, a, ACT_PLACE);

    act->object = a->object;
    act->lean = a->lean;
    act->draw.place[1] -= BACK;
    h->to = act_leaves(act);
    h->placed = true;
    find_spot(w, a, act, h);
    act_target(a->p, act, h->to - 1, h->wrist[1]);
}

static void hand_over(writing *w, acting *a, workplace_hold *h)
{
    workplace_act *act = begin_act(w, a, ACT_HAND_OVER);

    act->object = a->object;
    h->to = act_leaves(act);
    a->kept = true;
}

static void add_unit(writing *w, acting *a, unit u, int cls)
{
    switch (u) {
    case DOES: begin_act(w, a, cls); break;
    case PICKS_AND_PLACES: place(w, a, pick(w, a)); break;
    case PICKS_AND_HANDS_OVER: hand_over(w, a, pick(w, a)); break;
    case RECEIVES_AND_PLACES: place(w, a, receive(w, a)); break;
    }
}

static bool may_come(const acting *a, unit u)
{
    if (u == DOES)
        return true;
    if (a->object < 0 || (u != PICKS_AND_PLACES && !a->robot))
        return false;
    if (u == RECEIVES_AND_PLACES && a->p->act[a->p->n_acts - 1].draw.cls == ACT_HAND_OVER)
        return false;                           /* the robot is on its way */
    return (u == RECEIVES_AND_PLACES) == a->kept;
}

/* All that he can do, in some order, again and again; what cannot come yet waits for what is before it. */
static void act_until_end(writing *w, acting *a)
{
    static const struct { unit unit; int cls; } all[] = {
        { DOES, ACT_WAVE }, { DOES, ACT_REACH }, { DOES, ACT_CROSS }, { DOES, ACT_POINT }, { DOES, ACT_WAIT },
        { PICKS_AND_PLACES, ACT_PICK }, { PICKS_AND_HANDS_OVER, ACT_PICK }, { RECEIVES_AND_PLACES, ACT_RECEIVE },
    };
    enum { ALL = LT_COUNT(all) };

    come_walking(w, a);
    while (a->p->act[a->p->n_acts - 1].last < w->s->frames) {
        uint32_t order[ALL];
        bool done[ALL] = { false };

        lt_rng_permute(&w->r, order, ALL);
        for (int n = 0; n < ALL; n++)
            for (int i = 0; i < ALL; i++)
                if (!done[order[i]] && may_come(a, all[order[i]].unit)) {
                    add_unit(w, a, all[order[i]].unit, all[order[i]].cls);
                    done[order[i]] = true;
                    break;
                }
    }
}

/* What a hold is from and to the robot is where the hand has it then. */
static void settle_holds(workplace_script *s, workplace_person *p)
{
    for (int i = 0; i < p->n_holds; i++) {
        workplace_hold *h = &p->hold[i];
        workplace_moment m;

        if (!h->picked) {
            workplace_person_at(s, (int)(p - s->person), h->from, &m);
            act_in_hand(p, &m.body, &h->begin);
        }
        if (!h->placed) {
            workplace_person_at(s, (int)(p - s->person), h->to, &m);
            act_in_hand(p, &m.body, &h->end);
        }
    }
}

static lt_status write_acts(writing *w, acting *a)
{
    const int most = w->s->frames / 40 + 16;    /* more than can begin, and a round more */

    w->r = lt_rng_make(w->s->seed, lt_rng_mix(ACTS, (uint64_t)(a->p - w->s->person)));

    a->p->act = lt_arena_array(w->arena, (size_t)most, sizeof(*a->p->act));
    a->p->hold = lt_arena_array(w->arena, (size_t)most, sizeof(*a->p->hold));
    if (!a->p->act || !a->p->hold)
        return lt_error(LT_ENOMEM, "synth: no memory for a script");
    act_until_end(w, a);
    settle_holds(w->s, a->p);
    return LT_OK;
}

/* ---- the whole ------------------------------------------------------------------------------------------------ */

static void draw_place(writing *w)
{
    workplace_script *s = w->s;
    const double aside = lt_rng_below(&w->r, 2) ? 0.42 : -0.42;

    s->n_people = 1 + (int)lt_rng_below(&w->r, WORKPLACE_PEOPLE);
    s->n_objects = 1 + (int)lt_rng_below(&w->r, WORKPLACE_OBJECTS);
    s->table[2] = lt_rng_range(&w->r, 0.66, 0.8) + 0.38 * (s->n_people - 1);
    s->table[0] = -s->table[2];
    s->table[1] = -0.42;
    s->table[3] = EDGE;
    memcpy(s->robot, (double[]){ 0, -1, 0, ROBOT }, sizeof(s->robot));
    s->base[0] = -0.5 * APART * (s->n_people - 1) + aside;
    s->base[1] = s->table[1] - 0.12;
}

void workplace_cast(uint64_t seed, int number[WORKPLACE_CAST])
{
    lt_rng r = lt_rng_make(seed, CAST);
    uint32_t order[YCB_COUNT];

    lt_rng_permute(&r, order, YCB_COUNT);
    for (int i = 0; i < WORKPLACE_CAST; i++)
        number[i] = 1 + (int)order[i];
}

/* A person with an object of his own, while there are any. */
static lt_status cast_person(writing *w, int i, int objects, acting *out)
{
    workplace_script *s = w->s;
    workplace_object *o = &s->object[s->n_objects];
    bool found = false;
    lt_status st = draw_person(w, i);

    *out = (acting){ .p = &s->person[i], .object = -1, .robot = i == 0 };
    if (!st && s->n_objects < objects)
        st = give_object(w, &s->person[i], s->n_objects, &out->how, &out->lean, &found);
    if (st || !found)
        return st;
    out->object = s->n_objects++;
    out->at = o->kept = o->at;
    if (i == 0)
        find_keep(w, o);
    return LT_OK;
}

lt_status workplace_script_new(lt_arena *arena, workplace_script *s)
{
    writing w = { .arena = arena, .r = lt_rng_make(s->seed, SCRIPT), .s = s };
    acting who[WORKPLACE_PEOPLE];
    lt_status st = LT_OK;
    int objects;

    workplace_cast(s->seed, w.cast);
    synth_hand_frames_init(&s->hand_frames, s->hand);
    draw_place(&w);
    objects = s->n_objects;
    s->n_objects = 0;
    for (int i = 0; !st && i < s->n_people; i++)
        st = cast_person(&w, i, objects, &who[i]);
    for (int k = 0; !st && k < WORKPLACE_CAST && s->n_objects < objects; k++)
        if (w.cast[k]) {
            s->object[s->n_objects].prop = &s->prop[w.cast[k] - 1];
            measure_object(&s->object[s->n_objects]);
            scatter(&w, &s->object[s->n_objects]);
            s->n_objects++;
        }
    for (int i = 0; !st && i < s->n_people; i++)
        st = write_acts(&w, &who[i]);
    return st;
}
