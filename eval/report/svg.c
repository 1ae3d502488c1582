/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/report/internal.h"

#include "libtensor/base/common.h"

#include <math.h>

enum { WIDTH = 360, HEIGHT = 170, LEFT = 52, RIGHT = 8, TOP = 22, BOTTOM = 26, LEGEND = 14 };
enum { MOST_POINTS = 160, BINS = 24 };

/* Where a value stands along an axis from `from` to `to` pixels */
typedef struct {
    double lo, hi, from, to;
    bool log;
} axis;

static double place(const axis *a, double x)
{
    const double lo = a->log ? log(a->lo) : a->lo, hi = a->log ? log(a->hi) : a->hi, at = a->log ? log(x) : x;

    return hi > lo ? a->from + (at - lo) / (hi - lo) * (a->to - a->from) : (a->from + a->to) / 2;
}

/* below: pixels under the diagram */
static void open_svg(FILE *f, const char *name, int below)
{
    fprintf(f, "<svg viewBox=\"0 0 %d %d\" width=%d height=%d role=img><text class=t x=%d y=14>", WIDTH, HEIGHT + below,
            WIDTH, HEIGHT + below, LEFT);
    html_text(f, name);
    fputs("</text>\n", f);
}

static void label(FILE *f, double x, double y, const char *anchor, double value, const char *unit)
{
    fprintf(f, "<text x=%.1f y=%.1f text-anchor=%s>%.4g%s</text>\n", x, y, anchor, value, unit);
}

/* A frame with the ends of both axes */
static void draw_axes(FILE *f, const axis *x, const axis *y, const char *x_name)
{
    fprintf(f, "<path class=a d=\"M%d %dV%dH%d\"/>\n", LEFT, TOP, HEIGHT - BOTTOM, WIDTH - RIGHT);
    label(f, LEFT - 4, HEIGHT - BOTTOM, "end", y->lo, "");
    label(f, LEFT - 4, TOP + 8, "end", y->hi, "");
    label(f, LEFT, HEIGHT - BOTTOM + 14, "start", x->lo, "");
    label(f, WIDTH - RIGHT, HEIGHT - BOTTOM + 14, "end", x->hi, "");
    fprintf(f, "<text x=%d y=%d text-anchor=middle>", (LEFT + WIDTH - RIGHT) / 2, HEIGHT - BOTTOM + 14);
    html_text(f, x_name);
    fputs("</text>\n", f);
}

static void range(const double *v, int n, double *lo, double *hi)
{
    *lo = *hi = n ? v[0] : 0;
    for (int i = 1; i < n; i++) {
        *lo = fmin(*lo, v[i]);
        *hi = fmax(*hi, v[i]);
    }
}

/* The mean of a run of points: from is the first, n how many */
static void mean_of(const report_series *s, int from, int n, double *x, double *y)
{
    *x = *y = 0;
    for (int i = from; i < from + n; i++) {
        *x += s->x[i] / n;
        *y += s->y[i] / n;
    }
}

static void draw_points(FILE *f, const report_series *s, const axis *ax, const axis *ay, bool dots)
{
    const int each = (s->n + MOST_POINTS - 1) / MOST_POINTS;

    for (int i = 0; i < s->n; i += each) {
        double x, y;

        mean_of(s, i, i + each < s->n ? each : s->n - i, &x, &y);
        if (dots)
            fprintf(f, "<circle cx=%.1f cy=%.1f r=4><title>%.0f: %.6g</title></circle>\n", place(ax, x), place(ay, y),
                    x, y);
        else
            fprintf(f, "%s%.1f %.1f", i ? "L" : "M", place(ax, x), place(ay, y));
    }
}

void svg_curve(FILE *f, const report_series *s, const char *x_name)
{
    axis x = { .from = LEFT, .to = WIDTH - RIGHT }, y = { .from = HEIGHT - BOTTOM, .to = TOP };

    range(s->x, s->n, &x.lo, &x.hi);
    range(s->y, s->n, &y.lo, &y.hi);
    y.log = y.lo > 0 && y.hi > 50 * y.lo;
    open_svg(f, s->name, 0);
    draw_axes(f, &x, &y, x_name);
    fputs("<path class=c d=\"", f);
    draw_points(f, s, &x, &y, false);
    fputs("\"/>\n", f);
    draw_points(f, s, &x, &y, true);
    fputs("</svg>\n", f);
}

/* Two in a row, below the diagram */
static void put_legend(FILE *f, const report_series *s, int n, const char *const *color)
{
    for (int i = 0; i < n; i++) {
        const int x = LEFT + i % 2 * (WIDTH - LEFT) / 2, y = HEIGHT + LEGEND / 2 + LEGEND * (i / 2);

        fprintf(f, "<path style=\"stroke:%s;stroke-width:3\" d=\"M%d %dh12\"/><text x=%d y=%d>", color[i], x, y - 3,
                x + 16, y);
        html_text(f, s[i].name);
        fputs("</text>\n", f);
    }
}

void svg_shares(FILE *f, const char *name, const report_series *s, int n, const char *x_name, const char *y_name)
{
    static const char *const color[] = { "#c2410c", "#1d4ed8", "#15803d", "#222", "#7e22ce", "#0e7490", "#a16207",
                                         "#be185d" };
    const axis x = { 0, 1, LEFT, WIDTH - RIGHT, false }, y = { 0, 1, HEIGHT - BOTTOM, TOP, false };

    n = n < (int)LT_COUNT(color) ? n : (int)LT_COUNT(color);
    open_svg(f, name, LEGEND * ((n + 1) / 2));
    draw_axes(f, &x, &y, x_name);
    fprintf(f, "<text x=%d y=%d text-anchor=middle transform=\"rotate(-90 %d %d)\">", LEFT - 12,
            (TOP + HEIGHT - BOTTOM) / 2, LEFT - 12, (TOP + HEIGHT - BOTTOM) / 2);
    html_text(f, y_name);
    fputs("</text>\n", f);
    for (int i = 0; i < n; i++) {
        fprintf(f, "<path class=c style=\"stroke:%s\" d=\"", color[i]);
        draw_points(f, &s[i], &x, &y, false);
        fputs("\"/>\n", f);
    }
    put_legend(f, s, n, color);
    fputs("</svg>\n", f);
}

void svg_histogram(FILE *f, const char *name, const double *value, int n, const char *unit)
{
    double lo, hi, most = 1;
    int count[BINS] = { 0 };
    axis x = { .from = LEFT, .to = WIDTH - RIGHT }, y = { .from = HEIGHT - BOTTOM, .to = TOP };

    range(value, n, &lo, &hi);
    for (int i = 0; i < n; i++) {
        const int bin = hi > lo ? (int)((value[i] - lo) / (hi - lo) * BINS) : 0;

        count[bin < BINS ? bin : BINS - 1]++;
    }
    for (int i = 0; i < BINS; i++)
        most = fmax(most, count[i]);
    x.lo = lo;
    x.hi = hi;
    y.hi = most;
    open_svg(f, name, 0);
    draw_axes(f, &x, &y, unit);
    for (int i = 0; i < BINS; i++) {
        const double w = (x.to - x.from) / BINS, top = place(&y, count[i]);

        fprintf(f, "<rect x=%.1f y=%.1f width=%.1f height=%.1f><title>%.4g to %.4g: %d</title></rect>\n",
                x.from + i * w, top, w - 1, y.from - top, lo + (hi - lo) * i / BINS, lo + (hi - lo) * (i + 1) / BINS,
                count[i]);
    }
    fputs("</svg>\n", f);
}
