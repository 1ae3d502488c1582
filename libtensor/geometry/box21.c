/* SPDX-License-Identifier: Apache-2.0 */
/* The 21 control points of a bounding box. */
#include "libtensor/geometry/box21.h"

#include "libtensor/geometry/mat3.h"

lt_status lt_box_from_points(int n, const float *points, lt_box *out)
{
    lt_box box = { { INFINITY, INFINITY, INFINITY }, { -INFINITY, -INFINITY, -INFINITY } };

    if (n < 1)
        return lt_error(LT_EINVAL, "box: %d points, want at least 1", n);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) {
            const double v = points[3 * (size_t)i + k];
            if (!isfinite(v))
                return lt_error(LT_EINVAL, "box: point %d of %d has a coordinate that is not finite", i, n);
            box.lo[k] = fmin(box.lo[k], v);
            box.hi[k] = fmax(box.hi[k], v);
        }
    *out = box;
    return LT_OK;
}

double lt_box_diagonal(const lt_box *box)
{
    return lt_vec3_distance(box->lo, box->hi);
}

void lt_box21(const lt_box *box, double points[LT_BOX_POINTS][3])
{
    for (int i = 0; i < LT_BOX_CORNERS; i++)
        for (int k = 0; k < 3; k++)
            points[i][k] = i >> k & 1 ? box->hi[k] : box->lo[k];
    for (int e = 0; e < LT_BOX_EDGES; e++)
        for (int k = 0; k < 3; k++)
            points[LT_BOX_CORNERS + e][k] =
                0.5 * (points[lt_box_edge[e][0]][k] + points[lt_box_edge[e][1]][k]);
    for (int k = 0; k < 3; k++)
        points[LT_BOX_POINTS - 1][k] = 0.5 * (box->lo[k] + box->hi[k]);
}
