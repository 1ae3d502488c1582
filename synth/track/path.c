/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/track/path.h"

#include <math.h>

static const double PACE[2] = { 0.3, 0.55 };    /* of x, a second, on the mean of a leg */
static const double GONE = 1.5;                 /* x of what has left the picture */

/* From x to `to` in `lasts` seconds, then `waits` seconds there. */
typedef struct { double from, to, begins, lasts, waits; } leg;

/* The screen before a lane, if there is one. */
static const track_screen *screen_before(lt_rng *r, int lane, const track_screen *screen)
{
    const int any = (int)lt_rng_below(r, TRACK_SCREENS);

    for (int i = 0; i < TRACK_SCREENS; i++)
        if (screen[(any + i) % TRACK_SCREENS].lane <= lane)
            return &screen[(any + i) % TRACK_SCREENS];
    return NULL;
}

static leg draw_leg(lt_rng *r, int lane, const track_screen *screen, track_act act, double from, double begins)
{
    const double pace = lt_rng_range(r, PACE[0], PACE[1]), far = lt_rng_range(r, 0.3, 0.8);
    const double wait = lt_rng_uniform(r), side = lt_rng_below(r, 2) ? 1 : -1;
    const track_screen *before = screen_before(r, lane, screen);
    leg l = { .from = from, .to = from > 0 ? -far : far, .begins = begins };

    if (act == TRACK_HIDE && before) {
        l.to = before->middle;
        l.waits = 0.5 + 2 * wait;
    } else if (act == TRACK_LEAVE && fabs(from) < 1) {
        l.to = side * GONE;
        l.waits = 0.7 + 1.5 * wait;
    } else if (act == TRACK_STAND && fabs(from) < 1) {
        l.to = from;
        l.waits = 0.4 + wait;
    }
    l.lasts = fmax(0.1, fabs(l.to - from) / pace);
    return l;
}

/* It starts and stops gently. */
static track_point on_leg(const leg *l, double time)
{
    const double s = fmin(1, (time - l->begins) / l->lasts), far = l->to - l->from;

    return (track_point){ l->from + far * s * s * (3 - 2 * s), s < 1 ? far * 6 * s * (1 - s) / l->lasts : 0 };
}

void track_path_draw(lt_rng *r, int lane, const track_screen screen[TRACK_SCREENS], track_act first, const double *time,
                     int n, track_point *out)
{
    static const track_act deal[] = { TRACK_CROSS, TRACK_CROSS, TRACK_HIDE, TRACK_HIDE, TRACK_LEAVE, TRACK_STAND };
    const double start = lt_rng_range(r, -0.8, 0.8);
    leg l = draw_leg(r, lane, screen, first, start, 0);

    for (int k = 0; k < n; k++) {
        while (time[k] > l.begins + l.lasts + l.waits) {
            const track_act next = deal[lt_rng_below(r, LT_COUNT(deal))];
            l = draw_leg(r, lane, screen, next, l.to, l.begins + l.lasts + l.waits);
        }
        out[k] = on_leg(&l, time[k]);
    }
}
