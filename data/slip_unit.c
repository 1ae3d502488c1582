/* SPDX-License-Identifier: Apache-2.0 */
/* Slips in units: which one a size is in, and how that is said. */
#include "data/slip.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

int slip_unit(double size, double lo, double hi)
{
    const double middle = sqrt(lo * hi);
    int best = 0;

    if (!(size > 0) || (size >= lo && size <= hi))
        return 0;
    for (int power = -6; power <= 6; power++) {
        const double s = size * pow(10, power);
        const bool fits = s >= lo && s <= hi;
        if (fits && (!best || fabs(log(s / middle)) < fabs(log(size * pow(10, best) / middle))))
            best = power;
    }
    return best;
}

const char *slip_unit_words(int power, bool millimetres, char out[SLIP_UNIT])
{
    static const char *const name[] = { "metres", "decimetres", "centimetres", "millimetres" };
    const int file = (millimetres ? 3 : 0) - power;        /* the unit that was written is 10^-file metres */

    if (file >= 0 && file <= 3)
        snprintf(out, SLIP_UNIT, "in %s, not %s", name[file], name[millimetres ? 3 : 0]);
    else
        snprintf(out, SLIP_UNIT, "%g times too %s", pow(10, abs(power)), power < 0 ? "large" : "small");
    return out;
}
