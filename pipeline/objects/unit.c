/* SPDX-License-Identifier: Apache-2.0 */
/* Units and axes of a model, by what would make it the object that it should be. */
#include "pipeline/objects/mesh.h"

#include <math.h>
#include <string.h>

static const double NEARLY = 1.25;              /* a factor */
static const double SMALLEST = 0.005, LARGEST = 2, SMALLEST_MM = 10, LARGEST_MM = 1000;
static const double SIDE = 0.1, SIDE_M = 0.005, CENTRE_M = 0.005, MOVED = 0.015;    /* a share; metres */

static bool is_about(double x, double wanted)
{
    return x > wanted / NEARLY && x < wanted * NEARLY;
}

static object_unit unit_of_known(double ratio)
{
    static const struct { double per_metre; const char *name; } unit[] = {
        { 1000, "millimetres" }, { 100, "centimetres" }, { 39.37, "inches" }, { 0.001, "kilometres" },
    };

    for (size_t i = 0; i < LT_COUNT(unit); i++)
        if (is_about(ratio, unit[i].per_metre))
            return (object_unit){ 1 / unit[i].per_metre, unit[i].name };
    return (object_unit){ ratio > 0.2 && ratio < 5 ? 1 : 0, NULL };     /* another object, or none */
}

object_unit object_unit_of(double longest, double known)
{
    if (known > 0)
        return unit_of_known(longest / known);
    if (longest >= SMALLEST && longest <= LARGEST)
        return (object_unit){ 1, NULL };
    if (longest >= SMALLEST_MM && longest <= LARGEST_MM)
        return (object_unit){ 0.001, "millimetres" };
    return (object_unit){ 0, NULL };
}

/* ---- axes ------------------------------------------------------------------------------------------------ */

static double signed_axis(const double v[3], int axis)
{
    return axis < 0 ? -v[-axis - 1] : v[axis - 1];
}

static bool sides_fit(const int turn[3], const double size[3], const double known_size[3])
{
    for (int i = 0; i < 3; i++) {
        const double side = fabs(signed_axis(known_size, turn[i]));

        if (fabs(size[i] - side) > fmax(SIDE * side, SIDE_M))
            return false;
    }
    return true;
}

/* How far the centre is from where that turn would have it; metres, along the worst axis. */
static double centre_error(const int turn[3], const double centre[3], const double known_centre[3])
{
    double worst = 0;

    for (int i = 0; i < 3; i++)
        worst = fmax(worst, fabs(centre[i] - signed_axis(known_centre, turn[i])));
    return worst;
}

/* A mirror image is no turn. */
static bool is_rotation(const int turn[3])
{
    const int a = turn[0] < 0 ? -turn[0] : turn[0], b = turn[1] < 0 ? -turn[1] : turn[1];
    const int signs = (turn[0] < 0) + (turn[1] < 0) + (turn[2] < 0);
    const bool even = (a == 1 && b == 2) || (a == 2 && b == 3) || (a == 3 && b == 1);

    return even == (signs % 2 == 0);
}

/* The k-th of 48 ways to name the axes, of which the first changes nothing */
static void name_axes(int k, int turn[3])
{
    static const int order[6][3] = { { 1, 2, 3 }, { 1, 3, 2 }, { 2, 1, 3 }, { 2, 3, 1 }, { 3, 1, 2 }, { 3, 2, 1 } };

    for (int i = 0; i < 3; i++)
        turn[i] = k % 8 & 1 << i ? -order[k / 8][i] : order[k / 8][i];
}

/* The same axes end the search where they fit. */
bool object_turn_of(const double size[3], const double centre[3], const double known_size[3],
                    const double known_centre[3], int turn[3])
{
    double best = INFINITY;

    for (int k = 0; k < 6 * 8; k++) {
        int way[3];
        double error;

        name_axes(k, way);
        if (!is_rotation(way) || !sides_fit(way, size, known_size))
            continue;
        error = fmin(centre_error(way, centre, known_centre), MOVED);
        if (error < best) {
            best = error;
            memcpy(turn, way, sizeof(way));
        }
        if (k == 0 && error < CENTRE_M)
            break;
    }
    return best < INFINITY;
}
