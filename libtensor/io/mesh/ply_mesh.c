/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PLY: columns as meshes and as Gaussians, and both of them written.
 */
#include "libtensor/io/mesh/ply.h"

#include "libtensor/io/atomic_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- columns of numbers --------------------------------------------------------------------------- */

/* n plain columns of the vertex, interleaved into out (count, stride); false when one is not there. */
static bool has_columns(const lt_ply *p, const char *const *name, int n)
{
    for (int i = 0; i < n; i++) {
        const lt_ply_property *column = lt_ply_find(p, "vertex", name[i], NULL);

        if (!column || column->is_list)
            return false;
    }
    return true;
}

/* Integers of a colour are parts of their type's largest. */
static double unit_of(lt_elem type)
{
    return type == LT_ELEM_U1 ? 255 : type == LT_ELEM_U2 ? 65535 : 1;
}

static lt_status take_columns(const lt_ply *p, const char *const *name, int n, bool colour, float *out, size_t stride)
{
    for (int k = 0; k < n; k++) {
        size_t count;
        const lt_ply_property *column = lt_ply_find(p, "vertex", name[k], &count);
        const double unit = colour ? unit_of(column->values.type) : 1;

        for (size_t i = 0; i < count; i++) {
            const float x = (float)(lt_array_get(&column->values, i) / unit);

            if (!isfinite(x))
                return lt_error(LT_EFORMAT, "%s: %s of vertex %zu is not finite", p->path, name[k], i);
            out[i * stride + (size_t)k] = x;
        }
    }
    return LT_OK;
}

/* ---- meshes --------------------------------------------------------------------------------------- */

static const char *const position[] = { "x", "y", "z" }, *const normal[] = { "nx", "ny", "nz" };
static const char *const color[] = { "red", "green", "blue" };
static const char *const uv[][2] = { { "u", "v" }, { "s", "t" }, { "texture_u", "texture_v" } };

/* An array of the mesh out of n columns, where the file has them all. */
static lt_status optional(lt_arena *arena, const lt_ply *p, const char *const *name, int n, size_t count, void *out)
{
    void *array;
    lt_status st;

    if (!has_columns(p, name, n))
        return LT_OK;
    array = lt_arena_array(arena, count, (size_t)n * sizeof(float));
    if (!array)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu vertices", p->path, count);
    st = take_columns(p, name, n, name == color, array, (size_t)n);
    memcpy(out, &array, sizeof(array));
    return st;
}

static lt_status take_vertices(lt_arena *arena, const lt_ply *p, lt_mesh *m)
{
    size_t count = 0;
    lt_status st;

    if (!has_columns(p, position, 3))
        return lt_error(LT_EFORMAT, "%s: no vertices with x, y and z", p->path);
    lt_ply_find(p, "vertex", "x", &count);
    if (count > INT32_MAX)
        return lt_error(LT_EFORMAT, "%s: more than 2^31 vertices", p->path);
    m->n_vertices = (int)count;
    st = optional(arena, p, position, 3, count, &m->vertex);
    if (!st)
        st = optional(arena, p, normal, 3, count, &m->normal);
    if (!st)
        st = optional(arena, p, color, 3, count, &m->color);
    for (size_t i = 0; !st && !m->uv && i < LT_COUNT(uv); i++)
        st = optional(arena, p, uv[i], 2, count, &m->uv);
    return st;
}

/* The corners of the file's polygons as fans of triangles. */
static lt_status fill_faces(const lt_ply *p, const lt_ply_property *list, size_t count, lt_mesh *m)
{
    for (size_t f = 0; f < count; f++) {
        const uint32_t begin = list->begin[f], end = list->begin[f + 1];

        for (uint32_t i = begin; i < end; i++) {
            const int64_t v = lt_array_int(&list->values, i);

            if (v < 0 || v >= m->n_vertices || end - begin < 3)
                return lt_error(LT_EFORMAT, "%s: face %zu: vertex %lld, want 3 corners or more of 0 to %d", p->path, f,
                                (long long)v, m->n_vertices - 1);
        }
        for (uint32_t i = begin + 2; i < end; i++, m->n_faces++) {
            m->face[m->n_faces][0] = (int32_t)lt_array_int(&list->values, begin);
            m->face[m->n_faces][1] = (int32_t)lt_array_int(&list->values, i - 1);
            m->face[m->n_faces][2] = (int32_t)lt_array_int(&list->values, i);
        }
    }
    return LT_OK;
}

static lt_status take_faces(lt_arena *arena, const lt_ply *p, lt_mesh *m)
{
    size_t count = 0, triangles = 0;
    const lt_ply_property *list = lt_ply_find(p, "face", "vertex_indices", &count);

    if (!list)
        list = lt_ply_find(p, "face", "vertex_index", &count);
    if (list && !list->is_list)
        return lt_error(LT_EFORMAT, "%s: the vertices of faces are no list", p->path);
    for (size_t f = 0; list && f < count; f++)
        triangles += list->begin[f + 1] - list->begin[f] > 2 ? list->begin[f + 1] - list->begin[f] - 2 : 0;
    m->face = lt_arena_array(arena, triangles, sizeof(*m->face));
    if (!m->face)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu triangles", p->path, triangles);
    if (triangles > INT32_MAX)
        return lt_error(LT_EFORMAT, "%s: more than 2^31 triangles", p->path);
    return list ? fill_faces(p, list, count, m) : LT_OK;
}

lt_status lt_ply_mesh(lt_arena *arena, const lt_ply *p, lt_mesh *out)
{
    lt_mesh m = { 0 };
    lt_status st = take_vertices(arena, p, &m);

    if (!st)
        st = take_faces(arena, p, &m);
    if (!st)
        *out = m;
    return st;
}

/* ---- writing -------------------------------------------------------------------------------------- */

static void put_bytes(FILE *f, const void *bytes, size_t size)
{
    static const bool host_is_big = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;

    for (size_t i = 0; i < size; i++)
        fputc(((const uint8_t *)bytes)[host_is_big ? size - 1 - i : i], f);
}

static void put_floats(FILE *f, const float *x, size_t n)
{
    for (size_t i = 0; i < n; i++)
        put_bytes(f, &x[i], sizeof(*x));
}

static void put_properties(FILE *f, const char *type, const char *const *name, int n)
{
    for (int i = 0; i < n; i++)
        fprintf(f, "property %s %s\n", type, name[i]);
}

static bool whole_255ths(const lt_mesh *m)
{
    for (int i = 0; i < m->n_vertices; i++)
        for (int k = 0; k < 3; k++)
            if (!(m->color[i][k] >= 0 && m->color[i][k] <= 1) ||
                (float)(round((double)m->color[i][k] * 255) / 255) != m->color[i][k])
                return false;
    return true;
}

static void put_mesh_header(FILE *f, const lt_mesh *m, bool bytes)
{
    fprintf(f, "ply\nformat binary_little_endian 1.0\nelement vertex %d\n", m->n_vertices);
    put_properties(f, "float", position, 3);
    if (m->normal)
        put_properties(f, "float", normal, 3);
    if (m->uv)
        put_properties(f, "float", uv[0], 2);
    if (m->color)
        put_properties(f, bytes ? "uchar" : "float", color, 3);
    fprintf(f, "element face %d\nproperty list uchar int vertex_indices\nend_header\n", m->n_faces);
}

static void put_color(FILE *f, const float *rgb, bool bytes)
{
    if (!bytes)
        put_floats(f, rgb, 3);
    for (int k = 0; bytes && k < 3; k++)
        fputc((int)lround((double)rgb[k] * 255), f);
}

lt_status lt_ply_write_mesh(const char *path, const lt_mesh *m)
{
    const bool bytes = m->color && whole_255ths(m);
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    put_mesh_header(f.stream, m, bytes);
    for (int i = 0; i < m->n_vertices; i++) {
        put_floats(f.stream, m->vertex[i], 3);
        if (m->normal)
            put_floats(f.stream, m->normal[i], 3);
        if (m->uv)
            put_floats(f.stream, m->uv[i], 2);
        if (m->color)
            put_color(f.stream, m->color[i], bytes);
    }
    for (int i = 0; i < m->n_faces; i++) {
        fputc(3, f.stream);
        for (int k = 0; k < 3; k++)
            put_bytes(f.stream, &m->face[i][k], sizeof(m->face[i][k]));
    }
    return lt_atomic_commit(&f);
}
