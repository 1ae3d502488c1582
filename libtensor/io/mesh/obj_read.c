/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reading Wavefront OBJ: lines of "v", "vt", "vn", "f" twice over, once to count and once to fill. Then
 * corners become vertices: an OBJ indexes positions, texture and normals apart, a mesh does not.
 */
#include "libtensor/io/mesh/obj.h"

#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/mesh/obj_texture.h"
#include "libtensor/io/text/lines.h"

#include <math.h>
#include <string.h>

enum { LINES_MAX = 20000000 };

typedef struct {
    int32_t v, vt, vn;                  /* from 0; -1: none */
} corner;

typedef struct {
    const char *path;
    lt_text_lines lines;
    size_t n_v, n_vt, n_vn, n_tri;      /* filled so far */
    float (*v)[3], (*color)[3], (*vt)[2], (*vn)[3];
    corner *tri;                        /* 3 * n_tri */
    bool all_colors, all_vt, all_vn;
    const char *library, *material;     /* the first mtllib and usemtl, in the text */
} obj;

static lt_status bad(const obj *o, const char *reason)
{
    return lt_error(LT_EFORMAT, "%s:%zu: %s", o->path, o->lines.number, reason);
}

/* Whether a face's line has one more corner at *p, behind blanks; a comment may stand behind the last. */
static bool more_corners(const char **p)
{
    *p = lt_skip_blanks(*p);
    return **p != '\0' && **p != '#';
}

static size_t count_corners(const char *p)
{
    size_t n = 0;

    while (more_corners(&p)) {
        n++;
        p += strcspn(p, " \t\r");
    }
    return n;
}

/* First pass: how much of everything. Faces of fewer than 3 corners are found by the second. */
static lt_status count(obj *o)
{
    char *line;

    while ((line = lt_next_line(&o->lines)) != NULL) {
        const char *rest;

        if (o->lines.number > LINES_MAX)
            return bad(o, "more than 20 million lines");
        if (lt_line_is(line, "v", &rest)) {
            o->n_v++;
        } else if (lt_line_is(line, "vt", &rest)) {
            o->n_vt++;
        } else if (lt_line_is(line, "vn", &rest)) {
            o->n_vn++;
        } else if (lt_line_is(line, "f", &rest)) {
            const size_t n = count_corners(rest);

            o->n_tri += n > 2 ? n - 2 : 0;
        }
    }
    return LT_OK;
}

static lt_status allocate(obj *o, lt_arena *scratch)
{
    o->v = lt_arena_array(scratch, o->n_v, sizeof(*o->v));
    o->color = lt_arena_array(scratch, o->n_v, sizeof(*o->color));
    o->vt = lt_arena_array(scratch, o->n_vt, sizeof(*o->vt));
    o->vn = lt_arena_array(scratch, o->n_vn, sizeof(*o->vn));
    o->tri = lt_arena_array(scratch, o->n_tri, 3 * sizeof(*o->tri));
    if (!o->v || !o->color || !o->vt || !o->vn || !o->tri)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu vertices", o->path, o->n_v);
    o->all_colors = o->n_v > 0;
    o->all_vt = o->all_vn = true;
    o->n_v = o->n_vt = o->n_vn = o->n_tri = 0;
    return LT_OK;
}

static lt_status read_position(obj *o, const char *p)
{
    float x[6];
    const int n = lt_take_floats(&p, 6, x);

    if (n < 3)
        return bad(o, "vertex without three finite numbers");
    memcpy(o->v[o->n_v], x, sizeof(*o->v));
    if (n == 6)
        memcpy(o->color[o->n_v], x + 3, sizeof(*o->color));
    o->all_colors = o->all_colors && n == 6;
    o->n_v++;
    return LT_OK;
}

/* An index such as 7 or -1 (the last one so far), as a place from 0. What a positive index points to may
 * come later in the file; it is checked at the end. */
static bool take_index(const char **p, size_t so_far, int32_t *out)
{
    const bool negative = **p == '-';
    int64_t x = 0;

    *p += negative;
    if (**p < '0' || **p > '9')
        return false;
    for (; **p >= '0' && **p <= '9'; (*p)++) {
        x = x * 10 + (**p - '0');
        if (x > INT32_MAX)
            return false;
    }
    if (x == 0 || (negative && (size_t)x > so_far))
        return false;
    *out = (int32_t)(negative ? (int64_t)so_far - x : x - 1);
    return true;
}

static bool ends_word(char c)
{
    return c == '\0' || strchr(" \t\r", c);
}

/* v, v/t, v//n or v/t/n; some write v/ and v// where they have neither */
static bool take_corner(const obj *o, const char **p, corner *c)
{
    c->vt = c->vn = -1;
    if (!take_index(p, o->n_v, &c->v))
        return false;
    if (**p == '/') {
        (*p)++;
        if (**p != '/' && !ends_word(**p) && !take_index(p, o->n_vt, &c->vt))
            return false;
    }
    if (**p == '/') {
        (*p)++;
        if (!ends_word(**p) && !take_index(p, o->n_vn, &c->vn))
            return false;
    }
    return ends_word(**p);
}

static lt_status read_face(obj *o, const char *p)
{
    corner first = { 0 }, last = { 0 }, c;
    size_t n = 0;

    for (; more_corners(&p); n++, last = c) {
        if (!take_corner(o, &p, &c))
            return bad(o, "face with a corner that is no index");
        o->all_vt = o->all_vt && c.vt >= 0;
        o->all_vn = o->all_vn && c.vn >= 0;
        if (n == 0)
            first = c;
        if (n >= 2)
            memcpy(o->tri + 3 * o->n_tri++, (corner[3]){ first, last, c }, 3 * sizeof(c));
    }
    return n < 3 ? bad(o, "face of fewer than 3 corners") : LT_OK;
}

static lt_status read_line(obj *o, char *line)
{
    const char *rest;

    if (lt_line_is(line, "v", &rest))
        return read_position(o, rest);
    if (lt_line_is(line, "f", &rest))
        return read_face(o, rest);
    if (lt_line_is(line, "vt", &rest)) {
        if (lt_take_floats(&rest, 2, o->vt[o->n_vt++]) < 2)
            return bad(o, "texture vertex without two finite numbers");
    } else if (lt_line_is(line, "vn", &rest)) {
        if (lt_take_floats(&rest, 3, o->vn[o->n_vn++]) < 3)
            return bad(o, "normal without three finite numbers");
    } else if (lt_line_is(line, "mtllib", &rest) && !o->library) {
        o->library = rest;
    } else if (lt_line_is(line, "usemtl", &rest) && !o->material) {
        o->material = rest;
    }
    return LT_OK;
}

static lt_status check_indices(const obj *o)
{
    for (size_t i = 0; i < 3 * o->n_tri; i++) {
        const corner *c = &o->tri[i];

        if (c->v >= (int64_t)o->n_v || c->vt >= (int64_t)o->n_vt || c->vn >= (int64_t)o->n_vn)
            return lt_error(LT_EFORMAT, "%s: triangle %zu: index beyond the file's %zu v, %zu vt, %zu vn",
                            o->path, i / 3, o->n_v, o->n_vt, o->n_vn);
    }
    return LT_OK;
}

/* ---- corners to vertices ------------------------------------------------------------------------- */

/* Open addressing over corners; each slot holds a vertex number plus one. */
typedef struct {
    uint32_t *slot;
    size_t mask;
    corner *vertex;                     /* what each vertex is made of; vt = -2: nothing yet */
    size_t n;
} corner_map;

static size_t hash(const corner *c)
{
    uint64_t h = (uint64_t)(uint32_t)c->v * 0x9e3779b97f4a7c15u;

    h = (h ^ h >> 29 ^ (uint32_t)c->vt) * 0xbf58476d1ce4e5b9u;
    h = (h ^ h >> 32 ^ (uint32_t)c->vn) * 0x94d049bb133111ebu;
    return (size_t)(h ^ h >> 31);
}

/* The first corner of a position is the vertex of that number; other corners get new vertices. */
static int32_t vertex_of(corner_map *map, const corner *c)
{
    corner *own = &map->vertex[c->v];
    size_t i = hash(c) & map->mask;

    if (own->vt == -2)
        *own = *c;
    if (own->vt == c->vt && own->vn == c->vn)
        return c->v;
    for (; map->slot[i]; i = (i + 1) & map->mask) {
        const corner *seen = &map->vertex[map->slot[i] - 1];

        if (seen->v == c->v && seen->vt == c->vt && seen->vn == c->vn)
            return (int32_t)map->slot[i] - 1;
    }
    map->vertex[map->n++] = *c;
    map->slot[i] = (uint32_t)map->n;
    return (int32_t)map->n - 1;
}

static lt_status map_init(corner_map *map, lt_arena *scratch, const obj *o)
{
    size_t slots = 16, n_corners = 3 * o->n_tri;

    while (slots < 2 * n_corners)
        slots *= 2;
    map->mask = slots - 1;
    map->slot = lt_arena_array(scratch, slots, sizeof(*map->slot));
    map->vertex = lt_arena_array(scratch, o->n_v + n_corners, sizeof(*map->vertex));
    map->n = o->n_v;
    if (!map->slot || !map->vertex)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu triangles", o->path, o->n_tri);
    for (size_t i = 0; i < o->n_v; i++)
        map->vertex[i] = (corner){ (int32_t)i, -2, -1 };
    return LT_OK;
}

static lt_status make_arrays(lt_arena *arena, const obj *o, size_t n, lt_mesh *mesh)
{
    const bool uv = o->all_vt && o->n_tri, normal = o->all_vn && o->n_tri;

    mesh->vertex = lt_arena_array(arena, n, sizeof(*mesh->vertex));
    mesh->face = lt_arena_array(arena, o->n_tri, sizeof(*mesh->face));
    mesh->uv = uv ? lt_arena_array(arena, n, sizeof(*mesh->uv)) : NULL;
    mesh->normal = normal ? lt_arena_array(arena, n, sizeof(*mesh->normal)) : NULL;
    mesh->color = o->all_colors ? lt_arena_array(arena, n, sizeof(*mesh->color)) : NULL;
    if (!mesh->vertex || !mesh->face || (uv && !mesh->uv) || (normal && !mesh->normal) ||
        (o->all_colors && !mesh->color))
        return lt_error(LT_ENOMEM, "%s: no memory for %zu vertices", o->path, n);
    mesh->n_vertices = (int)n;
    mesh->n_faces = (int)o->n_tri;
    return LT_OK;
}

static void set_normal(float out[3], const float in[3])
{
    const double length = sqrt((double)in[0] * in[0] + (double)in[1] * in[1] + (double)in[2] * in[2]);

    for (int i = 0; i < 3; i++)
        out[i] = length > 0 ? (float)(in[i] / length) : 0;
}

static void fill_vertex(const obj *o, const corner *c, lt_mesh *mesh, size_t i)
{
    memcpy(mesh->vertex[i], o->v[c->v], sizeof(*mesh->vertex));
    if (mesh->color)
        memcpy(mesh->color[i], o->color[c->v], sizeof(*mesh->color));
    if (mesh->uv && c->vt >= 0)
        memcpy(mesh->uv[i], o->vt[c->vt], sizeof(*mesh->uv));
    if (mesh->normal && c->vn >= 0)
        set_normal(mesh->normal[i], o->vn[c->vn]);
}

static lt_status build_mesh(lt_arena *arena, lt_arena *scratch, obj *o, lt_mesh *out)
{
    int32_t *index = lt_arena_array(scratch, 3 * o->n_tri, sizeof(*index));
    corner_map map;
    lt_mesh mesh;
    lt_status st = map_init(&map, scratch, o);

    if (st)
        return st;
    if (!index)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu triangles", o->path, o->n_tri);
    for (size_t i = 0; i < 3 * o->n_tri; i++) {
        corner c = o->tri[i];

        c.vt = o->all_vt ? c.vt : -1;
        c.vn = o->all_vn ? c.vn : -1;
        index[i] = vertex_of(&map, &c);
    }
    if (map.n > INT32_MAX || o->n_tri > INT32_MAX)
        return lt_error(LT_EFORMAT, "%s: more than 2^31 vertices", o->path);
    st = make_arrays(arena, o, map.n, &mesh);
    if (st)
        return st;
    for (size_t i = 0; i < map.n; i++)
        fill_vertex(o, &map.vertex[i], &mesh, i);
    if (o->n_tri)
        memcpy(mesh.face, index, 3 * o->n_tri * sizeof(*index));
    *out = mesh;
    return LT_OK;
}

static lt_status parse(lt_arena *scratch, obj *o, char *text, size_t n)
{
    lt_status st;
    char *line;

    o->lines = lt_lines_of(text, n);
    st = count(o);
    if (st)
        return st;
    st = allocate(o, scratch);
    if (st)
        return st;
    lt_lines_rewind(&o->lines);
    while (!st && (line = lt_next_line(&o->lines)) != NULL)
        st = read_line(o, line);
    return st ? st : check_indices(o);
}

static lt_status read_obj(lt_arena *arena, const char *path, const lt_file *file, lt_mesh *out, const char **texture)
{
    obj o = { .path = path };
    lt_status st = lt_refuse_other(path, file->bytes, file->n, LT_KIND_UNKNOWN, "a mesh in OBJ");

    if (st)
        return st;
    if (memchr(file->bytes, '\0', file->n))
        return lt_error(LT_EFORMAT, "%s: a zero byte: no text file", path);
    st = parse(file->memory, &o, (char *)file->bytes, file->n);
    if (!st)
        st = build_mesh(arena, file->memory, &o, out);
    if (!st && texture)
        st = lt_obj_texture(arena, file->memory, path, o.library, o.material, texture);
    return st;
}

lt_status lt_obj_read(lt_arena *arena, const char *path, lt_mesh *out, const char **texture)
{
    lt_file file;
    lt_status st = lt_file_load(&file, path, LT_FILE_MAX);

    if (!st)
        st = read_obj(arena, path, &file, out, texture);
    lt_file_free(&file);
    return st;
}
