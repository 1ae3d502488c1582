/* SPDX-License-Identifier: Apache-2.0 */
/* What the formats of poses share: whose numbers they are, how many, how large, and whether they are a rotation. */
#include "data/poses/pose_file.h"

#include "libtensor/geometry/rotation.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

void pose_reader_at(pose_reader *r, const char *frame)
{
    snprintf(r->name, sizeof(r->name), "%s, \"%s\"", r->file.path, frame);
}

static const double MOST = 1e4;         /* no angle, shape or place in metres or millimetres is larger */

/* Adds the numbers of a value to out, of which there is room for n; the count goes on beyond that. */
static bool add_numbers(const cJSON *value, int n, double *out, int *count)
{
    if (cJSON_IsNumber(value)) {
        if (*count < n)
            out[*count] = value->valuedouble;
        ++*count;
        return fabs(value->valuedouble) < MOST;
    }
    if (!cJSON_IsArray(value))
        return false;
    for (const cJSON *item = value->child; item; item = item->next)
        if (!add_numbers(item, n, out, count))
            return false;
    return true;
}

lt_status pose_numbers(const pose_reader *r, const cJSON *list, const char *what, int n, double *out)
{
    int count = 0;

    if (!list)
        return lt_error(LT_EFORMAT, "%s: %s is missing, want %d numbers", r->name, what, n);
    if (!add_numbers(list, n, out, &count))
        return lt_error(LT_EFORMAT, "%s: %s: want %d numbers below %g, and nothing else", r->name, what, n, MOST);
    if (count != n)
        return lt_error(LT_EFORMAT, "%s: %s has %d numbers, want %d", r->name, what, count, n);
    return LT_OK;
}

lt_status pose_rotation(const pose_reader *r, const char *what, double R[9])
{
    double nearest[9];

    if (lt_mat3_det(R) <= 0)
        return lt_error(LT_EFORMAT, "%s: %s has the determinant %.3g, want 1: a mirror image is no rotation; is it of "
                        "a left hand, or of axes of the other handedness?", r->name, what, lt_mat3_det(R));
    if (!lt_rot_is_near(R, 1e-2))
        return lt_error(LT_EFORMAT, "%s: %s is no rotation to 0.01; it has the determinant %.4g, want 1 and rows that "
                        "are orthogonal, of length 1", r->name, what, lt_mat3_det(R));
    lt_rot_nearest(R, nearest);
    memcpy(R, nearest, sizeof(nearest));
    return LT_OK;
}
