/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How often a surface goes around a point. Near triangles are summed by their solid angles; many that are far away, by
 * a dipole and a quadrupole for all of them.
 *
 * Source: Jacobson et al. 2013, "Robust inside-outside segmentation using generalized winding numbers"; Barill et al.
 * 2018, "Fast winding numbers for soups and clouds"; Van Oosterom and Strackee 1983 for a triangle's solid angle.
 */
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/internal.h"

#define PI 3.14159265358979323846

/* Radii from its centre, beyond which a node is far. */
static const double FAR = 3;

/* The middle, and the area along the normal; returns the area. */
static double middle_of(const lt_mesh_triangle *t, double middle[3], double area[3])
{
    double ab[3], ac[3];

    lt_vec3_sub(t->corner[1], t->corner[0], ab);
    lt_vec3_sub(t->corner[2], t->corner[0], ac);
    lt_vec3_cross(ab, ac, area);
    for (int k = 0; k < 3; k++) {
        area[k] /= 2;
        middle[k] = (t->corner[0][k] + t->corner[1][k] + t->corner[2][k]) / 3;
    }
    return lt_vec3_norm(area);
}

void lt_mesh_measure_node(lt_mesh_node *node, const lt_mesh_triangle *t, int n)
{
    double sum = 0, centre[3] = { 0 }, middle[3], area[3];

    for (int i = 0; i < n; i++) {
        const double size = middle_of(&t[i], middle, area);

        sum += size;
        for (int k = 0; k < 3; k++)
            centre[k] += size * middle[k];
    }
    for (int k = 0; k < 3; k++) {
        node->centre[k] = sum > 0 ? centre[k] / sum : t[0].corner[0][k];
        node->area[k] = 0;
    }
    memset(node->moment, 0, sizeof(node->moment));
    node->radius = 0;
    for (int i = 0; i < n; i++) {
        middle_of(&t[i], middle, area);
        for (int k = 0; k < 3; k++) {
            node->area[k] += area[k];
            node->radius = fmax(node->radius, lt_vec3_distance(node->centre, t[i].corner[k]));
            for (int l = 0; l < 3; l++)
                node->moment[3 * k + l] += (middle[k] - node->centre[k]) * area[l];
        }
    }
}

/* Half the solid angle of a node that is d away: the first two terms of its series. */
static double far_half_angle(const lt_mesh_node *b, const double d[3], double far2)
{
    const double *m = b->moment;
    double md[3];

    lt_mat3_mulvec(m, d, md);
    return (lt_vec3_dot(b->area, d) + m[0] + m[4] + m[8] - 3 * lt_vec3_dot(d, md) / far2) / (2 * far2 * sqrt(far2));
}

/* Half the solid angle that the triangle takes of what is seen from p; positive where its back is seen. */
static double half_angle(const lt_mesh_triangle *t, const double p[3])
{
    double a[3], b[3], c[3], bc[3], la, lb, lc;

    lt_vec3_sub(t->corner[0], p, a);
    lt_vec3_sub(t->corner[1], p, b);
    lt_vec3_sub(t->corner[2], p, c);
    la = lt_vec3_norm(a);
    lb = lt_vec3_norm(b);
    lc = lt_vec3_norm(c);
    lt_vec3_cross(b, c, bc);
    return atan2(lt_vec3_dot(a, bc), la * lb * lc + lt_vec3_dot(a, b) * lc + lt_vec3_dot(b, c) * la +
                                     lt_vec3_dot(c, a) * lb);
}

double lt_mesh_winding(const lt_mesh_index *index, const double p[3])
{
    int stack[LT_MESH_STACK], depth = 0;
    double angle = 0;                               /* half of the solid angle */

    stack[depth++] = 0;
    while (depth > 0) {
        const lt_mesh_node *b = &index->nodes[stack[--depth]];
        const double d[3] = { b->centre[0] - p[0], b->centre[1] - p[1], b->centre[2] - p[2] };
        const double far2 = lt_vec3_dot(d, d);

        if (far2 > FAR * FAR * b->radius * b->radius) {
            angle += far_half_angle(b, d, far2);
            continue;
        }
        for (int i = 0; i < b->count; i++)
            angle += half_angle(&index->triangles[b->first + i], p);
        if (b->count > 0)
            continue;
        stack[depth++] = b->first;
        stack[depth++] = b->first + 1;
    }
    return angle / (2 * PI);
}
