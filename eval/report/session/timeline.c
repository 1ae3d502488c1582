/* SPDX-License-Identifier: Apache-2.0 */
/* When something was so, as rows of bars over one axis of time. */
#include "eval/report/session/internal.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 900, HEIGHT = 16, LETTER = 6, MOST_PERSONS = 12, MOST_CLASSES = 40, MOST_OF_CLASS = 12 };

/* Light ones, for dark words to stand on */
static const char *const colors[] = {
    "#93c5fd", "#fdba74", "#86efac", "#f9a8d4", "#c4b5fd", "#fde047", "#67e8f9", "#fca5a5", "#bef264", "#d6bfa6",
};

/* The same word has the same colour: actions one each, other words by their letters. */
static const char *color_of(const char *label)
{
    unsigned sum = 0;

    for (unsigned i = 0; i < ACTION_CLASSES; i++)
        if (strcmp(label, action_classes[i]) == 0)
            return colors[i % LT_COUNT(colors)];
    for (; *label; label++)
        sum = 31 * sum + (unsigned char)*label;
    return colors[sum % LT_COUNT(colors)];
}

static double length_of(const history *h)
{
    return h->n && h->time[h->n - 1] > 0 ? h->time[h->n - 1] : 1;
}

static double across(const history *h, double time)
{
    return WIDTH * fmax(0, fmin(1, time / length_of(h)));
}

static void put_span(FILE *f, const history *h, const lane_span *s)
{
    const double x = across(h, s->from), w = fmax(1.5, across(h, s->to) - x);

    fprintf(f, "<rect x=%.1f y=1 width=%.1f height=%d style=\"fill:%s;opacity:%s\"><title>", x, w, HEIGHT - 2,
            color_of(s->label), s->pale ? "0.4" : "1");
    html_text(f, s->label);
    fprintf(f, " %.2f to %.2f s</title></rect>", s->from, s->to);
    if (w < LETTER * (double)strlen(s->label) + 4)
        return;
    fprintf(f, "<text x=%.1f y=%d>", x + 3, HEIGHT - 5);
    html_text(f, s->label);
    fputs("</text>", f);
}

/* After the row's name */
static void put_bars(FILE *f, const history *h, const lane *l)
{
    fprintf(f, "</span><svg viewBox=\"0 0 %d %d\" width=%d height=%d>", WIDTH, HEIGHT, WIDTH, HEIGHT);
    for (int i = 0; i < l->n; i++)
        put_span(f, h, &l->span[i]);
    fputs("</svg></div>\n", f);
}

/* Ticks at 1, 2 or 5 times a power of ten, some ten of them */
static void put_axis(FILE *f, const history *h)
{
    const double length = length_of(h), power = pow(10, floor(log10(length / 10))), rest = length / 10 / power;
    const double step = power * (rest < 1.5 ? 1 : rest < 3.5 ? 2 : rest < 7.5 ? 5 : 10);

    fprintf(f, "<div class=row><span>seconds</span><svg viewBox=\"0 0 %d %d\" width=%d height=%d>", WIDTH, HEIGHT,
            WIDTH, HEIGHT);
    for (int i = 0; i * step <= length; i++)
        fprintf(f, "<path class=a d=\"M%.1f 0v4\"/><text x=%.1f y=14>%.4g</text>", across(h, i * step),
                across(h, i * step), i * step);
    fputs("</svg></div>\n", f);
}

/* ---- persons ---- */

static void put_person_row(FILE *f, const history *h, const lane *l)
{
    static const char *const names[] = {
        [LANE_ACTION] = "action", [LANE_TRUE_ACTION] = "action, truth", [LANE_INTERACTION] = "interaction",
        [LANE_TRUE_INTERACTION] = "interaction, truth", [LANE_CONTACT] = "contact",
    };

    fprintf(f, "<div class=row><span>%s%s%s", names[l->kind], *l->cls ? ", " : "", l->cls);
    put_bars(f, h, l);
}

static bool is_true(const lane *l)
{
    return l->kind == LANE_TRUE_ACTION || l->kind == LANE_TRUE_INTERACTION;
}

/* Whose row it is among persons; -1: nobody's. 0: of somebody who was not seen */
static int64_t person_of(const lane *l)
{
    return l->kind > LANE_CONTACT ? -1 : is_true(l) ? l->beside : l->id;
}

static void put_person(FILE *f, const history *h, int64_t id)
{
    if (id)
        fprintf(f, "<h3>Person %" PRId64 "</h3>\n", id);
    else
        fputs("<h3>Of nobody that is known</h3>\n", f);
    for (int kind = 0; kind <= LANE_CONTACT; kind++)
        for (int i = 0; i < h->n_lanes; i++)
            if (h->lane[i].kind == (lane_kind)kind && person_of(&h->lane[i]) == id)
                put_person_row(f, h, &h->lane[i]);
}

static int by_number(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;

    return (x > y) - (x < y);
}

/* The first MOST_PERSONS that did something, in the order of their numbers; how many. *nobody: so did somebody else */
static int list_persons(const history *h, int64_t met[MOST_PERSONS], bool *nobody)
{
    int n = 0;

    *nobody = false;
    for (int i = 0; i < h->n_lanes; i++) {
        const int64_t id = person_of(&h->lane[i]);
        bool known = id <= 0;

        *nobody = *nobody || id == 0;
        for (int k = 0; k < n; k++)
            known = known || met[k] == id;
        if (!known && n < MOST_PERSONS)
            met[n++] = id;
    }
    qsort(met, (size_t)n, sizeof(*met), by_number);
    return n;
}

static void put_persons(FILE *f, const history *h)
{
    int64_t met[MOST_PERSONS];
    bool nobody;
    const int n = list_persons(h, met, &nobody);

    fputs("<h2>Who did what</h2>\n", f);
    if (!n && !nobody) {
        fputs("<p>Nobody was seen to do anything.</p>\n", f);
        return;
    }
    for (int i = 0; i < n; i++)
        put_person(f, h, met[i]);
    if (nobody)
        put_person(f, h, 0);
    put_axis(f, h);
    if (n == MOST_PERSONS)
        fprintf(f, "<p>Of persons the first %d are shown.</p>\n", MOST_PERSONS);
}

/* ---- things ---- */

static void put_thing_row(FILE *f, const history *h, const lane *l)
{
    fputs("<div class=row><span>", f);
    html_text(f, l->cls);
    fprintf(f, "%s #%" PRId64, l->kind == LANE_HAND ? " hand" : "", l->id);
    put_bars(f, h, l);
}

static void put_followed(FILE *f, const history *h)
{
    int n = 0;

    fputs("<h2>Hands and objects, followed in space</h2>\n", f);
    for (int kind = LANE_HAND; kind <= LANE_OBJECT; kind++)
        for (int i = 0; i < h->n_lanes; i++)
            if (h->lane[i].kind == (lane_kind)kind && n++ < MOST_CLASSES)
                put_thing_row(f, h, &h->lane[i]);
    if (!n)
        fputs("<p>None was.</p>\n", f);
    else
        put_axis(f, h);
    if (n > MOST_CLASSES)
        fprintf(f, "<p>And %d more.</p>\n", n - MOST_CLASSES);
}

/* ---- tracks ---- */

static double seconds_of(const lane *l)
{
    double sum = 0;

    for (int i = 0; i < l->n; i++)
        sum += l->span[i].to - l->span[i].from;
    return sum;
}

/* Whether fewer than `most` tracks of its class were seen for longer; of equals the first ones */
static bool is_among_longest(const history *h, const lane *l, int most)
{
    const double seconds = seconds_of(l);
    int longer = 0;

    for (int i = 0; i < h->n_lanes; i++) {
        const lane *other = &h->lane[i];
        const double s = other->kind == LANE_TRACK && strcmp(other->cls, l->cls) == 0 ? seconds_of(other) : -1;

        longer += s > seconds || (s == seconds && other < l);
    }
    return longer < most;
}

static void put_class(FILE *f, const history *h, const char *cls)
{
    int n = 0;

    for (int i = 0; i < h->n_lanes; i++) {
        const lane *l = &h->lane[i];

        if (l->kind != LANE_TRACK || strcmp(l->cls, cls) != 0)
            continue;
        n++;
        if (is_among_longest(h, l, MOST_OF_CLASS))
            put_thing_row(f, h, l);
    }
    if (n > MOST_OF_CLASS)
        fprintf(f, "<p>%d numbers of this class; the %d that were seen for longest are shown.</p>\n", n, MOST_OF_CLASS);
}

static void put_tracks(FILE *f, const history *h)
{
    const char *met[MOST_CLASSES];
    int n = 0;

    fputs("<h2>Tracks</h2>\n<p>One number each, while it was seen by any camera.</p>\n", f);
    for (int i = 0; i < h->n_lanes; i++) {
        bool known = h->lane[i].kind != LANE_TRACK;

        for (int k = 0; k < n; k++)
            known = known || strcmp(met[k], h->lane[i].cls) == 0;
        if (known || n == MOST_CLASSES)
            continue;
        met[n++] = h->lane[i].cls;
        put_class(f, h, h->lane[i].cls);
    }
    put_axis(f, h);
    if (h->lanes_left_out)
        fprintf(f, "<p>More than %d rows: those that came last are left out.</p>\n", SESSION_MOST_LANES);
}

void timeline_put(FILE *f, const history *h)
{
    put_persons(f, h);
    put_followed(f, h);
    put_tracks(f, h);
}
