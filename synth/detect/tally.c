/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/detect/tally.h"

#include "libtensor/base/order.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double SMALL = 16, LARGE = 48;     /* COCO's 32 and 96 at twice the size */

lt_status detect_tally_add(detect_tally *t, const detect_sight *sight, int n)
{
    for (int i = 0; i < n; i++) {
        detect_sight *longer = lt_arena_grow(t->arena, t->sight, (size_t)t->n, &t->room, sizeof(*longer));

        if (!longer)
            return lt_error(LT_ENOMEM, "synth: no memory for the figures of %lld things", (long long)t->n + 1);
        t->sight = longer;
        t->sight[t->n++] = sight[i];
    }
    t->pictures++;
    t->empty += n == 0;
    return LT_OK;
}

/* ---- what is counted ---- */

typedef bool (*rule)(const detect_sight *s);

static bool is_hand(const detect_sight *s) { return s->kind == SYNTH_HAND_THING; }
static bool is_object(const detect_sight *s) { return s->kind > SYNTH_HAND_THING; }
static bool is_bare(const detect_sight *s) { return s->bare; }
static bool is_left(const detect_sight *s) { return s->left; }
static bool is_any(const detect_sight *s) { return s->kind >= 0; }
static bool is_small(const detect_sight *s) { return s->side < SMALL; }
static bool is_medium(const detect_sight *s) { return s->side >= SMALL && s->side <= LARGE; }
static bool is_large(const detect_sight *s) { return s->side > LARGE; }
static bool is_hidden(const detect_sight *s) { return s->visible < 0.5; }
static bool is_cut(const detect_sight *s) { return s->cut; }

static double count(const detect_tally *t, rule of)
{
    int64_t n = 0;

    for (int64_t i = 0; i < t->n; i++)
        n += of(&t->sight[i]);
    return (double)n;
}

static double share(const detect_tally *t, rule of, rule among)
{
    int64_t n = 0, all = 0;

    for (int64_t i = 0; i < t->n; i++)
        if (among(&t->sight[i])) {
            all++;
            n += of(&t->sight[i]);
        }
    return all ? (double)n / (double)all : NAN;
}

static double mean_visible(const detect_tally *t)
{
    double sum = 0;

    for (int64_t i = 0; i < t->n; i++)
        sum += t->sight[i].visible;
    return t->n ? sum / (double)t->n : NAN;
}

/* Of the rarest class, in a thousand pictures. */
static double rarest(const detect_tally *t)
{
    int64_t n[SYNTH_CLASSES] = { 0 }, least = INT64_MAX;

    for (int64_t i = 0; i < t->n; i++)
        n[t->sight[i].kind]++;
    for (int k = 0; k < SYNTH_CLASSES; k++)
        least = lt_min_i64(least, n[k]);
    return t->pictures ? 1000.0 * (double)least / (double)t->pictures : NAN;
}

/* The sides below which 10, 50 and 90 % are. */
static void percentiles(const detect_tally *t, rule of, double *scratch, double out[3])
{
    size_t n = 0;

    for (int64_t i = 0; i < t->n; i++)
        if (of(&t->sight[i]))
            scratch[n++] = t->sight[i].side;
    qsort(scratch, n, sizeof(*scratch), lt_ascending);
    for (int k = 0; k < 3; k++)
        out[k] = n ? scratch[(n - 1) * (size_t)(1 + 4 * k) / 10] : NAN;
}

lt_status detect_tally_figures(const detect_tally *t, synth_figure out[DETECT_FIGURES])
{
    const double pictures = t->pictures ? (double)t->pictures : NAN;
    double *scratch = malloc(sizeof(*scratch) * (size_t)lt_max_i64(1, t->n)), hand[3], object[3];

    if (!scratch)
        return lt_error(LT_ENOMEM, "synth: no memory for the figures");
    percentiles(t, is_hand, scratch, hand);
    percentiles(t, is_object, scratch, object);
    free(scratch);
    const synth_figure all[DETECT_FIGURES] = {
        { "things an image, mean", (double)t->n / pictures, 3, 6 },
        { "images with no thing", (double)t->empty / pictures, 0.03, 0.07 },
        { "hands an image, mean", count(t, is_hand) / pictures, 1, 2 },
        { "bare hands", share(t, is_bare, is_hand), 0.4, 0.6 },
        { "left hands", share(t, is_left, is_hand), 0.4, 0.6 },
        { "side of a hand, 10 %, pixels", hand[0], 10, 18 },
        { "side of a hand, median, pixels", hand[1], 28, 45 },
        { "side of a hand, 90 %, pixels", hand[2], 75, 130 },
        { "side of an object, 10 %, pixels", object[0], 12, 20 },
        { "side of an object, median, pixels", object[1], 30, 50 },
        { "side of an object, 90 %, pixels", object[2], 80, 140 },
        { "small, share", share(t, is_small, is_any), 0.10, 0.25 },
        { "medium, share", share(t, is_medium, is_any), 0.40, 0.60 },
        { "large, share", share(t, is_large, is_any), 0.25, 0.45 },
        { "visible, mean share", mean_visible(t), 0.72, 0.85 },
        { "less than half visible", share(t, is_hidden, is_any), 0.12, 0.22 },
        { "cut off by the border", share(t, is_cut, is_any), 0.08, 0.15 },
        { "instances of the rarest class, in 1,000 images", rarest(t), 60, INFINITY },
    };
    memcpy(out, all, sizeof(all));
    return LT_OK;
}
