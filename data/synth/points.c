/* SPDX-License-Identifier: Apache-2.0 */
/*
 * points.xyz of a stand-in: farthest-point samples of its surface.
 */
#include "data/synth/objects.h"

#include "libtensor/base/rng.h"

#include <float.h>
#include <math.h>

enum { DRAWS = 6 * SYNTH_POINTS };          /* of which the farthest are kept */

/* sum[f]: the area of the faces up to and including f. */
static void face_areas(const lt_mesh *m, double *sum)
{
    double total = 0;

    for (int f = 0; f < m->n_faces; f++) {
        const float *p = m->vertex[m->face[f][0]], *q = m->vertex[m->face[f][1]], *r = m->vertex[m->face[f][2]];
        double n2 = 0;
        for (int k = 0; k < 3; k++) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            const double c = ((double)q[i] - p[i]) * ((double)r[j] - p[j])
                           - ((double)q[j] - p[j]) * ((double)r[i] - p[i]);
            n2 += c * c;
        }
        total += sqrt(n2) / 2;
        sum[f] = total;
    }
}

static int find_face(const double *sum, int n, double area)
{
    int lo = 0, hi = n - 1;

    while (lo < hi) {
        const int mid = (lo + hi) / 2;
        if (sum[mid] < area)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo;
}

/* Uniform on a triangle: a parallelogram's far half is folded back. */
static void draw(const lt_mesh *m, const double *sum, lt_rng *rng, float out[3])
{
    const int f = find_face(sum, m->n_faces, lt_rng_uniform(rng) * sum[m->n_faces - 1]);
    const float *p = m->vertex[m->face[f][0]], *q = m->vertex[m->face[f][1]], *r = m->vertex[m->face[f][2]];
    double u = lt_rng_uniform(rng), v = lt_rng_uniform(rng);

    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    for (int k = 0; k < 3; k++)
        out[k] = (float)(p[k] + u * (q[k] - p[k]) + v * (r[k] - p[k]));
}

/* Greedy: each next point is the one farthest from all before. */
static void farthest(const float (*from)[3], float *d2, float (*out)[3])
{
    int next = 0;

    for (int i = 0; i < DRAWS; i++)
        d2[i] = FLT_MAX;
    for (int n = 0; n < SYNTH_POINTS; n++) {
        const float *p = from[next];
        int best = 0;
        for (int k = 0; k < 3; k++)
            out[n][k] = p[k];
        for (int i = 0; i < DRAWS; i++) {
            const float x = from[i][0] - p[0], y = from[i][1] - p[1], z = from[i][2] - p[2];
            const float d = x * x + y * y + z * z;
            d2[i] = d < d2[i] ? d : d2[i];
            if (d2[i] > d2[best])
                best = i;
        }
        next = best;
    }
}

lt_status synth_object_points(lt_arena *arena, const lt_mesh *mesh, float (**point)[3])
{
    lt_rng rng = lt_rng_make(0, SYNTH_POINTS);
    lt_arena *scratch = lt_arena_new();
    float (*out)[3] = lt_arena_array(arena, SYNTH_POINTS, sizeof(*out)), (*from)[3], *d2;
    lt_status st = LT_OK;
    double *sum;

    if (!scratch || !out)
        goto no_memory;
    sum = lt_arena_array(scratch, (size_t)mesh->n_faces, sizeof(*sum));
    from = lt_arena_array(scratch, DRAWS, sizeof(*from));
    d2 = lt_arena_array(scratch, DRAWS, sizeof(*d2));
    if (!sum || !from || !d2)
        goto no_memory;
    face_areas(mesh, sum);
    for (int i = 0; i < DRAWS; i++)
        draw(mesh, sum, &rng, from[i]);
    farthest((const float (*)[3])from, d2, out);
    *point = out;
    goto done;
no_memory:
    st = lt_error(LT_ENOMEM, "no memory for %d points", DRAWS);
done:
    lt_arena_free(scratch);
    return st;
}
