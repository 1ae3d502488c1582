/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writing OBJ; reading and writing .xyz.
 */
#include "libtensor/io/mesh/obj.h"

#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/text/lines.h"
#include "libtensor/io/text/number.h"

#include <stdio.h>
#include <string.h>

/* A line of numbers, perhaps of two arrays. */
static void put_floats(FILE *f, const float *x, int n)
{
    char text[LT_NUMBER_TEXT];

    for (int i = 0; i < n; i++)
        fprintf(f, " %s", lt_print_float(x[i], text));
}

static void put_corner(FILE *f, const lt_mesh *mesh, int32_t v)
{
    const int i = v + 1;

    if (mesh->uv && mesh->normal)
        fprintf(f, " %d/%d/%d", i, i, i);
    else if (mesh->uv)
        fprintf(f, " %d/%d", i, i);
    else if (mesh->normal)
        fprintf(f, " %d//%d", i, i);
    else
        fprintf(f, " %d", i);
}

static void put_mesh(FILE *f, const lt_mesh *mesh)
{
    for (int i = 0; i < mesh->n_vertices; i++) {
        fputc('v', f);
        put_floats(f, mesh->vertex[i], 3);
        if (mesh->color)
            put_floats(f, mesh->color[i], 3);
        fputc('\n', f);
    }
    for (int i = 0; mesh->uv && i < mesh->n_vertices; i++) {
        fputs("vt", f);
        put_floats(f, mesh->uv[i], 2);
        fputc('\n', f);
    }
    for (int i = 0; mesh->normal && i < mesh->n_vertices; i++) {
        fputs("vn", f);
        put_floats(f, mesh->normal[i], 3);
        fputc('\n', f);
    }
    for (int i = 0; i < mesh->n_faces; i++) {
        fputc('f', f);
        for (int k = 0; k < 3; k++)
            put_corner(f, mesh, mesh->face[i][k]);
        fputc('\n', f);
    }
}

/* "dir/box.obj" -> "dir/box.mtl" */
static char *library_path(lt_arena *arena, const char *path)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    const size_t stem = dot && (!slash || dot > slash + 1) ? (size_t)(dot - path) : strlen(path);

    return lt_arena_printf(arena, "%.*s.mtl", (int)stem, path);
}

static lt_status write_library(const char *path, const char *texture)
{
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    fprintf(f.stream, "newmtl textured\nKa 1 1 1\nKd 1 1 1\nmap_Kd %s\n", texture);
    return lt_atomic_commit(&f);
}

static lt_status write_obj(const char *path, const lt_mesh *mesh, const char *library)
{
    const char *slash = library ? strrchr(library, '/') : NULL;
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    if (library)
        fprintf(f.stream, "mtllib %s\nusemtl textured\n", slash ? slash + 1 : library);
    put_mesh(f.stream, mesh);
    return lt_atomic_commit(&f);
}

lt_status lt_obj_write(const char *path, const lt_mesh *mesh, const char *texture)
{
    lt_arena *arena;
    char *library;
    lt_status st;

    if (!texture)
        return write_obj(path, mesh, NULL);
    if (!lt_path_is_inside(texture) || strpbrk(texture, "\r\n"))
        return lt_error(LT_EINVAL, "%s: texture \"%s\" is no file name in its folder", path, texture);
    arena = lt_arena_new();
    library = arena ? library_path(arena, path) : NULL;
    if (!library)
        st = lt_error(LT_ENOMEM, "%s: no memory", path);
    else
        st = write_library(library, texture);
    if (!st)
        st = write_obj(path, mesh, library);
    lt_arena_free(arena);
    return st;
}

/* ---- xyz ----------------------------------------------------------------------------------------- */

static lt_status parse_xyz(lt_arena *arena, const char *path, char *text, size_t size,
                           float (**points)[3], size_t *n)
{
    lt_text_lines lines = lt_lines_of(text, size);
    size_t room = 0, used = 0;
    float (*out)[3];
    char *line;

    while (lt_next_line(&lines))
        room++;
    out = lt_arena_array(arena, room, sizeof(*out));
    if (!out)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu points", path, room);
    lt_lines_rewind(&lines);
    while ((line = lt_next_line(&lines)) != NULL) {
        const char *p = lt_skip_blanks(line);

        if (*p == '\0' || *p == '#')
            continue;
        if (lt_take_floats(&p, 3, out[used++]) < 3)
            return lt_error(LT_EFORMAT, "%s:%zu: want three finite numbers", path, lines.number);
    }
    *points = out;
    *n = used;
    return LT_OK;
}

lt_status lt_xyz_read(lt_arena *arena, const char *path, float (**points)[3], size_t *n)
{
    lt_file file;
    lt_status st = lt_file_load(&file, path, LT_FILE_MAX);

    if (!st)
        st = lt_refuse_other(path, file.bytes, file.n, LT_KIND_UNKNOWN, "points, three numbers a line");
    if (!st && memchr(file.bytes, '\0', file.n))
        st = lt_error(LT_EFORMAT, "%s: a zero byte: no text file", path);
    if (!st)
        st = parse_xyz(arena, path, (char *)file.bytes, file.n, points, n);
    lt_file_free(&file);
    return st;
}

lt_status lt_xyz_write(const char *path, const float (*points)[3], size_t n)
{
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    for (size_t i = 0; i < n; i++) {
        char x[LT_NUMBER_TEXT], y[LT_NUMBER_TEXT], z[LT_NUMBER_TEXT];

        fprintf(f.stream, "%s %s %s\n", lt_print_float(points[i][0], x),
                lt_print_float(points[i][1], y), lt_print_float(points[i][2], z));
    }
    return lt_atomic_commit(&f);
}
