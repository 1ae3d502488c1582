/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Slips in points. All that a hypothesis needs of the samples are sums: with centred points p found and g wanted, the
 * squared distance under order o, axes Q and scale s is  sum_j s^2 |p_o(j)|^2 + |g_j|^2 - 2 s g_j . Q p_o(j),  so that
 * some five hundred hypotheses cost no more than a look at each sample.
 */
#include "data/slip.h"

#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/mat3.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { J = LT_HAND_KEYPOINTS, AXES = 48, OTHER_ORDERS = 5, ORDERS = 1 + 2 * OTHER_ORDERS };

/* A slip has to make the distance at most half of what it is: less is an estimator's chance. */
static const double WORTH = 2;

/* Hands are of a size within this factor. */
static const double ALIKE = 1.5;

/* ---- orders ---- */

/* simple[i] = joint[from[i]] */
typedef struct { const char *words; int from[J]; } joint_order;

static const joint_order orders[1 + OTHER_ORDERS] = {
    { "are ordered from thumb to little finger, not as MANO has them",
      { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20 } },
    { "are in MANO's order (index, middle, little, ring, thumb; tips last)",
      { 0, 13, 14, 15, 16, 1, 2, 3, 17, 4, 5, 6, 18, 10, 11, 12, 19, 7, 8, 9, 20 } },
    { "are ordered from the tips down, the wrist last, as InterHand has them",
      { 20, 3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12, 19, 18, 17, 16 } },
    { "are ordered from the tips down, behind the wrist, as RHD has them",
      { 0, 4, 3, 2, 1, 8, 7, 6, 5, 12, 11, 10, 9, 16, 15, 14, 13, 20, 19, 18, 17 } },
    { "are ordered with the knuckles first, as F-PHAB and HANDS have them",
      { 0, 1, 6, 7, 8, 2, 9, 10, 11, 3, 12, 13, 14, 4, 15, 16, 17, 5, 18, 19, 20 } },
    { "are ordered from little finger to thumb",
      { 0, 17, 18, 19, 20, 13, 14, 15, 16, 9, 10, 11, 12, 5, 6, 7, 8, 1, 2, 3, 4 } },
};

/* What a reader that expects order `read` makes of joints in order `is`, turned back: simple[i] = joint[out[i]] of what
 * was read. */
static void turned_order(const joint_order *read, const joint_order *is, int out[J])
{
    int place[J];

    for (int i = 0; i < J; i++)
        place[read->from[i]] = i;
    for (int i = 0; i < J; i++)
        out[i] = place[is->from[i]];
}

/* Number 0 is none; then readers of simple order, whose joints are in each other one, and readers of MANO's. */
static const char *order_of(int number, int out[J])
{
    const int reader = number ? (number - 1) / OTHER_ORDERS : 0, at = number ? (number - 1) % OTHER_ORDERS + 1 : 0;
    const int is = reader && at <= 1 ? 0 : at;          /* not MANO's own, but simple order */

    turned_order(&orders[reader], &orders[is], out);
    return orders[is].words;
}

/* ---- axes ---- */

/* Axis a of what is wanted is sign[a] times axis from[a] of what was found. */
typedef struct { int from[3], sign[3]; } turn;

/* All 48; number 0 is none. */
static turn turn_of(int number)
{
    static const int from[6][3] = { { 0, 1, 2 }, { 0, 2, 1 }, { 1, 0, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 2, 1, 0 } };
    turn t;

    for (int a = 0; a < 3; a++) {
        t.from[a] = from[number / 8][a];
        t.sign[a] = number & 1 << a ? -1 : 1;
    }
    return t;
}

/* The trace of Q C^T for C = sum g p^T. */
static double agreement(const turn *t, const double C[9])
{
    double sum = 0;

    for (int a = 0; a < 3; a++)
        sum += t->sign[a] * C[3 * a + t->from[a]];
    return sum;
}

/* ---- words ---- */

typedef struct { slip *s; const char *what; int parts; } sentence;

static void say(sentence *w, const char *code, const char *fmt, ...) LT_PRINTF(3, 4);

static void say(sentence *w, const char *code, const char *fmt, ...)
{
    const size_t n = strlen(w->s->text);
    char part[SLIP_TEXT];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(part, sizeof(part), fmt, ap);
    va_end(ap);
    snprintf(w->s->text + n, SLIP_TEXT - n, "%s %s", w->parts ? ", and" : w->what, part);
    if (!w->parts++)
        w->s->code = code;
}

static char axis_letter(int axis)
{
    return "xyz"[axis];
}

/* In the file's own axes, which the reader may have turned. */
static void say_axes(sentence *w, const char *verb, const turn *t, bool opengl)
{
    const int file[3] = { 1, opengl ? -1 : 1, opengl ? -1 : 1 };
    char want[3][3];

    if (t->from[0] == 0 && t->from[1] == 1 && t->sign[0] > 0 && t->sign[1] < 0 && t->sign[2] < 0) {
        say(w, "axes", "%s %s", verb, opengl ? "OpenCV's axes (y down, z forward), not OpenGL's"
                                             : "OpenGL's axes (y up, z backward), not OpenCV's");
        return;
    }
    for (int a = 0; a < 3; a++)
        snprintf(want[a], sizeof(want[a]), "%s%c", t->sign[a] * file[a] * file[t->from[a]] < 0 ? "-" : "",
                 axis_letter(t->from[a]));
    say(w, "axes", "%s other axes: (%s, %s, %s) in the place of (x, y, z) would fit", verb, want[0], want[1], want[2]);
}

/* ---- sums ---- */

typedef struct {
    const slip_points *p;
    bool ordered;                           /* 21 points: other orders are tried */
    int power;                              /* of ten, that brings most hands to size */
    double ratio;                           /* median size of what was found, in those of what is wanted */
    int64_t used;
    double (*C)[J][9];                      /* (J, J) of ordered points, else C[0][0] of all: sums of g_j p_i^T */
    double found[J], wanted[J];             /* squares; of unordered points the first alone */
    double place_C[9], place_found, place_wanted;       /* of where the hands are */
} sums;

static void middle(const float *x, int points, double out[3])
{
    out[0] = out[1] = out[2] = 0;
    for (int i = 0; i < 3 * points; i++)
        out[i % 3] += (double)x[i] / points;
}

/* Root mean square distance of the points from their middle; NaN where they are not finite. */
static double size_of(const float *x, int points, const double m[3])
{
    double sum = 0;

    for (int i = 0; i < 3 * points; i++)
        sum += (x[i] - m[i % 3]) * (x[i] - m[i % 3]);
    return sqrt(sum / points);
}

static double ratio_of(const slip_points *p, int64_t i)
{
    const float *f = p->found + 3 * i * p->points, *g = p->wanted + 3 * i * p->points;
    double mf[3], mg[3], size;

    middle(f, p->points, mf);
    middle(g, p->points, mg);
    size = size_of(g, p->points, mg);
    return size > 0 ? size_of(f, p->points, mf) / size : 0;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return x < y ? -1 : x > y;
}

/* The median of the ratios that say something; 0: none does. */
static double median_ratio(const slip_points *p)
{
    double *r = malloc((size_t)p->n * sizeof(*r)), median;
    int64_t n = 0;

    for (int64_t i = 0; r && i < p->n; i++) {
        r[n] = ratio_of(p, i);
        n += isfinite(r[n]) && r[n] > 0;
    }
    if (r)
        qsort(r, (size_t)n, sizeof(*r), by_value);
    median = n ? r[n / 2] : 0;
    free(r);
    return median;
}

static void add_product(const double g[3], const double p[3], double C[9])
{
    for (int i = 0; i < 9; i++)
        C[i] += g[i / 3] * p[i % 3];
}

static void add_sample(sums *s, const float *f, const float *g)
{
    const int points = s->p->points;
    double mf[3], mg[3];

    middle(f, points, mf);
    middle(g, points, mg);
    for (int j = 0; j < points; j++) {
        const int k = s->ordered ? j : 0;
        const double q[3] = { g[3 * j] - mg[0], g[3 * j + 1] - mg[1], g[3 * j + 2] - mg[2] };
        const double r[3] = { f[3 * j] - mf[0], f[3 * j + 1] - mf[1], f[3 * j + 2] - mf[2] };
        s->wanted[k] += lt_vec3_dot(q, q);
        s->found[k] += lt_vec3_dot(r, r);
        for (int i = 0; s->ordered && i < J; i++) {
            const double o[3] = { f[3 * i] - mf[0], f[3 * i + 1] - mf[1], f[3 * i + 2] - mf[2] };
            add_product(q, o, s->C[j][i]);
        }
        if (!s->ordered)
            add_product(q, r, s->C[0][0]);
    }
    s->used++;
}

/* Whether a sample is of a size that others are of: what is not finite, or was lost, is not. */
static bool counts(const sums *s, int64_t i)
{
    const double r = ratio_of(s->p, i) / s->ratio;

    return r > 1.0 / 3 && r < 3;
}

static void add_up(sums *s)
{
    const slip_points *p = s->p;

    s->ratio = median_ratio(p);
    if (!(s->ratio > 0))
        return;
    s->power = slip_unit(s->ratio, 1 / ALIKE, ALIKE);
    for (int64_t i = 0; i < p->n; i++)
        if (counts(s, i))
            add_sample(s, p->found + 3 * i * p->points, p->wanted + 3 * i * p->points);
}

/* A hand is where its wrist is, which the order tells; a mesh, where its middle is. */
static void add_up_places(sums *s, int wrist)
{
    const slip_points *p = s->p;

    for (int64_t i = 0; i < p->n; i++) {
        const float *f = p->found + 3 * i * p->points, *g = p->wanted + 3 * i * p->points;
        double mf[3], mg[3];
        if (!counts(s, i))
            continue;
        middle(s->ordered ? f + 3 * wrist : f, s->ordered ? 1 : p->points, mf);
        middle(g, s->ordered ? 1 : p->points, mg);
        add_product(mg, mf, s->place_C);
        s->place_found += lt_vec3_dot(mf, mf);
        s->place_wanted += lt_vec3_dot(mg, mg);
    }
}

/* ---- hypotheses ---- */

typedef struct { int order, axes; double scale, distance; } hypothesis;

/* Root mean square distance under a hypothesis. */
static double shape_distance(const sums *s, const hypothesis *h)
{
    const turn t = turn_of(h->axes);
    const int points = s->ordered ? J : 1;
    const double each = s->ordered ? J - (s->p->skip >= 0) : s->p->points;
    double sum = 0;
    int order[J];

    order_of(h->order, order);
    for (int j = 0; j < points; j++) {
        const int i = s->ordered ? order[j] : 0;
        if (s->ordered && j == s->p->skip)
            continue;
        sum += h->scale * h->scale * s->found[i] + s->wanted[j] - 2 * h->scale * agreement(&t, s->C[j][i]);
    }
    return sqrt(fmax(0, sum) / (each * (double)s->used));
}

static double place_distance(const sums *s, double scale, int axes)
{
    const turn t = turn_of(axes);
    const double sum = scale * scale * s->place_found + s->place_wanted - 2 * scale * agreement(&t, s->place_C);

    return sqrt(fmax(0, sum) / (double)s->used);
}

static double unit_of(const sums *s)
{
    return pow(10, s->power);
}

/* The best by shape; order and axes count where each of them halves the distance. */
static hypothesis best_shape(const sums *s)
{
    hypothesis best = { .scale = unit_of(s) };
    double least;

    best.distance = least = shape_distance(s, &best);
    for (int order = 0; order < (s->ordered ? ORDERS : 1); order++)
        for (int axes = 0; axes < AXES; axes++) {
            hypothesis h = { order, axes, unit_of(s), 0 };
            double cost;
            h.distance = shape_distance(s, &h);
            cost = h.distance * (order ? WORTH : 1) * (axes ? WORTH : 1);
            if (cost < least) {
                least = cost;
                best = h;
            }
        }
    return best;
}

static const double NEAR = 0.15;            /* metres that a hand's place may be off without a slip */

/* The power of ten and the axes that bring the hands nearest to their places; true: near enough to be meant. */
static bool best_place(const sums *s, const hypothesis *h, double as_is, int *power, int *axes)
{
    double least = fmin(NEAR, as_is / (WORTH * WORTH));
    bool found = false;

    for (int p = -3; p <= 3; p++)
        for (int a = 0; a < AXES; a++) {
            const double d = place_distance(s, h->scale * pow(10, p), a);
            if (d >= least)
                continue;
            least = d;
            found = true;
            *power = p;
            *axes = a;
        }
    return found;
}

/* Hands that fit, in a place that does not: counted from the wrist, or in a unit or axes of its own. */
static void explain_place(const sums *s, const hypothesis *h, sentence *w)
{
    const double away = sqrt(s->place_wanted / (double)s->used);
    const double found = h->scale * sqrt(s->place_found / (double)s->used);
    const double as_is = place_distance(s, h->scale, h->axes);
    int power, axes;

    if (as_is < NEAR)
        return;
    if (away > 2 * NEAR && found < NEAR) {
        say(w, "place", "are counted from the wrist or the hand's middle, not from the camera");
    } else if (best_place(s, h, as_is, &power, &axes)) {
        const turn t = turn_of(axes);
        if (power)
            say(w, "place", "are placed %g times as far away as they ought to be", pow(10, -power));
        if (axes != h->axes)
            say_axes(w, "are placed in", &t, s->p->file.opengl);
    }
}

static void put_in_words(sums *s, const hypothesis *h, slip *out)
{
    const double size = s->ratio * unit_of(s);
    const turn t = turn_of(h->axes);
    sentence w = { out, s->p->what, 0 };
    char unit[SLIP_UNIT];
    int order[J];

    if (s->power)
        say(&w, "unit", "are %s", slip_unit_words(s->power, s->p->file.millimetres, unit));
    if (h->axes)
        say_axes(&w, "have", &t, s->p->file.opengl);
    if (h->order)
        say(&w, "order", "%s", order_of(h->order, order));
    if (s->p->places) {
        order_of(h->order, order);
        add_up_places(s, order[0]);
        explain_place(s, h, &w);
    }
    if (!w.parts && (size > 2 || size < 0.5))
        say(&w, "size", "are those of hands of %.2g times the true size", size);
}

void slip_in_points(const slip_points *p, slip *out)
{
    sums s = { .p = p, .ordered = p->points == J };
    const hypothesis as_read = { .scale = 1 };
    hypothesis best;

    *out = (slip){ 0 };
    s.C = calloc(J, sizeof(*s.C));
    if (s.C)
        add_up(&s);
    if (s.used) {
        best = best_shape(&s);
        put_in_words(&s, &best, out);
        out->before = shape_distance(&s, &as_read);
        out->after = best.distance;
    }
    free(s.C);
}
