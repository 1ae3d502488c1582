/* SPDX-License-Identifier: Apache-2.0 */
#include "pipeline/watch/internal.h"

#include "libtensor/base/order.h"

#include <math.h>
#include <string.h>

double pairing_offset(const pairing *p, int camera)
{
    const int64_t n = lt_min_i64(p->n_seen[camera], PAIRING_REMEMBERED);
    double d[PAIRING_REMEMBERED], middle;

    if (!n || camera == p->reference)
        return 0;
    memcpy(d, p->seen[camera], (size_t)n * sizeof(*d));
    middle = lt_median(n, d);
    return n < PAIRING_REMEMBERED / 2 && fabs(middle) <= p->period / 2 ? 0 : middle;
}

void pairing_note(pairing *p, int camera, double t, double reference_t)
{
    p->seen[camera][p->n_seen[camera]++ % PAIRING_REMEMBERED] = t - reference_t;
}

double pairing_apart(const pairing *p, int camera, double t, double reference_t)
{
    return t - pairing_offset(p, camera) - reference_t;
}

bool pairing_fits(const pairing *p, double apart)
{
    return fabs(apart) <= p->period / 2;
}
