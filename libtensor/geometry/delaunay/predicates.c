/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Places have 22 bits, so differences 23, their 2 x 2 determinants 47, 3 x 3 ones 72 and that of the sphere 122:
 * 128-bit integers are exact. In double what is larger than its rounding can be has the right sign, and that is nearly
 * always.
 */
#include "libtensor/geometry/delaunay/internal.h"

#include <math.h>

typedef __int128 wide;

static const double ORIENT_ERROR = 8 * 0x1p-53, SPHERE_ERROR = 18 * 0x1p-53;    /* over the sum of all terms' sizes */

static int sign_of(wide x)
{
    return (x > 0) - (x < 0);
}

static void differ(grid_place a, grid_place from, int64_t out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = (int64_t)a[k] - from[k];
}

/* Of rows a, b, and of columns i, j: 47 bits, exact in double as well */
static int64_t minor(const int64_t a[3], const int64_t b[3], int i, int j)
{
    return a[i] * b[j] - a[j] * b[i];
}

static double size_of(const int64_t a[3], const int64_t b[3], int i, int j)
{
    return fabs((double)a[i] * (double)b[j]) + fabs((double)a[j] * (double)b[i]);
}

int delaunay_orient(grid_place a, grid_place b, grid_place c, grid_place d)
{
    int64_t p[3], q[3], r[3], m[3];
    double det, bound;

    differ(b, a, p);
    differ(c, a, q);
    differ(d, a, r);
    m[0] = minor(p, q, 1, 2), m[1] = minor(p, q, 2, 0), m[2] = minor(p, q, 0, 1);
    det = (double)m[0] * (double)r[0] + (double)m[1] * (double)r[1] + (double)m[2] * (double)r[2];
    bound = ORIENT_ERROR * (fabs((double)m[0] * (double)r[0]) + fabs((double)m[1] * (double)r[1])
                            + fabs((double)m[2] * (double)r[2]));
    if (fabs(det) > bound)
        return det > 0 ? 1 : -1;
    return sign_of((wide)m[0] * r[0] + (wide)m[1] * r[1] + (wide)m[2] * r[2]);
}

/* Rows are the four corners seen from e, and their squared lengths. Determinants of three rows are made of the minors
 * of two in columns 0 and 1, and the third column. */
typedef struct {
    int64_t row[4][3], lift[4];
    int64_t ab, bc, cd, da, ac, bd;
} sphere;

static void set_up(sphere *s, grid_place a, grid_place b, grid_place c, grid_place d, grid_place e)
{
    const grid_place corner[4] = { a, b, c, d };
    int64_t (*x)[3] = s->row;

    for (int i = 0; i < 4; i++) {
        differ(corner[i], e, x[i]);
        s->lift[i] = x[i][0] * x[i][0] + x[i][1] * x[i][1] + x[i][2] * x[i][2];
    }
    s->ab = minor(x[0], x[1], 0, 1), s->bc = minor(x[1], x[2], 0, 1), s->cd = minor(x[2], x[3], 0, 1);
    s->da = minor(x[3], x[0], 0, 1), s->ac = minor(x[0], x[2], 0, 1), s->bd = minor(x[1], x[3], 0, 1);
}

#define SPHERE(T, s) \
    const T az = (T)s->row[0][2], bz = (T)s->row[1][2], cz = (T)s->row[2][2], dz = (T)s->row[3][2]; \
    const T abc = az * (T)s->bc - bz * (T)s->ac + cz * (T)s->ab, bcd = bz * (T)s->cd - cz * (T)s->bd + dz * (T)s->bc; \
    const T cda = cz * (T)s->da + dz * (T)s->ac + az * (T)s->cd, dab = dz * (T)s->ab + az * (T)s->bd + bz * (T)s->da; \
    const T det = ((T)s->lift[2] * dab - (T)s->lift[3] * abc) + ((T)s->lift[0] * bcd - (T)s->lift[1] * cda)

static double bound_of(const sphere *s)
{
    const int64_t (*x)[3] = s->row;
    const double ab = size_of(x[0], x[1], 0, 1), bc = size_of(x[1], x[2], 0, 1), cd = size_of(x[2], x[3], 0, 1);
    const double da = size_of(x[3], x[0], 0, 1), ac = size_of(x[0], x[2], 0, 1), bd = size_of(x[1], x[3], 0, 1);
    const double az = fabs((double)x[0][2]), bz = fabs((double)x[1][2]), cz = fabs((double)x[2][2]);
    const double dz = fabs((double)x[3][2]);

    return SPHERE_ERROR * ((double)s->lift[0] * (bz * cd + cz * bd + dz * bc)
                           + (double)s->lift[1] * (cz * da + dz * ac + az * cd)
                           + (double)s->lift[2] * (dz * ab + az * bd + bz * da)
                           + (double)s->lift[3] * (az * bc + bz * ac + cz * ab));
}

static int sphere_sign(const sphere *s)
{
    SPHERE(double, s);

    return fabs(det) > bound_of(s) ? (det > 0 ? 1 : -1) : 2;
}

static int exact_sphere_sign(const sphere *s)
{
    SPHERE(wide, s);

    return sign_of(det);
}

/* ---- ties -------------------------------------------------------------------------------------------------- */

static bool is_before(grid_place a, grid_place b)
{
    for (int k = 0; k < 3; k++)
        if (a[k] != b[k])
            return a[k] < b[k];
    return false;
}

/* On the sphere: as if each place were moved by an amount that is nothing beside that of any later one. */
static int break_tie(const grid_place corner[4], grid_place e)
{
    grid_place order[5] = { corner[0], corner[1], corner[2], corner[3], e };

    for (int i = 1; i < 5; i++)
        for (int k = i; k > 0 && is_before(order[k], order[k - 1]); k--) {
            const grid_place later = order[k - 1];

            order[k - 1] = order[k];
            order[k] = later;
        }
    for (int i = 4; i > 2; i--) {
        grid_place with[4] = { corner[0], corner[1], corner[2], corner[3] };
        int k = 0, side;

        if (order[i] == e)
            return -1;
        while (corner[k] != order[i])
            k++;
        with[k] = e;
        side = delaunay_orient(with[0], with[1], with[2], with[3]);
        if (side)
            return side;
    }
    return -1;
}

int delaunay_insphere(grid_place a, grid_place b, grid_place c, grid_place d, grid_place e)
{
    sphere s;
    int sign;

    set_up(&s, a, b, c, d, e);
    sign = sphere_sign(&s);
    if (sign == 2)
        sign = exact_sphere_sign(&s);
    return sign ? sign : break_tie((grid_place[]){ a, b, c, d }, e);
}
