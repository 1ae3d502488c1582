/* SPDX-License-Identifier: Apache-2.0 */
#include "pipeline/watch/interaction.h"

#include <math.h>

const char *const interaction_names[INTERACTION_STATES] = {
    "none", "approach", "contact", "hold", "handover", "receive", "place",
};

enum { REACHING = 2, RECEIVING = 6, PLACING, HANDING_OVER, PICKING };       /* classes of data/action */
enum { SETS_TO_CHANGE = 3 };

static const double SURE = 0.5;             /* of an action */
static const double FRAME = 1.0 / 30;
static const double NEAR = 0.40, CLOSING = 0.05;            /* metres, metres a second over 10 frames */
static const double AT_REST = 0.03, SLOW = 0.10;            /* metres a second */
static const double LIFTED = 0.02, DOWN = 0.03;
static const double BY_ROBOT = 0.35;
static const double OPEN_DEG = 25;

static bool does(const interaction_seen *e, int action)
{
    return e->action == action && e->p >= SURE;
}

/* How fast the wrist came nearer over the last 10 frames; NaN where that is not known */
static double closing(const interaction *s, const interaction_seen *e)
{
    const int64_t n = s->n_past < INTERACTION_PAST ? s->n_past : INTERACTION_PAST;

    for (int64_t i = 1; i <= n; i++) {
        const int64_t k = (s->n_past - i) % INTERACTION_PAST;

        if (e->t - s->past[k].t >= 9.5 * FRAME)
            return (s->past[k].reach - e->reach) / (e->t - s->past[k].t);
    }
    return NAN;
}

static bool gives(interaction_state now, const interaction_seen *e)
{
    if (now == INTERACTION_HANDOVER)
        return e->contact;
    return now == INTERACTION_HOLD && e->contact &&
        (does(e, HANDING_OVER) || (e->robot < BY_ROBOT && !(e->robot_speed < 0)));
}

static bool takes(interaction_state now, const interaction_seen *e)
{
    if (does(e, RECEIVING))
        return true;
    if (e->contact)
        return now == INTERACTION_RECEIVE && e->robot < BY_ROBOT;
    return e->robot < BY_ROBOT && e->flexion_deg < OPEN_DEG;
}

/* What was never up does not come down. */
static bool puts_down(const interaction *s, const interaction_seen *e)
{
    if (s->state == INTERACTION_PLACE)
        return e->contact;
    return s->state == INTERACTION_HOLD && e->contact &&
           (does(e, PLACING) || (s->lifted && e->lift < DOWN && e->object_speed < SLOW));
}

static bool holds(const interaction_seen *e)
{
    return e->contact && e->t - e->contact_since >= 5 * FRAME &&
           ((e->object_speed >= AT_REST && e->slip < SLOW) || e->lift > LIFTED);
}

/* Whoever surely waves, walks, crosses hands, points or waits reaches for nothing that his hands come near. */
static bool means_nothing(const interaction_seen *e)
{
    return e->action >= 0 && e->p >= SURE && e->action < RECEIVING && e->action != REACHING;
}

static bool approaches(const interaction *s, const interaction_seen *e)
{
    return !e->contact && (does(e, REACHING) || does(e, PICKING) ||
                           (e->reach < NEAR && closing(s, e) > CLOSING && !means_nothing(e)));
}

static interaction_state rule(const interaction *s, const interaction_seen *e)
{
    return gives(s->state, e) ? INTERACTION_HANDOVER : takes(s->state, e) ? INTERACTION_RECEIVE
        : puts_down(s, e) ? INTERACTION_PLACE : holds(e) ? INTERACTION_HOLD
        : e->contact ? INTERACTION_CONTACT : approaches(s, e) ? INTERACTION_APPROACH : INTERACTION_NONE;
}

void interaction_step(interaction *s, const interaction_seen *e)
{
    interaction_state wanted;

    s->lifted = e->contact && (s->lifted || e->lift > DOWN);
    wanted = rule(s, e);
    s->agreed = wanted == s->next ? s->agreed + 1 : 1;
    s->next = wanted;
    if (wanted != s->state && s->agreed >= SETS_TO_CHANGE) {
        s->state = wanted;
        s->since = e->t;
    }
    s->object = s->state == INTERACTION_NONE ? 0 : e->object;
    s->left = e->left;
    s->p = e->p;
    s->past[s->n_past % INTERACTION_PAST].t = e->t;
    s->past[s->n_past++ % INTERACTION_PAST].reach = e->reach;
}
