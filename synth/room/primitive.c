/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/render/small.h"
#include "synth/room/primitive.h"

#include <string.h>

lt_mesh primitive_alloc(lt_arena *arena, int n_vertices, int n_faces)
{
    lt_mesh m = { .n_vertices = n_vertices, .n_faces = n_faces };

    m.vertex = lt_arena_array(arena, (size_t)n_vertices, sizeof(*m.vertex));
    m.normal = lt_arena_array(arena, (size_t)n_vertices, sizeof(*m.normal));
    m.uv = lt_arena_array(arena, (size_t)n_vertices, sizeof(*m.uv));
    m.face = lt_arena_array(arena, (size_t)n_faces, sizeof(*m.face));
    if (!m.vertex || !m.normal || !m.uv || !m.face)
        memset(&m, 0, sizeof(m));
    return m;
}

static void set_face(lt_mesh *m, int f, int a, int b, int c)
{
    m->face[f][0] = a;
    m->face[f][1] = b;
    m->face[f][2] = c;
}

/* Point (i, j) of the 4 x 4 grid on one side of the box; the outer grid lines are bent by edge. */
static void box_vertex(lt_mesh *m, int k, int side, int i, int j, const double half[3], double edge)
{
    static const int axes[6][3] = {                     /* across, up, out */
        { 0, 2, 1 }, { 1, 2, 0 }, { 0, 2, 1 }, { 1, 2, 0 }, { 0, 1, 2 }, { 0, 1, 2 },
    };
    static const int sign[6][2] = {
        { 1, -1 }, { 1, 1 }, { -1, 1 }, { -1, -1 }, { 1, 1 }, { -1, -1 },
    };
    static const float cell[6][2] = {
        { 0, 0 }, { 0.25f, 0 }, { 0, 0.5f }, { 0.25f, 0.5f }, { 0.5f, 0 }, { 0.5f, 0.5f },
    };
    const int *a = axes[side];
    double p[3], d[3], n = 0, s, t;

    s = i == 0 ? -half[a[0]] : i == 1 ? edge - half[a[0]] : i == 2 ? half[a[0]] - edge : half[a[0]];
    t = j == 0 ? -half[a[1]] : j == 1 ? edge - half[a[1]] : j == 2 ? half[a[1]] - edge : half[a[1]];
    p[a[0]] = sign[side][0] * s;
    p[a[1]] = t;
    p[a[2]] = sign[side][1] * half[a[2]];
    for (int c = 0; c < 3; c++) {
        const double inner = fmin(fmax(p[c], edge - half[c]), half[c] - edge);

        d[c] = p[c] - inner;
        p[c] = inner;
        n += d[c] * d[c];
    }
    for (int c = 0; c < 3; c++) {
        m->normal[k][c] = (float)(d[c] / sqrt(n));
        m->vertex[k][c] = (float)(p[c] + edge * d[c] / sqrt(n)) + (c == 2 ? (float)half[2] : 0);
    }
    m->uv[k][0] = cell[side][0] + (side < 4 ? 0.25f : 0.5f) * (float)(0.5 + 0.49 * s / half[a[0]]);
    m->uv[k][1] = cell[side][1] + 0.5f * (float)(0.5 + 0.49 * t / half[a[1]]);
}

lt_mesh primitive_box(lt_arena *arena, const double size[3], double edge)
{
    const double half[3] = { size[0] / 2, size[1] / 2, size[2] / 2 };
    lt_mesh m = primitive_alloc(arena, 6 * 16, 6 * 18);
    int f = 0;

    for (int k = 0; k < m.n_vertices; k++)
        box_vertex(&m, k, k / 16, k % 4, k / 4 % 4, half, edge);
    for (int q = 0; f < m.n_faces; q++) {
        const int a = q / 9 * 16 + q % 9 / 3 * 4 + q % 3;

        set_face(&m, f++, a, a + 1, a + 5);
        set_face(&m, f++, a, a + 5, a + 4);
    }
    return m;
}

/* The outward normal of the segment from p to q. */
static void segment_normal(const float p[2], const float q[2], float n[2])
{
    const float dr = q[0] - p[0], dz = q[1] - p[1], length = sqrtf(dr * dr + dz * dz);

    n[0] = length > 0 ? dz / length : 0;
    n[1] = length > 0 ? -dr / length : 0;
}

/* The normal at one end of segment s: shared with its neighbour where the corner is blunt. */
static void end_normal(const float (*profile)[2], int n, int s, int end, float out[2])
{
    const int other = end ? s + 1 : s - 1;
    float mine[2], its[2], length;

    segment_normal(profile[s], profile[s + 1], mine);
    memcpy(out, mine, sizeof(mine));
    if (other < 0 || other >= n - 1)
        return;
    segment_normal(profile[other], profile[other + 1], its);
    if (mine[0] * its[0] + mine[1] * its[1] < 0.766f)
        return;
    length = hypotf(mine[0] + its[0], mine[1] + its[1]);
    out[0] = (mine[0] + its[0]) / length;
    out[1] = (mine[1] + its[1]) / length;
}

/* Two rings for each segment of the profile, so that each end can have its own normal. */
lt_mesh primitive_lathe(lt_arena *arena, const float (*profile)[2], int n, int segments)
{
    const int row = segments + 1;
    lt_mesh m = primitive_alloc(arena, 2 * (n - 1) * row, 2 * (n - 1) * segments);
    int f = 0;

    for (int k = 0; k < m.n_vertices; k++) {
        const int s = k / row / 2, end = k / row % 2, i = k % row;
        const double angle = 2 * M_PI * (i % segments) / segments;
        const float c = (float)cos(angle), d = (float)sin(angle), *p = profile[s + end];
        float normal[2];

        end_normal(profile, n, s, end, normal);
        memcpy(m.vertex[k], (float[3]){ c * p[0], d * p[0], p[1] }, sizeof(*m.vertex));
        memcpy(m.normal[k], (float[3]){ c * normal[0], d * normal[0], normal[1] }, sizeof(*m.normal));
        m.uv[k][0] = (float)i / (float)segments;
        m.uv[k][1] = (float)(s + end) / (float)(n - 1);
    }
    for (int s = 0; f < m.n_faces; s++)
        for (int i = 0; i < segments; i++) {
            const int a = 2 * s * row + i, b = a + row;

            set_face(&m, f++, a, a + 1, b + 1);
            set_face(&m, f++, a, b + 1, b);
        }
    return m;
}

static void weave_normal(lt_mesh *m, int ring, int i, int rings, int around)
{
    const int row = around + 1;
    const int up = ring + 1 < rings ? ring + 1 : ring, down = ring > 0 ? ring - 1 : ring;
    const int next = (i + 1) % around, last = (i + around - 1) % around;
    float a[3], b[3], *n = m->normal[ring * row + i];

    for (int c = 0; c < 3; c++) {
        a[c] = m->vertex[ring * row + next][c] - m->vertex[ring * row + last][c];
        b[c] = m->vertex[up * row + i][c] - m->vertex[down * row + i][c];
    }
    cross3(a, b, n);
    normalise3(n);
}

void primitive_weave(lt_mesh *m, int rings, int around)
{
    const int row = around + 1;
    int f = 0;

    for (int r = 0; r < rings; r++) {
        for (int i = 0; i < around; i++)
            weave_normal(m, r, i, rings, around);
        memcpy(m->normal[r * row + around], m->normal[r * row], sizeof(*m->normal));
    }
    for (int r = 0; r + 1 < rings; r++)
        for (int i = 0; i < around; i++) {
            const int a = r * row + i, b = a + row;

            set_face(m, f++, a, a + 1, b + 1);
            set_face(m, f++, a, b + 1, b);
        }
}

lt_mesh primitive_tube(lt_arena *arena, const float (*path)[3], const float *radius, int n, float flat,
                       const float side[3], int segments)
{
    const int row = segments + 1;
    lt_mesh m = primitive_alloc(arena, n * row, 2 * (n - 1) * segments);

    for (int r = 0; r < n && m.n_vertices; r++) {
        const float *p = path[r > 0 ? r - 1 : r], *q = path[r + 1 < n ? r + 1 : r];
        float along[3], x[3], y[3];

        for (int c = 0; c < 3; c++)
            along[c] = q[c] - p[c];
        normalise3(along);
        cross3(side, along, x);
        normalise3(x);
        cross3(along, x, y);
        for (int i = 0; i <= segments; i++) {
            const double angle = 2 * M_PI * (i % segments) / segments;
            const float u = radius[r] * (float)cos(angle), v = flat * radius[r] * (float)sin(angle);

            for (int c = 0; c < 3; c++)
                m.vertex[r * row + i][c] = path[r][c] + u * x[c] + v * y[c];
            m.uv[r * row + i][0] = (float)i / (float)segments;
            m.uv[r * row + i][1] = (float)r / (float)(n - 1);
        }
    }
    if (m.n_vertices)
        primitive_weave(&m, n, segments);
    return m;
}

lt_mesh primitive_sheet(lt_arena *arena, double width, double depth, double repeat_u, double repeat_v)
{
    lt_mesh m = primitive_alloc(arena, 4, 2);

    for (int k = 0; k < m.n_vertices; k++) {
        const int x = k == 1 || k == 2, y = k >= 2;

        m.vertex[k][0] = (float)((x - 0.5) * width);
        m.vertex[k][1] = (float)((y - 0.5) * depth);
        m.normal[k][2] = 1;
        m.uv[k][0] = (float)(x * repeat_u);
        m.uv[k][1] = (float)(y * repeat_v);
    }
    if (m.n_vertices) {
        set_face(&m, 0, 0, 1, 2);
        set_face(&m, 1, 0, 2, 3);
    }
    return m;
}
