/* SPDX-License-Identifier: Apache-2.0 */
/* Normals, area and samples of a triangle mesh. */
#include "libtensor/geometry/mesh/surface.h"

#include "libtensor/geometry/mat3.h"

static void corner(const lt_mesh *mesh, int face, int k, double out[3])
{
    const float *v = mesh->vertex[mesh->face[face][k]];

    for (int a = 0; a < 3; a++)
        out[a] = v[a];
}

/* Twice the face's area along its normal. */
static void face_normal(const lt_mesh *mesh, int face, double out[3])
{
    double a[3], ab[3], ac[3];

    corner(mesh, face, 0, a);
    corner(mesh, face, 1, ab);
    corner(mesh, face, 2, ac);
    lt_vec3_sub(ab, a, ab);
    lt_vec3_sub(ac, a, ac);
    lt_vec3_cross(ab, ac, out);
}

static void normalise(float n[3])
{
    const double wide[3] = { n[0], n[1], n[2] }, length = lt_vec3_norm(wide);

    for (int a = 0; a < 3; a++)
        n[a] = length > 0 ? (float)(wide[a] / length) : a == 2;
}

void lt_mesh_normals(const lt_mesh *mesh, float (*normal)[3])
{
    memset(normal, 0, (size_t)mesh->n_vertices * sizeof(*normal));
    for (int f = 0; f < mesh->n_faces; f++) {
        double n[3];
        face_normal(mesh, f, n);
        for (int k = 0; k < 3; k++)
            for (int a = 0; a < 3; a++)
                normal[mesh->face[f][k]][a] += (float)n[a];
    }
    for (int i = 0; i < mesh->n_vertices; i++)
        normalise(normal[i]);
}

double lt_mesh_area(const lt_mesh *mesh)
{
    double area = 0;

    for (int f = 0; f < mesh->n_faces; f++) {
        double n[3];
        face_normal(mesh, f, n);
        area += 0.5 * lt_vec3_norm(n);
    }
    return area;
}

static void closest_on_segment(const double p[3], const double a[3], const double b[3], double out[3])
{
    double ab[3], ap[3], length, s;

    lt_vec3_sub(b, a, ab);
    lt_vec3_sub(p, a, ap);
    length = lt_vec3_dot(ab, ab);
    s = length > 0 ? fmin(fmax(lt_vec3_dot(ab, ap) / length, 0), 1) : 0;
    for (int k = 0; k < 3; k++)
        out[k] = a[k] + s * ab[k];
}

/* The foot of p on the plane, when it lies within; else the nearest of three edges. */
void lt_closest_on_triangle(const double p[3], const double a[3], const double b[3], const double c[3],
                            double out[3])
{
    const double *end[4] = { a, b, c, a };
    double ab[3], ac[3], ap[3], n[3], side[3], sq, v, w, best = INFINITY;

    lt_vec3_sub(b, a, ab);
    lt_vec3_sub(c, a, ac);
    lt_vec3_sub(p, a, ap);
    lt_vec3_cross(ab, ac, n);
    sq = lt_vec3_dot(n, n);
    lt_vec3_cross(ap, ac, side);
    v = lt_vec3_dot(side, n) / sq;
    lt_vec3_cross(ab, ap, side);
    w = lt_vec3_dot(side, n) / sq;
    if (v >= 0 && w >= 0 && v + w <= 1) {           /* never when sq is 0 */
        for (int k = 0; k < 3; k++)
            out[k] = a[k] + v * ab[k] + w * ac[k];
        return;
    }
    for (int e = 0; e < 3; e++) {
        double q[3], d;
        closest_on_segment(p, end[e], end[e + 1], q);
        d = lt_vec3_distance(p, q);
        if (d >= best)
            continue;
        best = d;
        memcpy(out, q, sizeof(q));
    }
}

/* The first face whose running sum of areas exceeds u. */
static int find_face(const double *sum, int n, double u)
{
    int lo = 0, hi = n - 1;

    while (lo < hi) {
        const int mid = lo + (hi - lo) / 2;
        if (sum[mid] > u)
            hi = mid;
        else
            lo = mid + 1;
    }
    return lo;
}

/* Uniform on a triangle: a parallelogram's far half is folded back. */
static void sample_face(const lt_mesh *mesh, int face, lt_rng *rng, float out[3])
{
    const int32_t *f = mesh->face[face];
    const float *a = mesh->vertex[f[0]], *b = mesh->vertex[f[1]], *c = mesh->vertex[f[2]];
    double u = lt_rng_uniform(rng), v = lt_rng_uniform(rng);

    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    for (int k = 0; k < 3; k++)
        out[k] = (float)(a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
}

lt_status lt_mesh_sample(const lt_mesh *mesh, lt_rng *rng, int n, float (*points)[3], int *face)
{
    double *sum = lt_alloc((size_t)mesh->n_faces * sizeof(*sum)), total = 0;

    if (!sum)
        return lt_error(LT_ENOMEM, "mesh sample: no memory for %d faces", mesh->n_faces);
    for (int f = 0; f < mesh->n_faces; f++) {
        double nf[3];
        face_normal(mesh, f, nf);
        sum[f] = total += lt_vec3_norm(nf);
    }
    if (!(total > 0) || !isfinite(total)) {
        lt_release(sum);
        return lt_error(LT_EINVAL, "mesh sample: the area of %d faces is %g, want more than 0",
                        mesh->n_faces, 0.5 * total);
    }
    for (int i = 0; i < n; i++) {
        const int f = find_face(sum, mesh->n_faces, total * lt_rng_uniform(rng));
        sample_face(mesh, f, rng, points[i]);
        if (face)
            face[i] = f;
    }
    lt_release(sum);
    return LT_OK;
}

static double distance_sq(const float a[3], const float b[3])
{
    const double d[3] = { (double)a[0] - b[0], (double)a[1] - b[1], (double)a[2] - b[2] };

    return lt_vec3_dot(d, d);
}

lt_status lt_farthest_points(int n, const float (*points)[3], int k, int first, int *chosen)
{
    double *nearest;                                /* squared distance to what is chosen so far */

    if (k < 0 || k > n || first < 0 || first >= n)
        return lt_error(LT_EINVAL, "farthest points: want %d of %d, the first being %d", k, n, first);
    nearest = lt_alloc((size_t)n * sizeof(*nearest));
    if (!nearest)
        return lt_error(LT_ENOMEM, "farthest points: no memory for %d points", n);
    for (int i = 0; i < n; i++)
        nearest[i] = INFINITY;
    for (int c = 0, pick = first; c < k; c++) {
        const int last = pick;
        chosen[c] = pick;
        nearest[pick] = -1;                         /* never again, even where points coincide */
        for (int i = 0; i < n; i++) {
            const double d = distance_sq(points[i], points[last]);
            nearest[i] = d < nearest[i] ? d : nearest[i];
            if (nearest[i] > nearest[pick])
                pick = i;
        }
    }
    lt_release(nearest);
    return LT_OK;
}
