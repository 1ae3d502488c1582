/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/geometry/mesh/parts.h"

#include "libtensor/geometry/mat3.h"

static lt_status check_faces(const lt_mesh *m)
{
    for (int f = 0; f < m->n_faces; f++)
        for (int k = 0; k < 3; k++)
            if (m->face[f][k] < 0 || m->face[f][k] >= m->n_vertices)
                return lt_error(LT_EINVAL, "mesh: face %d has vertex %d of %d", f, m->face[f][k], m->n_vertices);
    return LT_OK;
}

/* ---- closed ----------------------------------------------------------------------------------------------------- */

/* How often a half of an edge goes from a to b. Those from vertex i end at to[begin[i]] .. to[begin[i + 1] - 1]. */
static int count_halves(const int32_t *begin, const int32_t *to, int32_t a, int32_t b)
{
    int n = 0;

    for (int32_t i = begin[a]; i < begin[a + 1]; i++)
        n += to[i] == b;
    return n;
}

static bool all_are_paired(const lt_mesh *m, int32_t *begin, int32_t *next, int32_t *to)
{
    for (int f = 0; f < m->n_faces; f++)
        for (int k = 0; k < 3; k++)
            begin[m->face[f][k] + 1]++;
    for (int i = 0; i < m->n_vertices; i++) {
        begin[i + 1] += begin[i];
        next[i] = begin[i];
    }
    for (int f = 0; f < m->n_faces; f++)
        for (int k = 0; k < 3; k++)
            to[next[m->face[f][k]]++] = m->face[f][(k + 1) % 3];
    for (int f = 0; f < m->n_faces; f++)
        for (int k = 0; k < 3; k++) {
            const int32_t a = m->face[f][k], b = m->face[f][(k + 1) % 3];

            if (a == b || count_halves(begin, to, a, b) != 1 || count_halves(begin, to, b, a) != 1)
                return false;
        }
    return m->n_faces > 0;
}

/* ---- parts ------------------------------------------------------------------------------------------------------ */

static int32_t root_of(int32_t *parent, int32_t i)
{
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

/* Of each vertex the lowest one that it hangs together with */
static void join(const lt_mesh *m, int32_t *parent)
{
    for (int i = 0; i < m->n_vertices; i++)
        parent[i] = i;
    for (int f = 0; f < m->n_faces; f++)
        for (int k = 1; k < 3; k++) {
            const int32_t a = root_of(parent, m->face[f][0]), b = root_of(parent, m->face[f][k]);

            parent[a > b ? a : b] = a > b ? b : a;
        }
    for (int i = 0; i < m->n_vertices; i++)
        parent[i] = root_of(parent, i);
}

static double area_of(const lt_mesh *m, int f)
{
    double x[3][3], n[3];

    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            x[i][k] = (double)m->vertex[m->face[f][i]][k];
    lt_vec3_sub(x[1], x[0], x[1]);
    lt_vec3_sub(x[2], x[0], x[2]);
    lt_vec3_cross(x[1], x[2], n);
    return 0.5 * lt_vec3_norm(n);
}

lt_status lt_mesh_topology_of(const lt_mesh *mesh, lt_mesh_topology *out)
{
    const size_t V = (size_t)mesh->n_vertices, F = (size_t)mesh->n_faces;
    int32_t *begin, *next;
    bool watertight;
    int components = 0;
    lt_status st = check_faces(mesh);

    if (st)
        return st;
    begin = lt_alloc((2 * V + 1 + 3 * F) * sizeof(*begin));
    if (!begin)
        return lt_error(LT_ENOMEM, "no memory for the edges of %d faces", mesh->n_faces);
    next = begin + V + 1;
    watertight = all_are_paired(mesh, begin, next, next + V);
    join(mesh, next);
    for (size_t i = 0; i < V; i++)
        components += next[i] == (int32_t)i && begin[i + 1] > begin[i];
    lt_release(begin);
    *out = (lt_mesh_topology){ watertight, components };
    return LT_OK;
}

/* ---- fewer ------------------------------------------------------------------------------------------------------ */

static void keep(const lt_mesh *m, const int32_t *part, const double *area, double least, int32_t *number, lt_mesh *out)
{
    for (int f = 0; f < m->n_faces; f++) {
        if (area[part[m->face[f][0]]] < least)
            continue;
        for (int k = 0; k < 3; k++) {
            const int32_t v = m->face[f][k];

            if (!number[v]) {
                memcpy(out->vertex[out->n_vertices], m->vertex[v], sizeof(*out->vertex));
                number[v] = ++out->n_vertices;
            }
            out->face[out->n_faces][k] = number[v] - 1;
        }
        out->n_faces++;
    }
}

lt_status lt_mesh_without_small_parts(lt_arena *arena, const lt_mesh *mesh, double share, lt_mesh *out)
{
    const size_t V = (size_t)mesh->n_vertices;
    lt_mesh kept = { .vertex = lt_arena_array(arena, V, sizeof(*kept.vertex)),
                     .face = lt_arena_array(arena, (size_t)mesh->n_faces, sizeof(*kept.face)) };
    int32_t *part = lt_alloc(2 * V * sizeof(*part));
    double *area = lt_alloc(V * sizeof(*area)), whole = 0;
    lt_status st = check_faces(mesh);

    if (!st && (!kept.vertex || !kept.face || !part || !area))
        st = lt_error(LT_ENOMEM, "no memory for the parts of %d faces", mesh->n_faces);
    if (!st) {
        join(mesh, part);
        for (int f = 0; f < mesh->n_faces; f++) {
            const double a = area_of(mesh, f);

            area[part[mesh->face[f][0]]] += a;
            whole += a;
        }
        keep(mesh, part, area, share * whole, part + V, &kept);
        *out = kept;
    }
    lt_release(area);
    lt_release(part);
    return st;
}
